//! EXT_lights_ies: lamps with the intensity that was measured in each direction, from files of
//! ANSI/IES LM-63.

mod lm63;

use super::buffer::Buffers;
use super::error::GltfError;
use super::json::Json;
use super::node::{Nodes, rigid};
use super::notes::Notes;
use super::source::Source;
use crate::scene::{Profile, PunctualKind, PunctualLight};
use glam::{DVec3, Vec3};
use lm63::{Lm63, Photometry};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

pub const NAME: &str = "EXT_lights_ies";

/// Entries of a table: every half degree.
const ROWS: usize = 361;
const COLUMNS: usize = 720;

/// The profiles of a file that some shown node has used, by their numbers in the file.
#[derive(Default)]
pub struct Profiles {
    known: BTreeMap<usize, Arc<Profile>>,
    /// What there is to note of them, and where.
    notes: Vec<(&'static str, String)>,
}

/// The profiles that the file defines.
pub fn lights<'a>(root: &Json<'a>) -> Result<Vec<Json<'a>>, GltfError> {
    match root.extension(NAME)? {
        Some(extension) => extension.objects("lights"),
        None => Ok(Vec::new()),
    }
}

/// The profile that a node refers to.
fn reference(node: &Json<'_>, count: usize) -> Result<Option<usize>, GltfError> {
    let Some(extension) = node.extension(NAME)? else {
        return Ok(None);
    };
    let index = extension.required("light")?;
    match usize::try_from(index.as_uint()?) {
        Ok(number) if number < count => Ok(Some(number)),
        _ => Err(index.invalid(format!(
            "{} is out of range: there are {count} lights",
            index.value()
        ))),
    }
}

impl Profiles {
    /// Reads those that shown nodes refer to.
    pub fn read(
        &mut self,
        root: &Json<'_>,
        (buffers, source): (&Buffers, &Source),
        notes: &mut Notes,
    ) -> Result<(), GltfError> {
        let lights = lights(root)?;
        if lights.is_empty() {
            // A node that refers to one is told so when it is placed.
            return Ok(());
        }
        // What there is to note of nodes is noted when the scene is read.
        let nodes = Nodes::read(root, &mut Notes::default())?;
        for &node in &nodes.shown {
            let Some(number) = reference(&nodes.json[node], lights.len())? else {
                continue;
            };
            if !self.known.contains_key(&number) {
                let profile = profile(&lights[number], buffers, source, &mut self.notes)?;
                self.known.insert(number, Arc::new(profile));
            }
        }
        for (message, at) in &self.notes {
            notes.add(*message, at);
        }
        Ok(())
    }

    /// All that were read, as `Scene::profiles` has them.
    pub fn all(&self) -> Vec<Arc<Profile>> {
        self.known.values().cloned().collect()
    }

    /// The lamp that a node holds, if it holds one. Scale does not touch it.
    pub fn light(
        &self,
        nodes: &Nodes<'_>,
        node: usize,
        notes: &mut Notes,
    ) -> Result<Option<PunctualLight>, GltfError> {
        let json = &nodes.json[node];
        let Some(extension) = json.extension(NAME)? else {
            return Ok(None);
        };
        let index = extension.required("light")?;
        let number = index.as_uint()? as usize;
        if !self.known.contains_key(&number) {
            return Err(index.invalid(format!("{number} is out of range")));
        }
        let place = self.known.range(..number).count();
        let multiplier = extension.number("multiplier")?.unwrap_or(1.0);
        if multiplier < 0.0 {
            return Err(extension.invalid("its multiplier is negative"));
        }
        let color = Vec3::from(extension.vector("color")?.unwrap_or([1.0; 3]));
        let clamped = color.clamp(Vec3::ZERO, Vec3::ONE);
        if clamped != color {
            notes.add(
                "colours of lamps outside of 0 to 1 are clamped",
                &extension.at,
            );
        }
        let frame = rigid(nodes.world(node));
        Ok(Some(PunctualLight {
            name: json.name(),
            kind: PunctualKind::Profile {
                profile: place,
                azimuth_zero: frame.transform_vector3(DVec3::X).as_vec3(),
            },
            intensity: clamped * multiplier,
            position: nodes.world_f32(node)?.translation.into(),
            direction: frame.transform_vector3(DVec3::NEG_Z).as_vec3(),
            range: None,
        }))
    }
}

fn profile(
    light: &Json<'_>,
    buffers: &Buffers,
    source: &Source,
    notes: &mut Vec<(&'static str, String)>,
) -> Result<Profile, GltfError> {
    let bytes = match buffers.view(light, "bufferView")? {
        Some(view) => view.bytes.to_vec(),
        None => match light.get("uri") {
            Some(uri) => source.resolve(&uri)?,
            None => return Err(light.invalid("it has neither `uri` nor `bufferView`")),
        },
    };
    // Numbers of one digit, each with what parts it from the next, as float64 and as text.
    let parsed = bytes.len() as u64 / 2 * 24;
    let table = (ROWS * COLUMNS * size_of::<f32>()) as u64;
    source
        .budget
        .take(parsed + table, light.file(), &light.at)?;
    let text = String::from_utf8_lossy(&bytes);
    let lamp = Lm63::parse(&text).map_err(|what| light.invalid(what))?;
    if lamp.tilted {
        let message = "how a lamp's output changes with its tilt is left out";
        notes.push((message, light.at.clone()));
    }
    if lamp.photometry != Photometry::C {
        let message = "angles of photometry of types A and B are taken with up towards the node's +x and right \
             towards its -y";
        notes.push((message, light.at.clone()));
    }
    Ok(resample(&lamp))
}

fn resample(lamp: &Lm63) -> Profile {
    let columns = match lamp.is_round() {
        true => 1,
        false => COLUMNS,
    };
    let candela = (0..ROWS * columns).into_par_iter().map(|i| {
        let polar = (i / columns) as f64 * PI / (ROWS - 1) as f64;
        let azimuth = (i % columns) as f64 * TAU / columns as f64;
        lamp.candela(polar, azimuth) as f32
    });
    Profile {
        rows: ROWS as u32,
        columns: columns as u32,
        candela: candela.collect(),
    }
}
