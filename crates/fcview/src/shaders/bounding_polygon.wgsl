// Bounding polygons for occlusion queries: clip positions come ready from the CPU, nothing is written.

@vertex
fn vertex(@location(0) clip: vec4<f32>) -> @builtin(position) vec4<f32> {
    return clip;
}
