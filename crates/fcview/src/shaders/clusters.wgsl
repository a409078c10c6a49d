// Unindexed triangles in colours of their own, with dark lines on some sides; follows frame.wgsl.

struct Vertex {
    @location(4) position: vec3<f32>,
    @location(5) color: vec4<f32>,
    // Component k is 0 on the side opposite corner k where a line is drawn on that side, else 1.
    @location(6) border: vec4<f32>,
};

struct Varying {
    @builtin(position) clip: vec4<f32>,
    @location(0) toward_eye: vec3<f32>,
    @location(1) color: vec3<f32>,
    @location(2) border: vec3<f32>,
};

@vertex
fn vertex(instance: Instance, vertex: Vertex) -> Varying {
    let position = eye_position(instance, vertex.position);
    var out: Varying;
    out.clip = frame.clip_from_eye * vec4<f32>(position, 1.0);
    out.toward_eye = -in_sight(position);
    out.color = linear_of_srgb(vertex.color.rgb);
    out.border = vertex.border.xyz;
    return out;
}

@fragment
fn fragment(in: Varying) -> @location(0) vec4<f32> {
    let toward_eye = unit(in.toward_eye);
    let normal = flat_normal(in.toward_eye);
    // Distance from the nearest border in pixels; a line about one pixel wide, fading where clusters shrink
    // to the size of the line itself.
    let width = fwidth(in.border);
    let pixels = in.border / max(width, vec3<f32>(1e-6));
    let nearest = min(pixels.x, min(pixels.y, pixels.z));
    let line = 1.0 - smoothstep(0.4, 1.3, nearest);
    let crowded = max(width.x, max(width.y, width.z));
    let strength = 0.85 * clamp(1.15 - 2.5 * crowded, 0.0, 1.0);
    let lit = shade(albedo_at(in.color, in.toward_eye), normal, toward_eye);
    return vec4<f32>(mix(lit, lit * 0.12, line * strength), 1.0);
}
