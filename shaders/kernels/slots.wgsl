// Which pixel and sample a slot stands for, and back. Slots run through 8 x 8 blocks of the tile, so
// that neighbours in a workgroup see alike scenes; the last blocks of a row or column may be narrower.

import package::bindings::{frame};

const BLOCK: u32 = 8u;

// Slots of one sample of the tile.
fn tile_slots() -> u32 {
    return frame.tile_size.x * frame.tile_size.y;
}

// (x, y) in the tile, running number of the sample in this dispatch. Slots go through rows of
// blocks; the last blocks of a row and of the tile may be narrower than BLOCK.
fn slot_pixel(slot: u32) -> vec3<u32> {
    let sample = slot / tile_slots();
    let index = slot % tile_slots();
    let row = index / (frame.tile_size.x * BLOCK);
    let rows = min(BLOCK, frame.tile_size.y - row * BLOCK);
    let in_row = index - row * frame.tile_size.x * BLOCK;
    let column = in_row / (BLOCK * rows);
    let columns = min(BLOCK, frame.tile_size.x - column * BLOCK);
    let in_block = in_row - column * BLOCK * rows;
    return vec3(column * BLOCK + in_block % columns, row * BLOCK + in_block / columns, sample);
}

// Slot of a pixel of the tile in the dispatch's first sample: the inverse of slot_pixel.
fn pixel_slot(pixel: vec2<u32>) -> u32 {
    let block = pixel / BLOCK;
    let size = min(vec2(BLOCK), frame.tile_size - block * BLOCK);
    let within = pixel - block * BLOCK;
    return block.y * BLOCK * frame.tile_size.x + block.x * BLOCK * size.y + within.y * size.x + within.x;
}
