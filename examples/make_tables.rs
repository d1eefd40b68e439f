//! Writes src/tables/tables.bin: `cargo run --release --example make_tables`.

use std::path::Path;

fn main() -> std::io::Result<()> {
    let tables = snell::tables::integrate();
    let words: &[u32] = bytemuck::cast_slice(bytemuck::bytes_of(&*tables));
    let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
    std::fs::write(
        Path::new(env!("CARGO_MANIFEST_DIR")).join("src/tables/tables.bin"),
        bytes,
    )
}
