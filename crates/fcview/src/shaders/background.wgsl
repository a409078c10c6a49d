// A quiet vertical gradient behind everything; follows frame.wgsl.

struct Varying {
    @builtin(position) clip: vec4<f32>,
    @location(0) place: vec2<f32>,
};

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> Varying {
    // One triangle that covers the picture.
    let place = vec2<f32>(f32((index << 1u) & 2u), f32(index & 2u));
    var out: Varying;
    out.clip = vec4<f32>(place * 2.0 - 1.0, 0.0, 1.0);
    out.place = place;
    return out;
}

// Noise of one step of 8 bits, from the pixel's place alone: hides the gradient's bands.
fn noise(at: vec2<f32>) -> f32 {
    let cell = vec2<u32>(at);
    var h = cell.x * 0x9E3779B1u ^ (cell.y * 0x85EBCA6Bu);
    h = (h ^ (h >> 15u)) * 0x2C1B3C6Du;
    h = (h ^ (h >> 12u)) * 0x297A2D39u;
    return f32((h ^ (h >> 15u)) & 0xFFFFu) / 65535.0 - 0.5;
}

@fragment
fn fragment(in: Varying) -> @location(0) vec4<f32> {
    let low = vec3<f32>(0.016, 0.018, 0.022);
    let high = vec3<f32>(0.105, 0.120, 0.140);
    let offset = in.place - vec2<f32>(0.5, 0.58);
    let glow = exp(-3.2 * dot(offset, offset));
    let linear = mix(low, high, 0.12 * in.place.y + 0.80 * glow);
    // A step of the encoded value is about this much of a dark linear one.
    let step = sqrt(linear) * 0.0075;
    return vec4<f32>(max(linear + step * noise(in.clip.xy), vec3<f32>(0.0)), 1.0);
}
