//! Tracing rays through the two levels of hierarchies: instances, and the triangles of their meshes.

use super::alpha::is_visible;
use super::intersect::{LocalRay, intersect_node, intersect_triangle, local_ray};
use super::ray::{Hit, Ray};
use super::transform::{instance_at, normal_matrix, transform_translation, vector_in_object};
use crate::bvh::STACK_SIZE;
use crate::pack::Packed;
use crate::shared::{NONE, TRIANGLE_ALPHA, TRIANGLE_CULLED};
use glam::{DVec2, UVec2};

/// The nearest visible hit.
pub fn trace_closest(packed: &Packed, ray: Ray, alpha_seed: u32) -> Hit {
    pulp::Arch::new().dispatch(Trace {
        packed,
        ray,
        alpha_seed,
        any: false,
    })
}

/// Whether anything visible is hit.
pub fn trace_any(packed: &Packed, ray: Ray, alpha_seed: u32) -> bool {
    let query = Trace {
        packed,
        ray,
        alpha_seed,
        any: true,
    };
    pulp::Arch::new().dispatch(query).instance != NONE
}

/// The arguments of `trace`, which is compiled for each width of vectors.
struct Trace<'a> {
    packed: &'a Packed,
    ray: Ray,
    alpha_seed: u32,
    any: bool,
}

impl pulp::WithSimd for Trace<'_> {
    type Output = Hit;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) -> Hit {
        trace(self.packed, self.ray, self.alpha_seed, self.any)
    }
}

/// The hierarchy that a ray is in, and the ray in its space.
struct Entered {
    local: LocalRay,
    /// Also the only one, if there is but one.
    instance: u32,
    first_triangle: u32,
}

/// Into the first of the instances `leaves`; what is left there and in `inner` waits on the stack.
#[inline(always)]
fn enter(
    packed: &Packed,
    ray: Ray,
    inner: &mut UVec2,
    leaves: &mut UVec2,
    stack: &mut [UVec2; STACK_SIZE],
    stack_size: &mut usize,
) -> Entered {
    let place = 31 - leaves.y.leading_zeros();
    let number = leaves.x + place;
    leaves.y &= !(1 << place);
    if inner.y > 0x00ff_ffff {
        stack[*stack_size] = *inner;
        *stack_size += 1;
    }
    if leaves.y != 0 {
        stack[*stack_size] = *leaves;
        *stack_size += 1;
    }
    let instance = instance_at(packed, number, ray.time);
    *inner = UVec2::new(instance.root, 0x8000_0000);
    leaves.y = 0;
    let rows = instance.world_from_object;
    let N = normal_matrix(rows);
    let origin = ray.origin - transform_translation(rows);
    Entered {
        local: local_ray(
            vector_in_object(rows, N, origin),
            vector_in_object(rows, N, ray.direction),
        ),
        instance: number,
        first_triangle: instance.first_triangle,
    }
}

/// The nearest visible hit, or the first that is found. In a miss, `t` is the ray's `t_max`.
#[inline(always)]
pub fn trace(packed: &Packed, ray: Ray, alpha_seed: u32, any: bool) -> Hit {
    if packed.frame.mesh_root == 0 {
        trace_levels::<true>(packed, ray, alpha_seed, any)
    } else {
        trace_levels::<false>(packed, ray, alpha_seed, any)
    }
}

/// `INSTANCES`: there is more than one mesh that stands in the world as it is.
// cpu only: the shader's constants are the pipeline's.
#[inline(always)]
fn trace_levels<const INSTANCES: bool>(
    packed: &Packed,
    ray: Ray,
    alpha_seed: u32,
    any: bool,
) -> Hit {
    // Ylitie, Karras and Laine 2017, "Efficient Incoherent Ray Traversal on GPUs Through Compressed
    // Wide BVHs", algorithm 1, for both levels in one loop. A group is the index of a first child and
    // a mask: inner children in bits 24 to 31 (bits 0 to 7 then tell which slots are inner ones), or
    // primitives in bits 0 to 23.
    let mut hit = Hit {
        t: ray.t_max,
        u: 0.0,
        v: 0.0,
        instance: NONE,
        triangle: NONE,
    };
    if INSTANCES && packed.frame.root == NONE {
        return hit;
    }
    let mut stack = [UVec2::ZERO; STACK_SIZE];
    let mut stack_size = 0;
    // Stack size at which the mesh is done, while in one.
    let mut mesh_floor = None;
    let mut entered = Entered {
        local: local_ray(ray.origin, ray.direction),
        instance: 0,
        first_triangle: 0,
    };
    let mut inner = UVec2::new(packed.frame.mesh_root, 0x8000_0000);
    if INSTANCES {
        inner.x = packed.frame.root;
    }
    loop {
        let mut leaves;
        // Only the top level's primitives wait on the stack.
        if !INSTANCES || inner.y > 0x00ff_ffff {
            let place = 31 - inner.y.leading_zeros();
            let slot = (place - 24) ^ entered.local.octant;
            let child = inner.x + (inner.y & 0xff & !(u32::MAX << slot)).count_ones();
            inner.y &= !(1 << place);
            if inner.y > 0x00ff_ffff {
                stack[stack_size] = inner;
                stack_size += 1;
            }
            let met = intersect_node(packed, &entered.local, ray.t_min, hit.t, child);
            inner = met.inner;
            leaves = met.leaves;
        } else {
            leaves = inner;
            inner = UVec2::ZERO;
        }
        if INSTANCES && mesh_floor.is_none() {
            if leaves.y != 0 {
                entered = enter(
                    packed,
                    ray,
                    &mut inner,
                    &mut leaves,
                    &mut stack,
                    &mut stack_size,
                );
                mesh_floor = Some(stack_size);
            }
        } else {
            while leaves.y != 0 {
                let place = 31 - leaves.y.leading_zeros();
                leaves.y &= !(1 << place);
                let index = entered.first_triangle + leaves.x + place;
                let triangle = &packed.triangles[index as usize];
                let found = intersect_triangle(&entered.local, triangle);
                let barycentrics = DVec2::new(found.u, found.v);
                if found.hit
                    && found.t > ray.t_min
                    && found.t < hit.t
                    && (found.front || triangle.flags & TRIANGLE_CULLED == 0)
                    && (triangle.flags & TRIANGLE_ALPHA == 0
                        || is_visible(packed, index, entered.instance, barycentrics, alpha_seed))
                {
                    hit = Hit {
                        t: found.t,
                        u: found.u,
                        v: found.v,
                        instance: entered.instance,
                        triangle: index,
                    };
                    if any {
                        return hit;
                    }
                }
            }
        }
        if inner.y <= 0x00ff_ffff {
            if stack_size == 0 {
                return hit;
            }
            if INSTANCES && mesh_floor == Some(stack_size) {
                mesh_floor = None;
                entered.local = local_ray(ray.origin, ray.direction);
            }
            stack_size -= 1;
            inner = stack[stack_size];
        }
    }
}
