// Tracing rays through the two levels of hierarchies: instances, and the triangles of their meshes.

import package::shared::{NONE, TRIANGLE_ALPHA, TRIANGLE_CULLED};
import package::bindings::{frame, triangles};
import package::ray::{Ray, Hit};
import package::intersect::{local_ray, intersect_node, intersect_triangle};
import package::alpha::{is_visible};
import package::variant::{INSTANCES, TEST_ALPHA, DEFERS_ALPHA};
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
    var instance = 0u; // also the only one, if there is but one
    var first_triangle = 0u;
    var local = local_ray(ray.origin, ray.direction);
    var inner = vec2<u32>(frame.mesh_root, 0x80000000u);
    if INSTANCES {
        inner.x = frame.root;
    }
    var leaves = vec2<u32>(0u);
    var candidate = hit;
    // A driver that carries out every branch for all lanes would look up alpha for every triangle. So a ray
    // leaves the traversal with a candidate, and goes on where it was once that has been decided.
    loop {
        var waits = false; // for the candidate's alpha
        var done = false;
        loop {
            // What is left of a node's triangles behind a candidate comes first.
            if !DEFERS_ALPHA || leaves.y == 0u {
                // Only the top level's primitives wait on the stack.
                if !INSTANCES || inner.y > 0x00ffffffu {
                    let place = firstLeadingBit(inner.y);
                    let slot = (place - 24u) ^ local.octant;
                    let child = inner.x + countOneBits(inner.y & 0xffu & ~(0xffffffffu << slot));
                    inner.y &= ~(1u << place);
                    // Stored in any case: a driver that stores lane by lane can foresee that, and not which lanes
                    // have something left.
                    stack[stack_size] = inner;
                    stack_size += select(0u, 1u, inner.y > 0x00ffffffu);
                    let met = intersect_node(local, ray.t_min, hit.t, child);
                    inner = met.inner;
                    leaves = met.leaves;
                } else {
                    leaves = inner;
                    inner = vec2<u32>(0u);
                }
            }
            if INSTANCES && mesh_floor == NONE {
                if leaves.y != 0u {
                    // Into an instance; what is left here waits on the stack.
                    let place = firstLeadingBit(leaves.y);
                    leaves.y &= ~(1u << place);
                    stack[stack_size] = inner;
                    stack_size += select(0u, 1u, inner.y > 0x00ffffffu);
                    stack[stack_size] = leaves;
                    stack_size += select(0u, 1u, leaves.y != 0u);
                    mesh_floor = stack_size;
                    instance = leaves.x + place;
                    let entered = instance_at(instance, ray.time);
                    let rows = entered.world_from_object;
                    let N = normal_matrix(rows);
                    // The translation first: near the instance little is left to round.
                    let origin = ray.origin - transform_translation(rows);
                    local = local_ray(vector_in_object(rows, N, origin), vector_in_object(rows, N, ray.direction));
                    first_triangle = entered.first_triangle;
                    inner = vec2<u32>(entered.root, 0x80000000u);
                    leaves.y = 0u;
                }
            } else if leaves.y != 0u {
                // Asked at the end: llvmpipe goes through a loop once more than any lane asks for.
                loop {
                    let place = firstLeadingBit(leaves.y);
                    leaves.y &= ~(1u << place);
                    let index = first_triangle + leaves.x + place;
                    let triangle = triangles[index];
                    let found = intersect_triangle(local, triangle);
                    if found.hit != 0u && found.t > ray.t_min && found.t < hit.t
                        && (found.front != 0u || (triangle.flags & TRIANGLE_CULLED) == 0u) {
                        candidate = Hit(found.t, found.u, found.v, instance, index);
                        let decided = !TEST_ALPHA || (triangle.flags & TRIANGLE_ALPHA) == 0u;
                        if DEFERS_ALPHA && !decided {
                            waits = true;
                            break;
                        }
                        let barycentrics = vec2<f32>(found.u, found.v);
                        if decided || (!DEFERS_ALPHA && is_visible(index, instance, barycentrics, alpha_seed)) {
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
                    local = local_ray(ray.origin, ray.direction);
                }
                stack_size -= 1u;
                inner = stack[stack_size];
            }
            if DEFERS_ALPHA && waits {
                break;
            }
        }
        if !DEFERS_ALPHA {
            break;
        }
        let barycentrics = vec2<f32>(candidate.u, candidate.v);
        if waits && is_visible(candidate.triangle, candidate.instance, barycentrics, alpha_seed) {
            hit = candidate;
            done = done || any;
        }
        if done {
            break;
        }
    }
    return hit;
}
