//! Which subtrees the objects of the input became.

use crate::import::Tally;
use crate::mesh::Mesh;
use crate::partition::{Hierarchy, Subtree};
use fct::{ChildRef, GroupRecord, U32};

/// The most groups a file names, and the most bytes their names may take: they share its description of 1 MiB.
const MAX_GROUPS: usize = 1 << 14;
const MAX_GROUP_NAMES: usize = 1 << 19;

/// The highest subtree of each group that still has faces, in tree order, and the groups' names in that order; none
/// of either, and a warning, if there are too many.
pub(crate) fn records(
    mesh: &Mesh,
    hierarchy: &Hierarchy,
    tally: &mut Tally,
) -> (Vec<GroupRecord>, Vec<String>) {
    let (mut records, mut names) = (Vec::new(), Vec::new());
    if mesh.face_group.is_empty() {
        return (records, names);
    }
    let group_at = |i: usize| mesh.face_group[hierarchy.order[i] as usize];
    let mut stack = vec![Subtree::whole(hierarchy.order.len())];
    while let Some(at) = stack.pop() {
        let (first, faces) = (at.faces.start, at.faces.len());
        if group_at(first) == group_at(first + faces - 1) {
            let root =
                if at.is_face() { ChildRef::face(first as u32) } else { ChildRef::node(at.node as u32) };
            records.push(GroupRecord {
                root: U32::new(root.raw()),
                first_face: U32::new(first as u32),
                face_count: U32::new(faces as u32),
                name: U32::new(names.len() as u32),
            });
            names.push(mesh.group_names[group_at(first) as usize].clone());
        } else {
            let [left, right] = at.children(&hierarchy.splits);
            stack.push(right);
            stack.push(left);
        }
    }
    if names.len() > MAX_GROUPS || names.iter().map(String::len).sum::<usize>() > MAX_GROUP_NAMES {
        let n = names.len() as u64;
        tally.warn("FC295", n, "these are more groups than a file keeps the names of; the tree has none");
        return (Vec::new(), Vec::new());
    }
    (records, names)
}
