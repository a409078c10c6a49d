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

/// Writes `mesh`. The tree's groups become nodes with their names, which share the vertices; an origin becomes the
/// translation of them all, since coordinates are in single precision here. `step` is called for each vertex and each triangle.
///
/// # Errors
/// Those of the writer, and `FileTooLarge` beyond the 4 GiB that the format can count.
pub(crate) fn write(mesh: &Mesh, out: &mut impl Write, step: &mut dyn FnMut()) -> io::Result<()> {
    let (description, numbers) = describe(mesh);
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
    for position in &buffers.positions {
        step();
        write_words(out, &position.map(f32::to_bits))?;
    }
    for normal in &buffers.normals {
        write_words(out, &normal.map(f32::to_bits))?;
    }
    out.write_all(buffers.colors.as_flattened())?;
    for triangle in mesh.triangles() {
        step();
        write_words(out, triangle)?;
    }
    Ok(())
}

fn write_words(out: &mut impl Write, words: &[u32]) -> io::Result<()> {
    words.iter().try_for_each(|word| out.write_all(&word.to_le_bytes()))
}

/// What the file says about itself, and how many bytes of numbers follow.
fn describe(mesh: &Mesh) -> (Value, u64) {
    let buffers = &mesh.buffers;
    let vertices = buffers.positions.len();
    let (mut views, mut accessors, mut attributes) = (Vec::new(), Vec::new(), Map::new());
    let mut end = 0_u64;
    let mut add_view = |bytes: usize, target: u32| {
        views.push(json!({ "buffer": 0, "byteOffset": end, "byteLength": bytes, "target": target }));
        end += bytes as u64;
        views.len() - 1
    };
    let (low, high) = bounds(&buffers.positions);
    attributes.insert("POSITION".to_owned(), json!(accessors.len()));
    accessors.push(json!({
        "bufferView": add_view(12 * vertices, ARRAY_BUFFER), "componentType": FLOAT, "count": vertices,
        "type": "VEC3", "min": low, "max": high,
    }));
    if !buffers.normals.is_empty() {
        attributes.insert("NORMAL".to_owned(), json!(accessors.len()));
        accessors.push(json!({
            "bufferView": add_view(12 * vertices, ARRAY_BUFFER), "componentType": FLOAT, "count": vertices,
            "type": "VEC3",
        }));
    }
    if !buffers.colors.is_empty() {
        attributes.insert("COLOR_0".to_owned(), json!(accessors.len()));
        accessors.push(json!({
            "bufferView": add_view(4 * vertices, ARRAY_BUFFER), "componentType": UNSIGNED_BYTE,
            "normalized": true, "count": vertices, "type": "VEC4",
        }));
    }
    let triangles = mesh.triangles().len();
    let view = add_view(12 * triangles, ELEMENT_ARRAY_BUFFER);
    let (mut meshes, mut nodes) = (Vec::new(), Vec::new());
    for (name, first, end) in parts(mesh, triangles) {
        let material_free = json!({ "attributes": &attributes, "indices": accessors.len(), "mode": 4 });
        accessors.push(json!({
            "bufferView": view, "byteOffset": 12 * first, "componentType": UNSIGNED_INT,
            "count": 3 * (end - first), "type": "SCALAR",
        }));
        let mut node = json!({ "name": name, "mesh": meshes.len() });
        if !mesh.is_at_origin()
            && let Some(node) = node.as_object_mut()
        {
            node.insert("translation".to_owned(), json!(mesh.origin));
        }
        nodes.push(node);
        meshes.push(json!({ "name": name, "primitives": [material_free] }));
    }
    let description = json!({
        "asset": { "version": "2.0", "generator": format!("fct {}", env!("CARGO_PKG_VERSION")) },
        "scene": 0,
        "scenes": [{ "nodes": (0..nodes.len()).collect::<Vec<_>>() }],
        "nodes": nodes,
        "meshes": meshes,
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{ "byteLength": end }],
    });
    (description, end)
}

/// The groups' names and their triangles; all triangles where there are no groups.
fn parts(mesh: &Mesh, triangles: usize) -> Vec<(&str, usize, usize)> {
    let Some((first, _)) = mesh.groups.first() else { return vec![("mesh", 0, triangles)] };
    debug_assert_eq!(*first, 0, "the first triangle begins a group");
    let ends = mesh.groups.iter().skip(1).map(|(start, _)| *start).chain([triangles]);
    mesh.groups.iter().zip(ends).map(|((start, name), end)| (name.as_str(), *start, end)).collect()
}

/// The box of all positions.
fn bounds(positions: &[[f32; 3]]) -> ([f32; 3], [f32; 3]) {
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
        for (node, expected) in scene.nodes().zip([[2, 0, 1], [0, 2, 3]]) {
            assert_eq!(node.transform().decomposed().0, [4096.0, 0.0, -2.0]);
            let primitive = node.mesh().unwrap().primitives().next().unwrap();
            let indices = primitive.reader(|_| Some(&blob)).read_indices().unwrap().into_u32();
            assert_eq!(indices.collect::<Vec<_>>(), expected);
        }
    }
}
