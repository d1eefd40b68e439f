//! The README's picture: a tray of spheres, one for each reflection model, under studio lights.

use super::document::Document;
use super::mesh::{Mesh, block, chessboard, cyclorama, polygon, sphere};
use serde_json::{Value, json};

const SPACING: f64 = 1.2;
const RADIUS: f64 = 0.48;
const MARBLE: f64 = 0.15;
/// Squares of the tray's chessboard are half a spacing wide: a sphere's square, and one between.
const SQUARES: [u16; 2] = [11, 9];

/// From the back row to the front, each from the left.
fn rows() -> [[(&'static str, Value); 5]; 4] {
    let metal = |name: &str| json!({"model": "conductor", "conductor": {"metal": name}});
    let facets = |metal: &str, distribution: Value| {
        json!({"model": "torrance-sparrow", "fresnel": {"conductor": {"metal": metal}},
               "distribution": distribution})
    };
    let snell = |model: Value| json!({"extensions": {"SNELL_materials_bsdf": model}});
    [
        [
            (
                "Lambertian",
                snell(json!({"model": "lambertian", "reflectance": [0.62, 0.16, 0.1]})),
            ),
            (
                "Oren-Nayar, qualitative",
                snell(
                    json!({"model": "oren-nayar", "reflectance": [0.75, 0.4, 0.08],
                             "form": "qualitative", "sigma": 0.6}),
                ),
            ),
            (
                "Oren-Nayar, energy-preserving",
                snell(
                    json!({"model": "oren-nayar", "reflectance": [0.12, 0.42, 0.3],
                             "form": "energy-preserving", "roughness": 0.9}),
                ),
            ),
            (
                "glTF dielectric",
                json!({"pbrMetallicRoughness": {"baseColorFactor": [0.04, 0.13, 0.5, 1.0],
                       "metallicFactor": 0.0, "roughnessFactor": 0.25}}),
            ),
            (
                "glTF metal",
                json!({"pbrMetallicRoughness": {"baseColorFactor": [0.6, 0.35, 0.65, 1.0],
                       "metallicFactor": 1.0, "roughnessFactor": 0.35}}),
            ),
        ],
        [
            ("gold", snell(metal("Au"))),
            ("silver", snell(metal("Ag"))),
            ("copper", snell(metal("Cu"))),
            ("aluminium", snell(metal("Al"))),
            (
                "mirror",
                snell(json!({"model": "specular-reflection",
                             "fresnel": {"constant": [0.55, 0.75, 0.9]}})),
            ),
        ],
        [
            (
                "facets, Blinn",
                snell(facets("Cu", json!({"name": "blinn", "exponent": 60.0}))),
            ),
            (
                "facets, Beckmann",
                snell(facets("Ag", json!({"name": "beckmann", "alpha": 0.25}))),
            ),
            (
                "facets, Ashikhmin-Shirley",
                snell(facets(
                    "Al",
                    json!({"name": "ashikhmin-shirley", "exponent": [12.0, 800.0]}),
                )),
            ),
            (
                "facets, GGX",
                snell(facets("Au", json!({"name": "ggx", "alpha": 0.2}))),
            ),
            (
                "facets, GGX anisotropic",
                snell(facets("Cu", json!({"name": "ggx", "alpha": [0.4, 0.05]}))),
            ),
        ],
        [
            ("water", snell(json!({"model": "dielectric", "eta": 1.333}))),
            (
                "rough glass",
                snell(json!({"model": "dielectric", "eta": 1.5,
                             "distribution": {"name": "ggx", "alpha": 0.12}})),
            ),
            ("glass", snell(json!({"model": "dielectric", "eta": 1.5}))),
            (
                "transmission only",
                snell(json!({"model": "specular-transmission", "eta": 1.5})),
            ),
            (
                "diamond",
                snell(json!({"model": "dielectric", "eta": 2.417})),
            ),
        ],
    ]
}

pub fn scene() -> String {
    let mut document = Document::default();
    stage(&mut document);
    lights(&mut document);

    let shape = document.shape(&sphere(68, 34));
    let mut meshes = Vec::new();
    for (j, row) in rows().into_iter().enumerate() {
        for (i, (name, material)) in row.into_iter().enumerate() {
            let material = document.material(name, material);
            let mesh = document.mesh(name, &[(shape, material)]);
            let at = [
                SPACING * (i as f64 - 2.0),
                RADIUS,
                SPACING * (j as f64 - 1.5),
            ];
            document.place(name, mesh, RADIUS, at);
            meshes.push(mesh);
        }
    }
    // Marbles between the spheres: the same meshes again, stepping by a number prime to their count.
    let mut next = 3;
    for j in 0..3 {
        for i in 0..4 {
            let at = [
                SPACING * (f64::from(i) - 1.5),
                MARBLE,
                SPACING * (f64::from(j) - 1.0),
            ];
            document.place("marble", meshes[next % meshes.len()], MARBLE, at);
            next += 7;
        }
    }

    let camera = json!({"type": "perspective", "perspective":
        {"yfov": 0.475, "aspectRatio": 4.0 / 3.0, "znear": 0.1}});
    document.camera(camera, [0.0, 9.3, 10.2], -0.735);
    document.finish()
}

fn stage(document: &mut Document) {
    let diffuse = |reflectance: f64| {
        json!({"model": "oren-nayar", "reflectance": [reflectance, reflectance, reflectance],
               "form": "energy-preserving", "roughness": 0.5})
    };
    let paper = document.bsdf("paper", diffuse(0.45));
    let rim = document.bsdf("tray", diffuse(0.06));
    let dark = document.bsdf("dark squares", diffuse(0.15));
    let light = document.bsdf("light squares", diffuse(0.6));

    // The tray's board is at y = 0, and the paper under it at the tray's foot.
    const FOOT: f64 = -0.16;
    let mut backdrop = cyclorama(14.0, 9.0, -5.0, 3.0, 9.0);
    for p in &mut backdrop.positions {
        p[1] += FOOT as f32;
    }
    document.add("backdrop", &backdrop, paper);

    let [x, z] = SQUARES.map(|n| 0.25 * SPACING * f64::from(n));
    let (board, others) = chessboard([-x, x], [-z, z], 0.0, SQUARES);
    let first = document.shape(&board);
    let second = document.other_triangles(first, &others);
    let board = document.mesh("board", &[(first, dark), (second, light)]);
    document.place("board", board, 1.0, [0.0; 3]);

    const WIDTH: f64 = 0.1;
    const LIP: f64 = 0.03;
    let mut tray = Mesh::default();
    for side in [-1.0, 1.0] {
        let bar = |inner: f64| {
            let ends = [side * inner, side * (inner + WIDTH)];
            [ends[0].min(ends[1]), ends[0].max(ends[1])]
        };
        let ([x0, x1], [z0, z1]) = (bar(x), bar(z));
        tray.append(&block([x0, FOOT, -z - WIDTH], [x1, LIP, z + WIDTH]));
        tray.append(&block([-x, FOOT, z0], [x, LIP, z1]));
    }
    document.add("tray", &tray, rim);
}

/// A rectangle of light that faces `target`, its long side level.
pub fn softbox(centre: [f64; 3], target: [f64; 3], half_width: f64, half_height: f64) -> Mesh {
    let unit = |v: [f64; 3]| {
        let length = v.iter().map(|c| c * c).sum::<f64>().sqrt();
        v.map(|c| c / length)
    };
    let n = unit([0, 1, 2].map(|i| target[i] - centre[i]));
    // right = up x n with up = +y, and the box's own up = n x right.
    let right = unit([n[2], 0.0, -n[0]]);
    let up = [
        n[1] * right[2] - n[2] * right[1],
        n[2] * right[0] - n[0] * right[2],
        n[0] * right[1] - n[1] * right[0],
    ];
    let corner = |a: f64, b: f64| {
        [0, 1, 2].map(|i| centre[i] + a * half_width * right[i] + b * half_height * up[i])
    };
    polygon(&[
        corner(-1.0, -1.0),
        corner(1.0, -1.0),
        corner(1.0, 1.0),
        corner(-1.0, 1.0),
    ])
}

/// Large and dim rather than small and bright: what metal and glass throw on the board then settles soon.
fn lights(document: &mut Document) {
    let middle = [0.0, 0.0, 0.0];
    let lights = [
        ("key", [9.0, 8.5, 7.6], [-6.0, 7.5, 4.5], [2.8, 2.0]),
        ("rim", [3.6, 4.0, 4.8], [6.5, 5.5, -4.5], [0.9, 2.2]),
        ("ceiling", [0.76, 0.8, 0.86], [0.0, 10.0, 2.0], [7.0, 5.0]),
        ("front", [0.3, 0.32, 0.36], [4.0, 5.0, 14.0], [6.0, 3.0]),
    ];
    for (name, radiance, centre, [half_width, half_height]) in lights {
        let material = document.emitter(name, radiance);
        let shape = softbox(centre, middle, half_width, half_height);
        document.add(name, &shape, material);
    }
}
