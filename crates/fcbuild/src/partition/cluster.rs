//! Splitting one connected cluster down to single faces, in place and in parallel.

use super::hierarchy::Split;
use super::side::Side;
use super::{SplitMode, balance, growth};
use crate::mesh::NONE;
use fcgeom::{Eigen, FaceMoments, Moments, cca_axis, eigen};
use glam::DVec3;

/// Faces of a cluster, each with what the split reads of it; adjacency counts from the cluster's first face.
pub(super) struct Patch<'a> {
    pub(super) moments: &'a mut [FaceMoments],
    pub(super) adjacent: &'a mut [[u32; 3]],
    pub(super) face: &'a mut [u32],
}

impl<'a> Patch<'a> {
    pub(super) fn split_at(self, faces: usize) -> (Patch<'a>, Patch<'a>) {
        let (moments_l, moments_r) = self.moments.split_at_mut(faces);
        let (adjacent_l, adjacent_r) = self.adjacent.split_at_mut(faces);
        let (face_l, face_r) = self.face.split_at_mut(faces);
        (
            Patch { moments: moments_l, adjacent: adjacent_l, face: face_l },
            Patch { moments: moments_r, adjacent: adjacent_r, face: face_r },
        )
    }
}

/// Room to work in, as long as the patch.
pub(super) struct Scratch<'a> {
    pub(super) height: &'a mut [f32],
    pub(super) queue: &'a mut [u32],
    pub(super) side: [&'a mut [Side]; 2],
}

impl<'a> Scratch<'a> {
    pub(super) fn split_at(self, faces: usize) -> (Scratch<'a>, Scratch<'a>) {
        let (height_l, height_r) = self.height.split_at_mut(faces);
        let (queue_l, queue_r) = self.queue.split_at_mut(faces);
        let [a, b] = self.side;
        let (a_l, a_r) = a.split_at_mut(faces);
        let (b_l, b_r) = b.split_at_mut(faces);
        (
            Scratch { height: height_l, queue: queue_l, side: [a_l, b_l] },
            Scratch { height: height_r, queue: queue_r, side: [a_r, b_r] },
        )
    }
}

/// A cluster's moments about a point near it, and what follows from them.
#[derive(Clone)]
pub(super) struct Shape {
    moments: Moments,
    /// The point that the moments are about.
    origin: DVec3,
    /// Axes of the position covariance (eq. 8); not computed for a single face.
    axes: Option<Eigen>,
}

impl Shape {
    pub(super) fn of(faces: &[FaceMoments], origin: DVec3) -> Shape {
        let mut moments = Moments::ZERO;
        for f in faces {
            moments.accumulate(f, origin);
        }
        Shape::from_moments(moments, origin, faces.len())
    }

    fn from_moments(moments: Moments, origin: DVec3, faces: usize) -> Shape {
        // One triangle is flat, and it is never split.
        let axes = (faces > 1).then(|| eigen(&moments.position_covariance()));
        Shape { moments, origin, axes }
    }

    /// The modelling error: the smallest eigenvalue of Z_rr, the mean square distance from the plane.
    fn epsilon(&self) -> f64 {
        self.axes.as_ref().map_or(0.0, |e| e.values[2].max(0.0))
    }

    fn centroid(&self) -> DVec3 {
        self.origin + self.moments.centroid()
    }

    fn split(&self, left_faces: usize) -> Split {
        let mut normal = self.axes.as_ref().map_or(DVec3::ZERO, |e| e.vectors[2]);
        if normal.dot(self.moments.normal) < 0.0 {
            normal = -normal;
        }
        Split {
            left_faces: left_faces as u32,
            joins_components: false,
            epsilon: self.epsilon() as f32,
            key: self.epsilon().sqrt() as f32,
            offset: normal.dot(self.centroid()) as f32,
            normal: normal.as_vec3(),
        }
    }
}

/// Below this many faces a subtree stays on one thread: a task costs about as much as splitting 30 faces.
pub(super) const SERIAL_BELOW: usize = 2048;

/// What stays the same all the way down.
#[derive(Clone, Copy)]
pub(super) struct Job<'a> {
    pub(super) mode: SplitMode,
    pub(super) progress: &'a (dyn Fn(u64) + Sync),
}

/// Everything one subtree writes to, split hand in hand on the way down.
pub(super) struct Room<'a> {
    pub(super) from: Patch<'a>,
    pub(super) to: Patch<'a>,
    pub(super) scratch: Scratch<'a>,
    /// One fewer than faces.
    pub(super) splits: &'a mut [Split],
    pub(super) order: &'a mut [u32],
}

impl<'a> Room<'a> {
    /// The node's own split, and the rooms of its children, of which the left one has `faces` faces.
    pub(super) fn children(self, faces: usize) -> (&'a mut Split, Room<'a>, Room<'a>) {
        let (from_l, from_r) = self.from.split_at(faces);
        let (to_l, to_r) = self.to.split_at(faces);
        let (scratch_l, scratch_r) = self.scratch.split_at(faces);
        let (own, below) = self.splits.split_at_mut(1);
        let (splits_l, splits_r) = below.split_at_mut(faces - 1);
        let (order_l, order_r) = self.order.split_at_mut(faces);
        (
            &mut own[0],
            Room { from: from_l, to: to_l, scratch: scratch_l, splits: splits_l, order: order_l },
            Room { from: from_r, to: to_r, scratch: scratch_r, splits: splits_r, order: order_r },
        )
    }

    /// The faces have been moved from one patch to the other.
    fn moved(self) -> Room<'a> {
        Room { from: self.to, to: self.from, ..self }
    }
}

/// Splits the cluster in `room.from` completely: the splits and the order are filled.
///
/// The two patches swap their parts at every level, as in a merge sort, so nothing is allocated on the way down.
pub(super) fn split_down(job: Job<'_>, shape: &Shape, depth: u32, mut room: Room<'_>) {
    let n = room.from.face.len();
    if n <= 2 {
        room.order.copy_from_slice(room.from.face);
        if n == 2 {
            room.splits[0] = shape.split(1);
        }
        return;
    }
    let [left, right] = best_cut(job.mode, shape, depth, &room.from, &mut room.scratch);
    let middle = separate(&room.from, &mut room.to, room.scratch.side[0], room.scratch.queue);
    let (split, room_l, room_r) = room.moved().children(middle);
    *split = shape.split(middle);
    let go_left = || split_down(job, &left, depth + 1, room_l);
    let go_right = || split_down(job, &right, depth + 1, room_r);
    if n >= SERIAL_BELOW {
        rayon::join(go_left, go_right);
        // Told once by the smallest tasks, those whose children are serial.
        let serial = |m: usize| if m < SERIAL_BELOW { m as u64 } else { 0 };
        (job.progress)(serial(middle) + serial(n - middle));
    } else {
        go_left();
        go_right();
    }
}

/// Leaves the kept cut in the first side array and returns the shapes of its two clusters.
fn best_cut(
    mode: SplitMode,
    shape: &Shape,
    depth: u32,
    patch: &Patch<'_>,
    room: &mut Scratch<'_>,
) -> [Shape; 2] {
    let Scratch { height, queue, side: [kept, tried] } = room;
    let pca = shape.axes.as_ref().map_or(DVec3::X, |e| e.vectors[0]);
    let cca = if mode == SplitMode::Pca { None } else { cca_axis(&shape.moments) };
    let first = if mode == SplitMode::Cca { cca.unwrap_or(pca) } else { pca };
    let mut best = try_axis(shape, depth, patch, first, height, queue, kept);
    if let (SplitMode::Paper, Some(axis)) = (mode, cca)
        && let Some(other) = try_axis(shape, depth, patch, axis, height, queue, tried)
        && best.as_ref().is_none_or(|b| sum_of_errors(&other) < sum_of_errors(b))
    {
        kept.copy_from_slice(tried);
        best = Some(other);
    }
    best.unwrap_or_else(|| {
        balance::cut_spanning_tree(patch.adjacent, kept);
        shapes_of_sides(shape.centroid(), patch.moments, kept)
    })
}

fn sum_of_errors(pair: &[Shape; 2]) -> f64 {
    pair[0].epsilon() + pair[1].epsilon()
}

/// One cut; none if the faces cannot be told apart along `axis` or the cut would let the tree grow too deep.
fn try_axis(
    shape: &Shape,
    depth: u32,
    patch: &Patch<'_>,
    axis: DVec3,
    height: &mut [f32],
    queue: &mut [u32],
    side: &mut [Side],
) -> Option<[Shape; 2]> {
    let centroid = shape.centroid();
    let (p, offset) = (axis.as_vec3(), axis.dot(centroid) as f32);
    for (h, f) in height.iter_mut().zip(patch.moments.iter()) {
        *h = p.dot(f.centroid) - offset;
    }
    if !growth::grow(patch.adjacent, height, side, queue) {
        return None;
    }
    let left = side.iter().filter(|s| **s == Side::Left).count();
    if !balance::fits(left.max(side.len() - left), depth + 1) {
        return None;
    }
    Some(shapes_of_sides(centroid, patch.moments, side))
}

fn shapes_of_sides(origin: DVec3, faces: &[FaceMoments], side: &[Side]) -> [Shape; 2] {
    let (mut left, mut right) = (Moments::ZERO, Moments::ZERO);
    let mut left_faces = 0;
    for (f, s) in faces.iter().zip(side) {
        if *s == Side::Left {
            left.accumulate(f, origin);
            left_faces += 1;
        } else {
            right.accumulate(f, origin);
        }
    }
    [
        Shape::from_moments(left, origin, left_faces),
        Shape::from_moments(right, origin, faces.len() - left_faces),
    ]
}

/// Moves the faces into `to`, left ones first, both in their old order, and cuts the adjacency between the sides.
///
/// `place` is scratch. Returns how many are left.
fn separate(from: &Patch<'_>, to: &mut Patch<'_>, side: &[Side], place: &mut [u32]) -> usize {
    let (mut left, mut right) = (0, 0);
    for (p, s) in place.iter_mut().zip(side) {
        let count = if *s == Side::Left { &mut left } else { &mut right };
        *p = *count;
        *count += 1;
    }
    let middle = left as usize;
    for (i, s) in side.iter().enumerate() {
        let slot = place[i] as usize + if *s == Side::Left { 0 } else { middle };
        to.moments[slot] = from.moments[i];
        to.face[slot] = from.face[i];
        to.adjacent[slot] = from.adjacent[i]
            .map(|near| if near == NONE || side[near as usize] != *s { NONE } else { place[near as usize] });
    }
    middle
}
