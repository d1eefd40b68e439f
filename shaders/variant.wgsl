// What a pipeline may take for granted of its scene; the host writes other values here for the packed
// scene (src/gpu/variant.rs) and takes out what they decide. These take nothing for granted.
//
// A driver that carries out every branch for the lanes that take another one (llvmpipe of Mesa 22)
// pays for each model, texture and mask at every surface, whether the scene has it or not.

import package::shared::{BSDF_OREN_NAYAR, BSDF_OREN_NAYAR_EON, BSDF_ROUGH_DIELECTRIC, BSDF_TORRANCE_SPARROW, BSDF_GLTF, BSDF_UNLIT};
import package::shared::{BSDF_SPECULAR_REFLECTION, BSDF_SPECULAR_TRANSMISSION, BSDF_DIELECTRIC, DISTRIBUTION_GGX, MASKING_SMITH};
import package::shared::{LIGHT_POINT, LIGHT_SPOT, LIGHT_PROFILE, LIGHT_DIRECTIONAL, LIGHT_TRIANGLE, LIGHT_ENVIRONMENT};
import package::shared::{CAMERA_PANORAMA, CAMERA_FISHEYE, CAMERA_BROWN_CONRADY};

// Which class of surfaces a shading kernel is for; the constants on materials hold for those of the class.
const SHADED_CLASS: u32 = 0u;

const LENS: bool = true;                      // the camera has an aperture
const PROFILES: bool = true;                  // some light is a lamp as measured
const INSTANCES: bool = true;                 // there is more than one mesh that stands in the world as it is
const LIGHT_TREE: bool = true;                // lights are chosen by a tree
const MOTION: bool = true;                    // something moves while the shutter is open
const TEST_ALPHA: bool = true;                // some material is masked or blended
const SKIPS_BRANCHES: bool = true;            // the driver jumps over a branch that no lane takes
const DEFERS_ALPHA: bool = TEST_ALPHA && !SKIPS_BRANCHES;
const DEFERS_ENTRY: bool = INSTANCES && !SKIPS_BRANCHES;
const MEDIA: bool = true;                     // some material is the boundary of a medium
const BOUNDARIES: bool = true;                // of the class' materials
const DISPERSION: bool = true;                // that disperses
const EMISSION: bool = true;                  // some material of the class emits, or is unlit
const THIN_WALLS: bool = true;                // some material is a thin wall
const VERTEX_TANGENTS: bool = true;           // some vertices have tangents; and so on
const VERTEX_COLORS: bool = true;
const UNORM_TEXCOORDS: bool = true;           // some texture coordinates have one word
const FLOAT_TEXCOORDS: bool = true;           // some have two
const BASE_COLOR_TEXTURES: bool = true;       // some material has one; and so on
const METALLIC_ROUGHNESS_TEXTURES: bool = true;
const NORMAL_TEXTURES: bool = true;
const EMISSIVE_TEXTURES: bool = true;
const TRANSMISSION_TEXTURES: bool = true;
const DIFFUSE_TRANSMISSION_TEXTURES: bool = true;
const SPECULAR_TEXTURES: bool = true;
const ANISOTROPY_TEXTURES: bool = true;
const COAT_TEXTURES: bool = true;
const SHEEN_TEXTURES: bool = true;
const IRIDESCENCE_TEXTURES: bool = true;
const COAT_NORMALS: bool = true;              // some coat lies over a normal map or has its own

// Lobes of glTF's extensions.
const COAT: bool = true;                      // some material has one; and so on
const SHEEN: bool = true;
const TRANSMISSION: bool = true;
const DIFFUSE_TRANSMISSION: bool = true;
const IRIDESCENCE: bool = true;
const ANISOTROPY: bool = true;

// What glTF's base is made of.
const METALS: bool = true;                    // some material may be a metal, in part
const DIELECTRICS: bool = true;
const DIFFUSE: bool = true;                   // some dielectric may be opaque, in part
const OPAQUE: bool = true;                    // some material does not transmit at all
const THIN: bool = true;                      // some material that transmits has no inside
const SMOOTH: bool = true;                    // some facets may be smooth: a mirror's or a window's
const ROUGH: bool = true;                     // some may not

// The reflection models that some material has, one bit each: 1 << BSDF_LAMBERTIAN and so on.
const MODELS: u32 = 0xffffffffu;
const HAS_OTHER_MODELS: bool = (MODELS & ~((1u << BSDF_GLTF) | (1u << BSDF_UNLIT))) != 0u; // than glTF's
const HAS_OREN_NAYAR: bool = (MODELS & ((1u << BSDF_OREN_NAYAR) | (1u << BSDF_OREN_NAYAR_EON))) != 0u;
const HAS_SPECULAR: bool = (MODELS & ((1u << BSDF_SPECULAR_REFLECTION) | (1u << BSDF_SPECULAR_TRANSMISSION) | (1u << BSDF_DIELECTRIC))) != 0u;
const HAS_ROUGH_DIELECTRIC: bool = (MODELS & (1u << BSDF_ROUGH_DIELECTRIC)) != 0u;
const HAS_TORRANCE_SPARROW: bool = (MODELS & (1u << BSDF_TORRANCE_SPARROW)) != 0u;
const HAS_GLTF: bool = (MODELS & (1u << BSDF_GLTF)) != 0u;

// The kinds of camera, one bit each: 1 << CAMERA_PERSPECTIVE and so on.
const CAMERAS: u32 = 0xffffffffu;
const HAS_PANORAMA: bool = (CAMERAS & (1u << CAMERA_PANORAMA)) != 0u;
const HAS_FISHEYE: bool = (CAMERAS & (1u << CAMERA_FISHEYE)) != 0u;
const HAS_BROWN_CONRADY: bool = (CAMERAS & (1u << CAMERA_BROWN_CONRADY)) != 0u;

// The kinds of lights, one bit each: 1 << LIGHT_POINT and so on.
const LIGHTS: u32 = 0xffffffffu;
const HAS_TRIANGLE_LIGHTS: bool = (LIGHTS & (1u << LIGHT_TRIANGLE)) != 0u;
const HAS_ENVIRONMENT_LIGHT: bool = (LIGHTS & (1u << LIGHT_ENVIRONMENT)) != 0u;
const HAS_DIRECTIONAL_LIGHTS: bool = (LIGHTS & (1u << LIGHT_DIRECTIONAL)) != 0u;
const HAS_POINT_LIGHTS: bool = (LIGHTS & ((1u << LIGHT_POINT) | (1u << LIGHT_SPOT) | (1u << LIGHT_PROFILE))) != 0u;
const MANY_LIGHTS: bool = true;               // there is a choice
const ENVIRONMENT: bool = true;               // there is light from all around

// What all reflecting materials have in common, or NONE.
const COMMON_MODEL: u32 = 0xffffffffu;
const COMMON_FRESNEL: u32 = 0xffffffffu;
const COMMON_DISTRIBUTION: u32 = 0xffffffffu;
const COMMON_MASKING: u32 = 0xffffffffu;
const ONLY_GGX: bool = COMMON_DISTRIBUTION == DISTRIBUTION_GGX;
const ONLY_SMITH: bool = COMMON_MASKING == MASKING_SMITH;

// Where the texels are (src/gpu/upload.rs): in a buffer, or in so many textures, whose layers have a side
// of 1 << TEXEL_SIDE_BITS words and are 1 << TEXEL_LAYER_BITS in each.
const TEXEL_PAGES: u32 = 0u;
const TEXEL_SIDE_BITS: u32 = 12u;
const TEXEL_LAYER_BITS: u32 = 4u;
const TEXELS_IN_BUFFER: bool = TEXEL_PAGES == 0u;
const TEXELS_IN_2_PAGES: bool = TEXEL_PAGES >= 2u;
const TEXELS_IN_3_PAGES: bool = TEXEL_PAGES >= 3u;
const TEXELS_IN_4_PAGES: bool = TEXEL_PAGES >= 4u;
