//! Structures and constants that shaders and host both define, compared through naga's reflection.
#![allow(clippy::unwrap_used, reason = "a test's unwrap is its assertion")]

use snell::gpu::link::link;
use std::mem::offset_of;

/// Name, offset, size of every field, and the whole's size.
type Layout = (Vec<(String, u32, u32)>, u32);

macro_rules! host {
    ($($module:ident)::+ { $($field:ident),* $(,)? }) => {{
        type Twin = snell::$($module)::+;
        fn size<T, F>(_: fn(&T) -> &F) -> u32 { size_of::<F>() as u32 }
        let fields = vec![$((
            stringify!($field).to_owned(),
            offset_of!(Twin, $field) as u32,
            size::<Twin, _>(|twin| &twin.$field),
        )),*];
        (fields, size_of::<Twin>() as u32)
    }};
}

fn shader(module: &naga::Module, name: &str) -> Layout {
    let mut layouter = naga::proc::Layouter::default();
    layouter.update(module.to_ctx()).unwrap();
    let (_, ty) = module
        .types
        .iter()
        .find(|(_, ty)| ty.name.as_deref() == Some(name))
        .unwrap_or_else(|| panic!("no struct {name} in the shaders"));
    let naga::TypeInner::Struct { members, span } = &ty.inner else {
        panic!("{name} is no struct");
    };
    let fields = members
        .iter()
        .map(|member| {
            let size = module.types[member.ty].inner.size(module.to_ctx());
            (member.name.clone().unwrap(), member.offset, size)
        })
        .collect();
    (fields, *span)
}

fn compare(module: &naga::Module, name: &str, host: Layout) {
    // Without hidden padding on the host, the listed fields are all there are.
    let listed: u32 = host.0.iter().map(|(_, _, size)| size).sum();
    assert_eq!(listed, host.1, "{name}: this test must list every field");
    assert_eq!(host, shader(module, name), "{name}: host, then shader");
}

#[test]
fn structures_agree_field_by_field() {
    let (module, _) = link("shared").unwrap().validate().unwrap();
    let structs: [(&str, Layout); 13] = [
        (
            "Camera",
            host!(shared::Camera {
                origin,
                kind,
                right,
                half_width,
                up,
                half_height,
                forward,
                near,
                closing_origin,
                lens_radius,
                closing_right,
                focus,
                closing_forward,
                moves,
                center,
                reserved,
                distortion
            }),
        ),
        (
            "Frame",
            host!(shared::Frame {
                camera,
                background,
                background_kind,
                environment_strength,
                environment_cos,
                environment_sin,
                environment_weight,
                film_size,
                tile_origin,
                tile_size,
                environment_size,
                environment_cells,
                first_sample,
                sample_count,
                seed,
                max_depth,
                light_count,
                light_weight_total,
                root,
                capacity,
                ray_offset_floor,
                has_alpha,
                clamp,
                has_thin_walls,
                mesh_root,
                light_tree_triangles,
                light_tree_leaves,
                reserved0,
                reserved1,
            }),
        ),
        (
            "Tables",
            host!(shared::Tables {
                albedo,
                albedo_average,
                albedo_dielectric,
                albedo_average_dielectric,
                albedo_sheen,
                interference
            }),
        ),
        (
            "Triangle",
            host!(shared::Triangle {
                p0,
                vertex0,
                e1,
                vertex1,
                e2,
                flags,
                vertex2,
                material,
                vertex_layout,
                primitive
            }),
        ),
        (
            "Instance",
            host!(shared::Instance {
                world_from_object,
                root,
                first_triangle,
                flags,
                motion
            }),
        ),
        (
            "Texture",
            host!(shared::Texture {
                row_u,
                texels,
                row_v,
                wrap,
                size,
                texcoord,
                format
            }),
        ),
        (
            "Material",
            host!(shared::Material {
                base_color,
                emissive,
                emission_weight,
                model,
                flags,
                alpha_cutoff,
                normal_scale,
                metallic,
                roughness,
                ior,
                fresnel,
                eta,
                distribution,
                k,
                masking,
                alpha,
                transmission,
                dispersion,
                absorption,
                diffuse_transmission,
                diffuse_transmission_color,
                specular,
                specular_color,
                anisotropy,
                anisotropy_rotation,
                coat,
                coat_roughness,
                sheen_color,
                sheen_roughness,
                iridescence,
                film_ior,
                film_thickness,
                coat_normal_scale,
                reserved0,
                reserved1,
                base_color_texture,
                metallic_roughness_texture,
                normal_texture,
                emissive_texture,
                transmission_texture,
                diffuse_transmission_texture,
                diffuse_transmission_color_texture,
                specular_texture,
                specular_color_texture,
                anisotropy_texture,
                coat_texture,
                coat_roughness_texture,
                coat_normal_texture,
                sheen_color_texture,
                sheen_roughness_texture,
                iridescence_texture,
                film_thickness_texture,
            }),
        ),
        (
            "Light",
            host!(shared::Light {
                position,
                kind,
                direction,
                alias_index,
                edge2,
                alias_threshold,
                radiance,
                weight,
                cos_inner,
                cos_outer,
                range,
                triangle,
                instance,
                profile,
                profile_rows,
                profile_columns,
            }),
        ),
        (
            "LightNode",
            host!(shared::LightNode {
                centre,
                radius2,
                facing,
                weight,
                light,
                reserved0,
                reserved1,
            }),
        ),
        (
            "Gltf",
            host!(shared::Gltf {
                F0,
                F90,
                metallic,
                transmission,
                rotation,
                diffuse_transmission_color,
                diffuse_transmission,
                sheen_color,
                sheen_roughness,
                coat_normal,
                coat,
                coat_roughness,
                iridescence,
                film_ior,
                film_thickness,
                flags,
                reserved0,
                reserved1,
            }),
        ),
        (
            "Bsdf",
            host!(shared::Bsdf {
                reflectance,
                model,
                eta,
                fresnel,
                k,
                distribution,
                alpha,
                roughness,
                masking,
                gltf,
            }),
        ),
        (
            "LabQuery",
            host!(shared::LabQuery {
                bsdf,
                wo,
                cos_theta,
                wi,
                reserved,
                u,
                reserved1
            }),
        ),
        ("LabAnswer", host!(shared::LabAnswer { f, pdf, wi, delta })),
    ];
    let defined = module
        .types
        .iter()
        .filter(|(_, ty)| matches!(ty.inner, naga::TypeInner::Struct { .. }));
    assert_eq!(
        defined.count(),
        structs.len(),
        "a struct of shared.wgsl is missing here"
    );
    for (name, host) in structs {
        compare(&module, name, host);
    }
}

#[test]
fn the_film_cell_agrees() {
    let (module, _) = link("kernels/accumulate").unwrap().validate().unwrap();
    compare(
        &module,
        "FilmCell",
        host!(gpu::wavefront::FilmCell {
            sum,
            lost,
            squares,
            non_finite,
            weight,
            weight_lost,
            weight_squares,
            reserved
        }),
    );
}

/// The value of a shader's u32 or f32 constant.
fn constant(module: &naga::Module, name: &str) -> f64 {
    let (_, constant) = module
        .constants
        .iter()
        .find(|(_, constant)| constant.name.as_deref() == Some(name))
        .unwrap_or_else(|| panic!("no constant {name} in the shaders"));
    match module.global_expressions[constant.init] {
        naga::Expression::Literal(naga::Literal::U32(value)) => f64::from(value),
        naga::Expression::Literal(naga::Literal::F32(value)) => f64::from(value),
        ref other => panic!("{name} is {other:?}"),
    }
}

/// `pub const NAME: TYPE = VALUE;` lines of a Rust file.
fn host_constants(text: &str) -> Vec<(String, f64)> {
    let parse = |value: &str| match value {
        "u32::MAX" => f64::from(u32::MAX),
        "f32::MAX" => f64::from(f32::MAX),
        number => number.replace('_', "").parse().unwrap(),
    };
    text.lines()
        .filter_map(|line| {
            let (name, rest) = line.strip_prefix("pub const ")?.split_once(": ")?;
            let (_, value) = rest.strip_suffix(';')?.split_once(" = ")?;
            Some((name.to_owned(), parse(value)))
        })
        .collect()
}

#[test]
fn constants_agree_by_value() {
    let pairs = [
        ("shared", include_str!("../src/shared.rs")),
        ("estimator", include_str!("../src/cpu/estimator.rs")),
    ];
    for (name, text) in pairs {
        let (module, _) = link(name).unwrap().validate().unwrap();
        let host = host_constants(text);
        assert!(host.len() > 5);
        for (constant_name, value) in &host {
            let shader = constant(&module, constant_name);
            assert!(
                (shader - value).abs() <= 1e-7 * value.abs(),
                "{name}: {constant_name} is {value} on the host and {shader} in the shader"
            );
        }
        if name == "shared" {
            assert_eq!(
                host.len(),
                module.constants.len(),
                "a constant of shared.wgsl has no twin"
            );
        }
    }
}

#[test]
fn the_wavefront_makes_room_for_every_plane_and_counter() {
    let (module, _) = link("kernels/state").unwrap().validate().unwrap();
    assert_eq!(
        constant(&module, "PLANES") as u64 * 16,
        snell::gpu::wavefront::PATH_BYTES
    );
    assert_eq!(
        constant(&module, "COUNTERS") as u64 * 4,
        snell::gpu::wavefront::COUNTER_BYTES
    );
    assert_eq!(
        constant(&module, "WORKGROUP") as u32,
        snell::gpu::wavefront::WORKGROUP
    );
}
