//! Promise: what is written is what is read, and the same data makes the same bytes.

mod sample;

use fct::{Child, ChildRef, LOOP_END, Tree, WriteOptions};
use sample::{Sample, Split};

#[test]
fn everything_survives() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.fct");
    let sample = Sample::patches(4, 3);
    let options = WriteOptions { source_id: 77, ..WriteOptions::default() };
    let written = fct::write(&path, &sample.data(), &options).unwrap();
    let tree = Tree::open(&path).unwrap();

    assert_eq!(tree.root(), sample.root);
    assert_eq!(tree.meta(), &sample.meta);
    assert_eq!(tree.nodes(), sample.nodes);
    assert_eq!(tree.vertices(), sample.vertices);
    assert_eq!(tree.faces(), sample.faces);
    assert_eq!(tree.loops(), sample.loops);
    assert_eq!(tree.weld(), sample.weld);
    assert_eq!(tree.bounding_polygons(), sample.bounding_polygons);
    assert_eq!(tree.normals(), sample.normals.as_deref());
    assert_eq!(tree.colors(), sample.colors.as_deref());
    assert_eq!(tree.groups(), sample.groups);
    assert_eq!(tree.header().source_id, 77);
    assert_eq!(tree.header().content_id, written.content_id);
    assert_eq!(written.bytes, std::fs::metadata(&path).unwrap().len());
    let listed: Vec<_> = tree.sections().iter().map(|s| (s.tag.to_string(), s.length)).collect();
    assert_eq!(written.sections, listed);

    let verified = tree.verify().unwrap();
    assert_eq!(verified.faces, 48);
    assert_eq!(verified.nodes, 47);
    assert_eq!(verified.depth, sample.meta.depth);
    assert_eq!(verified.loop_entries, sample.loops.len() as u64);
}

#[test]
fn sections_left_out_read_as_nothing() {
    let sample = Sample::fan(5, Split::Halves);
    let tree = sample.tree();
    assert_eq!(tree.normals(), None);
    assert_eq!(tree.colors(), None);
    assert!(tree.weld().is_empty() && tree.bounding_polygons().is_empty());
    assert!(tree.groups().is_empty());
    assert_eq!(tree.sections().len(), 5);
    tree.verify().unwrap();
}

#[test]
fn a_single_face_is_a_tree_without_nodes() {
    let tree = Sample::fan(1, Split::Halves).tree();
    assert_eq!(tree.root(), ChildRef::face(0));
    assert!(tree.nodes().is_empty());
    assert_eq!(tree.face(0).unwrap(), [0, 1, 2]);
    assert_eq!(tree.verify().unwrap().depth, 0);
}

#[test]
fn two_faces_have_one_node() {
    let tree = Sample::fan(2, Split::Halves).tree();
    let children = tree.children(0, 2).unwrap();
    assert_eq!(children.map(|c| c.child), [ChildRef::face(0), ChildRef::face(1)]);
    assert_eq!(tree.verify().unwrap().depth, 1);
}

#[test]
fn the_same_data_makes_the_same_bytes() {
    let sample = Sample::patches(3, 2);
    assert_eq!(sample.bytes(), sample.bytes());
}

#[test]
fn the_content_id_tells_the_content_not_the_source() {
    let folder = tempfile::tempdir().unwrap();
    let sample = Sample::fan(4, Split::Halves);
    let ids = [1, 2].map(|source_id| {
        let path = folder.path().join(format!("{source_id}.fct"));
        let options = WriteOptions { source_id, ..WriteOptions::default() };
        fct::write(&path, &sample.data(), &options).unwrap().content_id
    });
    assert_eq!(ids[0], ids[1]);
    let mut other = sample.clone();
    other.nodes[0].epsilon = 0.5.into();
    assert_ne!(other.tree().header().content_id, ids[0]);
}

#[test]
fn a_walk_by_children_meets_every_node_and_face_once_in_order() {
    let tree = Sample::patches(5, 4).tree();
    let (mut nodes, mut faces) = (Vec::new(), Vec::new());
    let mut stack = vec![tree.whole()];
    while let Some(subtree) = stack.pop() {
        match subtree.child.kind() {
            Child::Face(face) => faces.push(face),
            Child::Node(node) => {
                nodes.push(node);
                let [left, right] = tree.children(node, subtree.face_end).unwrap();
                assert_eq!(left.face_end, right.first_face);
                stack.extend([right, left]);
            }
        }
    }
    assert!(nodes.iter().copied().eq(0..tree.nodes().len() as u32));
    assert!(faces.iter().copied().eq(0..tree.faces().len() as u32));
}

#[test]
fn loops_are_handed_out_one_by_one() {
    let tree = Sample::patches(4, 3).tree();
    // The virtual root owns two patches, each with its rim.
    let rims: Vec<Vec<u32>> = tree.loops_of(0).unwrap().map(|l| l.vertices().collect()).collect();
    assert_eq!(rims.iter().map(Vec::len).collect::<Vec<_>>(), [14, 14]);
    assert!(rims.iter().flatten().all(|v| v & LOOP_END == 0));
}
