// Shared by every pipeline: the view and the light. Positions in "eye space" have the world's axes and the
// eye as origin, so that their errors shrink with their distance from the eye.

struct Frame {
    clip_from_eye: mat4x4<f32>,
    // Unit directions toward the lights, world axes.
    key: vec4<f32>,
    fill: vec4<f32>,
    rim: vec4<f32>,
    // Colours for distances: log2 of the nearest in units of the near plane's, and one over the span of logarithms.
    // Then one over the distance of the near plane.
    depth: vec4<f32>,
};

// Whether the surface shows its distance from the eye. A constant, because a software rasteriser runs both sides of a
// branch.
override shows_distance: bool = false;

@group(0) @binding(0) var<uniform> frame: Frame;

// One placed copy of a model: rows of the matrix that takes a position relative to the model's centre to
// eye space.
struct Instance {
    @location(0) row_x: vec4<f32>,
    @location(1) row_y: vec4<f32>,
    @location(2) row_z: vec4<f32>,
    // The model's centre, and a tint: 0 for none, else a hue in 0..1.
    @location(3) center: vec4<f32>,
};

fn eye_position(instance: Instance, position: vec3<f32>) -> vec3<f32> {
    let local = vec4<f32>(position - instance.center.xyz, 1.0);
    return vec3<f32>(dot(instance.row_x, local), dot(instance.row_y, local), dot(instance.row_z, local));
}

fn eye_direction(instance: Instance, direction: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(
        dot(instance.row_x.xyz, direction),
        dot(instance.row_y.xyz, direction),
        dot(instance.row_z.xyz, direction),
    );
}

// The vector in the unit of the near plane's distance: there squares of what is in sight neither vanish nor overflow.
fn in_sight(position: vec3<f32>) -> vec3<f32> {
    return position * frame.depth.z;
}

// Unit vector; a zero one stays zero and does not become NaN.
fn unit(v: vec3<f32>) -> vec3<f32> {
    return v * inverseSqrt(max(dot(v, v), 1e-37));
}

// The normal of the triangle's plane, toward the eye.
fn flat_normal(toward_eye: vec3<f32>) -> vec3<f32> {
    let normal = unit(cross(dpdx(toward_eye), dpdy(toward_eye)));
    return select(normal, -normal, dot(normal, toward_eye) < 0.0);
}

fn squared(x: f32) -> f32 {
    return x * x;
}

// A warm key light, a cool fill, light from sky and ground, a faint rim and a soft highlight: enough to read
// curvature everywhere, no shadow that hides form. `normal` and `toward_eye` are unit vectors.
fn shade(albedo: vec3<f32>, normal: vec3<f32>, toward_eye: vec3<f32>) -> vec3<f32> {
    let key_cos = dot(normal, frame.key.xyz);
    // The key wraps a little past its terminator, which keeps the shadow side from going flat.
    let wrapped = clamp((key_cos + 0.15) / 1.15, 0.0, 1.0);
    let key = vec3<f32>(1.0, 0.95, 0.87) * (1.10 * wrapped * wrapped);
    let fill = vec3<f32>(0.62, 0.74, 1.0) * (0.16 * max(dot(normal, frame.fill.xyz), 0.0));
    let up = 0.5 + 0.5 * normal.y;
    let ambient = mix(vec3<f32>(0.070, 0.062, 0.058), vec3<f32>(0.155, 0.175, 0.205), up);
    let half_way = unit(frame.key.xyz + toward_eye);
    // Powers by squares: a software rasteriser takes longer for pow than for all the rest.
    let mirrored = squared(squared(max(dot(normal, half_way), 0.0)));
    let glint = squared(squared(squared(mirrored))) * 0.09 * step(0.0, key_cos);
    let facing = clamp(dot(normal, toward_eye), 0.0, 1.0);
    let edge = squared(squared(1.0 - facing)) * max(dot(normal, frame.rim.xyz), 0.0) * 0.35;
    return albedo * (key + fill + ambient) + vec3<f32>(glint) + vec3<f32>(0.80, 0.90, 1.0) * edge;
}

// The surface's colour, or one for its distance from the eye where distances are coloured: from warm and bright to
// dark and blue.
fn albedo_at(surface: vec3<f32>, toward_eye: vec3<f32>) -> vec3<f32> {
    if !shows_distance {
        return surface;
    }
    let t = clamp((log2(max(length(toward_eye), 1e-18)) - frame.depth.x) * frame.depth.y, 0.0, 1.0);
    let near = vec3<f32>(1.0, 0.83, 0.42);
    let middle = vec3<f32>(0.72, 0.16, 0.30);
    let far = vec3<f32>(0.035, 0.045, 0.20);
    return mix(mix(near, middle, clamp(2.0 * t, 0.0, 1.0)), far, clamp(2.0 * t - 1.0, 0.0, 1.0));
}

// Within 0.002 of the exact curve, and without a power.
fn linear_of_srgb(c: vec3<f32>) -> vec3<f32> {
    return c * (c * (c * 0.305306011 + 0.682171111) + 0.012522878);
}
