// The packed scene as every kernel sees it (src/pack). A kernel that reads all of group 0's storage
// arrays but one still has room for the two of group 1 within WebGPU's default of eight.

import package::shared::{Frame, Tables, Triangle, Instance, Material, Light};

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<uniform> tables: Tables;
@group(0) @binding(2) var<storage, read> nodes: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read> triangles: array<Triangle>;
@group(0) @binding(4) var<storage, read> instances: array<Instance>;
@group(0) @binding(5) var<storage, read> vertices: array<u32>;
@group(0) @binding(6) var<storage, read> materials: array<Material>;
@group(0) @binding(7) var<storage, read> texels: array<u32>;
@group(0) @binding(8) var<storage, read> lights: array<Light>;
@group(0) @binding(9) var environment: texture_2d<f32>;
@group(0) @binding(10) var environment_cells: texture_2d<f32>;
// `texels` where they are more than one binding holds: see texel_word.
@group(0) @binding(11) var texel_page0: texture_2d_array<u32>;
@group(0) @binding(12) var texel_page1: texture_2d_array<u32>;
@group(0) @binding(13) var texel_page2: texture_2d_array<u32>;
@group(0) @binding(14) var texel_page3: texture_2d_array<u32>;
// The nodes of the light tree: see light_node.
@group(0) @binding(15) var light_nodes: texture_2d<u32>;
