// What a pipeline may take for granted of its scene; the host sets it from the packed scene
// (src/gpu/variant.rs). The defaults take nothing for granted.
//
// A driver that carries out every branch for the lanes that take another one (llvmpipe of Mesa 22)
// pays for each model, texture and mask at every surface, whether the scene has it or not.

override TEST_ALPHA: bool = true;                // some material is masked or blended
override MEDIA: bool = true;                     // some material is the boundary of a medium
override DISPERSION: bool = true;                // that disperses
override THIN_WALLS: bool = true;                // some material is a thin wall
override BASE_COLOR_TEXTURES: bool = true;       // some material has one; and so on
override METALLIC_ROUGHNESS_TEXTURES: bool = true;
override NORMAL_TEXTURES: bool = true;
override EMISSIVE_TEXTURES: bool = true;
override TRANSMISSION_TEXTURES: bool = true;
override DIFFUSE_TRANSMISSION_TEXTURES: bool = true;
override SPECULAR_TEXTURES: bool = true;
override ANISOTROPY_TEXTURES: bool = true;
override COAT_TEXTURES: bool = true;
override SHEEN_TEXTURES: bool = true;
override IRIDESCENCE_TEXTURES: bool = true;
override COAT_NORMALS: bool = true;              // some coat lies over a normal map or has its own

// Lobes of glTF's extensions.
override COAT: bool = true;                      // some material has one; and so on
override SHEEN: bool = true;
override TRANSMISSION: bool = true;
override DIFFUSE_TRANSMISSION: bool = true;
override IRIDESCENCE: bool = true;
override ANISOTROPY: bool = true;

// What all reflecting materials have in common, or NONE.
override COMMON_MODEL: u32 = 0xffffffffu;
override COMMON_FRESNEL: u32 = 0xffffffffu;
override COMMON_DISTRIBUTION: u32 = 0xffffffffu;
override COMMON_MASKING: u32 = 0xffffffffu;
