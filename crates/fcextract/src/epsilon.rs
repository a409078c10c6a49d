//! Cuts by the paper's modelling error.

use crate::copies::Copies;
use crate::corners::Corners;
use crate::extraction::Stats;
use crate::part::{Part, Sight};
use crate::{Error, Order, Selection, Tolerance};
use fct::{Child, Loops, Tree};
use glam::DVec3;

/// Along open borders and ridges a vertex is drawn too when its distance bound is over so many tolerances.
///
/// Epsilon is a mean over the cluster and does not see what a chord cuts off its border. Fewer tolerances give more
/// triangles, more of them coarser borders: 4 doubles the triangles of a scan, 8 adds a sixth to those of none.
const BORDER: f64 = 8.0;

/// Chooses the cut of the first clusters on the way from the root whose modelling error is within the tolerance.
///
/// Epsilon, a mean square distance, is held against the square of what `selection` allows: one distance d everywhere is
/// epsilon <= d^2, and a [`Tolerance::Perspective`] of slope s is epsilon <= k d^2 with k = s^2 and the distance d from
/// the eye. Regions count as they do elsewhere. The selection that comes back names the clusters one by one, because no
/// key of the tree leads to them: epsilon may grow towards the leaves.
///
/// # Errors
/// As [`crate::extract`].
///
/// # Paper
/// `[Tsuji07, eq. 17]` and `[Tsuji07, eq. 18]`.
///
/// # Deviations
/// The distance is that of the near side of the cluster's sphere, so that the error holds for all of it.
pub fn by_epsilon(tree: &Tree, selection: Selection) -> Result<Selection, Error> {
    selection.check()?;
    let distance = f64::INFINITY;
    let mut cut = Selection {
        tolerance: Tolerance::Uniform { distance },
        order: Order::Bound,
        regions: Vec::new(),
        displaced: false,
        extra: crate::Extra::default(),
        ..selection.clone()
    };
    let reader = tree.reader();
    let mut copies = Copies::default();
    copies.read(tree);
    let (mut corners, mut loops, mut stats) = (Corners::default(), Loops::default(), Stats::default());
    let mut stack = vec![Part::whole(tree, &selection)];
    while let Some(Part { subtree, settled }) = stack.pop() {
        let Child::Node(index) = subtree.child.kind() else { continue };
        let node = reader.node(&subtree)?;
        let settled = match cut.sight(&subtree, &node, settled, &mut stats) {
            Sight::Culled => continue,
            Sight::Refined { settled } => settled,
            Sight::Drawn => {
                let sphere = || (DVec3::from(node.center.map(f64::from)), f64::from(node.radius));
                let allowed = selection.allowed(sphere);
                if allowed.is_some_and(|allowed| f64::from(node.epsilon()) <= allowed * allowed) {
                    reader.read_loops(&subtree, &mut loops)?;
                    for &vertex in &loops.vertices {
                        let Some(record) = reader.vertices().get(vertex as usize) else { continue };
                        let sphere = || (DVec3::from(record.center()), record.radius());
                        let allowed = selection.allowed(sphere).unwrap_or(0.0);
                        if f64::from(record.bound()) > BORDER * allowed {
                            copies.each(tree, vertex, |copy| {
                                cut.extra.add_vertex(copy, reader.vertices().get(copy as usize));
                            });
                        }
                    }
                    continue;
                }
                cut.extra.nodes.add(index);
                // What the frustum holds is found out once more below; it costs little.
                settled
            }
        };
        let children = reader.children(&subtree)?;
        let needed =
            corners.of_split(&reader, &children, Order::Bound, node.bound, |v| cut.draws(&reader, v))?;
        for &vertex in needed {
            copies.each(tree, vertex, |copy| {
                cut.extra.add_vertex(copy, reader.vertices().get(copy as usize));
            });
        }
        let [left, right] = children;
        stack.extend([right, left].map(|subtree| Part { subtree, settled }));
    }
    Ok(cut)
}
