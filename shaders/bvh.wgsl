// Tracing rays through the two levels of hierarchies: instances, and the triangles of their meshes.

import package::shared::{NONE, TRIANGLE_ALPHA, TRIANGLE_CULLED};
import package::bindings::{frame, triangles};
import package::ray::{Ray, Hit};
import package::intersect::{LocalRay, local_ray, intersect_node, intersect_triangle};
import package::alpha::{is_visible};
import package::variant::{INSTANCES, TEST_ALPHA, DEFERS_ALPHA, DEFERS_ENTRY};
import package::transform::{instance_at, normal_matrix, transform_translation, vector_in_object};

// Entries of the stack; the host builds no hierarchies that need more (src/bvh.rs).
const STACK_SIZE: u32 = 32u;

// The nearest visible hit.
fn trace_closest(ray: Ray, alpha_seed: u32) -> Hit {
    return trace(ray, alpha_seed, false);
}

// Whether anything visible is hit.
fn trace_any(ray: Ray, alpha_seed: u32) -> bool {
    return trace(ray, alpha_seed, true).instance != NONE;
}

// The hierarchy that a ray is in, and the ray in its space.
struct Entered {
    local: LocalRay,
    instance: u32, // also the only one, if there is but one
    first_triangle: u32,
}

// Into the first of the instances `leaves`; what is left there and in `inner` waits on the stack.
fn enter(
    ray: Ray, inner: ptr<function, vec2<u32>>, leaves: ptr<function, vec2<u32>>,
    stack: ptr<function, array<vec2<u32>, STACK_SIZE>>, stack_size: ptr<function, u32>,
) -> Entered {
    let place = firstLeadingBit((*leaves).y);
    let number = (*leaves).x + place;
    (*leaves).y &= ~(1u << place);
    (*stack)[*stack_size] = *inner;
    *stack_size += select(0u, 1u, (*inner).y > 0x00ffffffu);
    (*stack)[*stack_size] = *leaves;
    *stack_size += select(0u, 1u, (*leaves).y != 0u);
    let instance = instance_at(number, ray.time);
    *inner = vec2<u32>(instance.root, 0x80000000u);
    (*leaves).y = 0u;
    let rows = instance.world_from_object;
    let N = normal_matrix(rows);
    // The translation first: near the instance little is left to round.
    let origin = ray.origin - transform_translation(rows);
    let local = local_ray(vector_in_object(rows, N, origin), vector_in_object(rows, N, ray.direction));
    return Entered(local, number, instance.first_triangle);
}

// The nearest visible hit, or the first that is found. In a miss, `t` is the ray's t_max.
//
// Ylitie, Karras and Laine 2017, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide
// BVHs", algorithm 1, for both levels in one loop. A group is the index of a first child and a mask:
// inner children in bits 24 to 31 (bits 0 to 7 then tell which slots are inner ones), or primitives
// in bits 0 to 23.
fn trace(ray: Ray, alpha_seed: u32, any: bool) -> Hit {
    var hit = Hit(ray.t_max, 0.0, 0.0, NONE, NONE);
    if INSTANCES && frame.root == NONE {
        return hit;
    }
    var stack: array<vec2<u32>, STACK_SIZE>;
    var stack_size = 0u;
    var mesh_floor = NONE; // stack size at which the mesh is done; NONE: at the top level
    var entered = Entered(local_ray(ray.origin, ray.direction), 0u, 0u);
    var inner = vec2<u32>(frame.mesh_root, 0x80000000u);
    if INSTANCES {
        inner.x = frame.root;
    }
    var leaves = vec2<u32>(0u);
    var candidate = hit;
    // A driver that carries out every branch for all lanes would look up alpha for every triangle, and enter an
    // instance at every node. So a ray leaves the traversal with a candidate or an instance, and goes on where it
    // was once that has been decided or entered.
    loop {
        var waits = false; // for the candidate's alpha
        var enters = false; // an instance, the next of `leaves`
        var done = false;
        loop {
            // What is left of a node's triangles behind a candidate comes first.
            if !DEFERS_ALPHA || leaves.y == 0u {
                // Only the top level's primitives wait on the stack.
                if !INSTANCES || inner.y > 0x00ffffffu {
                    let place = firstLeadingBit(inner.y);
                    let slot = (place - 24u) ^ entered.local.octant;
                    let child = inner.x + countOneBits(inner.y & 0xffu & ~(0xffffffffu << slot));
                    inner.y &= ~(1u << place);
                    // Stored in any case: a driver that stores lane by lane can foresee that, and not which lanes
                    // have something left.
                    stack[stack_size] = inner;
                    stack_size += select(0u, 1u, inner.y > 0x00ffffffu);
                    let met = intersect_node(entered.local, ray.t_min, hit.t, child);
                    inner = met.inner;
                    leaves = met.leaves;
                } else {
                    leaves = inner;
                    inner = vec2<u32>(0u);
                }
            }
            if INSTANCES && mesh_floor == NONE {
                if leaves.y != 0u {
                    if DEFERS_ENTRY {
                        enters = true;
                        break;
                    }
                    entered = enter(ray, &inner, &leaves, &stack, &stack_size);
                    mesh_floor = stack_size;
                }
            } else if leaves.y != 0u {
                // Asked at the end: llvmpipe goes through a loop once more than any lane asks for.
                loop {
                    let place = firstLeadingBit(leaves.y);
                    leaves.y &= ~(1u << place);
                    let index = entered.first_triangle + leaves.x + place;
                    let triangle = triangles[index];
                    let found = intersect_triangle(entered.local, triangle);
                    if found.hit != 0u && found.t > ray.t_min && found.t < hit.t
                        && (found.front != 0u || (triangle.flags & TRIANGLE_CULLED) == 0u) {
                        candidate = Hit(found.t, found.u, found.v, entered.instance, index);
                        let decided = !TEST_ALPHA || (triangle.flags & TRIANGLE_ALPHA) == 0u;
                        if DEFERS_ALPHA && !decided {
                            waits = true;
                            break;
                        }
                        let barycentrics = vec2<f32>(found.u, found.v);
                        if decided || (!DEFERS_ALPHA && is_visible(index, entered.instance, barycentrics, alpha_seed)) {
                            hit = candidate;
                            if any {
                                return hit;
                            }
                        }
                    }
                    if leaves.y == 0u {
                        break;
                    }
                }
            }
            if (!DEFERS_ALPHA || leaves.y == 0u) && inner.y <= 0x00ffffffu {
                if stack_size == 0u {
                    done = true;
                    break;
                }
                if INSTANCES && stack_size == mesh_floor {
                    mesh_floor = NONE;
                    entered.local = local_ray(ray.origin, ray.direction);
                }
                stack_size -= 1u;
                inner = stack[stack_size];
            }
            if DEFERS_ALPHA && waits {
                break;
            }
        }
        if !DEFERS_ENTRY && !DEFERS_ALPHA {
            break;
        }
        if DEFERS_ENTRY && enters {
            entered = enter(ray, &inner, &leaves, &stack, &stack_size);
            mesh_floor = stack_size;
        }
        let barycentrics = vec2<f32>(candidate.u, candidate.v);
        if DEFERS_ALPHA && waits && is_visible(candidate.triangle, candidate.instance, barycentrics, alpha_seed) {
            hit = candidate;
            done = done || any;
        }
        if done {
            break;
        }
    }
    return hit;
}
