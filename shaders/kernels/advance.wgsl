// Between the stages: turns the queues' lengths into the next dispatches' sizes, so that the host
// need not wait to learn them.

import package::bindings::{frame};
import package::kernels::state::{counters, COUNTER_PATHS, COUNTER_SHADOW, COUNTER_TURN, COUNTER_CLOSEST_RAYS, COUNTER_SHADOW_RAYS, WORKGROUP};

// Arguments of dispatch_workgroups_indirect: path stages, then the shadow stage.
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
}

// Before the shadow rays of a bounce.
@compute @workgroup_size(1)
fn advance_shadow() {
    let count = atomicLoad(&counters[COUNTER_SHADOW]);
    atomicAdd(&counters[COUNTER_SHADOW_RAYS], count);
    set_arguments(4u, count);
}
