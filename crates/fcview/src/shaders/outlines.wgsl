// Lines over the picture: clip positions and colours come ready from the CPU.

struct Varying {
    @builtin(position) clip: vec4<f32>,
    @location(0) color: vec4<f32>,
};

@vertex
fn vertex(@location(0) clip: vec4<f32>, @location(1) color: vec4<f32>) -> Varying {
    var out: Varying;
    out.clip = clip;
    out.color = color;
    return out;
}

@fragment
fn fragment(in: Varying) -> @location(0) vec4<f32> {
    return in.color;
}
