//! The top of the tree: virtual nodes that join the components of a mesh.

use super::cluster::{Job, Patch, Room, SERIAL_BELOW, Scratch, Shape, split_down};
use super::hierarchy::{Hierarchy, Split, depth};
use super::side::Side;
use super::{SplitMode, balance};
use crate::mesh::{Components, Mesh, NONE};
use fcgeom::FaceMoments;
use glam::DVec3;
use rayon::prelude::*;

/// Partitions every component and joins their roots: groups first, inside a group by a median split of the
/// component centroids along the longest side of their box.
pub(super) fn join_components(
    mesh: &Mesh,
    components: &Components,
    mode: SplitMode,
    progress: &(dyn Fn(u64) + Sync),
) -> Hierarchy {
    // Places the components in tree order first; a component's faces are then one contiguous run.
    let (list, joins) = order(components);

    let n = mesh.faces.len();
    let mut face: Vec<u32> =
        list.iter().flat_map(|&c| components.faces_of(c as usize).iter().copied()).collect();
    let mut place = vec![0_u32; n];
    for &c in &list {
        for (i, &f) in components.faces_of(c as usize).iter().enumerate() {
            place[f as usize] = i as u32;
        }
    }
    let corner = |v: u32| mesh.positions[v as usize];
    let mut moments: Vec<FaceMoments> = face
        .par_iter()
        .map(|&f| {
            let [a, b, c] = mesh.faces[f as usize].map(corner);
            FaceMoments::of_triangle(a, b, c)
        })
        .collect();
    let mut adjacent: Vec<[u32; 3]> = face
        .par_iter()
        .map(|&f| {
            [0, 1, 2].map(|e| match mesh.graph.opposite[f as usize * 3 + e] {
                NONE => NONE,
                across => place[across as usize / 3],
            })
        })
        .collect();
    drop(place);

    let mut other_moments = moments.clone();
    let mut other_adjacent = vec![[NONE; 3]; n];
    let mut other_face = vec![0_u32; n];
    let mut height = vec![0_f32; n];
    let mut queue = vec![0_u32; n];
    let mut side = [vec![Side::Neither; n], vec![Side::Neither; n]];
    let mut splits = vec![Split::EMPTY; n - 1];
    let mut order = vec![0_u32; n];
    {
        let [side_a, side_b] = &mut side;
        let room = Room {
            from: Patch { moments: &mut moments, adjacent: &mut adjacent, face: &mut face },
            to: Patch { moments: &mut other_moments, adjacent: &mut other_adjacent, face: &mut other_face },
            scratch: Scratch { height: &mut height, queue: &mut queue, side: [side_a, side_b] },
            splits: &mut splits,
            order: &mut order,
        };
        let sizes: Vec<usize> = list.iter().map(|&c| components.faces_of(c as usize).len()).collect();
        descend(Job { mode, progress }, &joins, &sizes, 0, room);
    }
    let depth = depth(&splits);
    Hierarchy { splits, order, mode, depth }
}

/// The components in the order of the tree's leaves, and in preorder how many of them each join has left.
pub(super) fn order(components: &Components) -> (Vec<u32>, Vec<u32>) {
    let mut list: Vec<u32> = (0..components.len() as u32).collect();
    list.sort_by_key(|&c| (components.group[c as usize], c));
    let mut joins = Vec::with_capacity(list.len().saturating_sub(1));
    order_components(components, &mut list, &mut joins);
    (list, joins)
}

/// Sorts `list` into the order of the tree's leaves and notes, in preorder, how many components each join has left.
fn order_components(components: &Components, list: &mut [u32], joins: &mut Vec<u32>) {
    // An explicit stack of ranges: preorder, left before right.
    let mut stack = vec![(0, list.len())];
    while let Some((low, high)) = stack.pop() {
        if high - low < 2 {
            continue;
        }
        let range = &mut list[low..high];
        let left = median_split(components, range);
        joins.push(left as u32);
        stack.push((low + left, high));
        stack.push((low, low + left));
    }
}

/// How many components of `list` go left; the list is reordered to match.
fn median_split(components: &Components, list: &mut [u32]) -> usize {
    let group = |c: u32| components.group[c as usize];
    if group(list[0]) != group(list[list.len() - 1]) {
        // Still sorted by group: the border between groups nearest to the middle.
        let middle = list.len() / 2;
        let border = (1..list.len()).filter(|&i| group(list[i - 1]) != group(list[i]));
        return border.min_by_key(|&i| (i.abs_diff(middle), i)).unwrap_or(middle);
    }
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for &c in list.iter() {
        low = low.min(components.centroid[c as usize]);
        high = high.max(components.centroid[c as usize]);
    }
    let size = (high - low).to_array();
    let axis = (0..3).fold(0, |best, a| if size[a] > size[best] { a } else { best });
    let key = |c: &u32| components.centroid[*c as usize].to_array()[axis];
    let middle = list.len() / 2;
    list.select_nth_unstable_by(middle, |a, b| key(a).total_cmp(&key(b)).then(a.cmp(b)));
    // Selection leaves the halves in an order of its own; sorting by index makes it the documented one.
    list[..middle].sort_unstable();
    list[middle..].sort_unstable();
    middle
}

/// Follows the joins down to the components. The joins halve their lists (but for groups), so the depth is bounded.
fn descend(job: Job<'_>, joins: &[u32], sizes: &[usize], depth: u32, room: Room<'_>) {
    let [size, ..] = sizes else { return };
    if sizes.len() == 1 {
        debug_assert!(balance::fits(*size, depth));
        let shape = Shape::of(room.from.moments, mean(room.from.moments));
        let faces = *size as u64;
        split_down(job, &shape, depth, room);
        if faces < SERIAL_BELOW as u64 {
            (job.progress)(faces);
        }
        return;
    }
    let left = joins[0] as usize;
    let left_faces: usize = sizes[..left].iter().sum();
    let (own, room_l, room_r) = room.children(left_faces);
    *own = Split { left_faces: left_faces as u32, joins_components: true, ..Split::EMPTY };
    rayon::join(
        || descend(job, &joins[1..left], &sizes[..left], depth + 1, room_l),
        || descend(job, &joins[left..], &sizes[left..], depth + 1, room_r),
    );
}

/// A point inside the cloud of centroids, to measure moments from.
fn mean(faces: &[FaceMoments]) -> DVec3 {
    faces.iter().map(|f| f.centroid.as_dvec3()).sum::<DVec3>() / faces.len() as f64
}
