// Textures: wrapping, filtering and decoding by hand, since a scene's textures share one array of
// words and every adapter must filter alike. glTF 2.0 sections 3.8 and 5.26; minification is left
// to the pixel's samples.

import package::shared::{Texture, NONE, WRAP_CLAMP, WRAP_MIRROR, FORMAT_RGBA8_SRGB};
import package::shared::{FORMAT_RGBA16_UNORM, FILTER_LINEAR};
import package::bindings::{texels, texel_page0, texel_page1, texel_page2, texel_page3};
import package::variant::{TEXEL_SIDE_BITS, TEXEL_LAYER_BITS, TEXELS_IN_BUFFER};
import package::variant::{TEXELS_IN_2_PAGES, TEXELS_IN_3_PAGES, TEXELS_IN_4_PAGES};

// IEC 61966-2-1: where the linear foot of the curve ends, in encoded units.
const SRGB_FOOT: f32 = 0.04045;

// x^(1/5) for x in [0.09, 1], which holds all that srgb_decode asks: three Newton steps from a
// parabola that is right to 2.6 % bring it to 2e-11, past float32's rounding.
fn fifth_root(x: vec3<f32>) -> vec3<f32> {
    var y = 0.56348 + x * (0.81755 - 0.39250 * x);
    for (var step = 0u; step < 3u; step++) {
        let y2 = y * y;
        y = 0.8 * y + 0.2 * x / (y2 * y2);
    }
    return y;
}

// The decoded colour of an sRGB-encoded one in [0, 1]: IEC 61966-2-1. x^2.4 = (x (x^(1/5)))^2.
fn srgb_decode(encoded: vec3<f32>) -> vec3<f32> {
    let x = max((encoded + 0.055) / 1.055, vec3<f32>(0.09));
    let power = x * fifth_root(x);
    return select(power * power, encoded / 12.92, encoded <= vec3<f32>(SRGB_FOOT));
}

// Into [0, 1] (repeat, clamp) or [0, 2] (mirror), so that what follows fits an integer.
fn wrap_coordinate(u: f32, wrap: u32) -> f32 {
    if wrap == WRAP_CLAMP {
        return clamp(u, 0.0, 1.0);
    }
    if wrap == WRAP_MIRROR {
        return u - 2.0 * floor(0.5 * u);
    }
    return u - floor(u);
}

// The texel that stands at place i of the wrapped image; i lies in [-1, 2 size].
fn wrap_texel(i: i32, size: u32, wrap: u32) -> u32 {
    let n = i32(size);
    if wrap == WRAP_CLAMP {
        return u32(clamp(i, 0, n - 1));
    }
    if wrap == WRAP_MIRROR {
        let j = (i + 2 * n) % (2 * n);
        return u32(min(j, 2 * n - 1 - j));
    }
    return u32((i + n) % n);
}

// A word of the scene's texels. Pages are filled one after another, layer by layer and row by row.
fn texel_word(index: u32) -> u32 {
    if TEXELS_IN_BUFFER {
        return texels[index];
    }
    let last = (1u << TEXEL_SIDE_BITS) - 1u;
    let at = vec2<u32>(index & last, (index >> TEXEL_SIDE_BITS) & last);
    let layer = (index >> (2u * TEXEL_SIDE_BITS)) & ((1u << TEXEL_LAYER_BITS) - 1u);
    let page = index >> (2u * TEXEL_SIDE_BITS + TEXEL_LAYER_BITS);
    if TEXELS_IN_2_PAGES && page == 1u {
        return textureLoad(texel_page1, at, layer, 0).x;
    }
    if TEXELS_IN_3_PAGES && page == 2u {
        return textureLoad(texel_page2, at, layer, 0).x;
    }
    if TEXELS_IN_4_PAGES && page == 3u {
        return textureLoad(texel_page3, at, layer, 0).x;
    }
    return textureLoad(texel_page0, at, layer, 0).x;
}

// One texel, decoded; x and y lie in the image, row 0 on top.
fn texel_load(texture: Texture, x: u32, y: u32) -> vec4<f32> {
    let index = y * texture.size.x + x;
    let format = texture.format & 0xffu;
    if format == FORMAT_RGBA16_UNORM {
        let red_green = texel_word(texture.texels + 2u * index);
        let blue_alpha = texel_word(texture.texels + 2u * index + 1u);
        return vec4<f32>(
            f32(red_green & 0xffffu),
            f32(red_green >> 16u),
            f32(blue_alpha & 0xffffu),
            f32(blue_alpha >> 16u),
        ) / 65535.0;
    }
    let word = texel_word(texture.texels + index);
    let value = vec4<f32>(
        f32(word & 0xffu),
        f32((word >> 8u) & 0xffu),
        f32((word >> 16u) & 0xffu),
        f32(word >> 24u),
    ) / 255.0;
    if format == FORMAT_RGBA8_SRGB {
        return vec4<f32>(srgb_decode(value.rgb), value.a);
    }
    return value;
}

// The texture at glTF coordinates (0, 0 is the top left corner) before its transform; white where
// there is none. Colours are decoded before they are filtered.
fn texture_sample(texture: Texture, uv: vec2<f32>) -> vec4<f32> {
    if texture.texels == NONE {
        return vec4<f32>(1.0);
    }
    let size = vec2<f32>(texture.size);
    let wrap_s = texture.wrap & 3u;
    let wrap_t = (texture.wrap >> 2u) & 3u;
    let u = wrap_coordinate(dot(texture.row_u, vec3<f32>(uv, 1.0)), wrap_s) * size.x;
    let v = wrap_coordinate(dot(texture.row_v, vec3<f32>(uv, 1.0)), wrap_t) * size.y;
    if texture.format >> 8u != FILTER_LINEAR {
        return texel_load(
            texture,
            wrap_texel(i32(floor(u)), texture.size.x, wrap_s),
            wrap_texel(i32(floor(v)), texture.size.y, wrap_t),
        );
    }
    let x = i32(floor(u - 0.5));
    let y = i32(floor(v - 0.5));
    let fraction = vec2<f32>(u - 0.5 - f32(x), v - 0.5 - f32(y));
    let x0 = wrap_texel(x, texture.size.x, wrap_s);
    let x1 = wrap_texel(x + 1, texture.size.x, wrap_s);
    let y0 = wrap_texel(y, texture.size.y, wrap_t);
    let y1 = wrap_texel(y + 1, texture.size.y, wrap_t);
    let top = mix(texel_load(texture, x0, y0), texel_load(texture, x1, y0), fraction.x);
    let bottom = mix(texel_load(texture, x0, y1), texel_load(texture, x1, y1), fraction.x);
    return mix(top, bottom, fraction.y);
}
