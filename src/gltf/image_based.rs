//! EXT_lights_image_based: the light around a scene, as a cube map.
//!
//! The extension holds the light twice, filtered for a rasterizer: mirror reflections of growing
//! roughness, of which the first is the light itself, and nine coefficients of the irradiance. A path
//! tracer needs the light; the coefficients only serve to check it.

use super::buffer::Buffers;
use super::error::GltfError;
use super::image;
use super::json::Json;
use super::notes::Notes;
use super::source::Source;
use crate::scene::{Environment, Pixels};
use glam::{DQuat, DVec3};
use rayon::prelude::*;
use serde_json::Value;
use std::f64::consts::{PI, TAU};

pub const NAME: &str = "EXT_lights_image_based";

/// What a light was made into, with the part of its JSON that it was made from.
#[derive(Default)]
pub struct Known {
    cube: Option<(Value, Cube)>,
    environment: Option<([f32; 4], Environment)>,
}

/// Widest map, texels: as much as a face of 1024 needs.
const WIDTH_MAX: usize = 4096;

impl Known {
    /// The light around the scene that is shown, if the file gives it one.
    pub fn environment(
        &mut self,
        root: &Json<'_>,
        (buffers, source): (&Buffers, &Source),
        notes: &mut Notes,
    ) -> Result<Option<Environment>, GltfError> {
        let scene = super::node::scene(root)?;
        let Some(reference) = scene
            .map(|scene| scene.extension(NAME))
            .transpose()?
            .flatten()
        else {
            return Ok(None);
        };
        let index = reference.required("light")?;
        let lights = match root.extension(NAME)? {
            Some(extension) => extension.objects("lights")?,
            None => Vec::new(),
        };
        let Some(light) = lights.get(index.as_uint()? as usize) else {
            return Err(index.invalid(format!(
                "{} is out of range: there are {} lights",
                index.value(),
                lights.len()
            )));
        };
        let intensity = light.number("intensity")?.unwrap_or(1.0);
        if intensity < 0.0 {
            return Err(light.invalid("its intensity is negative"));
        }
        let rotation = light.vector("rotation")?.unwrap_or([0.0, 0.0, 0.0, 1.0]);
        if rotation == [0.0; 4] {
            return Err(light.invalid("its rotation has no length"));
        }
        let images = light.required("specularImages")?;
        let cube = match self.cube.take() {
            Some((made_from, cube)) if made_from == *images.value() => cube,
            _ => {
                self.environment = None;
                Cube::read(light, buffers, source)?
            }
        };
        let mut environment = match self.environment.take() {
            Some((turned, environment)) if turned == rotation => environment,
            _ => cube.environment(rotation),
        };
        environment.strength = intensity;
        check_irradiance(light, &environment, notes)?;
        self.cube = Some((images.value().clone(), cube));
        self.environment = Some((rotation, environment.clone()));
        Ok(Some(environment))
    }
}

/// Six square faces: +x, -x, +y, -y, +z, -z.
struct Cube {
    size: usize,
    /// Row 0 on top.
    faces: Vec<Vec<[f32; 3]>>,
}

/// Of each face: where it lies, where its right and where its upper edge point. The extension mirrors
/// the usual cube map's images left to right, so that each is the view from inside.
const FACES: [[DVec3; 3]; 6] = [
    [DVec3::X, DVec3::Z, DVec3::Y],
    [DVec3::NEG_X, DVec3::NEG_Z, DVec3::Y],
    [DVec3::Y, DVec3::NEG_X, DVec3::NEG_Z],
    [DVec3::NEG_Y, DVec3::NEG_X, DVec3::Z],
    [DVec3::Z, DVec3::NEG_X, DVec3::Y],
    [DVec3::NEG_Z, DVec3::X, DVec3::Y],
];

impl Cube {
    /// The sharpest of the light's images.
    fn read(light: &Json<'_>, buffers: &Buffers, source: &Source) -> Result<Self, GltfError> {
        let levels = light.required("specularImages")?;
        let level = light.elements("specularImages")?.into_iter().next();
        let level = level.ok_or_else(|| levels.invalid("it has no images"))?;
        let indices = level.items()?;
        if indices.len() != FACES.len() {
            return Err(level.invalid(format!("{} images where 6 belong", indices.len())));
        }
        let mut faces: Vec<Vec<[f32; 3]>> = Vec::new();
        let mut size = 0;
        for index in &indices {
            let (_, json) = index.follow("images")?;
            let (width, height, face) = read_face(&json, buffers, source)?;
            if size == 0 {
                size = width;
            }
            if width != height || width != size {
                return Err(index.invalid(format!(
                    "{} is {width} x {height} pixels; the six faces are squares of one size, {size}",
                    json.at
                )));
            }
            faces.push(face);
        }
        let cube = Self { size, faces };
        // The map, and the copy of it that a scene gets.
        let texels = cube.width_of_map() * cube.width_of_map() / 2;
        let bytes = 2 * texels * size_of::<[f32; 3]>();
        source.budget.take(bytes as u64, light.file(), &light.at)?;
        Ok(cube)
    }

    fn width_of_map(&self) -> usize {
        (4 * self.size).min(WIDTH_MAX)
    }

    fn environment(&self, rotation: [f32; 4]) -> Environment {
        let (width, height) = (self.width_of_map(), self.width_of_map() / 2);
        let rotation = DQuat::from_array(rotation.map(f64::from));
        let cube_from_world = rotation.normalize().inverse();
        // Points of a texel along each axis: two, or as many as there are texels of the cube.
        let points = (4 * self.size).div_ceil(width).max(2);
        let texel = |i: usize| {
            let mut sum = DVec3::ZERO;
            for point in 0..points * points {
                let at = |i: usize, point: usize| i as f64 + (point as f64 + 0.5) / points as f64;
                let theta = at(i / width, point / points) * PI / height as f64;
                let phi = (at(i % width, point % points) / width as f64 - 0.5) * TAU;
                let (sin, cos) = theta.sin_cos();
                let d = DVec3::new(sin * phi.cos(), cos, sin * phi.sin());
                sum += self.radiance(cube_from_world * d);
            }
            (sum / (points * points) as f64).as_vec3().to_array()
        };
        Environment {
            width: width as u32,
            height: height as u32,
            radiance: (0..width * height).into_par_iter().map(texel).collect(),
            strength: 1.0,
            rotation: 0.0,
        }
    }

    /// Bilinear between texels, over the edges too.
    fn radiance(&self, d: DVec3) -> DVec3 {
        let (face, [u, v]) = place(d);
        let size = self.size as f64;
        let (x, y) = (u * size - 0.5, v * size - 0.5);
        let (fx, fy) = (x - x.floor(), y - y.floor());
        let (x, y) = (x.floor(), y.floor());
        let tap = |dx: f64, dy: f64| self.texel(face, x + dx, y + dy);
        let top = tap(0.0, 0.0).lerp(tap(1.0, 0.0), fx);
        let bottom = tap(0.0, 1.0).lerp(tap(1.0, 1.0), fx);
        top.lerp(bottom, fy)
    }

    /// A texel; one beyond the face's edge is the one of the neighbour that lies there.
    fn texel(&self, face: usize, x: f64, y: f64) -> DVec3 {
        let inside = 0.0..self.size as f64;
        if inside.contains(&x) && inside.contains(&y) {
            return self.stored(face, x as usize, y as usize);
        }
        let [forward, right, up] = FACES[face];
        let at = |i: f64| 2.0 * (i + 0.5) / self.size as f64 - 1.0;
        let (face, [u, v]) = place(forward + right * at(x) - up * at(y));
        let last = self.size - 1;
        let index = |u: f64| ((u * self.size as f64) as usize).min(last);
        self.stored(face, index(u), index(v))
    }

    fn stored(&self, face: usize, x: usize, y: usize) -> DVec3 {
        DVec3::from(self.faces[face][y * self.size + x].map(f64::from))
    }
}

/// The face that a direction meets, and where: [0, 1]^2 from the upper left.
fn place(d: DVec3) -> (usize, [f64; 2]) {
    let a = d.abs();
    let (axis, side) = if a.x >= a.y && a.x >= a.z {
        (0, d.x)
    } else if a.y >= a.z {
        (1, d.y)
    } else {
        (2, d.z)
    };
    let face = 2 * axis + usize::from(side < 0.0);
    let [forward, right, up] = FACES[face];
    let depth = d.dot(forward);
    let u = 0.5 + 0.5 * d.dot(right) / depth;
    let v = 0.5 - 0.5 * d.dot(up) / depth;
    (face, [u, v])
}

type Face = (usize, usize, Vec<[f32; 3]>);

/// An image as radiance. A PNG with alpha is RGBD: its colours, by the power of 2.2 that those who write
/// such files take (the extension names none; Babylon.js, toRGBD), divided by alpha. Others are sRGB.
fn read_face(json: &Json<'_>, buffers: &Buffers, source: &Source) -> Result<Face, GltfError> {
    let (image, rgbd) = image::single(json, buffers, source)?;
    let (width, height) = (image.width as usize, image.height as usize);
    source.budget.take(
        (width * height * size_of::<[f32; 3]>()) as u64,
        json.file(),
        &json.at,
    )?;
    let values: Vec<[f64; 4]> = match &image.pixels {
        Pixels::Rgba8(bytes) => {
            let (texels, _) = bytes.as_chunks::<4>();
            texels
                .iter()
                .map(|t| t.map(|x| f64::from(x) / 255.0))
                .collect()
        }
        Pixels::Rgba16(words) => {
            let (texels, _) = words.as_chunks::<4>();
            texels
                .iter()
                .map(|t| t.map(|x| f64::from(x) / 65535.0))
                .collect()
        }
    };
    let dark = |t: &[f64; 4]| rgbd && t[3] == 0.0 && t[..3].iter().any(|&x| x > 0.0);
    if let Some(i) = values.iter().position(dark) {
        return Err(json.invalid(format!(
            "pixel ({}, {}) of its RGBD is divided by an alpha of 0",
            i % width,
            i / width
        )));
    }
    let radiance = values.iter().map(|&[r, g, b, divisor]| {
        [r, g, b].map(|x| match (rgbd, x > 0.0) {
            (_, false) => 0.0,
            (true, true) => (x.powf(2.2) / divisor) as f32,
            (false, true) => crate::output::tonemap::srgb_decode(x) as f32,
        })
    });
    Ok((width, height, radiance.collect()))
}

/// The mean irradiance over all normals is pi times the mean radiance; by the coefficients it is their
/// first times the first spherical harmonic (Ramamoorthi and Hanrahan 2001, "An Efficient Representation
/// for Irradiance Environment Maps").
fn check_irradiance(
    light: &Json<'_>,
    environment: &Environment,
    notes: &mut Notes,
) -> Result<(), GltfError> {
    /// Beyond this the two are not of one light, however coarsely it was filtered.
    const RATIO_MAX: f64 = 2.0;
    const Y_00: f64 = 0.282_094_791_773_878_1;
    let Some(first) = light.elements("irradianceCoefficients")?.into_iter().next() else {
        return Err(light.invalid("`irradianceCoefficients` is missing"));
    };
    let mut told = 0.0;
    for channel in first.items()? {
        told += f64::from(channel.as_number()?) * Y_00 / (3.0 * PI);
    }
    let (mut sum, mut weights) = (0.0, 0.0);
    for (y, row) in environment
        .radiance
        .chunks_exact(environment.width as usize)
        .enumerate()
    {
        let weight = ((y as f64 + 0.5) * PI / f64::from(environment.height)).sin();
        let mean = |texel: &[f32; 3]| texel.iter().map(|&x| f64::from(x)).sum::<f64>() / 3.0;
        sum += weight * row.iter().map(mean).sum::<f64>();
        weights += weight * row.len() as f64;
    }
    let shown = sum / weights;
    if !(shown <= RATIO_MAX * told && told <= RATIO_MAX * shown) {
        notes.add(
            format!(
                "the irradiance coefficients are of a light of mean radiance {told:.3}, its images \
                 of {shown:.3}: the images light the scene"
            ),
            &light.at,
        );
    }
    Ok(())
}
