// Which pixel and sample a slot stands for, and back. The samples that count for a tile are those of its pixels
// and of a frame of FILTER_REACH pixels around it. Slots run through 8 x 8 blocks of these, so that neighbours in
// a workgroup see alike scenes; the last blocks of a row or column may be narrower.

import package::bindings::{frame};
import package::filter::{FILTER_REACH};

const BLOCK: u32 = 8u;

// The tile with the frame around it, pixels.
fn sampled_size() -> vec2<u32> {
    return frame.tile_size + 2u * FILTER_REACH;
}

// Slots of one sample of all these pixels.
fn sampled_slots() -> u32 {
    let size = sampled_size();
    return size.x * size.y;
}

// (x, y) from the frame's corner, running number of the sample in this dispatch. Slots go through rows of
// blocks; the last blocks of a row and of the whole may be narrower than BLOCK.
fn slot_pixel(slot: u32) -> vec3<u32> {
    let size = sampled_size();
    let sample = slot / sampled_slots();
    let index = slot % sampled_slots();
    let row = index / (size.x * BLOCK);
    let rows = min(BLOCK, size.y - row * BLOCK);
    let in_row = index - row * size.x * BLOCK;
    let column = in_row / (BLOCK * rows);
    let columns = min(BLOCK, size.x - column * BLOCK);
    let in_block = in_row - column * BLOCK * rows;
    return vec3(column * BLOCK + in_block % columns, row * BLOCK + in_block / columns, sample);
}

// Slot of a pixel, (x, y) from the frame's corner, in the dispatch's first sample: the inverse of slot_pixel.
fn pixel_slot(pixel: vec2<u32>) -> u32 {
    let size = sampled_size();
    let block = pixel / BLOCK;
    let block_size = min(vec2(BLOCK), size - block * BLOCK);
    let within = pixel - block * BLOCK;
    return block.y * BLOCK * size.x + block.x * BLOCK * block_size.y + within.y * block_size.x + within.x;
}
