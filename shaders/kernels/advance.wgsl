// Between the stages: turns the queues' lengths into the next dispatches' sizes, so that the host
// need not wait to learn them.

import package::bindings::{frame};
import package::kernels::state::{counters, COUNTER_PATHS, COUNTER_SHADOW, COUNTER_TURN, COUNTER_CLOSEST_RAYS, COUNTER_SHADOW_RAYS, COUNTER_CLASSES, WORKGROUP};
import package::shared::{CLASSES};

// Arguments of dispatch_workgroups_indirect: trace closest, trace shadow, then shading
// by class.
@group(1) @binding(2) var<storage, read_write> arguments: array<u32>;

fn set_arguments(first: u32, count: u32) {
    arguments[first] = (count + WORKGROUP - 1u) / WORKGROUP;
    arguments[first + 1u] = 1u;
    arguments[first + 2u] = 1u;
}

// Before the first bounce: all slots are in queue x, which is read first.
@compute @workgroup_size(1)
fn advance_start() {
    atomicStore(&counters[COUNTER_PATHS], frame.capacity);
    atomicStore(&counters[COUNTER_PATHS + 1u], 0u);
    atomicStore(&counters[COUNTER_TURN], 1u);
}

// Before each bounce: the queue that was written is read, the other is emptied.
@compute @workgroup_size(1)
fn advance_bounce() {
    let turn = 1u - atomicLoad(&counters[COUNTER_TURN]);
    atomicStore(&counters[COUNTER_TURN], turn);
    atomicStore(&counters[COUNTER_PATHS + 1u - turn], 0u);
    atomicStore(&counters[COUNTER_SHADOW], 0u);
    let count = atomicLoad(&counters[COUNTER_PATHS + turn]);
    atomicAdd(&counters[COUNTER_CLOSEST_RAYS], count);
    set_arguments(0u, count);
    for (var shading_class = 0u; shading_class < CLASSES; shading_class++) {
        atomicStore(&counters[COUNTER_CLASSES + shading_class], 0u);
    }
}

// Before the surfaces of a bounce are shaded.
@compute @workgroup_size(1)
fn advance_shade() {
    for (var shading_class = 0u; shading_class < CLASSES; shading_class++) {
        set_arguments(8u + 4u * shading_class, atomicLoad(&counters[COUNTER_CLASSES + shading_class]));
    }
}

// Before the shadow rays of a bounce.
@compute @workgroup_size(1)
fn advance_shadow() {
    let count = atomicLoad(&counters[COUNTER_SHADOW]);
    atomicAdd(&counters[COUNTER_SHADOW_RAYS], count);
    set_arguments(4u, count);
}
