//! Promises of the glTF and GLB readers, by the entries of the catalogue of bad inputs.

use std::fs;

use serde_json::{Value, json};

use super::super::testing::{
    MAX_FACES, is_f64, read, read_limited, refuse_truncation, refused, shape, survive_damage, warned,
};
use super::super::{DropReason, ImportOptions, Soup, import};

/// Positions of a quad, two triangles as 16-bit indices, colours and normals, at known offsets.
fn binary() -> Vec<u8> {
    let mut out = Vec::new();
    for p in [[0.0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]] {
        out.extend(p.iter().flat_map(|x| x.to_le_bytes()));
    }
    out.extend([0u16, 1, 2, 0, 2, 3].iter().flat_map(|i| i.to_le_bytes()));
    out.extend([255, 0, 0, 255, 0, 255, 0, 128, 0, 0, 255, 255, 9, 9, 9, 9]);
    (0..4).for_each(|_| out.extend([0.0f32, 0.6, 0.8].iter().flat_map(|x| x.to_le_bytes())));
    out
}

fn scene() -> Value {
    json!({
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "name": "quad"}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]},
            {"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"},
            {"bufferView": 2, "componentType": 5121, "count": 4, "type": "VEC4", "normalized": true},
            {"bufferView": 3, "componentType": 5126, "count": 4, "type": "VEC3"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": 48},
            {"buffer": 0, "byteOffset": 48, "byteLength": 12},
            {"buffer": 0, "byteOffset": 60, "byteLength": 16},
            {"buffer": 0, "byteOffset": 76, "byteLength": 48},
        ],
        "buffers": [{"byteLength": 124}],
    })
}

fn chunk(kind: &[u8; 4], content: &[u8]) -> Vec<u8> {
    [&(content.len() as u32).to_le_bytes()[..], kind, content].concat()
}

fn container(version: u32, chunks: &[Vec<u8>]) -> Vec<u8> {
    let length = 12 + chunks.iter().map(Vec::len).sum::<usize>() as u32;
    [b"glTF", &version.to_le_bytes()[..], &length.to_le_bytes(), &chunks.concat()].concat()
}

fn padded(scene: &Value) -> Vec<u8> {
    let mut text = scene.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    text
}

fn glb(scene: &Value) -> Vec<u8> {
    container(2, &[chunk(b"JSON", &padded(scene)), chunk(b"BIN\0", &binary())])
}

/// The scene with the value at a JSON pointer replaced; a pointer to nothing adds a key.
fn with(pointer: &str, value: Value) -> Value {
    edit(scene(), &[(pointer, value)])
}

fn edit(mut scene: Value, edits: &[(&str, Value)]) -> Value {
    for (pointer, value) in edits {
        let (parent, key) = pointer.rsplit_once('/').unwrap();
        match scene.pointer_mut(parent).unwrap() {
            Value::Array(list) => list[key.parse::<usize>().unwrap()] = value.clone(),
            parent => parent[key] = value.clone(),
        }
    }
    scene
}

fn ok(scene: &Value) -> Soup {
    read("scene.glb", &glb(scene)).unwrap()
}

fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let digits = |group: &[u8]| {
        let n = (0..3).fold(0u32, |n, i| n << 8 | u32::from(*group.get(i).unwrap_or(&0)));
        (0..4)
            .map(
                move |i| {
                    if i > group.len() { '=' } else { DIGITS[(n >> (18 - 6 * i) & 63) as usize] as char }
                },
            )
            .collect::<String>()
    };
    bytes.chunks(3).map(digits).collect()
}

fn embedded(scene: &Value) -> Vec<u8> {
    let uri = format!("data:application/octet-stream;base64,{}", base64(&binary()));
    edit(scene.clone(), &[("/buffers/0/uri", json!(uri))]).to_string().into_bytes()
}

#[test]
fn container_and_document_agree() {
    let a = ok(&scene());
    let b = read("scene.gltf", &embedded(&scene())).unwrap();
    assert_eq!(a, b);
    assert_eq!(a.triangles, [[0, 1, 2], [0, 2, 3]]);
    assert_eq!((a.groups[0].name.as_str(), is_f64(&a), a.tally.warnings.len()), ("quad", false, 0));
}

#[test]
fn attributes_are_read() {
    let soup =
        ok(&with("/meshes/0/primitives/0/attributes", json!({"POSITION": 0, "COLOR_0": 2, "NORMAL": 3})));
    assert_eq!(soup.colors.unwrap()[1], [0, 255, 0, 128]);
    assert_eq!(soup.normals.unwrap()[3], [0.0, 0.6, 0.8]);
}

#[test]
fn transforms_apply_along_the_tree_and_mirrors_turn_the_winding() {
    let soup = ok(&edit(
        scene(),
        &[
            ("/scenes/0/nodes", json!([0, 3])),
            (
                "/nodes",
                json!([
                    {"children": [1, 2], "translation": [10, 0, 0]},
                    {"mesh": 0, "rotation": [0, 0, 1, 1], "scale": [2, 1, 1], "name": "turned"},
                    {"mesh": 0, "matrix": [-1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]},
                    {"mesh": 0, "scale": [1, 0, 1]},
                ]),
            ),
            ("/meshes/0/name", json!("plate")),
            ("/meshes/0/primitives/0/attributes", json!({"POSITION": 0, "NORMAL": 3})),
        ],
    ));
    assert!(is_f64(&soup));
    let names: Vec<_> = soup.groups.iter().map(|g| (g.name.as_str(), g.triangles.len())).collect();
    assert_eq!(names, [("turned", 2), ("plate", 2), ("plate", 2)]);
    let close = |a: [f64; 3], b: [f64; 3]| a.iter().zip(&b).all(|(a, b)| (a - b).abs() < 1e-7);
    let shapes = shape(&soup);
    assert!(close(shapes[0][1], [10.0, 2.0, 0.0]) && close(shapes[0][2], [9.0, 2.0, 0.0]), "{:?}", shapes[0]);
    assert_eq!(shapes[2], [[10.0, 0.0, 0.0], [9.0, 1.0, 0.0], [9.0, 0.0, 0.0]]);
    assert_eq!(warned(&soup, "flattened_meshes"), 1);
    // Normals follow: a quarter turn about z with a stretch along x, and a mirror that leaves y and z.
    let normals = soup.normals.unwrap();
    assert!(close(normals[0].map(f64::from), [-0.6, 0.0, 0.8]), "{:?}", normals[0]);
    assert!(close(normals[4].map(f64::from), [0.0, 0.6, 0.8]), "{:?}", normals[4]);
}

#[test]
fn strips_fans_points_and_missing_indices() {
    let mode = |m: u32| with("/meshes/0/primitives/0", json!({"attributes": {"POSITION": 0}, "mode": m}));
    assert_eq!(ok(&mode(5)).triangles, [[0, 1, 2], [2, 1, 3]]);
    assert_eq!(ok(&mode(6)).triangles, [[0, 1, 2], [0, 2, 3]]);
    let soup = ok(&mode(4));
    assert_eq!((soup.triangles.len(), soup.tally.dropped.count(DropReason::TooFewVertices)), (1, 1));
    let both =
        json!([{"attributes": {"POSITION": 0}, "mode": 0}, {"attributes": {"POSITION": 0}, "indices": 1}]);
    let soup = ok(&with("/meshes/0/primitives", both));
    assert_eq!((soup.triangles.len(), soup.tally.dropped.count(DropReason::NotTriangles)), (2, 1));
}

#[test]
fn sparse_values_replace_the_base() {
    let sparse = |indices: u64, count: u64| {
        with(
            "/accessors/0/sparse",
            json!({"count": count,
                "indices": {"bufferView": 1, "byteOffset": indices, "componentType": 5123},
                "values": {"bufferView": 3}}),
        )
    };
    // The index buffer holds 0 1 2 0 2 3, of which 1 2 rises.
    let soup = ok(&sparse(2, 2));
    let at = |i| soup.positions.get(i).unwrap();
    assert_eq!(
        (at(0), at(1)[2], at(2)[2], at(3)),
        ([0.0; 3], f64::from(0.8f32), f64::from(0.8f32), [0.0, 1.0, 0.0])
    );
    refused("G10 unsorted", "s.glb", &glb(&sparse(2, 3)), "FC211", "accessors[0].sparse.indices: index 0");
    refused("G10 none", "s.glb", &glb(&sparse(2, 0)), "FC211", "accessors[0].sparse.count");
    refused("G10 too many", "s.glb", &glb(&sparse(2, 5)), "FC211", "5 of 4");
    refused("G10 beyond", "s.glb", &glb(&sparse(10, 2)), "FC211", "do not lie");
    let mut zeros = scene();
    zeros["accessors"][0].as_object_mut().unwrap().remove("bufferView");
    assert_eq!(shape(&ok(&zeros)), [[[0.0; 3]; 3]; 2]);
}

#[test]
fn broken_containers_are_refused() {
    let good = glb(&scene());
    let patched = |at: usize, value: u32| {
        let mut bytes = good.clone();
        bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
        bytes
    };
    let json = || chunk(b"JSON", &padded(&scene()));
    let cases: Vec<(&str, Vec<u8>, &str, &str)> = vec![
        ("G1 short", b"glTF\x02\0\0\0".to_vec(), "FC204", "12 bytes"),
        ("G1 length 0", patched(8, 0), "FC202", "byte 8"),
        ("G1 length too large", patched(8, good.len() as u32 + 4), "FC204", "byte 8"),
        ("G1 chunk beyond", patched(12, 1 << 20), "FC204", "byte 12: chunk 0 declares 1048576 bytes"),
        ("G1 two documents", container(2, &[json(), json()]), "FC202", "two JSON chunks"),
        ("G1 no document", container(2, &[chunk(b"BIN\0", &binary())]), "FC202", "first chunk"),
        ("G1 misaligned", container(2, &[chunk(b"JSON", b"{} ")]), "FC202", "multiple of 4"),
        ("G2 version 1", container(1, &[json()]), "FC209", "version 1"),
        ("G2 version 3", container(3, &[json()]), "FC209", "version 3"),
    ];
    for (what, bytes, code, part) in cases {
        refused(what, "scene.glb", &bytes, code, part);
    }
    let more = [good.clone(), vec![0; 3]].concat();
    assert_eq!(warned(&read("scene.glb", &more).unwrap(), "trailing_bytes"), 1);
    let unknown = container(2, &[json(), chunk(b"BIN\0", &binary()), chunk(b"XTRA", b"1234")]);
    assert_eq!(read("scene.glb", &unknown).unwrap(), ok(&scene()));
}

#[test]
fn broken_scenes_are_refused() {
    let accessor = |field: &str, value: Value| with(&format!("/accessors/0/{field}"), value);
    let nodes = |nodes: Value| with("/nodes", nodes);
    let deep = |depth: usize| {
        let mut list: Vec<Value> = (0..depth).map(|i| json!({"children": [i + 1]})).collect();
        list.push(json!({"mesh": 0}));
        nodes(json!(list))
    };
    let uri = |uri: &str| with("/buffers/0/uri", json!(uri));
    let extension = |name: &str| with("/extensionsRequired", json!([name]));
    let float_indices =
        [("/accessors/1/componentType", json!(5126)), ("/bufferViews/1/byteLength", json!(24))];
    let float_indices = edit(scene(), &float_indices);
    let cases: Vec<(&str, Value, &str, &str)> = vec![
        ("G2 asset", with("/asset/version", json!("1.0")), "FC209", "asset.version"),
        ("G4 count 0", accessor("count", json!(0)), "FC211", "accessors[0].count"),
        ("G4 count 5", accessor("count", json!(5)), "FC211", "accessors[0].count: 5 elements"),
        ("G4 count 2^60", accessor("count", json!(1u64 << 60)), "FC211", "accessors[0].count"),
        ("G5 offset wraps", accessor("byteOffset", json!(u64::MAX)), "FC211", "accessors[0].count"),
        (
            "G5 view wraps",
            with("/bufferViews/0/byteOffset", json!(u64::MAX)),
            "FC211",
            "bufferViews[0].byteLength",
        ),
        (
            "G5 view beyond",
            with("/bufferViews/0/byteLength", json!(125)),
            "FC211",
            "do not lie in the buffer of 124",
        ),
        ("G5 buffer beyond", with("/buffers/0/byteLength", json!(1000)), "FC204", "buffers[0].byteLength"),
        ("G5 buffer missing", with("/bufferViews/0/buffer", json!(3)), "FC211", "buffers[3]"),
        ("G5 view missing", accessor("bufferView", json!(9)), "FC211", "buffer view 9 of 4"),
        ("G6 stride", with("/bufferViews/0/byteStride", json!(8)), "FC211", "bufferViews[0].byteStride"),
        ("G7 float indices", float_indices, "FC211", "accessors[1].componentType"),
        ("G7 signed indices", with("/accessors/1/componentType", json!(5122)), "FC211", "unsigned"),
        ("G8 scalar", accessor("type", json!("SCALAR")), "FC208", "attributes.POSITION"),
        ("G8 unknown type", accessor("type", json!("VEC9")), "FC211", "accessors[0].type"),
        ("G8 short", accessor("componentType", json!(5122)), "FC208", "VEC3 of FLOAT"),
        ("G8 none", with("/meshes/0/primitives/0/attributes", json!({})), "FC208", "no POSITION"),
        (
            "G9 index",
            accessor("count", json!(3)),
            "FC203",
            "meshes[0].primitives[0].indices: index 5 uses vertex 3 of 3",
        ),
        ("accessor missing", with("/meshes/0/primitives/0/indices", json!(77)), "FC211", "accessor 77 of 4"),
        ("G12 own child", nodes(json!([{"mesh": 0}, {"children": [1]}])), "FC211", "cycle"),
        ("G12 cycle", nodes(json!([{"mesh": 0}, {"children": [2]}, {"children": [1]}])), "FC211", "each of"),
        (
            "G12 root has parent",
            nodes(json!([{"mesh": 0}, {"children": [0]}])),
            "FC211",
            "scenes[0].nodes[0]",
        ),
        (
            "G12 two parents",
            nodes(json!([{"children": [2]}, {"children": [2]}, {}])),
            "FC211",
            "two parents, 0 and 1",
        ),
        ("G12 deep", deep(1024), "FC504", "deeper than 1024"),
        ("child missing", nodes(json!([{"children": [8]}])), "FC211", "node 8 of 1"),
        ("mesh missing", nodes(json!([{"mesh": 4}])), "FC211", "mesh 4 of 1"),
        ("scene missing", with("/scene", json!(7)), "FC211", "scene 7 of 1"),
        ("G13 parent", uri("../scene.bin"), "FC212", "buffers[0].uri"),
        ("G13 coded parent", uri("%2e%2e/scene.bin"), "FC212", "leads out"),
        ("G13 absolute", uri("/etc/passwd"), "FC212", "leads out"),
        ("G13 file", uri("file:///etc/passwd"), "FC212", "leads out"),
        ("G13 http", uri("http://example.org/a.bin"), "FC212", "leads out"),
        ("G13 share", uri("\\\\host\\share"), "FC212", "leads out"),
        ("G13 bytes", uri("a%FF.bin"), "FC202", "malformed"),
        ("G14 base64", uri("data:;base64,AA*A"), "FC202", "buffers[0].uri: character 2"),
        ("G15 draco", extension("KHR_draco_mesh_compression"), "FC209", "KHR_draco_mesh_compression"),
        ("G15 meshopt", extension("EXT_meshopt_compression"), "FC209", "extensionsRequired[0]"),
        ("G16 mode", with("/meshes/0/primitives/0/mode", json!(9)), "FC211", "mode"),
        ("G18 missing file", uri("nowhere/missing.bin"), "FC401", "cannot open"),
        (
            "G19 not affine",
            nodes(json!([{"mesh": 0, "matrix": [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,2]}])),
            "FC211",
            "last row",
        ),
        ("G19 rotation", nodes(json!([{"mesh": 0, "rotation": [0, 0, 0, 0]}])), "FC211", "quaternion"),
        ("no meshes", with("/scenes/0/nodes", json!([])), "FC207", "no faces"),
        ("wrong shape", with("/meshes", json!({"a": 1})), "FC202", "no glTF scene"),
    ];
    for (what, scene, code, part) in cases {
        if code == "FC401" {
            let e = read("scene.glb", &glb(&scene)).unwrap_err();
            assert_eq!((e.code(), e.exit_code()), (code, 4));
            continue;
        }
        let e = refused(what, "scene.glb", &glb(&scene), code, part);
        assert_eq!(e.exit_code(), if code.starts_with("FC5") { 5 } else { 3 }, "{what}");
    }
    assert_eq!(ok(&deep(1023)).triangles.len(), 2);
    assert_eq!(ok(&extension("KHR_materials_unlit")).triangles.len(), 2);
    let nested = format!("{{\"asset\":{}1{}}}", "[".repeat(200), "]".repeat(200));
    refused("G3 depth", "scene.gltf", nested.as_bytes(), "FC504", "deeper than 128");
    refused("G3 size", "scene.gltf", &vec![b' '; (64 << 20) + 1], "FC504", "67108864");
    refused("cut off", "scene.gltf", b"{\n\"asset\":\n", "FC202", "line 3");
}

#[test]
fn instances_are_counted_before_they_are_made() {
    let nodes: Vec<Value> = (0..100_000).map(|_| json!({"mesh": 0})).collect();
    let roots: Vec<usize> = (0..nodes.len()).collect();
    let many = edit(scene(), &[("/nodes", json!(nodes)), ("/scenes/0/nodes", json!(roots))]);
    let e = read_limited("scene.glb", &glb(&many), 199_999).unwrap_err();
    assert_eq!((e.code(), e.exit_code()), ("FC501", 5));
    assert_eq!(ok(&many).triangles.len(), 200_000);
}

#[test]
fn buffers_beside_the_scene_are_read_but_none_outside() {
    let dir = tempfile::tempdir().unwrap();
    let inside = dir.path().join("in/deep");
    fs::create_dir_all(&inside).unwrap();
    fs::write(dir.path().join("outside.bin"), binary()).unwrap();
    fs::write(inside.join("a b.bin"), binary()).unwrap();
    let path = dir.path().join("in/scene.gltf");
    let options = ImportOptions { max_faces: MAX_FACES, progress: &|_, _| {} };
    let outcome = |uri: &str| {
        fs::write(&path, with("/buffers/0/uri", json!(uri)).to_string()).unwrap();
        import(&path, &options)
    };
    assert_eq!(outcome("deep/a%20b.bin").unwrap().triangles.len(), 2);
    assert_eq!(outcome("./deep/a b.bin").unwrap().triangles.len(), 2);
    assert_eq!(outcome("deep").unwrap_err().exit_code(), 4);
    assert_eq!(outcome("gone.bin").unwrap_err().code(), "FC401");
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(dir.path().join("outside.bin"), inside.join("link.bin")).unwrap();
        assert_eq!(outcome("deep/link.bin").unwrap_err().code(), "FC212");
    }
}

#[test]
fn every_truncation_is_refused() {
    refuse_truncation("scene.glb", &glb(&scene()), |_| false);
    let text = embedded(&scene());
    refuse_truncation("scene.gltf", &text, |_| false);
}

#[test]
fn damage_never_panics() {
    let tree = edit(
        scene(),
        &[(
            "/nodes",
            json!([{"children": [1, 2]}, {"mesh": 0, "scale": [2, 1, 1]}, {"mesh": 0, "rotation": [0, 0, 1, 0]}]),
        )],
    );
    survive_damage("scene.glb", &[glb(&scene()), glb(&tree)], 2000);
    survive_damage("scene.gltf", &[embedded(&scene()), embedded(&tree)], 2000);
}
