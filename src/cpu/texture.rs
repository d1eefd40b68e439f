//! Textures: wrapping, filtering and decoding by hand, since a scene's textures share one array of
//! words and every adapter must filter alike. glTF 2.0 sections 3.8 and 5.26; minification is left
//! to the pixel's samples.

use crate::pack::Packed;
use crate::shared::{
    FILTER_LINEAR, FORMAT_RGBA8_SRGB, FORMAT_RGBA16_UNORM, NONE, Texture, WRAP_CLAMP, WRAP_MIRROR,
};
use glam::{DVec2, DVec3, DVec4};

/// IEC 61966-2-1: where the linear foot of the curve ends, in encoded units.
pub const SRGB_FOOT: f64 = 0.04045;

/// x^(1/5).
pub fn fifth_root(x: DVec3) -> DVec3 {
    x.powf(0.2)
}

/// The decoded colour of an sRGB-encoded one in [0, 1]: IEC 61966-2-1. x^2.4 = (x (x^(1/5)))^2.
pub fn srgb_decode(encoded: DVec3) -> DVec3 {
    let x = (encoded + 0.055) / 1.055;
    let power = x * fifth_root(x);
    let foot = encoded.cmple(DVec3::splat(SRGB_FOOT));
    DVec3::select(foot, encoded / 12.92, power * power)
}

/// Into [0, 1] (repeat, clamp) or [0, 2] (mirror), so that what follows fits an integer.
pub fn wrap_coordinate(u: f64, wrap: u32) -> f64 {
    match wrap {
        WRAP_CLAMP => u.clamp(0.0, 1.0),
        WRAP_MIRROR => u - 2.0 * (0.5 * u).floor(),
        _ => u - u.floor(),
    }
}

/// The texel that stands at place i of the wrapped image; i lies in [-1, 2 size].
pub fn wrap_texel(i: i32, size: u32, wrap: u32) -> u32 {
    let n = size as i32;
    let wrapped = match wrap {
        WRAP_CLAMP => i.clamp(0, n - 1),
        WRAP_MIRROR => {
            let j = (i + 2 * n) % (2 * n);
            j.min(2 * n - 1 - j)
        }
        _ => (i + n) % n,
    };
    wrapped as u32
}

/// A word of the scene's texels.
pub fn texel_word(packed: &Packed, index: u32) -> u32 {
    packed.texels[index as usize]
}

/// One texel, decoded; x and y lie in the image, row 0 on top.
pub fn texel_load(packed: &Packed, texture: &Texture, x: u32, y: u32) -> DVec4 {
    let index = y * texture.size[0] + x;
    let format = texture.format & 0xff;
    if format == FORMAT_RGBA16_UNORM {
        let red_green = texel_word(packed, texture.texels + 2 * index);
        let blue_alpha = texel_word(packed, texture.texels + 2 * index + 1);
        return DVec4::new(
            f64::from(red_green & 0xffff),
            f64::from(red_green >> 16),
            f64::from(blue_alpha & 0xffff),
            f64::from(blue_alpha >> 16),
        ) / 65535.0;
    }
    let value = DVec4::from_array(
        texel_word(packed, texture.texels + index)
            .to_le_bytes()
            .map(f64::from),
    ) / 255.0;
    if format == FORMAT_RGBA8_SRGB {
        return srgb_decode(value.truncate()).extend(value.w);
    }
    value
}

/// The texture at glTF coordinates (0, 0 is the top left corner) before its transform; white where
/// there is none. Colours are decoded before they are filtered.
pub fn texture_sample(packed: &Packed, texture: &Texture, uv: DVec2) -> DVec4 {
    if texture.texels == NONE {
        return DVec4::ONE;
    }
    let [width, height] = texture.size;
    let wrap_s = texture.wrap & 3;
    let wrap_t = (texture.wrap >> 2) & 3;
    let row = |row: [f32; 3]| DVec3::from_array(row.map(f64::from)).dot(uv.extend(1.0));
    let u = wrap_coordinate(row(texture.row_u), wrap_s) * f64::from(width);
    let v = wrap_coordinate(row(texture.row_v), wrap_t) * f64::from(height);
    let load = |x: i32, y: i32| {
        let (x, y) = (wrap_texel(x, width, wrap_s), wrap_texel(y, height, wrap_t));
        texel_load(packed, texture, x, y)
    };
    if texture.format >> 8 != FILTER_LINEAR {
        return load(u.floor() as i32, v.floor() as i32);
    }
    let x = (u - 0.5).floor() as i32;
    let y = (v - 0.5).floor() as i32;
    let fraction = DVec2::new(u - 0.5 - f64::from(x), v - 0.5 - f64::from(y));
    let top = load(x, y).lerp(load(x + 1, y), fraction.x);
    let bottom = load(x, y + 1).lerp(load(x + 1, y + 1), fraction.x);
    top.lerp(bottom, fraction.y)
}
