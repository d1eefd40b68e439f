//! Shapes made from formulas, in metres, with counter-clockwise front faces.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

#[derive(Clone, Default)]
pub struct Mesh {
    pub positions: Vec<[f32; 3]>,
    /// `None` asks the reader for flat normals.
    pub normals: Option<Vec<[f32; 3]>>,
    pub tangents: Option<Vec<[f32; 4]>>,
    pub triangles: Vec<[u16; 3]>,
}

impl Mesh {
    fn vertex(&mut self, p: [f64; 3]) -> u16 {
        self.positions.push(p.map(|x| x as f32));
        u16::try_from(self.positions.len() - 1).expect("invariant: our shapes are small")
    }

    /// Adds another shape's faces.
    pub fn append(&mut self, other: &Mesh) {
        let first = u16::try_from(self.positions.len()).expect("invariant: our shapes are small");
        self.positions.extend(&other.positions);
        self.triangles
            .extend(other.triangles.iter().map(|t| t.map(|i| i + first)));
    }

    /// The same faces seen from the other side.
    pub fn inside_out(mut self) -> Mesh {
        for triangle in &mut self.triangles {
            triangle.swap(1, 2);
        }
        self
    }
}

/// A convex polygon, flat, its corners counter-clockwise seen from the front.
pub fn polygon(corners: &[[f64; 3]]) -> Mesh {
    let mut mesh = Mesh::default();
    let ids: Vec<u16> = corners.iter().map(|p| mesh.vertex(*p)).collect();
    for pair in ids[1..].windows(2) {
        mesh.triangles.push([ids[0], pair[0], pair[1]]);
    }
    mesh
}

/// A rectangle x0..x1 by y0..y1 at depth z, facing +z.
pub fn upright([x0, x1]: [f64; 2], [y0, y1]: [f64; 2], z: f64) -> Mesh {
    polygon(&[[x0, y0, z], [x1, y0, z], [x1, y1, z], [x0, y1, z]])
}

/// A rectangle x0..x1 by z0..z1 at height y, facing +y.
pub fn level([x0, x1]: [f64; 2], [z0, z1]: [f64; 2], y: f64) -> Mesh {
    polygon(&[[x0, y, z1], [x1, y, z1], [x1, y, z0], [x0, y, z0]])
}

/// A straight prism: a convex outline in the (a, b) plane that `at(a, b, c)` maps to space, between
/// c0 and c1. The outline is counter-clockwise seen from the +c end, and `at` keeps handedness.
pub fn extrude(
    outline: &[[f64; 2]],
    [c0, c1]: [f64; 2],
    at: impl Fn(f64, f64, f64) -> [f64; 3],
) -> Mesh {
    let ring = |c: f64| -> Vec<[f64; 3]> { outline.iter().map(|[a, b]| at(*a, *b, c)).collect() };
    let (low, high) = (ring(c0), ring(c1));
    let mut mesh = polygon(&high);
    mesh.append(&polygon(&low.iter().rev().copied().collect::<Vec<_>>()));
    for i in 0..outline.len() {
        let j = (i + 1) % outline.len();
        mesh.append(&polygon(&[low[i], low[j], high[j], high[i]]));
    }
    mesh
}

/// An axis-aligned box, its faces looking outwards.
pub fn block(low: [f64; 3], high: [f64; 3]) -> Mesh {
    let outline = [
        [low[0], low[1]],
        [high[0], low[1]],
        [high[0], high[1]],
        [low[0], high[1]],
    ];
    extrude(&outline, [low[2], high[2]], |a, b, c| [a, b, c])
}

/// A unit sphere by longitude and latitude, smooth, its tangents along the parallels. Each pole is a
/// vertex per meridian, because the tangent has no value there.
pub fn sphere(meridians: u16, parallels: u16) -> Mesh {
    let mut mesh = Mesh::default();
    let mut tangents = Vec::new();
    for j in 0..=parallels {
        let theta = PI * f64::from(j) / f64::from(parallels);
        for i in 0..meridians {
            // A pole's vertex stands between the two meridians of its triangle.
            let shift = if j == 0 || j == parallels { 0.5 } else { 0.0 };
            let phi = TAU * (f64::from(i) + shift) / f64::from(meridians);
            mesh.vertex([
                theta.sin() * phi.sin(),
                theta.cos(),
                theta.sin() * phi.cos(),
            ]);
            tangents.push([phi.cos() as f32, 0.0, -phi.sin() as f32, 1.0]);
        }
    }
    for j in 0..parallels {
        for i in 0..meridians {
            let next = (i + 1) % meridians;
            let (above, below) = (j * meridians, (j + 1) * meridians);
            if j + 1 < parallels {
                let top = if j == 0 { i } else { next };
                mesh.triangles.push([above + top, below + i, below + next]);
            }
            if j > 0 {
                mesh.triangles.push([above + i, below + i, above + next]);
            }
        }
    }
    mesh.normals = Some(mesh.positions.clone());
    mesh.tangents = Some(tangents);
    mesh
}

/// A polyhedron on the sphere's vertices, with flat faces.
pub fn faceted_sphere(meridians: u16, parallels: u16) -> Mesh {
    Mesh {
        normals: None,
        tangents: None,
        ..sphere(meridians, parallels)
    }
}

/// A level grid of `nx` by `nz` squares in two sets like a chessboard's; the corner square with the
/// least x and z is of the first set. Facing +y.
pub fn chessboard(
    [x0, x1]: [f64; 2],
    [z0, z1]: [f64; 2],
    y: f64,
    [nx, nz]: [u16; 2],
) -> (Mesh, Vec<[u16; 3]>) {
    let mut first = Mesh::default();
    let mut second = Vec::new();
    for j in 0..=nz {
        for i in 0..=nx {
            let x = x0 + (x1 - x0) * f64::from(i) / f64::from(nx);
            let z = z0 + (z1 - z0) * f64::from(j) / f64::from(nz);
            first.vertex([x, y, z]);
        }
    }
    for j in 0..nz {
        for i in 0..nx {
            let back = j * (nx + 1) + i;
            let front = back + nx + 1;
            let square = [[front, front + 1, back + 1], [front, back + 1, back]];
            let set = if (i + j) % 2 == 0 {
                &mut first.triangles
            } else {
                &mut second
            };
            set.extend(square);
        }
    }
    (first, second)
}

/// A floor that bends up into a wall: level at y = 0 from z = `front` to z = `bend`, a quarter circle
/// of the given radius, and upright to y = `top`. Smooth.
pub fn cyclorama(half_width: f64, front: f64, bend: f64, radius: f64, top: f64) -> Mesh {
    const ARC_STEPS: u16 = 32;
    let mut profile = vec![([0.0, front], [1.0, 0.0])];
    for step in 0..=ARC_STEPS {
        let (sin, cos) = (FRAC_PI_2 * f64::from(step) / f64::from(ARC_STEPS)).sin_cos();
        profile.push(([radius * (1.0 - cos), bend - radius * sin], [cos, sin]));
    }
    profile.push(([top, bend - radius], [0.0, 1.0]));
    let mut mesh = Mesh::default();
    let mut normals = Vec::new();
    for ([y, z], [ny, nz]) in profile {
        for x in [-half_width, half_width] {
            mesh.vertex([x, y, z]);
            normals.push([0.0, ny as f32, nz as f32]);
        }
    }
    let rows = u16::try_from(normals.len() / 2).expect("invariant: our shapes are small");
    for row in 1..rows {
        let (near, far) = (2 * row - 2, 2 * row);
        mesh.triangles
            .extend([[near, near + 1, far + 1], [near, far + 1, far]]);
    }
    mesh.normals = Some(normals);
    mesh
}
