//! Animated files through the `gltf` crate's own readers, posed by other formulas: an independent
//! opinion on where nodes, joints and morphed vertices are at a time.

use crate::asset::{corpus, models};
use crate::oracle::buffers;
use glam::{DMat4, DQuat, DVec3, DVec4, Vec3};
use gltf::accessor::DataType;
use gltf::animation::{Interpolation, util::ReadOutputs};
use gltf::mesh::{Mode, Primitive};
use snell::gltf::{AnimationChoice, Asset, LoadOptions, Loaded, Moment};
use std::path::Path;

struct Posed {
    translation: DVec3,
    rotation: DQuat,
    scale: DVec3,
    matrix: Option<DMat4>,
    weights: Vec<f64>,
}

impl Posed {
    fn matrix(&self) -> DMat4 {
        self.matrix.unwrap_or_else(|| {
            DMat4::from_translation(self.translation)
                * DMat4::from_quat(self.rotation)
                * DMat4::from_scale(self.scale)
        })
    }
}

fn rest(node: &gltf::Node<'_>) -> Posed {
    let (translation, rotation, scale) = node.transform().decomposed();
    let mesh_weights = node
        .mesh()
        .and_then(|mesh| mesh.weights().map(<[f32]>::to_vec));
    let weights = node.weights().map(<[f32]>::to_vec).or(mesh_weights);
    Posed {
        translation: DVec3::from(translation.map(f64::from)),
        rotation: DQuat::from_array(rotation.map(f64::from)).normalize(),
        scale: DVec3::from(scale.map(f64::from)),
        matrix: match node.transform() {
            gltf::scene::Transform::Matrix { matrix } => {
                let columns = matrix.as_flattened().iter().map(|&v| f64::from(v));
                Some(DMat4::from_cols_slice(&columns.collect::<Vec<_>>()))
            }
            _ => None,
        },
        weights: weights
            .unwrap_or_default()
            .into_iter()
            .map(f64::from)
            .collect(),
    }
}

/// Splines by de Casteljau's construction, lines of quaternions by glam.
fn value(times: &[f32], values: &[DVec4], kind: Interpolation, turns: bool, t: f64) -> DVec4 {
    let spline = kind == Interpolation::CubicSpline;
    let key = |i: usize| if spline { values[3 * i + 1] } else { values[i] };
    let last = times.len() - 1;
    let next = times
        .iter()
        .position(|&time| f64::from(time) > t)
        .unwrap_or(last + 1);
    if next == 0 || next > last {
        return key(next.min(last + 1).saturating_sub(1));
    }
    let interval = f64::from(times[next] - times[next - 1]);
    let u = (t - f64::from(times[next - 1])) / interval;
    let (a, b) = (key(next - 1), key(next));
    match kind {
        Interpolation::Step => a,
        Interpolation::Linear if turns => {
            let (a, b) = (
                DQuat::from_vec4(a).normalize(),
                DQuat::from_vec4(b).normalize(),
            );
            a.slerp(b, u).into()
        }
        Interpolation::Linear => a.lerp(b, u),
        Interpolation::CubicSpline => {
            let third = interval / 3.0;
            let (c, d) = (
                a + values[3 * next - 1] * third,
                b - values[3 * next] * third,
            );
            let (ac, cd, db) = (a.lerp(c, u), c.lerp(d, u), d.lerp(b, u));
            ac.lerp(cd, u).lerp(cd.lerp(db, u), u)
        }
    }
}

fn pose(file: &gltf::Gltf, data: &[Vec<u8>], t: f64) -> Vec<Posed> {
    let mut posed: Vec<Posed> = file.nodes().map(|node| rest(&node)).collect();
    let Some(animation) = file.animations().next() else {
        return posed;
    };
    for channel in animation.channels() {
        let reader = channel.reader(|buffer| data.get(buffer.index()).map(Vec::as_slice));
        let times: Vec<f32> = reader.read_inputs().unwrap().collect();
        let kind = channel.sampler().interpolation();
        let node = &mut posed[channel.target().node().index()];
        let three = |v: [f32; 3]| DVec3::from(v.map(f64::from)).extend(0.0);
        match reader.read_outputs().unwrap() {
            ReadOutputs::Translations(values) => {
                let values: Vec<_> = values.map(three).collect();
                node.translation = value(&times, &values, kind, false, t).truncate();
            }
            ReadOutputs::Scales(values) => {
                let values: Vec<_> = values.map(three).collect();
                node.scale = value(&times, &values, kind, false, t).truncate();
            }
            ReadOutputs::Rotations(values) => {
                let values = values.into_f32().map(|v| DVec4::from(v.map(f64::from)));
                let values: Vec<_> = values.collect();
                let found = value(&times, &values, kind, true, t);
                node.rotation = DQuat::from_vec4(found).normalize();
            }
            ReadOutputs::MorphTargetWeights(values) => {
                let values: Vec<f64> = values.into_f32().map(f64::from).collect();
                let parts = if kind == Interpolation::CubicSpline {
                    3
                } else {
                    1
                };
                let count = values.len() / times.len() / parts;
                let of_target = |target: usize| {
                    let rows = values.chunks_exact(count);
                    rows.map(|row| DVec4::splat(row[target]))
                        .collect::<Vec<_>>()
                };
                node.weights = (0..count)
                    .map(|target| value(&times, &of_target(target), kind, false, t).x)
                    .collect();
            }
        }
    }
    posed
}

fn worlds(file: &gltf::Gltf, posed: &[Posed]) -> Vec<DMat4> {
    let mut worlds = vec![DMat4::IDENTITY; posed.len()];
    let mut children = vec![false; posed.len()];
    file.nodes().for_each(|node| {
        node.children()
            .for_each(|child| children[child.index()] = true)
    });
    let mut stack: Vec<_> = file
        .nodes()
        .filter(|node| !children[node.index()])
        .map(|node| (node, DMat4::IDENTITY))
        .collect();
    while let Some((node, parent)) = stack.pop() {
        let world = parent * posed[node.index()].matrix();
        worlds[node.index()] = world;
        stack.extend(node.children().map(|child| (child, world)));
    }
    worlds
}

/// Morphed and skinned, in the order of the file.
fn positions(
    primitive: &Primitive<'_>,
    data: &[Vec<u8>],
    weights: &[f64],
    joints: Option<&[DMat4]>,
) -> Option<Vec<DVec3>> {
    let float = |accessor: Option<gltf::Accessor<'_>>| {
        accessor.is_none_or(|accessor| accessor.data_type() == DataType::F32)
    };
    let targets = primitive.morph_targets();
    if !float(primitive.get(&gltf::Semantic::Positions))
        || !targets.clone().all(|t| float(t.positions()))
    {
        return None;
    }
    let reader = primitive.reader(|buffer| data.get(buffer.index()).map(Vec::as_slice));
    let place = |p: [f32; 3]| DVec3::from(p.map(f64::from));
    let mut positions: Vec<DVec3> = reader.read_positions()?.map(place).collect();
    for ((deltas, ..), weight) in reader.read_morph_targets().zip(weights) {
        for (position, delta) in positions.iter_mut().zip(deltas.into_iter().flatten()) {
            *position += *weight * place(delta);
        }
    }
    if let Some(joints) = joints {
        let sets = reader
            .read_joints(0)?
            .into_u16()
            .zip(reader.read_weights(0)?.into_f32());
        for (position, (indices, weights)) in positions.iter_mut().zip(sets) {
            let mut sum = DVec3::ZERO;
            let mut total = 0.0;
            for (joint, weight) in indices.into_iter().zip(weights) {
                let weight = f64::from(weight);
                sum += weight * joints[usize::from(joint)].transform_point3(*position);
                total += weight;
            }
            *position = sum / total;
        }
    }
    Some(positions)
}

fn near(a: DVec3, b: Vec3, size: f64, name: &str) {
    let error = (a - b.as_dvec3()).length();
    assert!(error < 2e-5 * size, "{name}: {a} is not {b}");
}

/// Compares all instances; says how many corners and how many matrices.
fn compare(loaded: &Loaded, file: &gltf::Gltf, data: &[Vec<u8>], t: f64, name: &str) -> [usize; 2] {
    let posed = pose(file, data, t);
    let worlds = worlds(file, &posed);
    let mut compared = [0, 0];
    let reach = loaded.scene.meshes.iter().flat_map(|mesh| &mesh.primitives);
    let reach = reach
        .flat_map(|p| &p.positions)
        .map(|p| f64::from(p.length()));
    let size = reach.fold(1.0, f64::max);
    for instance in &loaded.scene.instances {
        let node = file.nodes().nth(instance.node).unwrap();
        let skin = node.skin();
        if skin.is_none() {
            let world = worlds[instance.node];
            for p in [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z] {
                let ours = instance.world_from_object.transform_point3(p.as_vec3());
                let expected = world.transform_point3(p);
                near(expected, ours, 1.0 + expected.length(), name);
            }
            compared[1] += 1;
        }
        let joints: Option<Vec<DMat4>> = skin.map(|skin| {
            let reader = skin.reader(|buffer| data.get(buffer.index()).map(Vec::as_slice));
            let inverse: Vec<DMat4> = match reader.read_inverse_bind_matrices() {
                Some(all) => all
                    .map(|m| {
                        let columns = m.as_flattened().iter().map(|&v| f64::from(v));
                        DMat4::from_cols_slice(&columns.collect::<Vec<_>>())
                    })
                    .collect(),
                None => vec![DMat4::IDENTITY; skin.joints().count()],
            };
            skin.joints()
                .zip(inverse)
                .map(|(joint, inverse)| worlds[joint.index()] * inverse)
                .collect()
        });
        let ours = &loaded.scene.meshes[instance.mesh].primitives;
        let theirs: Vec<_> = node.mesh().unwrap().primitives().collect();
        if theirs.len() != ours.len() || theirs.iter().any(|one| one.mode() != Mode::Triangles) {
            continue;
        }
        for (theirs, ours) in theirs.iter().zip(ours) {
            let weights = &posed[instance.node].weights;
            let Some(positions) = positions(theirs, data, weights, joints.as_deref()) else {
                continue;
            };
            let reader = theirs.reader(|buffer| data.get(buffer.index()).map(Vec::as_slice));
            let indices: Vec<u32> = match reader.read_indices() {
                Some(indices) => indices.into_u32().collect(),
                None => (0..positions.len() as u32).collect(),
            };
            let (triangles, _) = indices.as_chunks::<3>();
            let whole = triangles
                .iter()
                .filter(|t| t[0] != t[1] && t[1] != t[2] && t[2] != t[0]);
            for (theirs, ours_at) in whole.zip(&ours.triangles) {
                for (a, b) in theirs.iter().zip(ours_at) {
                    near(
                        positions[*a as usize],
                        ours.positions[*b as usize],
                        size,
                        name,
                    );
                    compared[0] += 1;
                }
            }
        }
    }
    compared
}

#[test]
fn another_reader_poses_the_same_scenes() {
    let Some(corpus) = corpus() else {
        println!("NOT RUN: there is no corpus of models beside this checkout");
        return;
    };
    let mut total = [0, 0];
    let mut skinned = Vec::new();
    for path in models(&corpus) {
        let Ok(mut ours) = Asset::open(&path, &LoadOptions::default()) else {
            continue;
        };
        let Some(info) = ours.animations().into_iter().next() else {
            continue;
        };
        let bytes = std::fs::read(&path).unwrap();
        let Ok(file) = gltf::Gltf::from_slice_without_validation(&bytes) else {
            continue;
        };
        let compressed = file
            .extensions_required()
            .any(|name| name.ends_with("compression"));
        let Some(data) = buffers(&file, path.parent().unwrap()).filter(|_| !compressed) else {
            continue;
        };
        let name = path.display().to_string();
        for part in [-0.1, 0.0, 0.123, 0.5, 0.871, 1.0, 1.3] {
            let seconds = info.start + part * (info.end - info.start);
            let moment = Moment::At {
                animation: AnimationChoice::Index(0),
                seconds,
                shutter: 0.0,
            };
            let loaded = ours
                .scene(&moment)
                .unwrap_or_else(|error| panic!("{error}"));
            let found = compare(
                &loaded,
                &file,
                &data,
                seconds,
                &format!("{name} at {seconds}"),
            );
            total = [total[0] + found[0], total[1] + found[1]];
            if loaded.counts.skins > 0 && found[0] > 0 && part == 0.5 {
                skinned.push(path.file_name().unwrap().to_string_lossy().into_owned());
            }
        }
    }
    println!(
        "{} corners and {} matrices; skins: {skinned:?}",
        total[0], total[1]
    );
    assert!(total[0] > 100_000 && total[1] > 200, "{total:?}");
    for name in ["CesiumMan.glb", "RiggedSimple.glb"] {
        assert!(
            skinned
                .iter()
                .any(|file| Path::new(file) == Path::new(name)),
            "{skinned:?}"
        );
    }
}
