//! Animations (glTF 2.0 section 3.11, KHR_animation_pointer): a moment is a patch of the file's JSON.
//!
//! What a channel gives at a time is written where the file has the property, and everything behind
//! reads the JSON as if the file had said so.

use super::accessor::{Accessors, Attribute};
use super::error::GltfError;
use super::json::Json;
use super::notes::Notes;
use super::pointer::{self, Kind, Undo};
use glam::{DQuat, DVec4};
use serde::Serialize;
use serde_json::Value;
use std::collections::{BTreeSet, HashMap};
use std::sync::Arc;

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
        /// How long the shutter is open from then on, in seconds; 0 freezes what moves.
        shutter: f64,
    },
}

/// Which animations are played.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AnimationChoice {
    /// One, by its number in the file.
    Index(usize),
    /// All at once; of two that move the same property the later one counts.
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

pub struct Animation {
    pub info: AnimationInfo,
    channels: Vec<Channel>,
    /// What of it is not played: message and place.
    left_out: Vec<(String, String)>,
}

struct Channel {
    /// Where the property stands in the JSON.
    path: Vec<String>,
    kind: Kind,
    interpolation: Interpolation,
    /// Seconds, not descending.
    times: Arc<[f32]>,
    /// `kind.width()` numbers for each key, three times that for a cubic spline.
    values: Arc<[f32]>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Interpolation {
    Step,
    Linear,
    CubicSpline,
}

/// Reads all animations of a file, each accessor once.
pub fn animations(root: &Json<'_>, accessors: Accessors<'_>) -> Result<Vec<Animation>, GltfError> {
    let mut reader = Reader {
        root: root.clone(),
        accessors,
        known: HashMap::new(),
    };
    let animations = root.objects("animations")?;
    animations
        .iter()
        .map(|json| reader.animation(json))
        .collect()
}

/// Writes what some animations give at a time into the JSON, and what it takes to undo that.
pub fn pose<'a>(
    root: &mut Value,
    animations: impl IntoIterator<Item = &'a Animation>,
    seconds: f64,
    undo: &mut Vec<Undo>,
) {
    for animation in animations {
        for channel in &animation.channels {
            let value = channel.at(seconds);
            undo.extend(pointer::write(root, &channel.path, channel.kind, &value));
        }
    }
}

impl Animation {
    pub fn say_what_is_left_out(&self, notes: &mut Notes) {
        for (message, at) in &self.left_out {
            notes.add(message.as_str(), at);
        }
    }

    /// The nodes whose translation, rotation or scale it drives.
    pub fn moved_nodes(&self) -> impl Iterator<Item = usize> + '_ {
        let channels = self.channels.iter();
        channels.filter_map(|channel| match channel.node()? {
            (node, "translation" | "rotation" | "scale") => Some(node),
            _ => None,
        })
    }

    /// The nodes of which it changes anything.
    pub fn driven_nodes(&self) -> impl Iterator<Item = usize> + '_ {
        let channels = self.channels.iter();
        channels.filter_map(|channel| Some(channel.node()?.0))
    }

    /// The nodes whose weights differ between two times.
    pub fn morphed_nodes(&self, from: f64, to: f64) -> BTreeSet<usize> {
        let channels = self.channels.iter();
        channels
            .filter_map(|channel| match channel.node()? {
                (node, "weights") if channel.at(from) != channel.at(to) => Some(node),
                _ => None,
            })
            .collect()
    }
}

impl Channel {
    fn node(&self) -> Option<(usize, &str)> {
        match self.path.as_slice() {
            [section, node, property, ..] if section == "nodes" => {
                Some((node.parse().ok()?, property))
            }
            _ => None,
        }
    }

    /// glTF 2.0 appendix C; the first and the last key hold outside.
    fn at(&self, seconds: f64) -> Vec<f64> {
        let width = self.kind.width();
        let stride = match self.interpolation {
            Interpolation::CubicSpline => 3 * width,
            _ => width,
        };
        // Of a cubic spline's key: 0 the tangent in, 1 the value, 2 the tangent out.
        let part = |key: usize, part: usize| {
            let first = key * stride + part * width;
            let values = &self.values[first..first + width];
            values.iter().map(|&value| f64::from(value))
        };
        let value = |key| part(key, usize::from(stride > width));
        let next = self
            .times
            .partition_point(|&time| f64::from(time) <= seconds);
        if next == 0 {
            return value(0).collect();
        }
        if next == self.times.len() || self.interpolation == Interpolation::Step {
            return value(next - 1).collect();
        }
        let (a, b) = (next - 1, next);
        let interval = f64::from(self.times[b]) - f64::from(self.times[a]);
        let t = (seconds - f64::from(self.times[a])) / interval;
        let values: Vec<f64> = match self.interpolation {
            Interpolation::CubicSpline => {
                let (t2, t3) = (t * t, t * t * t);
                let tangents = part(a, 2).zip(part(b, 0));
                let ends = value(a).zip(value(b));
                let terms = ends.zip(tangents).map(|((a, b), (out_of_a, into_b))| {
                    (2.0 * t3 - 3.0 * t2 + 1.0) * a
                        + interval * (t3 - 2.0 * t2 + t) * out_of_a
                        + (3.0 * t2 - 2.0 * t3) * b
                        + interval * (t3 - t2) * into_b
                });
                terms.collect()
            }
            _ if self.kind == Kind::Rotation => {
                let quaternion = |key| DQuat::from_vec4(vector(value(key))).normalize();
                return slerp(quaternion(a), quaternion(b), t).to_array().to_vec();
            }
            _ => value(a)
                .zip(value(b))
                .map(|(a, b)| (1.0 - t) * a + t * b)
                .collect(),
        };
        if self.kind != Kind::Rotation {
            return values;
        }
        // A spline that passes through zero has no rotation there: the node says so.
        let rotation = vector(values.into_iter());
        rotation.normalize_or_zero().to_array().to_vec()
    }
}

fn vector(values: impl Iterator<Item = f64>) -> DVec4 {
    let mut vector = DVec4::ZERO;
    for (part, value) in vector.as_mut().iter_mut().zip(values) {
        *part = value;
    }
    vector
}

/// Along the shorter arc; a quaternion and its negative are the same rotation.
fn slerp(a: DQuat, b: DQuat, t: f64) -> DQuat {
    let dot = a.dot(b);
    let b = if dot < 0.0 { -b } else { b };
    // The angle by its half chord: the arc cosine of a dot product near 1 has lost it.
    let angle = 2.0 * (0.5 * (b - a).length()).asin();
    if angle == 0.0 {
        return a;
    }
    let weight = |t: f64| (t * angle).sin() / angle.sin();
    (a * weight(1.0 - t) + b * weight(t)).normalize()
}

struct Reader<'a, 'b> {
    root: Json<'a>,
    accessors: Accessors<'b>,
    /// By the accessor's number, and whether its integers are normalized in any case.
    known: HashMap<(usize, bool), Arc<[f32]>>,
}

impl Reader<'_, '_> {
    fn animation(&mut self, json: &Json<'_>) -> Result<Animation, GltfError> {
        let samplers = json.objects("samplers")?;
        let mut channels = Vec::new();
        let mut left_out = Vec::new();
        let given = json.objects("channels")?;
        for channel in &given {
            let index = channel.required("sampler")?;
            let number = index.as_uint()?;
            let sampler = usize::try_from(number).ok().and_then(|i| samplers.get(i));
            let sampler = sampler.ok_or_else(|| {
                let count = samplers.len();
                index.invalid(format!(
                    "{number} is out of range: there are {count} samplers"
                ))
            })?;
            let target = channel
                .object("target")?
                .ok_or_else(|| channel.invalid("`target` is missing"))?;
            match self.target(&target)? {
                Ok((path, kind, normalized)) => {
                    channels.push(self.channel(sampler, path, kind, normalized)?);
                }
                Err(why) => left_out.push((why, target.at)),
            }
        }
        let starts = channels.iter().filter_map(|channel| channel.times.first());
        let ends = channels.iter().filter_map(|channel| channel.times.last());
        let start = starts.copied().fold(f32::INFINITY, f32::min);
        let end = ends.copied().fold(0.0, f32::max);
        Ok(Animation {
            info: AnimationInfo {
                name: json.name(),
                start: f64::from(start.min(end)),
                end: f64::from(end),
                channels: given.len(),
            },
            channels,
            left_out,
        })
    }

    /// What a channel drives, and whether integers stand for fractions in any case; or why it is left
    /// out.
    #[allow(clippy::type_complexity, reason = "it is taken apart where it is used")]
    fn target(
        &self,
        target: &Json<'_>,
    ) -> Result<Result<(Vec<String>, Kind, bool), String>, GltfError> {
        const POINTER: &str = "KHR_animation_pointer";
        if let Some(extension) = target.extension(POINTER)? {
            let found = pointer::resolve(&self.root, &extension.required("pointer")?)?;
            return Ok(found.map(|(path, kind)| (path, kind, false)));
        }
        let path = target.required("path")?;
        let name = path.as_string()?;
        let Some((node, json)) = target.reference("node", "nodes")? else {
            return Ok(Err("an animation of no node is left out".to_owned()));
        };
        let kind = match name {
            "translation" | "scale" => Kind::Floats(3),
            "rotation" => Kind::Rotation,
            "weights" => match pointer::target_count(&json)? {
                0 => {
                    return Ok(Err(
                        "weights of a mesh without targets are left out".to_owned()
                    ));
                }
                count => Kind::Weights(count),
            },
            _ => {
                return Err(path.invalid(format!(
                    "`{name}` is none of translation, rotation, scale, weights"
                )));
            }
        };
        if name != "weights" {
            pointer::refuse_matrix(&json, target)?;
        }
        let path = ["nodes", &node.to_string(), name].map(str::to_owned);
        Ok(Ok((path.to_vec(), kind, true)))
    }

    fn channel(
        &mut self,
        sampler: &Json<'_>,
        path: Vec<String>,
        kind: Kind,
        normalized: bool,
    ) -> Result<Channel, GltfError> {
        let interpolation = match sampler.string("interpolation")?.unwrap_or("LINEAR") {
            "STEP" => Interpolation::Step,
            "LINEAR" => Interpolation::Linear,
            "CUBICSPLINE" => Interpolation::CubicSpline,
            other => {
                let at = sampler.required("interpolation")?;
                return Err(at.invalid(format!("`{other}` is none of STEP, LINEAR, CUBICSPLINE")));
            }
        };
        if kind == Kind::Bool && interpolation != Interpolation::Step {
            return Err(sampler.invalid("what is true or false is animated by STEP only"));
        }
        let times = self.accessor(sampler, "input", "SCALAR", false)?;
        let input = sampler.required("input")?;
        if times.is_empty() {
            return Err(input.invalid("it has no keys"));
        }
        if let Some(key) = times
            .iter()
            .position(|&time| !time.is_finite() || time < 0.0)
        {
            let time = times[key];
            return Err(input.invalid(format!(
                "the time of key {key} is {time}; it must be finite and not negative"
            )));
        }
        if let Some(key) = times.windows(2).position(|pair| pair[1] < pair[0]) {
            let (time, after) = (times[key], times[key + 1]);
            return Err(input.invalid(format!(
                "the times do not ascend: key {key} is at {time} and the next at {after}"
            )));
        }
        let values = self.accessor(sampler, "output", kind.accessor_type(), normalized)?;
        let output = sampler.required("output")?;
        let parts = match interpolation {
            Interpolation::CubicSpline => 3,
            _ => 1,
        };
        let width = kind.width();
        if values.len() != times.len() * parts * width {
            return Err(output.invalid(format!(
                "it has {} numbers; {} keys of {} take {}",
                values.len(),
                times.len(),
                parts * width,
                times.len() * parts * width
            )));
        }
        if let Some(index) = values.iter().position(|value| !value.is_finite()) {
            let key = index / (parts * width);
            return Err(output.invalid(format!("key {key} holds {}", values[index])));
        }
        if kind == Kind::Rotation {
            let mut keys = values.chunks_exact(parts * width);
            let middle = if parts == 3 {
                width..2 * width
            } else {
                0..width
            };
            if let Some(key) = keys.position(|key| key[middle.clone()].iter().all(|&v| v == 0.0)) {
                return Err(output.invalid(format!("key {key} is a rotation of length zero")));
            }
        }
        Ok(Channel {
            path,
            kind,
            interpolation,
            times,
            values,
        })
    }

    fn accessor(
        &mut self,
        sampler: &Json<'_>,
        key: &str,
        kind: &str,
        normalized: bool,
    ) -> Result<Arc<[f32]>, GltfError> {
        let (number, _) = sampler.required(key)?.follow("accessors")?;
        let (accessors, budget) = (self.accessors, self.accessors.budget);
        if let Some(known) = self.known.get(&(number, normalized)) {
            return Ok(Arc::clone(known));
        }
        let used = budget.used();
        let attribute = |types| Attribute {
            types,
            fill: 0.0,
            normalized,
        };
        let flat = |vectors: Option<Vec<f32>>| vectors.unwrap_or_default();
        let values = match kind {
            "SCALAR" => accessors
                .floats::<1>(sampler, key, &attribute(&["SCALAR"]))?
                .map(|values| values.concat()),
            "VEC2" => accessors
                .floats::<2>(sampler, key, &attribute(&["VEC2"]))?
                .map(|values| values.concat()),
            "VEC3" => accessors
                .floats::<3>(sampler, key, &attribute(&["VEC3"]))?
                .map(|values| values.concat()),
            _ => accessors
                .floats::<4>(sampler, key, &attribute(&["VEC4"]))?
                .map(|values| values.concat()),
        };
        let values: Arc<[f32]> = flat(values).into();
        // What it took to read them is free again.
        budget.rewind(used);
        budget.take(4 * values.len() as u64, sampler.file(), &sampler.at)?;
        self.known.insert((number, normalized), Arc::clone(&values));
        Ok(values)
    }
}
