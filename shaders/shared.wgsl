// Every struct and constant that the host defines too (src/shared.rs). A test reflects this file
// through naga and compares names, offsets, spans and values with the Rust twins, so nothing here
// relies on a reader's care. Each vec3 is followed by a scalar, so that there is no hidden padding.

const NONE: u32 = 0xffffffffu; // "no texture", "no hit", "no instance"

// Reflection models, `Bsdf.model` and `Material.model`.
const BSDF_LAMBERTIAN: u32 = 0u;
const BSDF_OREN_NAYAR: u32 = 1u;            // the qualitative form (Oren and Nayar 1994)
const BSDF_OREN_NAYAR_EON: u32 = 2u;        // the energy-preserving form (Portsmouth et al. 2025)
const BSDF_SPECULAR_REFLECTION: u32 = 3u;
const BSDF_SPECULAR_TRANSMISSION: u32 = 4u;
const BSDF_DIELECTRIC: u32 = 5u;            // smooth: a delta reflection and a delta transmission
const BSDF_ROUGH_DIELECTRIC: u32 = 6u;      // Walter et al. 2007
const BSDF_TORRANCE_SPARROW: u32 = 7u;
const BSDF_GLTF: u32 = 8u;    // glTF 2.0 appendix B
const BSDF_UNLIT: u32 = 9u;                 // KHR_materials_unlit: emits base colour, reflects nothing

// `Bsdf.fresnel`
const FRESNEL_CONSTANT: u32 = 0u;
const FRESNEL_DIELECTRIC: u32 = 1u;
const FRESNEL_CONDUCTOR: u32 = 2u;             // exact, complex index
const FRESNEL_CONDUCTOR_APPROXIMATE: u32 = 3u; // the lecture's form, for large eta^2 + k^2
const FRESNEL_SCHLICK: u32 = 4u;

// `Bsdf.distribution`
const DISTRIBUTION_BLINN: u32 = 0u;
const DISTRIBUTION_ASHIKHMIN_SHIRLEY: u32 = 1u;
const DISTRIBUTION_BECKMANN: u32 = 2u;
const DISTRIBUTION_GGX: u32 = 3u;

// `Bsdf.masking`
const MASKING_NONE: u32 = 0u;
const MASKING_V_CAVITY: u32 = 1u;
const MASKING_SMITH: u32 = 2u;

// `Material.flags`
const MATERIAL_DOUBLE_SIDED: u32 = 1u;
const MATERIAL_ALPHA_MASK: u32 = 2u;
const MATERIAL_ALPHA_BLEND: u32 = 4u;
const MATERIAL_TRANSMISSIVE: u32 = 8u;  // the closed boundary of a medium: rays meet its back faces too, whatever double-sidedness says
const MATERIAL_EMISSIVE: u32 = 16u;     // its triangles are in the table of lights
const MATERIAL_THIN_WALLED: u32 = 32u;  // light passes through it, and there is no inside
const MATERIAL_SPECULAR_GLOSSINESS: u32 = 64u; // KHR_materials_pbrSpecularGlossiness

// `Gltf.flags`
const GLTF_TRANSMISSIVE: u32 = 1u; // the dielectric part has the exact Fresnel term; light may pass
const GLTF_THIN_WALLED: u32 = 2u;  // and passes straight, without refraction
const GLTF_INSIDE: u32 = 4u;       // wo is inside of the medium: coat, sheen and film are on the other side

// `Triangle.flags`: what tracing asks of the material, beside the corners that it reads anyway.
const TRIANGLE_CLASS: u32 = 7u;   // one of CLASS_*
const TRIANGLE_CULLED: u32 = 8u;  // its back is not met
const TRIANGLE_ALPHA: u32 = 16u;  // masked or blended: whether it is there, alpha says

// By which kernel a surface is shaded. A driver that carries out every branch for all lanes pays at each
// surface for the models that any of them may have, so materials that are shaded alike have a kernel of
// their own.
const CLASS_DIFFUSE: u32 = 0u; // Lambert, Oren-Nayar, unlit
const CLASS_OPAQUE: u32 = 1u;  // glTF's dielectric and metal, without extensions' lobes
const CLASS_CLEAR: u32 = 2u;   // smooth glass: deltas alone, no light is chosen for it
const CLASS_GLASS: u32 = 3u;   // other dielectrics that transmit, without further lobes
const CLASS_OTHER: u32 = 4u;
const CLASS_MISS: u32 = 5u;    // of rays that leave the scene
const CLASSES: u32 = 6u;

// `Texture.wrap`: wrap_s | wrap_t << 2; `Texture.format`; `Texture.filter`
const WRAP_REPEAT: u32 = 0u;
const WRAP_CLAMP: u32 = 1u;
const WRAP_MIRROR: u32 = 2u;
const FORMAT_RGBA8_UNORM: u32 = 0u;  // one word a texel, red in the low byte
const FORMAT_RGBA8_SRGB: u32 = 1u;   // the same, red green blue sRGB-encoded, alpha linear
const FORMAT_RGBA16_UNORM: u32 = 2u; // two words a texel: red | green << 16, blue | alpha << 16
const FILTER_NEAREST: u32 = 0u;
const FILTER_LINEAR: u32 = 1u;

// `Triangle.vertex_layout`: what follows a vertex' normal (one word) in `vertices`, in this order.
const LAYOUT_TANGENT: u32 = 1u;         // 1 word: tangent, handedness
const LAYOUT_COLOR: u32 = 2u;           // linear RGBA, 4 words of f32
const LAYOUT_COLOR_UNORM: u32 = 4u;     // or, with this bit too, 1 word: steps of 1/255
const LAYOUT_TEXCOORD_UNORM: u32 = 8u;  // coordinates have 1 word a set: steps of 1/65535; else 2 words of f32
const LAYOUT_TEXCOORDS_SHIFT: u32 = 8u; // vertex_layout >> 8: number of texture coordinate sets
const NORMAL_STEPS: u32 = 32767u;       // of the octahedral map from its centre to a corner: 16 bits an axis
const TANGENT_STEPS: u32 = 16383u;      // 15 bits

// `Instance.flags`
const INSTANCE_FLIPPED: u32 = 1u; // negative determinant: front faces wind the other way
const INSTANCE_KEYS_SHIFT: u32 = 8u;  // number of further keys from this bit on, 0: it stands still
const INSTANCE_KEYS_MASK: u32 = 255u;

// `Light.kind`
const LIGHT_POINT: u32 = 0u;
const LIGHT_SPOT: u32 = 1u;
const LIGHT_DIRECTIONAL: u32 = 2u;
const LIGHT_TRIANGLE: u32 = 3u;
const LIGHT_ENVIRONMENT: u32 = 4u;
const LIGHT_PROFILE: u32 = 5u;
const LIGHT_CLUSTER: u32 = 6u; // all lights of the light tree (light/tree.wgsl)

// `Camera.kind`
const CAMERA_PERSPECTIVE: u32 = 0u;
const CAMERA_ORTHOGRAPHIC: u32 = 1u;
const CAMERA_PANORAMA: u32 = 2u;
const CAMERA_BROWN_CONRADY: u32 = 3u; // perspective through a lens that distorts
const CAMERA_FISHEYE: u32 = 4u;

// `Frame.background_kind`: what a camera ray that meets nothing brings home.
const BACKGROUND_ENVIRONMENT: u32 = 0u;
const BACKGROUND_COLOR: u32 = 1u;
const BACKGROUND_TRANSPARENT: u32 = 2u;

// The axes of the table of directional albedo, `Tables.albedo`.
const ALBEDO_COSINES: u32 = 48u;
const ALBEDO_ROUGHNESSES: u32 = 40u;
// The axes of `Tables.albedo_dielectric`, and the largest index ratio on them; the smallest is its inverse.
const ALBEDO_DIELECTRIC_COSINES: u32 = 24u;
const ALBEDO_DIELECTRIC_ROUGHNESSES: u32 = 18u;
const ALBEDO_DIELECTRIC_ETAS: u32 = 21u;
const ETA_MAX: f32 = 3.0;
// Sides of `Tables.albedo_sheen` (cosine x roughness), and the albedo that its integers are fractions of.
const ALBEDO_SHEEN_SIZE: u32 = 32u;
const ALBEDO_SHEEN_MAX: f32 = 8.0;

// `Tables.interference`: entries, nanometres of path difference between them, and the wavelength
// (nanometres) that its phases are counted from.
const INTERFERENCE_TABLE_SIZE: u32 = 257u;
const INTERFERENCE_STEP: f32 = 32.0;
const INTERFERENCE_CARRIER: f32 = 520.0;

// A camera in world space; `right`, `up`, `forward` are orthonormal.
struct Camera {
    origin: vec3<f32>,
    kind: u32,
    right: vec3<f32>,
    half_width: f32,  // perspective: tangent of half the horizontal angle; orthographic: metres
    up: vec3<f32>,
    half_height: f32,
    forward: vec3<f32>,
    near: f32,        // metres along forward, fisheye and panorama: all around; nothing nearer is seen
    closing_origin: vec3<f32>, // where it is when the shutter closes, if it moves
    lens_radius: f32, // metres; 0: a pinhole
    closing_right: vec3<f32>,
    focus: f32,       // metres along forward to the plane in focus
    closing_forward: vec3<f32>,
    moves: u32,       // 1: it does
    center: vec2<f32>, // of the film, from the axis to the right and down, at one metre of depth
    reserved: vec2<u32>,
    // Brown-Conrady: (k1, k2, p1, p2), (k3, k4, k5, k6), (s1, s2, s3, s4); fisheye: (k1, k2, k3, k4).
    distortion: array<vec4<f32>, 3>,
}

// What changes between dispatches, and what is one per picture. A uniform.
struct Frame {
    camera: Camera,
    background: vec3<f32>,
    background_kind: u32,
    environment_strength: f32, // factor on the map's radiance; 0: there is no environment
    environment_cos: f32,      // of the map's rotation about +y
    environment_sin: f32,
    environment_weight: f32,   // its weight in the choice of a light; 0: it is not sampled
    film_size: vec2<u32>,      // the whole picture, pixels
    tile_origin: vec2<u32>,    // this tile in the picture
    tile_size: vec2<u32>,
    environment_size: vec2<u32>,   // texels of the map
    environment_cells: vec2<u32>,  // cells of its importance table
    first_sample: u32,
    sample_count: u32,         // samples a pixel in this dispatch
    seed: u32,
    max_depth: u32,            // surface interactions a path may have; 1 is direct light only
    light_count: u32,          // entries of the table of lights to choose from; those in the light tree come behind
    light_weight_total: f32,   // sum of all lights' weights, the environment's included; 0: no lights
    root: u32,                 // node index of the top-level hierarchy's root, NONE: nothing to hit
    capacity: u32,             // path slots
    ray_offset_floor: f32,     // metres; see offset_origin
    has_alpha: u32,            // 1: some material needs the opacity test while tracing
    clamp: f32,                // what the largest channel of a sample's radiance is limited to; 0: not
    has_thin_walls: u32,       // 1: shadow rays may pass some material
    mesh_root: u32,            // of the one mesh that there is, if it stands in the world as it is; else 0
    light_tree_triangles: u32, // triangles among its lights; they come first, by instance and triangle
    light_tree_leaves: u32,    // a power of two, the number of the first leaf; 0: there is no light tree
    reserved0: u32,
    reserved1: vec2<u32>,
}

// Tables that reflection models look up. A uniform, from src/tables.rs.
struct Tables {
    // Directional albedo of the single-scattering GGX lobe with Schlick's Fresnel, split so that
    // E(cos, roughness) = F0 * x + F90 * y: 16-bit fractions of 1, x in the low half; entry
    // [roughness][cosine], four entries in a vec4.
    albedo: array<vec4<u32>, 480>,
    // Hemispherical average of the same, 2 * integral of E * cos; entry [roughness], two in a vec4.
    albedo_average: array<vec4<f32>, 20>,
    // Energy that a rough dielectric boundary reflects (low 16 bits) and reflects or transmits (high), as
    // fractions of 65535, single scattering; entry [roughness][cosine][eta], four entries in a vec4.
    albedo_dielectric: array<vec4<u32>, 2268>,
    // Hemispherical averages of the same; entry [roughness][eta], two entries in a vec4.
    albedo_average_dielectric: array<vec4<f32>, 189>,
    // What the white layer of sheen reflects, 16-bit fractions of ALBEDO_SHEEN_MAX; entry
    // [roughness][cosine], eight entries in a vec4. Zero, as the two above, where no material asks.
    albedo_sheen: array<vec4<u32>, 128>,
    // The observer's view of interference: the integral of color_matching(lambda) e^(2 pi i D (1 / lambda
    // - 1 / carrier)) over the wavelengths, pairs (real, imaginary) of red, green, blue; entry [path
    // difference D], its pairs two in a vec4.
    interference: array<vec4<f32>, 386>,
}

// One triangle of a mesh, in the mesh's object space and in the order of its hierarchy's leaves.
struct Triangle {
    p0: vec3<f32>,
    vertex0: u32,   // first word of the vertex in `vertices`
    e1: vec3<f32>,  // p1 - p0
    vertex1: u32,
    e2: vec3<f32>,  // p2 - p0
    flags: u32,     // TRIANGLE_*
    vertex2: u32,
    material: u32,
    vertex_layout: u32,
    primitive: u32, // running number of the glTF primitive
}

// A mesh placed in the world; the matrix is 3x4, by rows, and has an inverse. What moves has further keys
// behind the placed instances, whole entries, at equal steps of time: the entry itself is where it is when
// the shutter opens, the last key where it is when it closes, and in between the matrices are linear.
struct Instance {
    world_from_object: array<vec4<f32>, 3>,
    root: u32,           // node index of the mesh's hierarchy
    first_triangle: u32, // index that the hierarchy's leaves count from
    flags: u32,
    motion: u32,         // index in `instances` of the first of its further keys, if it has any
}

// A texture as one material uses it: texels, sampler, and the affine map from KHR_texture_transform.
struct Texture {
    row_u: vec3<f32>,  // u' = dot(row_u, (u, v, 1))
    texels: u32,       // first word in `texels`; NONE: no texture, sampling gives white
    row_v: vec3<f32>,
    wrap: u32,
    size: vec2<u32>,
    texcoord: u32,     // set of texture coordinates
    format: u32,       // format | filter << 8
}

struct Material {
    base_color: vec4<f32>,   // glTF base colour; the lecture's models: reflectance
    emissive: vec3<f32>,     // radiance, strength included
    emission_weight: f32,    // mean luminance of the emission, textures included; 0: not a light
    model: u32,
    flags: u32,
    alpha_cutoff: f32,
    normal_scale: f32,
    metallic: f32,
    roughness: f32,          // glTF's, of specular-glossiness: glossiness; Oren-Nayar: sigma in radians, or EON's
    ior: f32,                // of the inside, absolute: dielectrics and glTF's dielectric part
    fresnel: u32,
    eta: vec3<f32>,          // conductor's index, or the constant reflectance, or F0
    distribution: u32,
    k: vec3<f32>,
    masking: u32,
    alpha: vec2<f32>,        // of Beckmann and GGX, or the exponents of Blinn and Ashikhmin-Shirley
    transmission: f32,       // KHR_materials_transmission
    dispersion: f32,         // KHR_materials_dispersion, 20 over the Abbe number; 0: none, or no medium
    absorption: vec3<f32>,   // KHR_materials_volume: -ln(attenuation colour) / distance, per metre
    diffuse_transmission: f32, // KHR_materials_diffuse_transmission
    diffuse_transmission_color: vec3<f32>,
    specular: f32,           // KHR_materials_specular
    specular_color: vec3<f32>, // the same; of KHR_materials_pbrSpecularGlossiness: F0
    anisotropy: f32,         // KHR_materials_anisotropy, strength
    anisotropy_rotation: vec2<f32>, // cosine and sine
    coat: f32,               // KHR_materials_clearcoat
    coat_roughness: f32,
    sheen_color: vec3<f32>,  // KHR_materials_sheen
    sheen_roughness: f32,
    iridescence: f32,        // KHR_materials_iridescence
    film_ior: f32,
    film_thickness: vec2<f32>, // nanometres where the texture is 0 and where it is 1
    coat_normal_scale: f32,
    reserved0: u32,
    reserved1: vec2<u32>,
    base_color_texture: Texture,
    metallic_roughness_texture: Texture,
    normal_texture: Texture,
    emissive_texture: Texture,
    transmission_texture: Texture,        // red
    diffuse_transmission_texture: Texture, // alpha
    diffuse_transmission_color_texture: Texture,
    specular_texture: Texture,            // alpha
    specular_color_texture: Texture,      // of specular-glossiness: F0 and, in alpha, glossiness
    anisotropy_texture: Texture,          // direction in red and green, strength in blue
    coat_texture: Texture,                // red
    coat_roughness_texture: Texture,      // green
    coat_normal_texture: Texture,
    sheen_color_texture: Texture,
    sheen_roughness_texture: Texture,     // alpha
    iridescence_texture: Texture,         // red
    film_thickness_texture: Texture,      // green
}

// One entry of the table of lights; also an entry of its alias table (Walker 1977, Vose 1991).
struct Light {
    position: vec3<f32>,   // triangle: its first corner, world space
    kind: u32,
    direction: vec3<f32>,  // spot, profile, directional: where the light goes, unit length; triangle: edge 1
    alias_index: u32,      // in the light tree: the number of its leaf
    edge2: vec3<f32>,      // triangle: edge 2, world space; profile: where its azimuth is 0, unit length
    alias_threshold: f32,  // keep this entry where the remapped u is below it
    radiance: vec3<f32>,   // triangle: factor on the texture; point, spot: W/(sr m^2) m^2; directional: W/m^2;
                           // profile: factor on its table
    weight: f32,           // chosen with probability weight / light_weight_total
    cos_inner: f32,        // spot; profile: the mean of its table over all directions, for the weight
    cos_outer: f32,
    range: f32,            // point, spot: metres, 0 is unlimited (KHR_lights_punctual)
    triangle: u32,         // triangle: its index in `triangles`
    instance: u32,
    profile: u32,          // profile: first of its table's words in `texels`, float32 by rows
    profile_rows: u32,     // polar angles, 0 to pi; at least 2
    profile_columns: u32,  // azimuths, all of a turn
}

// A node of the light tree (light/tree.wgsl): what the lights below it are like.
struct LightNode {
    centre: vec3<f32>,  // of a sphere around them, world space
    radius2: f32,       // the sphere's radius squared
    facing: vec3<f32>,  // mean of the directions that they face, by weight; 0 of one that shines to all sides
    weight: f32,        // sum of their weights
    light: u32,         // at a leaf: its light's index, or NONE
    reserved0: u32,
    reserved1: vec2<u32>,
}

// What glTF's extensions add to a reflection model, after texturing. Of the base, `Bsdf.reflectance` is
// the base colour, `Bsdf.eta.x` the dielectric's index over that of the medium which wo is in (of its
// inside: the inverse), `Bsdf.roughness` glTF's, `Bsdf.alpha` along and across the anisotropy.
struct Gltf {
    F0: vec3<f32>,             // of the dielectric part (KHR_materials_ior, KHR_materials_specular)
    F90: f32,
    metallic: f32,
    transmission: f32,
    rotation: vec2<f32>,       // cosine and sine of the anisotropy's direction against the frame's x
    diffuse_transmission_color: vec3<f32>,
    diffuse_transmission: f32,
    sheen_color: vec3<f32>,
    sheen_roughness: f32,
    coat_normal: vec3<f32>,    // in the frame of wo and wi, unit length
    coat: f32,
    coat_roughness: f32,
    iridescence: f32,
    film_ior: f32,
    film_thickness: f32,       // nanometres
    flags: u32,
    reserved0: u32,
    reserved1: vec2<u32>,
}

// A reflection model with its parameters after texturing, in the local frame of a hit: what the
// reflection functions take and what the laboratory's queries carry.
struct Bsdf {
    reflectance: vec3<f32>, // diffuse albedo, or the factor of a specular lobe; glTF: base colour
    model: u32,
    eta: vec3<f32>,         // conductor: index; constant: reflectance; Schlick: F0; dielectric: x is far over near, seen from wo
    fresnel: u32,
    k: vec3<f32>,
    distribution: u32,
    alpha: vec2<f32>,
    roughness: f32,         // Oren-Nayar: sigma in radians, EON: roughness, glTF's
    masking: u32,
    gltf: Gltf,
}

// The laboratory: one query and its answer (kernels/bsdf_lab).
struct LabQuery {
    bsdf: Bsdf,
    wo: vec3<f32>,
    cos_theta: f32,
    wi: vec3<f32>,
    reserved: u32,
    u: vec3<f32>,
    reserved1: u32,
}

struct LabAnswer {
    f: vec3<f32>,  // F for a Fresnel query
    pdf: f32,
    wi: vec3<f32>,
    delta: u32,
}
