//! What both renderers are asked for, and what they say on the way.

use std::ops::Range;

/// Which part of the picture and of its samples to render.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Settings {
    /// x, y, width, height in pixels of the whole picture (`frame.film_size`).
    pub crop: [u32; 4],
    /// Running numbers of the samples of each pixel.
    pub samples: Range<u32>,
}

/// How far a renderer is, in units of its own choice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    pub done: u64,
    pub total: u64,
}

/// What a renderer did, for the record.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    pub closest_rays: u64,
    pub shadow_rays: u64,
    /// Samples that `View::clamp` has darkened.
    pub clamped_samples: u64,
}
