// Copies the picture to the window, encoding sRGB where the window's format does not.

// Off where the window's format encodes after all.
override encode: bool = true;

@group(0) @binding(0) var picture: texture_2d<f32>;

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    let place = vec2<f32>(f32((index << 1u) & 2u), f32(index & 2u));
    return vec4<f32>(place * 2.0 - 1.0, 0.0, 1.0);
}

@fragment
fn fragment(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
    let size = vec2<i32>(textureDimensions(picture));
    let place = clamp(vec2<i32>(at.xy), vec2<i32>(0), size - vec2<i32>(1));
    let linear = textureLoad(picture, place, 0).rgb;
    if !encode {
        return vec4<f32>(linear, 1.0);
    }
    let low = linear * 12.92;
    let high = 1.055 * pow(linear, vec3<f32>(1.0 / 2.4)) - 0.055;
    return vec4<f32>(select(high, low, linear <= vec3<f32>(0.0031308)), 1.0);
}
