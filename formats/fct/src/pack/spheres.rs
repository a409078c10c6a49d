//! Spheres on a grid, nested exactly.
//!
//! Centres and radii are whole steps of the page's grid, so whether one sphere lies in another is a question about
//! integers. A parent is grown over its children as they are stored, from the faces up.

use super::ball::Ball;
use super::page::{Below, Place};

/// A sphere in steps of the grid.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct GridBall {
    pub(super) center: [i32; 3],
    pub(super) radius: i32,
}

/// The grid of a page and the spheres of its nodes.
#[derive(Clone, Debug)]
pub(super) struct Grid {
    pub(super) origin: [f32; 3],
    pub(super) quantum: f32,
    pub(super) balls: Vec<GridBall>,
}

/// The last step of the grid, which centres and radii must not pass.
const LAST: i32 = 255;

/// Steps that the box of the centres may take: the rest is for those that move when they are rounded.
const ROOM: f64 = 250.0;

/// A coordinate is at most so many steps: its sum with the grid's 255 is exact in single precision.
const MOST_STEPS: f64 = (1_u32 << 23) as f64;

/// Finds the finest grid on which the spheres of a page can be nested; none if single precision has none.
pub(super) fn nest(nodes: &[Place], corners: &impl Fn(usize) -> [[f32; 3]; 3]) -> Option<Grid> {
    if nodes.is_empty() {
        return Some(Grid { origin: [0.0; 3], quantum: 1.0, balls: Vec::new() });
    }
    let exact = before_rounding(nodes, corners);
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for ball in &exact {
        for (axis, c) in ball.center.into_iter().enumerate() {
            low[axis] = low[axis].min(c);
            high[axis] = high[axis].max(c);
        }
    }
    let mut need = f64::from(f32::from_bits(1));
    for axis in 0..3 {
        let reach = low[axis].abs().max(high[axis].abs());
        need = need.max((high[axis] - low[axis]) / ROOM).max(reach / MOST_STEPS);
    }
    if !need.is_finite() {
        return None;
    }
    let mut quantum = power_of_two_from(need);
    // Ends: a few doublings make the radii fit, and then the range of single precision is left.
    while quantum <= f64::from(f32::MAX) / f64::from(2 * LAST) {
        let origin = low.map(|x| (x / quantum).floor() * quantum);
        if let Some(balls) = nest_on(&exact, nodes, corners, origin, quantum) {
            return Some(Grid { origin: origin.map(|x| x as f32), quantum: quantum as f32, balls });
        }
        quantum *= 2.0;
    }
    None
}

/// The nested balls without a grid.
fn before_rounding(nodes: &[Place], corners: &impl Fn(usize) -> [[f32; 3]; 3]) -> Vec<Ball> {
    let mut balls = vec![Ball { center: [0.0; 3], radius: 0.0 }; nodes.len()];
    for index in (0..nodes.len()).rev() {
        balls[index] = match nodes[index].children(index) {
            [Below::Node(a), Below::Node(b)] => Ball::around(&balls[a], &balls[b]),
            [Below::Node(node), Below::Face(face)] | [Below::Face(face), Below::Node(node)] => {
                balls[node].stretched_to(&corners(face))
            }
            [Below::Face(a), Below::Face(b)] => Ball::of_faces(&corners(a), &corners(b)),
        };
    }
    balls
}

/// The spheres on one grid, or none if a radius does not fit.
fn nest_on(
    exact: &[Ball],
    nodes: &[Place],
    corners: &impl Fn(usize) -> [[f32; 3]; 3],
    origin: [f64; 3],
    quantum: f64,
) -> Option<Vec<GridBall>> {
    // Exact, as the quantum is a power of two.
    let per_quantum = 1.0 / quantum;
    let mut balls = vec![GridBall::default(); nodes.len()];
    for index in (0..nodes.len()).rev() {
        let children = nodes[index].children(index);
        let center = exact[index].center;
        let near = [0, 1, 2].map(|k| step((center[k] - origin[k]) * per_quantum));
        let radius = |center: [i32; 3]| {
            let at = [0, 1, 2].map(|k| origin[k] + f64::from(center[k]) * quantum);
            children.iter().fold(0, |radius, child| {
                radius.max(match *child {
                    Below::Node(child) => reach(center, &balls[child]),
                    Below::Face(face) => reach_of_corners(at, &corners(face), per_quantum),
                })
            })
        };
        let mut best = GridBall { center: near, radius: radius(near) };
        // The two spheres below have grown as they were rounded, and may be held better from elsewhere.
        if let [Below::Node(a), Below::Node(b)] = children {
            let between = between(&balls[a], &balls[b]);
            let other = GridBall { center: between, radius: radius(between) };
            if other.radius < best.radius {
                best = other;
            }
        }
        if best.radius > LAST {
            return None;
        }
        balls[index] = best;
    }
    Some(balls)
}

/// The nearest step.
fn step(x: f64) -> i32 {
    // A cast takes what is behind the point away, which for numbers over zero is rounding down.
    ((x + 0.5) as i32).clamp(0, LAST)
}

/// How far a sphere reaches from a point of the grid, in whole steps.
fn reach(from: [i32; 3], ball: &GridBall) -> i32 {
    let squared: i32 = [0, 1, 2].map(|k| (from[k] - ball.center[k]).pow(2)).iter().sum();
    let mut root = f64::from(squared).sqrt() as i32;
    while root * root < squared {
        root += 1;
    }
    root + ball.radius
}

/// How far the corners of a face reach from a place, in whole steps.
fn reach_of_corners(from: [f64; 3], corners: &[[f32; 3]; 3], per_quantum: f64) -> i32 {
    let squared = corners.iter().map(|corner| {
        let d = [0, 1, 2].map(|k| (f64::from(corner[k]) - from[k]) * per_quantum);
        d[0] * d[0] + d[1] * d[1] + d[2] * d[2]
    });
    // A cast saturates, so that what is far too long stays too long.
    let reach = squared.fold(0.0, f64::max).sqrt().min(1e6);
    let whole = reach as i32;
    whole + i32::from(f64::from(whole) < reach)
}

/// The centre of the smallest sphere around two, rounded.
fn between(a: &GridBall, b: &GridBall) -> [i32; 3] {
    let d = [0, 1, 2].map(|k| f64::from(b.center[k] - a.center[k]));
    let distance = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt();
    let (ra, rb) = (f64::from(a.radius), f64::from(b.radius));
    // 0 at the centre of a, 1 at that of b, which is where it stays if one holds the other.
    let along = if distance > 0.0 { ((distance + rb - ra) / (2.0 * distance)).clamp(0.0, 1.0) } else { 0.0 };
    [0, 1, 2].map(|k| step(f64::from(a.center[k]) + d[k] * along))
}

/// The smallest power of two that is not less than `x`, a positive number in the range of single precision.
fn power_of_two_from(x: f64) -> f64 {
    let bits = x.to_bits();
    let exponent = (bits >> 52) + u64::from(bits << 12 != 0);
    f64::from_bits(exponent << 52)
}

#[cfg(test)]
mod tests {
    use super::{GridBall, power_of_two_from, reach};

    #[test]
    fn powers_of_two_are_not_less_and_less_than_twice() {
        for x in [1e-45, 0.75, 1.0, 1.5, 2.0, 3e38, f64::from(f32::from_bits(1))] {
            let p = power_of_two_from(x);
            assert!(x <= p && p < 2.0 * x, "{x}: {p}");
            assert_eq!(p.to_bits() << 12, 0);
        }
    }

    #[test]
    fn a_sphere_reaches_whole_steps_and_no_less() {
        let ball = GridBall { center: [3, 4, 0], radius: 7 };
        assert_eq!(reach([0, 0, 0], &ball), 12);
        assert_eq!(reach([0, 0, 1], &ball), 13);
        assert_eq!(reach([3, 4, 0], &ball), 7);
    }
}
