//! Every .gltf and .glb file under a folder on one sheet, rendered in one process, each with its name below:
//! `cargo run --release --example contact_sheet -- FOLDER -o sheet.png`.
//!
//! A file that fails has a red cell with its sentence. One line a file goes to standard output; the exit
//! status is 1 where one failed.

use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use clap::Parser;
use plotters::prelude::*;
use plotters::style::register_font;
use snell::film::Film;
use snell::gltf::{Asset, LoadOptions, Moment, default_camera};
use snell::gpu::device::{Gpu, open};
use snell::output::{Channels, Format, Look, Window, encode};
use snell::pack::{Background, View, pack};
use snell::render::Settings;
use snell::{cpu, gpu};

#[derive(Parser)]
struct Args {
    /// Where the files are, folders in it included.
    folder: PathBuf,
    /// The sheet, a PNG; where it takes several, they are numbered: sheet_1.png, sheet_2.png ...
    #[arg(short, long, default_value = "sheet.png")]
    output: PathBuf,
    /// Of each picture, in pixels.
    #[arg(long, default_value = "160x120", value_parser = size)]
    size: [u32; 2],
    /// Samples of each pixel.
    #[arg(long, default_value_t = 16)]
    spp: u32,
    /// Pictures in a row, and rows on a sheet.
    #[arg(long, default_value = "10x8", value_parser = size)]
    cells: [u32; 2],
    /// Render with the float64 reference.
    #[arg(long)]
    cpu: bool,
}

fn size(text: &str) -> Result<[u32; 2], String> {
    let (width, height) = text.split_once('x').ok_or("give it as WxH")?;
    match (width.parse(), height.parse()) {
        (Ok(width @ 1..=4096), Ok(height @ 1..=4096)) => Ok([width, height]),
        _ => Err("each side is a whole number from 1 to 4096".into()),
    }
}

/// A file and what came of it: RGB rows, or why there are none.
struct Cell {
    name: String,
    picture: Result<Vec<u8>, String>,
}

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let args = Args::parse();
    let mut files = Vec::new();
    find(&args.folder, &mut files)?;
    files.sort();
    let mut gpu = if args.cpu { None } else { Some(open(None)?) };
    let mut cells = Vec::new();
    for path in &files {
        let start = Instant::now();
        let picture = render(path, &args, gpu.as_mut()).map_err(|error| error.to_string());
        let name = path.strip_prefix(&args.folder)?.display().to_string();
        let status = match &picture {
            Ok(_) => "ok".to_owned(),
            Err(error) => format!("failed: {error}"),
        };
        println!("{name}: {} ms, {status}", start.elapsed().as_millis());
        cells.push(Cell { name, picture });
    }
    register_font("sans-serif", FontStyle::Normal, ttf_noto_sans::REGULAR)
        .map_err(|_| "the embedded font is damaged")?;
    let pages: Vec<&[Cell]> = cells
        .chunks((args.cells[0] * args.cells[1]) as usize)
        .collect();
    for (number, page) in (1..).zip(&pages) {
        let path = match pages.len() {
            1 => args.output.clone(),
            _ => numbered(&args.output, number),
        };
        draw(page, &args, &path)?;
        println!("{}", path.display());
    }
    let failed = cells.iter().filter(|cell| cell.picture.is_err()).count();
    println!("{} files, {failed} failed", cells.len());
    Ok(ExitCode::from(u8::from(failed > 0)))
}

fn find(folder: &Path, files: &mut Vec<PathBuf>) -> std::io::Result<()> {
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        let ending = path.extension().map(|ending| ending.to_ascii_lowercase());
        if path.is_dir() {
            find(&path, files)?;
        } else if ending.is_some_and(|ending| ending == "gltf" || ending == "glb") {
            files.push(path);
        }
    }
    Ok(())
}

fn numbered(path: &Path, number: u32) -> PathBuf {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!("{stem}_{number}.png"))
}

/// The scene's first camera, or one that frames everything, at rest.
fn render(path: &Path, args: &Args, gpu: Option<&mut Gpu>) -> Result<Vec<u8>, Box<dyn Error>> {
    let mut asset = Asset::open(path, &LoadOptions::default())?;
    let scene = asset.scene(&Moment::Rest)?.scene;
    let [width, height] = args.size;
    let camera = scene.cameras.first().cloned();
    let packed = pack(
        &scene,
        &View {
            camera: camera.unwrap_or_else(|| default_camera(&scene, width as f32 / height as f32)),
            film_size: args.size,
            seed: 0,
            max_depth: 12,
            background: Background::Environment,
            clamp: None,
        },
    )?;
    let settings = Settings {
        crop: [0, 0, width, height],
        samples: 0..args.spp,
    };
    let film: Film = match gpu {
        Some(gpu) => gpu::render::render(gpu, &packed, &settings, &mut |_| {})?.0,
        None => cpu::render::render(&packed, &settings, &|_| {}).0,
    };
    let (channels, look) = (Channels::default(), Look::default());
    let png = encode(&film, Format::Png, channels, look, Window::whole(&film), "")?;
    Ok(image::load_from_memory(&png)?.to_rgb8().into_raw())
}

/// Height of a line of letters, pixels.
const LINE: i32 = 14;
/// Between cells, pixels.
const GAP: i32 = 6;
/// Below a picture: its name, and the folder.
const CAPTION: i32 = 2 * LINE + 2;
const LETTERS: i32 = 12;

fn draw(page: &[Cell], args: &Args, path: &Path) -> Result<(), Box<dyn Error>> {
    let [width, height] = args.size.map(|side| side as i32);
    let [step_x, step_y] = [width + GAP, height + CAPTION + GAP];
    let columns = args.cells[0] as usize;
    let rows = page.len().div_ceil(columns) as i32;
    let sheet = (
        (columns as i32 * step_x + GAP) as u32,
        (rows * step_y + GAP) as u32,
    );
    let mut pixels = vec![0; 3 * sheet.0 as usize * sheet.1 as usize];
    let root = BitMapBackend::with_buffer(&mut pixels, sheet).into_drawing_area();
    root.fill(&WHITE)?;
    let text = |color: RGBColor| ("sans-serif", LETTERS).into_font().color(&color);
    for (i, cell) in page.iter().enumerate() {
        let x = GAP + (i % columns) as i32 * step_x;
        let y = GAP + (i / columns) as i32 * step_y;
        match &cell.picture {
            Ok(pixels) => {
                let size = (width as u32, height as u32);
                let picture = BitMapElement::with_owned_buffer((x, y), size, pixels.clone());
                root.draw(&picture.ok_or("a picture of another size")?)?;
            }
            Err(error) => {
                let corners = [(x, y), (x + width, y + height)];
                root.draw(&Rectangle::new(
                    corners,
                    RGBColor(0xb0, 0x20, 0x20).filled(),
                ))?;
                let lines = (height / LINE) as usize;
                for (row, line) in (0..).zip(wrapped(error, width)?.iter().take(lines)) {
                    let place = (x + 2, y + 2 + row * LINE);
                    root.draw(&Text::new(line.as_str(), place, text(WHITE)))?;
                }
            }
        }
        let name = Path::new(&cell.name);
        let file = name.file_name().unwrap_or_default().to_string_lossy();
        let folder = name.parent().unwrap_or(name).display().to_string();
        for (row, line, color) in [(0, &*file, BLACK), (1, &folder, RGBColor(110, 110, 110))] {
            let place = (x, y + height + 1 + row * LINE);
            root.draw(&Text::new(shortened(line, width)?, place, text(color)))?;
        }
    }
    root.present()?;
    drop(root);
    image::save_buffer(path, &pixels, sheet.0, sheet.1, image::ColorType::Rgb8)?;
    Ok(())
}

fn width_of(text: &str) -> Result<i32, Box<dyn Error>> {
    Ok(("sans-serif", LETTERS).into_font().box_size(text)?.0 as i32)
}

/// The end of a text, which tells names of one series apart, as long as it fits.
fn shortened(text: &str, width: i32) -> Result<String, Box<dyn Error>> {
    if width_of(text)? <= width {
        return Ok(text.to_owned());
    }
    for (start, _) in text.char_indices().skip(1) {
        let end = format!("...{}", &text[start..]);
        if width_of(&end)? <= width {
            return Ok(end);
        }
    }
    Ok(String::new())
}

/// A sentence in lines that fit, broken anywhere: paths have no spaces.
fn wrapped(text: &str, width: i32) -> Result<Vec<String>, Box<dyn Error>> {
    let mut lines = vec![String::new()];
    for letter in text.chars() {
        let line = lines.len() - 1;
        lines[line].push(letter);
        if width_of(&lines[line])? > width - 4 {
            lines[line].pop();
            lines.push(letter.to_string());
        }
    }
    Ok(lines)
}
