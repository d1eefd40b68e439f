//! Animations (glTF 2.0 section 3.11).

use serde::Serialize;

/// When a scene is looked at.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Moment {
    /// No animation is played: the pose that the file rests in.
    #[default]
    Rest,
    At {
        animation: AnimationChoice,
        /// On the animations' own clock; before their first key and after their last they stand.
        seconds: f64,
        /// How long the shutter is open from then on, in seconds.
        shutter: f64,
    },
}

/// Which animations are played.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AnimationChoice {
    /// One, by its number in the file.
    Index(usize),
    /// All at once.
    All,
}

/// What there is to say of an animation.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AnimationInfo {
    pub name: String,
    /// Of its first key and its last, in seconds.
    pub start: f64,
    pub end: f64,
    pub channels: usize,
}
