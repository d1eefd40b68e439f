//! What kernels may take for granted of a scene (`gpu::variant`). It is told before meshes and their hierarchies are
//! packed, so that kernels can be compiled meanwhile, and found again in what was packed, which is what counts.

use super::light_tree::TREE_LIGHTS_MIN;
use super::lights::is_infinite;
use super::vertex::Layout;
use super::{Packed, bake, geometry};
use crate::scene::{Instance, Scene};
use crate::shared::{
    Camera, LIGHT_CLUSTER, LIGHT_ENVIRONMENT, LIGHT_TRIANGLE, Light, MATERIAL_EMISSIVE, Material,
    Triangle,
};
use std::collections::BTreeSet;

#[derive(Clone, Debug, PartialEq)]
pub struct Outline {
    /// In the order of all materials, those that some triangle has.
    pub materials: Vec<Material>,
    /// The `Triangle.vertex_layout`s that there are.
    pub layouts: BTreeSet<u32>,
    pub camera: Camera,
    /// Bit `1 << LIGHT_*` for each kind that is there.
    pub light_kinds: u32,
    /// There are more than one to choose from.
    pub many_lights: bool,
    pub light_tree: bool,
    pub environment: bool,
    /// Meshes stand in spaces of their own, under a hierarchy over them.
    pub two_levels: bool,
    /// Something does while the shutter is open.
    pub moves: bool,
}

impl Outline {
    pub fn of(packed: &Packed) -> Self {
        let mut used = vec![false; packed.materials.len()];
        for triangle in &packed.triangles {
            used[triangle.material as usize] = true;
        }
        let alike = |a: &Triangle, b: &Triangle| a.vertex_layout == b.vertex_layout;
        let frame = &packed.frame;
        Self {
            materials: keep(&packed.materials, &used),
            layouts: (packed.triangles.chunk_by(alike))
                .map(|run| run[0].vertex_layout)
                .collect(),
            camera: frame.camera,
            light_kinds: kinds(&packed.lights),
            many_lights: packed.lights.len() > 1,
            light_tree: frame.light_tree_leaves != 0,
            environment: frame.environment_strength != 0.0,
            two_levels: frame.mesh_root == 0,
            moves: packed.moves(),
        }
    }

    /// What `of` will most probably find: triangles without area, maps without light and hierarchies that are too
    /// deep for one level are not looked for. `baked`: the numbers of the instances that become one mesh;
    /// `punctual`: the lights that are not of the meshes or the environment.
    pub fn foresee(
        scene: &Scene,
        materials: &[Material],
        camera: Camera,
        punctual: &[Light],
        baked: &[usize],
    ) -> Self {
        let mut apart = vec![true; scene.instances.len()];
        baked.iter().for_each(|&number| apart[number] = false);
        let placed: Vec<(&Instance, bool)> = (scene.instances.iter().zip(apart))
            .filter(|(instance, _)| geometry::is_placed(instance))
            .filter(|(instance, _)| scene.meshes[instance.mesh].triangle_count() > 0)
            .collect();
        let mut used = vec![false; materials.len()];
        let mut glowing = 0;
        let mut meshes = BTreeSet::new();
        for (instance, _) in &placed {
            meshes.insert(instance.mesh);
            for primitive in &scene.meshes[instance.mesh].primitives {
                let triangles = primitive.triangles.len();
                used[primitive.material] |= triangles > 0;
                if materials[primitive.material].flags & MATERIAL_EMISSIVE != 0 {
                    glowing += triangles;
                }
            }
        }
        let environment = (scene.environment.as_ref()).is_some_and(|map| map.strength != 0.0);
        let finite = glowing + punctual.iter().filter(|light| !is_infinite(light)).count();
        let light_tree = finite >= TREE_LIGHTS_MIN;
        let bit = |there: bool, kind: u32| u32::from(there) << kind;
        let mut apart = placed.iter().filter(|(_, apart)| *apart);
        let one_level = match (baked, apart.next(), apart.next()) {
            ([], Some((one, _)), None) => bake::is_identity(one),
            (baked, first, _) => !baked.is_empty() && first.is_none(),
        };
        let primitives = meshes
            .iter()
            .flat_map(|&mesh| &scene.meshes[mesh].primitives);
        let layouts = primitives
            .filter(|primitive| !primitive.triangles.is_empty())
            .map(|primitive| Layout::of(primitive, scene).flags());
        Self {
            materials: keep(materials, &used),
            layouts: layouts.collect(),
            camera,
            light_kinds: kinds(punctual)
                | bit(glowing > 0, LIGHT_TRIANGLE)
                | bit(environment, LIGHT_ENVIRONMENT)
                | bit(light_tree, LIGHT_CLUSTER),
            many_lights: punctual.len() + glowing + usize::from(environment) > 1,
            light_tree,
            environment,
            two_levels: !one_level,
            moves: camera.moves != 0
                || placed
                    .iter()
                    .any(|(instance, _)| !instance.motion.is_empty()),
        }
    }
}

fn keep(materials: &[Material], used: &[bool]) -> Vec<Material> {
    let used = materials.iter().zip(used).filter(|(_, used)| **used);
    used.map(|(material, _)| *material).collect()
}

fn kinds(lights: &[Light]) -> u32 {
    lights.iter().fold(0, |all, light| all | 1 << light.kind)
}
