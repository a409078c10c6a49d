// The extracted surface, lit; follows frame.wgsl.

// Whether the model stores normals; without them each triangle is flat.
override has_normals: bool = true;

struct Vertex {
    @location(4) position: vec3<f32>,
    @location(5) normal: vec2<f32>,
    @location(6) color: vec4<f32>,
};

struct Varying {
    @builtin(position) clip: vec4<f32>,
    @location(0) toward_eye: vec3<f32>,
    @location(1) normal: vec3<f32>,
    @location(2) albedo: vec3<f32>,
};

// Inverse of the octahedral map.
fn octahedral(e: vec2<f32>) -> vec3<f32> {
    let z = 1.0 - abs(e.x) - abs(e.y);
    let fold = max(-z, 0.0);
    let sign = select(vec2<f32>(-1.0), vec2<f32>(1.0), e >= vec2<f32>(0.0));
    return vec3<f32>(e - sign * fold, z);
}

// A pale tint of a hue in 0..1, so that neighbouring copies can be told apart.
fn tint(hue: f32) -> vec3<f32> {
    let turn = 6.2831853 * (hue + vec3<f32>(0.0, 0.33, 0.67));
    return vec3<f32>(1.0) + 0.13 * cos(turn);
}

@vertex
fn vertex(instance: Instance, vertex: Vertex) -> Varying {
    let position = eye_position(instance, vertex.position);
    var out: Varying;
    out.clip = frame.clip_from_eye * vec4<f32>(position, 1.0);
    out.toward_eye = -in_sight(position);
    out.normal = unit(eye_direction(instance, octahedral(vertex.normal)));
    out.albedo = linear_of_srgb(vertex.color.rgb);
    if instance.center.w > 0.0 {
        out.albedo *= tint(instance.center.w);
    }
    return out;
}

// Cosines of the angle between the stored normal and the triangle's own. Up to about 15 degrees the stored one is the
// surface's, and the triangle an approximation of it. From about 32 it was averaged over a crease and would smear across
// the triangle.
const SMOOTH: f32 = 0.965;
const CREASED: f32 = 0.85;

// Beyond 75 degrees the triangle may be a sliver whose plane says nothing: across one the stored normal changes by more
// than a fiftieth from pixel to pixel. Squares of changes.
const STRAY: f32 = 0.50;
const SLIVER: f32 = 0.26;
const SLOW: f32 = 0.0005;
const FAST: f32 = 0.005;

@fragment
fn fragment(in: Varying, @builtin(front_facing) front: bool) -> @location(0) vec4<f32> {
    let toward_eye = unit(in.toward_eye);
    var normal = flat_normal(in.toward_eye);
    if has_normals {
        let stored = select(-1.0, 1.0, front) * unit(in.normal);
        let alike = dot(normal, stored);
        let change = dpdx(in.normal);
        let other = dpdy(in.normal);
        let thin = smoothstep(SLOW, FAST, max(dot(change, change), dot(other, other)));
        let kept = smoothstep(CREASED, SMOOTH, alike) + thin * (1.0 - smoothstep(SLIVER, STRAY, alike));
        normal = unit(mix(normal, stored, kept));
    }
    let albedo = albedo_at(in.albedo, in.toward_eye);
    return vec4<f32>(shade(albedo, normal, toward_eye), 1.0);
}
