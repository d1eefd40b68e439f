//! Which moment of the file, and which of its variants: names on the command line become numbers.

use super::render::RenderArgs;
use crate::error::Error;
use crate::gltf::{AnimationChoice, AnimationInfo, Asset, Moment};
use crate::report;

/// What plays while the pictures are made.
pub struct Playing {
    animation: Option<AnimationChoice>,
    shutter: f64,
    /// `all`, or the animation's own, or its number.
    name: Option<String>,
    /// Of the first key and the last of what plays, in seconds.
    pub span: [f64; 2],
    /// What was asked for and is not there to be done.
    pub note: Option<String>,
}

impl Playing {
    /// By what the options say of time; without any, nothing plays.
    pub fn choose(asset: &Asset, args: &RenderArgs) -> Result<Self, Error> {
        let animations = asset.animations();
        let asked = args.time.is_some() || args.frames.is_some() || args.shutter.is_some();
        let animation = match args.animation.as_deref() {
            Some("all") => (!animations.is_empty()).then_some(AnimationChoice::All),
            Some(name) => Some(AnimationChoice::Index(find(&animations, name)?)),
            None => (asked && !animations.is_empty()).then_some(AnimationChoice::Index(0)),
        };
        let played = match animation {
            None => &[][..],
            Some(AnimationChoice::All) => &animations,
            Some(AnimationChoice::Index(index)) => &animations[index..=index],
        };
        let still = animation.is_none() && (asked || args.animation.is_some());
        // A turntable is a sequence of its own.
        let missed = still && args.turntable.is_none();
        Ok(Self {
            animation,
            shutter: args.shutter.unwrap_or(0.0),
            name: animation.map(|animation| match animation {
                AnimationChoice::All => "all".to_owned(),
                AnimationChoice::Index(index) => called(&animations[index].name, index),
            }),
            span: [
                played.iter().map(|a| a.start).fold(f64::INFINITY, f64::min),
                played
                    .iter()
                    .map(|a| a.end)
                    .fold(f64::NEG_INFINITY, f64::max),
            ],
            note: missed.then(|| {
                "there are no animations: at all times the file is drawn as it rests".to_owned()
            }),
        })
    }

    /// Whether anything moves.
    pub fn is_still(&self) -> bool {
        self.animation.is_none()
    }

    pub fn moment(&self, seconds: f64) -> Moment {
        match self.animation {
            None => Moment::Rest,
            Some(animation) => Moment::At {
                animation,
                seconds,
                shutter: self.shutter,
            },
        }
    }

    /// The same for the record.
    pub fn record(&self, seconds: f64) -> Option<report::Moment> {
        self.name.clone().map(|animation| report::Moment {
            animation,
            seconds,
            shutter: self.shutter,
        })
    }
}

/// Has the asset show the variant that is asked for.
pub fn choose_variant(asset: &mut Asset, wanted: Option<&str>) -> Result<(), Error> {
    let Some(wanted) = wanted else {
        return Ok(());
    };
    let variants = asset.variants();
    match variants.iter().position(|name| name == wanted) {
        Some(index) => {
            asset.choose_variant(Some(index));
            Ok(())
        }
        None if variants.is_empty() => Err(Error::Usage(format!(
            "there is no variant '{wanted}': the file has none; leave --variant away"
        ))),
        None => Err(Error::Usage(format!(
            "there is no variant '{wanted}'; the file has '{}'",
            variants.join("', '")
        ))),
    }
}

/// A name wins over a number: an animation may be named "2".
fn find(animations: &[AnimationInfo], wanted: &str) -> Result<usize, Error> {
    let named = animations.iter().position(|a| a.name == wanted);
    let index = || wanted.parse().ok().filter(|&i| i < animations.len());
    named.or_else(index).ok_or_else(|| {
        let list: Vec<String> = animations
            .iter()
            .enumerate()
            .map(|(i, animation)| format!("{i} '{}'", animation.name))
            .collect();
        Error::Usage(match list.is_empty() {
            true => format!(
                "there is no animation '{wanted}': the file has none; leave --animation away"
            ),
            false => format!(
                "there is no animation '{wanted}'; the file has {}, or 'all'",
                list.join(", ")
            ),
        })
    })
}

fn called(name: &str, index: usize) -> String {
    match name {
        "" => index.to_string(),
        name => name.to_owned(),
    }
}
