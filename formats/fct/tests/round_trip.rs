//! Promise: what is written is what is read, and the same data makes the same bytes.

mod sample;

use fct::{Child, ChildRef, Plan, SMALL_FACES, Tree, WriteOptions};
use sample::{Sample, Split};

#[test]
fn everything_survives() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.fct");
    let sample = Sample::patches(4, 3, 24);
    let options = WriteOptions { source_id: 77, ..WriteOptions::default() };
    let written = fct::write(&path, &sample.data(), &options).unwrap();
    let tree = Tree::open(&path).unwrap();

    assert_eq!(tree.meta(), &sample.meta);
    assert_eq!(tree.vertices(), sample.vertices);
    assert_eq!(tree.faces().unwrap(), sample.plain.faces);
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
    let drawn = sample.plain.boundaries.iter().skip(1);
    assert_eq!(verified.loop_entries, drawn.map(|b| b.len() as u64).sum::<u64>());
}

#[test]
fn sections_left_out_read_as_nothing() {
    let sample = Sample::fan(5, Split::Halves);
    let tree = sample.tree();
    assert_eq!(tree.normals(), None);
    assert_eq!(tree.colors(), None);
    assert!(tree.weld().is_empty() && tree.bounding_polygons().is_empty());
    assert!(tree.groups().is_empty());
    assert_eq!(tree.sections().len(), 9);
    tree.verify().unwrap();
}

#[test]
fn a_single_face_is_a_tree_without_nodes() {
    let tree = Sample::fan(1, Split::Halves).tree();
    assert_eq!(tree.root(), ChildRef::face(0));
    assert_eq!(tree.header().node_count, 0);
    assert_eq!(tree.reader().face(&tree.whole()).unwrap(), [0, 1, 2]);
    assert_eq!(tree.verify().unwrap().depth, 0);
}

#[test]
fn two_faces_have_one_node() {
    let tree = Sample::fan(2, Split::Halves).tree();
    let children = tree.children(&tree.whole()).unwrap();
    assert_eq!(children.map(|c| c.child), [ChildRef::face(0), ChildRef::face(1)]);
    assert_eq!(tree.verify().unwrap().depth, 1);
}

#[test]
fn the_same_data_makes_the_same_bytes() {
    let sample = Sample::patches(3, 2, 5);
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
    other.packed.nodes[0].epsilon += 1;
    assert_ne!(other.tree().header().content_id, ids[0]);
}

#[test]
fn a_walk_by_children_meets_every_node_and_face_once_in_order() {
    let tree = Sample::patches(5, 4, 17).tree();
    let (mut nodes, mut faces) = (Vec::new(), Vec::new());
    let mut stack = vec![tree.whole()];
    while let Some(subtree) = stack.pop() {
        match subtree.child.kind() {
            Child::Face(face) => faces.push(face),
            Child::Node(node) => {
                nodes.push(node);
                assert_eq!(tree.find(subtree.child).unwrap(), subtree);
                let [left, right] = tree.children(&subtree).unwrap();
                assert_eq!(left.face_end, right.first_face);
                stack.extend([right, left]);
            }
        }
    }
    assert!(nodes.iter().copied().eq(0..tree.header().node_count as u32));
    assert!(faces.iter().copied().eq(0..tree.face_count() as u32));
    assert!(tree.find(ChildRef::node(nodes.len() as u32)).is_err());
    assert!(tree.find(ChildRef::face(faces.len() as u32)).is_err());
}

/// In pages of every size, a single face included, and asked for in any order.
#[test]
fn a_packer_decodes_what_a_reader_reads() {
    for page_faces in [1, 2, 7, 30, 253] {
        let sample = Sample::patches(7, 5, page_faces);
        let tree = sample.tree();
        let plan = Plan::new(&sample.plain, page_faces).unwrap();
        let mut decoded = sample.packed.decoded(&plan);
        let mut stack = vec![tree.whole()];
        while let Some(subtree) = stack.pop() {
            let Child::Node(index) = subtree.child.kind() else { continue };
            assert_eq!(decoded.node(index), Some(tree.node(&subtree).unwrap()));
            stack.extend(tree.children(&subtree).unwrap());
        }
        assert_eq!(decoded.node(sample.plain.clusters.len() as u32), None);
    }
}

/// In pages of every size: what is decoded holds what was packed, and little more.
#[test]
fn packing_errs_on_the_safe_side() {
    for page_faces in [1, 2, 7, 30, 253] {
        let sample = Sample::patches(7, 5, page_faces);
        let tree = sample.tree();
        tree.verify().unwrap_or_else(|e| panic!("pages of {page_faces}: {e}"));
        let mut stack = vec![tree.whole()];
        while let Some(subtree) = stack.pop() {
            let Child::Node(index) = subtree.child.kind() else { continue };
            let (node, plain) = (tree.node(&subtree).unwrap(), &sample.plain.clusters[index as usize]);
            for (stored, exact) in [(node.bound, plain.bound), (node.budget, plain.budget)] {
                assert!(stored >= exact && (stored <= exact * 1.01 || exact == f32::INFINITY));
            }
            assert!(node.cos() <= plain.cos && node.cos() > plain.cos - 0.02);
            assert!((node.epsilon().sqrt() - 0.5).abs() < 0.035);
            let corners = subtree.of(&sample.plain.faces).iter().flatten();
            let corners: Vec<[f32; 3]> = corners.map(|v| sample.plain.positions[*v as usize]).collect();
            let distance = |a: &[f32; 3], b: &[f32; 3]| {
                a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f32>().sqrt()
            };
            let apart = corners.iter().flat_map(|a| corners.iter().map(move |b| distance(a, b)));
            // No sphere is smaller than half the way between two corners.
            let least = 0.5 * apart.fold(0.0, f32::max);
            assert!(node.radius < 1.5 * least, "{subtree}: {} around {least}", node.radius);
            let boundary = &sample.plain.boundaries[index as usize];
            let loops = tree.loops_of(&subtree).unwrap();
            let drawn = node.bound < f32::INFINITY || subtree.face_count() <= SMALL_FACES;
            assert_eq!(loops.vertices.len(), if drawn { boundary.len() } else { 0 });
            stack.extend(tree.children(&subtree).unwrap());
        }
    }
}

#[test]
fn loops_are_handed_out_one_by_one() {
    for page_faces in [5, 24, 253] {
        let mut sample = Sample::patches(4, 3, page_faces);
        sample.plain.clusters[0].bound = 1e3;
        sample.pack();
        let tree = sample.tree();
        // The root owns two patches, each with its rim.
        let rims = tree.loops_of(&tree.whole()).unwrap();
        assert_eq!(rims.iter().map(<[u32]>::len).collect::<Vec<_>>(), [14, 14]);
        let entries = rims.iter().flat_map(|rim| {
            rim.iter().enumerate().map(|(i, v)| if i + 1 == rim.len() { v | fct::LOOP_END } else { *v })
        });
        assert!(entries.eq(sample.plain.boundaries[0].iter().copied()));
    }
}
