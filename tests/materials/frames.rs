//! What turns with the surface: anisotropy, and the normals of coats.

use crate::common::rays::{ray, towards};
use crate::common::shapes;
use crate::{extended, texture};
use glam::{Affine3A, DVec3, Vec2, Vec3, Vec4};
use snell::cpu;
use snell::scene::material::IDENTITY_ROWS;
use snell::scene::{Image, Material, Pixels, Texture};

/// A square of one texture coordinate, seen aslant: what the channels of a flat image do.
fn flat(
    material: Material,
    texel: [u8; 4],
    front: bool,
) -> (cpu::surface::Surface, cpu::bsdf::Bsdf) {
    let mut mesh = shapes::grid(1, |_, _| 0.0);
    let primitive = &mut mesh.primitives[0];
    let count = primitive.positions.len();
    // Normal +y, tangent +x: glTF's bitangent is cross(n, t) * w = -z for +1.
    primitive.tangents = Some(vec![Vec4::new(1.0, 0.0, 0.0, 1.0); count]);
    primitive.texcoords = vec![vec![Vec2::ZERO; count]];
    let mut scene = shapes::scene(vec![mesh], vec![shapes::instance(0, Affine3A::IDENTITY)]);
    scene.materials = vec![material];
    scene.images = vec![std::sync::Arc::new(Image {
        name: String::new(),
        width: 1,
        height: 1,
        pixels: Pixels::Rgba8(texel.into()),
    })];
    let packed = shapes::packed(&scene);
    let side = if front { 1.0 } else { -1.0 };
    let query = towards(Vec3::new(0.2, side, 0.3), Vec3::new(0.1, 0.0, 0.2));
    let hit = cpu::bvh::trace_closest(&packed, ray(&query), 0);
    let surface = cpu::surface::surface_at(&packed, ray(&query), hit);
    let material = &packed.materials[0];
    let bsdf = cpu::material::bsdf_at(&packed, material, &surface, 1.5);
    (surface, bsdf)
}

fn flat_texture() -> Option<Texture> {
    Some(Texture {
        rows: IDENTITY_ROWS,
        ..texture(0, false).unwrap()
    })
}

#[test]
fn anisotropy_points_along_the_texture_turned_by_the_rotation_on_both_sides() {
    let brushed = || {
        extended(|all| {
            all.anisotropy.strength.factor = 1.0;
            all.anisotropy.strength.texture = flat_texture();
            all.anisotropy.rotation = std::f32::consts::FRAC_PI_6;
        })
    };
    for front in [true, false] {
        // (1, 1) in tangent space: 45 degrees, and 30 more.
        let (surface, bsdf) = flat(brushed(), [255, 255, 128, 255], front);
        let r = bsdf.gltf.rotation;
        let world = cpu::math::to_world(surface.basis, DVec3::new(r.x, r.y, 0.0));
        let angle = 75.0_f64.to_radians();
        let expected = DVec3::new(angle.cos(), 0.0, -angle.sin());
        assert!((world - expected).length() < 1e-6, "{world}");
        let strength = 128.0 / 255.0;
        let alpha = 0.25 + 0.75 * strength * strength;
        assert!((bsdf.alpha.x - alpha).abs() < 1e-6, "{}", bsdf.alpha);
    }
}

#[test]
fn a_coat_is_smooth_over_bumps_and_follows_its_own() {
    let world = |(surface, bsdf): (cpu::surface::Surface, cpu::bsdf::Bsdf)| {
        cpu::math::to_world(surface.basis, bsdf.gltf.coat_normal)
    };
    // A normal 26.6 degrees towards the tangent.
    let tilted = [191, 128, 255, 255];
    for front in [true, false] {
        let up = if front { DVec3::Y } else { DVec3::NEG_Y };
        let mut bumpy = extended(|all| all.clearcoat.coat.factor = 1.0);
        bumpy.normal_texture = flat_texture();
        let (surface, bsdf) = flat(bumpy, tilted, front);
        assert!(surface.basis.n.dot(up) < 0.95);
        assert!((world((surface, bsdf)) - up).length() < 1e-6);
        let own = extended(|all| {
            all.clearcoat.coat.factor = 1.0;
            all.clearcoat.normal_texture = flat_texture();
        });
        let (surface, bsdf) = flat(own, tilted, front);
        assert!((surface.basis.n - up).length() < 1e-9);
        let cosine = world((surface, bsdf)).dot(up);
        assert!(
            (cosine - 26.5_f64.to_radians().cos()).abs() < 5e-3,
            "{cosine}"
        );
    }
}
