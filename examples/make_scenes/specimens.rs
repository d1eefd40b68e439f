//! glTF's materials across their parameters: rows of specimens on a staircase, one parameter a row.

use super::document::{Document, Shape};
use super::gallery::softbox;
use super::mesh::{block, chessboard, cyclorama, faceted_sphere, sphere};
use serde_json::{Value, json};

const SPACING: f64 = 1.2;
const RADIUS: f64 = 0.48;
const STEP_DEPTH: f64 = 1.3;
const STEP_HEIGHT: f64 = 0.55;
const COLUMNS: usize = 8;

/// What stands on a step: a name, whether its specimens are cut like gems, and their materials.
struct Row {
    name: &'static str,
    gems: bool,
    materials: Vec<Value>,
}

/// `COLUMNS` materials, from a parameter that runs from 0 to 1.
fn row(name: &'static str, material: impl Fn(f64) -> Value) -> Row {
    let last = (COLUMNS - 1) as f64;
    Row {
        name,
        gems: false,
        materials: (0..COLUMNS).map(|i| material(i as f64 / last)).collect(),
    }
}

fn pbr(color: [f64; 3], metallic: f64, roughness: f64, extensions: Value) -> Value {
    json!({
        "pbrMetallicRoughness": {
            "baseColorFactor": [color[0], color[1], color[2], 1.0],
            "metallicFactor": metallic, "roughnessFactor": roughness
        },
        "extensions": extensions
    })
}

/// Rows of surfaces that nothing passes through, from the highest step down.
pub fn coatings() -> String {
    let copper = [0.93, 0.52, 0.38];
    scene(vec![
        row("metal, roughness 0 to 1", |t| {
            pbr(copper, 1.0, t, json!({}))
        }),
        row(
            "specular 0 to 1, then specular colour from white to red",
            |t| {
                let strength = (2.0 * t).min(1.0);
                let rest = 1.0 - (2.0 * t - 1.0).max(0.0);
                let specular = json!({"specularFactor": strength,
                                      "specularColorFactor": [4.0, 4.0 * rest, 4.0 * rest]});
                pbr(
                    [0.02, 0.03, 0.05],
                    0.0,
                    0.2,
                    json!({"KHR_materials_specular": specular}),
                )
            },
        ),
        row("anisotropy -1 to 1, along and across", |t| {
            let strength = (2.0 * t - 1.0).abs();
            let rotation = if t < 0.5 {
                std::f64::consts::FRAC_PI_2
            } else {
                0.0
            };
            let anisotropy =
                json!({"anisotropyStrength": strength, "anisotropyRotation": rotation});
            pbr(
                [0.9, 0.9, 0.92],
                1.0,
                0.4,
                json!({"KHR_materials_anisotropy": anisotropy}),
            )
        }),
        row("iridescence, film of 100 to 800 nm", |t| {
            let film = json!({"iridescenceFactor": 1.0, "iridescenceIor": 1.6,
                              "iridescenceThicknessMaximum": 100.0 + 700.0 * t});
            let specular = json!({"specularColorFactor": [8.0, 8.0, 8.0]});
            pbr(
                [0.01, 0.01, 0.01],
                0.0,
                0.15,
                json!({"KHR_materials_iridescence": film, "KHR_materials_specular": specular}),
            )
        }),
        row("clear coat 0 to 1, then its roughness 0 to 0.6", |t| {
            let coat = json!({"clearcoatFactor": (2.0 * t).min(1.0),
                              "clearcoatRoughnessFactor": 0.6 * (2.0 * t - 1.0).max(0.0)});
            pbr(
                [0.35, 0.02, 0.03],
                0.3,
                0.6,
                json!({"KHR_materials_clearcoat": coat}),
            )
        }),
        row("sheen, roughness 0.1 to 1", |t| {
            let sheen = json!({"sheenColorFactor": [0.35, 0.55, 0.9],
                               "sheenRoughnessFactor": 0.1 + 0.9 * t});
            pbr(
                [0.03, 0.04, 0.09],
                0.0,
                0.9,
                json!({"KHR_materials_sheen": sheen}),
            )
        }),
    ])
}

/// Rows of bodies that light passes through, from the highest step down.
pub fn glasses() -> String {
    const THICK: f64 = 2.0 * RADIUS;
    let white = [1.0, 1.0, 1.0];
    let volume = || json!({"thicknessFactor": THICK});
    let transmission = || json!({"transmissionFactor": 1.0});
    let mut dispersion = row("dispersion 0 to 7, gems of index 1.8", |t| {
        pbr(
            white,
            0.0,
            0.0,
            json!({"KHR_materials_transmission": transmission(), "KHR_materials_volume": volume(),
                   "KHR_materials_ior": {"ior": 1.8},
                   "KHR_materials_dispersion": {"dispersion": 7.0 * t}}),
        )
    });
    dispersion.gems = true;
    scene(vec![
        row("glass, index 1 to 2.4", |t| {
            pbr(
                white,
                0.0,
                0.0,
                json!({"KHR_materials_transmission": transmission(),
                       "KHR_materials_volume": volume(),
                       "KHR_materials_ior": {"ior": 1.0 + 1.4 * t}}),
            )
        }),
        row("glass, roughness 0 to 1", |t| {
            pbr(
                white,
                0.0,
                t,
                json!({"KHR_materials_transmission": transmission(),
                       "KHR_materials_volume": volume()}),
            )
        }),
        row("attenuation distance 4 m to 0.05 m", |t| {
            let distance = 4.0 * (0.05f64 / 4.0).powf(t);
            pbr(
                white,
                0.0,
                0.0,
                json!({"KHR_materials_transmission": transmission(),
                       "KHR_materials_volume": {"thicknessFactor": THICK,
                           "attenuationColor": [0.25, 0.7, 0.55],
                           "attenuationDistance": distance}}),
            )
        }),
        dispersion,
        row(
            "thin walls, transmission 0 to 1, then roughness 0 to 0.5",
            |t| {
                pbr(
                    [0.95, 0.6, 0.25],
                    0.0,
                    0.5 * (2.0 * t - 1.0).max(0.0),
                    json!({"KHR_materials_transmission":
                           {"transmissionFactor": (2.0 * t).min(1.0)}}),
                )
            },
        ),
        row("diffuse transmission 0 to 1", |t| {
            pbr(
                [0.25, 0.5, 0.12],
                0.0,
                0.5,
                json!({"KHR_materials_diffuse_transmission":
                           {"diffuseTransmissionFactor": t,
                            "diffuseTransmissionColorFactor": [0.7, 0.75, 0.1]}}),
            )
        }),
    ])
}

fn scene(rows: Vec<Row>) -> String {
    let mut document = Document::default();
    let ball = document.shape(&sphere(56, 28));
    let gem = document.shape(&faceted_sphere(10, 5));
    let steps = rows.len();
    stage(&mut document, steps);
    for (j, row) in rows.into_iter().enumerate() {
        for (i, material) in row.materials.into_iter().enumerate() {
            let name = format!("{} ({})", row.name, i + 1);
            let material = document.material(&name, material);
            let shape: Shape = if row.gems { gem } else { ball };
            let mesh = document.mesh(&name, &[(shape, material)]);
            let [x, y, z] = place(i, j, steps);
            document.place(&name, mesh, RADIUS, [x, y + RADIUS, z]);
        }
    }
    lights(&mut document);
    let camera = json!({"type": "perspective", "perspective":
        {"yfov": 0.425, "aspectRatio": 4.0 / 3.0, "znear": 0.1}});
    document.camera(camera, [0.0, 13.4, 16.4], -0.62);
    document.finish()
}

/// Where a specimen touches its step.
fn place(column: usize, row: usize, rows: usize) -> [f64; 3] {
    [
        SPACING * (column as f64 - 0.5 * (COLUMNS as f64 - 1.0)),
        STEP_HEIGHT * (rows - 1 - row) as f64,
        STEP_DEPTH * (row as f64 - 0.5 * (rows as f64 - 1.0)),
    ]
}

/// Steps with a chessboard on each, so that what is seen through a specimen can be told.
fn stage(document: &mut Document, rows: usize) {
    let diffuse = |reflectance: f64| json!({"model": "lambertian", "reflectance": [reflectance, reflectance, reflectance]});
    let paper = document.bsdf("paper", diffuse(0.4));
    let stone = document.bsdf("steps", diffuse(0.2));
    let dark = document.bsdf("dark squares", diffuse(0.12));
    let light = document.bsdf("light squares", diffuse(0.6));
    const FOOT: f64 = -0.3;
    let mut backdrop = cyclorama(20.0, 12.0, -5.0, 4.0, 14.0);
    for p in &mut backdrop.positions {
        p[1] += FOOT as f32;
    }
    document.add("backdrop", &backdrop, paper);
    let half_width = 0.5 * SPACING * COLUMNS as f64;
    // The board lies just over the step, so that the two never meet in one plane.
    const BOARD: f64 = 0.002;
    for row in 0..rows {
        let [_, y, z] = place(0, row, rows);
        let (back, front) = (z - 0.5 * STEP_DEPTH, z + 0.5 * STEP_DEPTH);
        let step = block([-half_width, FOOT, back], [half_width, y - BOARD, front]);
        document.add("step", &step, stone);
        let (board, others) = chessboard(
            [-half_width, half_width],
            [back, front],
            y,
            [4 * COLUMNS as u16, 4],
        );
        let first = document.shape(&board);
        let second = document.other_triangles(first, &others);
        let board = document.mesh("board", &[(first, dark), (second, light)]);
        document.place("board", board, 1.0, [0.0; 3]);
    }
}

fn lights(document: &mut Document) {
    let middle = [0.0, 1.5, 0.0];
    let lights = [
        ("key", [10.0, 9.4, 8.4], [-9.0, 11.0, 6.0], [3.4, 2.6]),
        ("rim", [5.0, 5.6, 6.6], [10.0, 8.0, -5.0], [1.4, 3.2]),
        ("ceiling", [0.8, 0.84, 0.9], [0.0, 15.0, 2.0], [9.0, 7.0]),
        ("front", [0.35, 0.37, 0.4], [6.0, 7.0, 20.0], [8.0, 4.0]),
    ];
    for (name, radiance, centre, [half_width, half_height]) in lights {
        let material = document.emitter(name, radiance);
        let shape = softbox(centre, middle, half_width, half_height);
        document.add(name, &shape, material);
    }
}
