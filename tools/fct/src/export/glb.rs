//! Binary glTF 2.0: a description in JSON, and the numbers behind it.

use super::mesh::Mesh;
use serde_json::{Map, Value, json};
use std::io::{self, Write};

// Numbers of the specification: the words that begin a file and its chunks, kinds of numbers and of buffers.
const GLB: u32 = 0x4654_6C67;
const VERSION: u32 = 2;
const JSON: u32 = 0x4E4F_534A;
const BIN: u32 = 0x004E_4942;
const FLOAT: u32 = 5126;
const UNSIGNED_BYTE: u32 = 5121;
const UNSIGNED_INT: u32 = 5125;
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;

/// The file's header and those of its two chunks.
const HEADERS: u64 = 12 + 8 + 8;

/// Writes `mesh`. The tree's groups become nodes with their names and vertices of their own; an origin becomes the
/// translation of them all, since coordinates are in single precision here. `step` is called for each vertex and each triangle.
///
/// # Errors
/// Those of the writer, and `FileTooLarge` beyond the 4 GiB that the format can count.
pub(crate) fn write(mesh: &Mesh, out: &mut impl Write, step: &mut dyn FnMut()) -> io::Result<()> {
    let parts = parts(mesh);
    let (description, numbers) = describe(mesh, &parts);
    let mut text = description.to_string().into_bytes();
    // Chunks are whole words: the text is filled up with spaces, and the numbers are words as they are.
    text.resize(text.len().next_multiple_of(4), b' ');
    let too_large = |_overflow| io::Error::from(io::ErrorKind::FileTooLarge);
    let total = u32::try_from(HEADERS + text.len() as u64 + numbers).map_err(too_large)?;
    let numbers = u32::try_from(numbers).map_err(too_large)?;
    write_words(out, &[GLB, VERSION, total, text.len() as u32, JSON])?;
    out.write_all(&text)?;
    write_words(out, &[numbers, BIN])?;
    let buffers = &mesh.buffers;
    let vertices = || parts.iter().flat_map(|part| &part.vertices).map(|vertex| *vertex as usize);
    for vertex in vertices() {
        step();
        write_words(out, &buffers.positions[vertex].map(f32::to_bits))?;
    }
    if !buffers.normals.is_empty() {
        for vertex in vertices() {
            write_words(out, &buffers.normals[vertex].map(f32::to_bits))?;
        }
    }
    if !buffers.colors.is_empty() {
        for vertex in vertices() {
            out.write_all(&buffers.colors[vertex])?;
        }
    }
    for triangle in parts.iter().flat_map(|part| part.indices.as_chunks::<3>().0) {
        step();
        write_words(out, triangle)?;
    }
    Ok(())
}

fn write_words(out: &mut impl Write, words: &[u32]) -> io::Result<()> {
    words.iter().try_for_each(|word| out.write_all(&word.to_le_bytes()))
}

/// A group, or all of a mesh without groups.
struct Part<'a> {
    name: &'a str,
    /// Those of the mesh that it uses.
    vertices: Vec<u32>,
    /// Three a triangle, into its own vertices.
    indices: Vec<u32>,
}

/// The groups in order. Along an edge where two of them meet both have the vertices.
fn parts(mesh: &Mesh) -> Vec<Part<'_>> {
    let triangles = mesh.triangles();
    let all = || (0..mesh.buffers.positions.len() as u32).collect();
    let Some((first, _)) = mesh.groups.first() else {
        return vec![Part { name: &mesh.name, vertices: all(), indices: mesh.buffers.indices.clone() }];
    };
    debug_assert_eq!(*first, 0, "the first triangle begins a group");
    let ends = mesh.groups.iter().skip(1).map(|(start, _)| *start).chain([triangles.len()]);
    // Where each vertex is among those of the part that has used it last.
    let mut places: Vec<Option<(usize, u32)>> = vec![None; mesh.buffers.positions.len()];
    let mut parts = Vec::with_capacity(mesh.groups.len());
    for (number, ((start, name), end)) in mesh.groups.iter().zip(ends).enumerate() {
        let mut vertices = Vec::new();
        let place = |vertex: &u32| match places[*vertex as usize] {
            Some((part, place)) if part == number => place,
            _ => {
                let place = vertices.len() as u32;
                places[*vertex as usize] = Some((number, place));
                vertices.push(*vertex);
                place
            }
        };
        let indices = triangles[*start..end].as_flattened().iter().map(place).collect();
        parts.push(Part { name, vertices, indices });
    }
    parts
}

/// What the file says about itself, and how many bytes of numbers follow.
fn describe(mesh: &Mesh, parts: &[Part<'_>]) -> (Value, u64) {
    let buffers = &mesh.buffers;
    let vertices: usize = parts.iter().map(|part| part.vertices.len()).sum();
    let corners: usize = parts.iter().map(|part| part.indices.len()).sum();
    let (mut views, mut end) = (Vec::new(), 0_u64);
    let mut add_view = |count: usize, stride: usize, target: u32| {
        let bytes = count * stride;
        let mut view = json!({ "buffer": 0, "byteOffset": end, "byteLength": bytes, "target": target });
        // Each view of vertices is that of all parts, so it must say how far apart they are.
        if target == ARRAY_BUFFER {
            view["byteStride"] = json!(stride);
        }
        views.push(view);
        end += bytes as u64;
        views.len() - 1
    };
    let positions = add_view(vertices, 12, ARRAY_BUFFER);
    let normals = (!buffers.normals.is_empty()).then(|| add_view(vertices, 12, ARRAY_BUFFER));
    let colors = (!buffers.colors.is_empty()).then(|| add_view(vertices, 4, ARRAY_BUFFER));
    let view_of_indices = add_view(corners, 4, ELEMENT_ARRAY_BUFFER);
    let (mut accessors, mut meshes, mut nodes) = (Vec::new(), Vec::new(), Vec::new());
    let (mut first_vertex, mut first_corner) = (0, 0);
    for Part { name, vertices, indices } in parts {
        let mut attributes = Map::new();
        let mut add = |attribute: &str, view: usize, stride: usize, mut accessor: Value| {
            attributes.insert(attribute.to_owned(), json!(accessors.len()));
            accessor["bufferView"] = json!(view);
            accessor["byteOffset"] = json!(stride * first_vertex);
            accessor["count"] = json!(vertices.len());
            accessors.push(accessor);
        };
        let (low, high) = bounds(vertices.iter().map(|vertex| &buffers.positions[*vertex as usize]));
        let position = json!({ "componentType": FLOAT, "type": "VEC3", "min": low, "max": high });
        add("POSITION", positions, 12, position);
        if let Some(normals) = normals {
            add("NORMAL", normals, 12, json!({ "componentType": FLOAT, "type": "VEC3" }));
        }
        if let Some(colors) = colors {
            let color = json!({ "componentType": UNSIGNED_BYTE, "normalized": true, "type": "VEC4" });
            add("COLOR_0", colors, 4, color);
        }
        let primitive =
            json!({ "attributes": attributes, "indices": accessors.len(), "material": 0, "mode": 4 });
        accessors.push(json!({
            "bufferView": view_of_indices, "byteOffset": 4 * first_corner, "componentType": UNSIGNED_INT,
            "count": indices.len(), "type": "SCALAR",
        }));
        let mut node = json!({ "name": name, "mesh": meshes.len() });
        if !mesh.is_at_origin() {
            node["translation"] = json!(mesh.origin);
        }
        nodes.push(node);
        meshes.push(json!({ "name": name, "primitives": [primitive] }));
        first_vertex += vertices.len();
        first_corner += indices.len();
    }
    let description = json!({
        "asset": { "version": "2.0", "generator": format!("fct {}", env!("CARGO_PKG_VERSION")) },
        "scene": 0,
        "scenes": [{ "nodes": (0..nodes.len()).collect::<Vec<_>>() }],
        "nodes": nodes,
        "meshes": meshes,
        // Without one a surface is metal, which is dark where nothing is to be mirrored.
        "materials": [{ "pbrMetallicRoughness": { "metallicFactor": 0.0, "roughnessFactor": 1.0 } }],
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{ "byteLength": end }],
    });
    (description, end)
}

/// The box of all positions.
fn bounds<'a>(positions: impl Iterator<Item = &'a [f32; 3]>) -> ([f32; 3], [f32; 3]) {
    let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for point in positions {
        for ((low, high), x) in low.iter_mut().zip(&mut high).zip(point) {
            *low = low.min(*x);
            *high = high.max(*x);
        }
    }
    (low, high)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mesh() -> Mesh {
        let mut mesh = Mesh::default();
        mesh.buffers.positions.extend([[0.1, -2.5, 3e-7], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 2.0]]);
        mesh.buffers.normals.extend([[0.0, 0.0, 1.0]; 4]);
        mesh.buffers.colors.extend([[255, 0, 51, 9]; 4]);
        mesh.buffers.indices.extend([2, 0, 1, 0, 2, 3]);
        mesh
    }

    fn read(mesh: &Mesh) -> (gltf::Document, Vec<u8>) {
        let mut bytes = Vec::new();
        write(mesh, &mut bytes, &mut || ()).unwrap();
        // The crate checks the description against the specification.
        let gltf::Gltf { document, blob } = gltf::Gltf::from_slice(&bytes).unwrap();
        (document, blob.unwrap())
    }

    #[test]
    fn what_was_written_is_read_by_the_gltf_crate() {
        let mesh = mesh();
        let (document, blob) = read(&mesh);
        let primitive = document.meshes().next().unwrap().primitives().next().unwrap();
        assert_eq!(primitive.mode(), gltf::mesh::Mode::Triangles);
        let reader = primitive.reader(|_| Some(&blob));
        assert_eq!(reader.read_positions().unwrap().collect::<Vec<_>>(), mesh.buffers.positions);
        assert_eq!(reader.read_normals().unwrap().collect::<Vec<_>>(), mesh.buffers.normals);
        assert_eq!(reader.read_colors(0).unwrap().into_rgba_u8().collect::<Vec<_>>(), mesh.buffers.colors);
        assert_eq!(reader.read_indices().unwrap().into_u32().collect::<Vec<_>>(), mesh.buffers.indices);
        let bounds = primitive.bounding_box();
        assert_eq!((bounds.min, bounds.max), ([0.0, -2.5, 0.0], [1.0, 1.0, 2.0]));
    }

    #[test]
    fn attributes_that_are_not_there_are_not_written() {
        let mut mesh = mesh();
        mesh.buffers.normals.clear();
        mesh.buffers.colors.clear();
        let (document, blob) = read(&mesh);
        assert_eq!(blob.len(), 4 * 12 + 6 * 4);
        let primitive = document.meshes().next().unwrap().primitives().next().unwrap();
        assert_eq!(primitive.attributes().count(), 1);
        let reader = primitive.reader(|_| Some(&blob));
        assert_eq!(reader.read_indices().unwrap().into_u32().collect::<Vec<_>>(), mesh.buffers.indices);
    }

    #[test]
    fn groups_are_nodes_and_the_origin_moves_them() {
        let mut mesh = mesh();
        mesh.groups = vec![(0, "left \"wing\"".to_owned()), (1, "tail".to_owned())];
        mesh.origin = [4096.0, 0.0, -2.0];
        let (document, blob) = read(&mesh);
        let scene = document.default_scene().unwrap();
        let names: Vec<_> = scene.nodes().map(|node| node.name().unwrap().to_owned()).collect();
        assert_eq!(names, ["left \"wing\"", "tail"]);
        let highest = [[1.0, 1.0, 3e-7], [0.1, 1.0, 2.0]];
        for ((node, expected), highest) in scene.nodes().zip([[2, 0, 1], [0, 2, 3]]).zip(highest) {
            assert_eq!(node.transform().decomposed().0, [4096.0, 0.0, -2.0]);
            let primitive = node.mesh().unwrap().primitives().next().unwrap();
            // Each has a box and vertices of its own.
            assert_eq!(primitive.bounding_box().max, highest);
            let reader = primitive.reader(|_| Some(&blob));
            let positions: Vec<_> = reader.read_positions().unwrap().collect();
            assert_eq!((positions.len(), reader.read_normals().unwrap().count()), (3, 3));
            let corners = reader.read_indices().unwrap().into_u32().map(|i| positions[i as usize]);
            assert_eq!(corners.collect::<Vec<_>>(), expected.map(|i| mesh.buffers.positions[i]));
        }
    }
}
