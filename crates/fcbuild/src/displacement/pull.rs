//! What planes do to a vertex, added up.

use super::LEVELS;
use fcgeom::SymMat3;
use fct::{Displacement, ShortFloat};
use glam::{DMat3, DVec3};

/// Holds a vertex to its place as a plane of this share of the clusters' area would in every direction: less lets
/// vertices slide along nearly parallel planes, more leaves them where they are.
const HOLD: f64 = 0.01;

/// What planes do to a vertex: the normal equations of its least squares.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pull {
    matrix: SymMat3,
    right: DVec3,
    weight: f64,
}

impl Pull {
    pub(super) const NONE: Pull = Pull { matrix: SymMat3::ZERO, right: DVec3::ZERO, weight: 0.0 };

    /// A plane of this normal, of which the vertex is to come down by `height`.
    pub(super) fn plane(normal: DVec3, height: f64, weight: f64) -> Pull {
        Pull { matrix: SymMat3::outer(normal) * weight, right: normal * (-height * weight), weight }
    }

    pub(super) fn add(&mut self, other: &Pull) {
        self.matrix += other.matrix;
        self.right += other.right;
        self.weight += other.weight;
    }

    fn solve(&self) -> DVec3 {
        let hold = SymMat3::IDENTITY * (HOLD * self.weight);
        let matrix: DMat3 = (self.matrix + hold).to_dmat3();
        let solved = matrix.inverse() * self.right;
        if solved.is_finite() { solved } else { DVec3::ZERO }
    }
}

/// What pulls at a vertex make of it, which has this budget key.
pub(super) fn solve(pulls: &[Pull; LEVELS], key: f32) -> Displacement {
    let displaced = pulls.each_ref().map(|pull| pull.solve().to_array());
    Displacement::encode(displaced, ShortFloat::up(f64::from(key)))
}

/// A vertex, a level, and what happens to it there.
pub(super) type PullAt = (usize, usize, Pull);

/// Adds up pulls at the same vertex and level, in their order.
pub(super) fn summed(mut pulls: Vec<PullAt>) -> Vec<PullAt> {
    pulls.sort_by_key(|(vertex, level, _)| (*vertex, *level));
    pulls.dedup_by(|next, sum| {
        let same = (next.0, next.1) == (sum.0, sum.1);
        if same {
            sum.2.add(&next.2);
        }
        same
    });
    pulls.shrink_to_fit();
    pulls
}
