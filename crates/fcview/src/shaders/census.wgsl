// Numbers of triangles instead of colours, for counting what shows; follows frame.wgsl.

struct Vertex {
    @location(4) position: vec3<f32>,
    @location(5) number: u32,
};

struct Varying {
    @builtin(position) clip: vec4<f32>,
    @location(0) @interpolate(flat) number: u32,
};

// One word a triangle: 1 once it covers a pixel's centre.
@group(1) @binding(0) var<storage, read_write> covering: array<u32>;

@vertex
fn vertex(instance: Instance, vertex: Vertex) -> Varying {
    var out: Varying;
    out.clip = frame.clip_from_eye * vec4<f32>(eye_position(instance, vertex.position), 1.0);
    out.number = vertex.number;
    return out;
}

// Leaves the number of the triangle that shows in each pixel; 0 is no triangle.
@fragment
fn shows(in: Varying) -> @location(0) u32 {
    return in.number + 1u;
}

// Marks every triangle that reaches a pixel, whatever is before it.
@fragment
fn covers(in: Varying) {
    covering[in.number] = 1u;
}
