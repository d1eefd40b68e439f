//! What stands still, as one mesh in world space under one hierarchy: a ray then goes through no boxes
//! that overlap because one was put around each mesh, and is taken into no other space.

use super::geometry::{KnownMeshes, is_invertible, to_f64, transform_bounds};
use super::mesh::{self, PackedMesh};
use super::vertex;
use crate::bvh::Bounds;
use crate::scene::{Instance, Mesh, Primitive, Scene};
use glam::{Affine3A, DAffine3, DVec3, Vec4};
use rayon::prelude::*;
use std::sync::{Arc, Weak};

/// Triangles that copies may add, beyond one of each mesh. As many take about 40 MB and a tenth of a second to
/// build; scenes that are made of copies stay at the size of their meshes.
const MAX_ADDED: usize = 1 << 18;

/// Sizes, in metres, at which products of three lengths are far from both ends of float32's range.
const SIZE_RANGE: (f64, f64) = (1e-6, 1e6);

/// How far from the origin a mesh may be, in lengths of its triangles' edges: rounding to float32 there
/// moves a corner by no more than 2^-9 of an edge.
const REACH_IN_EDGES: f64 = 65536.0;

/// Or else how many times further than it is from its own origin, in sizes of itself: what is lost by
/// so much is two bits.
const REACH_GAIN: f64 = 4.0;

/// What was baked last, for the next picture.
pub struct KnownBake {
    /// Address and place of each part. An address is not given to another mesh while a `Weak` is left.
    parts: Vec<(Weak<Mesh>, Affine3A)>,
    /// Of the parts' vertices, as far as they follow from materials.
    layouts: Vec<u32>,
    packed: Option<Arc<PackedMesh>>,
}

/// The numbers of the instances to bake: of those that stand still in this picture and in the next,
/// all if their copies add few triangles, else those whose mesh is placed once.
pub fn choose(scene: &Scene) -> Vec<usize> {
    let mut placed = vec![0_usize; scene.meshes.len()];
    for instance in &scene.instances {
        placed[instance.mesh] += 1;
    }
    let shapes: Vec<Shape> = scene
        .meshes
        .par_iter()
        .zip(&placed)
        .map(|(mesh, placed)| match placed {
            0 => Shape::NOTHING,
            _ => Shape::of(mesh),
        })
        .collect();
    let mut chosen: Vec<usize> = (0..scene.instances.len())
        .into_par_iter()
        .filter(|&number| {
            let instance = &scene.instances[number];
            shapes[instance.mesh].keeps_its_shape(instance)
        })
        .collect();
    let all: usize = chosen
        .iter()
        .map(|&number| shapes[scene.instances[number].mesh].triangles)
        .sum();
    let placed_meshes = shapes
        .iter()
        .zip(&placed)
        .filter(|(_, placed)| **placed > 0);
    let once: usize = placed_meshes.map(|(shape, _)| shape.triangles).sum();
    if all > once + MAX_ADDED {
        chosen.retain(|&number| placed[scene.instances[number].mesh] == 1);
    }
    // One alone gains nothing beside others, or if it is where it would be put.
    match *chosen {
        [one] if scene.instances.len() > 1 || is_identity(&scene.instances[one]) => Vec::new(),
        _ => chosen,
    }
}

/// The mesh of the chosen instances. `None`: none were chosen, or it does not fit a hierarchy or the
/// indices, as smaller ones may.
pub fn pack_baked(
    scene: &Scene,
    chosen: &[usize],
    known: Option<&mut KnownMeshes>,
) -> Option<Arc<PackedMesh>> {
    let instances = chosen.iter().map(|&number| &scene.instances[number]);
    let parts: Vec<(&Arc<Mesh>, Affine3A)> = instances
        .map(|instance| (&scene.meshes[instance.mesh], instance.world_from_object))
        .collect();
    let layouts: Vec<u32> = parts
        .iter()
        .flat_map(|(mesh, _)| vertex::layouts(mesh, scene))
        .collect();
    let before = known.as_ref().and_then(|known| known.baked.as_ref());
    if let Some(before) = before.filter(|before| before.is_of(&parts, &layouts)) {
        return before.packed.clone();
    }
    let packed = bake(&parts, scene).map(Arc::new);
    if let Some(known) = known {
        known.new += usize::from(packed.is_some());
        let parts = parts.iter();
        known.baked = Some(KnownBake {
            parts: parts
                .map(|(mesh, transform)| (Arc::downgrade(mesh), *transform))
                .collect(),
            layouts,
            packed: packed.clone(),
        });
    }
    packed
}

impl KnownBake {
    fn is_of(&self, parts: &[(&Arc<Mesh>, Affine3A)], layouts: &[u32]) -> bool {
        self.layouts == layouts
            && self.parts.len() == parts.len()
            && self
                .parts
                .iter()
                .zip(parts)
                .all(|(known, part)| known.0.as_ptr() == Arc::as_ptr(part.0) && known.1 == part.1)
    }
}

fn bake(parts: &[(&Arc<Mesh>, Affine3A)], scene: &Scene) -> Option<PackedMesh> {
    let primitives = parts
        .par_iter()
        .flat_map_iter(|(mesh, transform)| mesh.primitives.iter().map(move |p| (p, *transform)))
        .map(|(primitive, transform)| in_world(primitive, to_f64(&transform)))
        .collect();
    let mesh = Mesh {
        name: "all that stands still".to_owned(),
        primitives,
    };
    mesh::pack_mesh(&mesh, scene).ok().flatten()
}

/// A primitive as its instance shows it. Mirrored, its triangles' corners go the other way round, so that
/// the front stays in front (glTF 2.0 section 3.7.4), and bitangents change sides.
fn in_world(primitive: &Primitive, world_from_object: DAffine3) -> Primitive {
    let matrix = world_from_object.matrix3;
    let normal_matrix = matrix.inverse().transpose();
    let mirrored = matrix.determinant() < 0.0;
    let position = |p: &glam::Vec3| world_from_object.transform_point3(p.as_dvec3()).as_vec3();
    let unit = |v: DVec3| v.normalize_or_zero().as_vec3();
    let tangent =
        |t: &Vec4| unit(matrix * t.truncate().as_dvec3()).extend(if mirrored { -t.w } else { t.w });
    let turned = |&[a, b, c]: &[u32; 3]| if mirrored { [a, c, b] } else { [a, b, c] };
    Primitive {
        positions: primitive.positions.par_iter().map(position).collect(),
        normals: primitive
            .normals
            .par_iter()
            .map(|n| unit(normal_matrix * n.as_dvec3()))
            .collect(),
        tangents: primitive
            .tangents
            .as_ref()
            .map(|tangents| tangents.par_iter().map(tangent).collect()),
        colors: primitive.colors.clone(),
        texcoords: primitive.texcoords.clone(),
        triangles: primitive.triangles.par_iter().map(turned).collect(),
        material: primitive.material,
    }
}

/// What decides whether a mesh may be put elsewhere.
struct Shape {
    bounds: Bounds,
    triangles: usize,
}

impl Shape {
    const NOTHING: Self = Self {
        bounds: Bounds::EMPTY,
        triangles: 0,
    };

    fn of(mesh: &Mesh) -> Self {
        let primitives = mesh.primitives.iter();
        primitives.fold(Self::NOTHING, |all, primitive| {
            let corners = primitive.triangles.iter().flatten();
            let points = corners.map(|&corner| primitive.positions[corner as usize].into());
            Self {
                bounds: all.bounds.union(Bounds::of_points(points)),
                triangles: all.triangles + primitive.triangles.len(),
            }
        })
    }

    /// Whether an instance stands still and loses next to nothing when its corners are rounded where it
    /// stands. What is left out has its own hierarchy, or its own error.
    fn keeps_its_shape(&self, instance: &Instance) -> bool {
        let transform = to_f64(&instance.world_from_object);
        if instance.animated
            || !instance.motion.is_empty()
            || self.triangles == 0
            || !is_invertible(transform)
        {
            return false;
        }
        let measure = |bounds: Bounds| {
            let size = (bounds.max.as_dvec3() - bounds.min.as_dvec3()).max_element();
            let reach = bounds.min.abs().max(bounds.max.abs()).max_element();
            (size, f64::from(reach) / size)
        };
        let (size, reach) = measure(transform_bounds(transform, self.bounds));
        let (_, own_reach) = measure(self.bounds);
        let edges_across = (self.triangles as f64).sqrt();
        (SIZE_RANGE.0..=SIZE_RANGE.1).contains(&size)
            && (reach * edges_across <= REACH_IN_EDGES || reach <= REACH_GAIN * own_reach)
    }
}

/// Whether a mesh stands in the world as it is.
pub fn is_identity(instance: &Instance) -> bool {
    instance.motion.is_empty() && instance.world_from_object == Affine3A::IDENTITY
}
