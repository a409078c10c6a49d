//! Regions of interest.

use crate::Error;
use fcgeom::distance_to_segment;
use fct::{Child, Tree};
use glam::DVec3;

/// A ball with an error of its own.
///
/// # Paper
/// `[Tsuji07]` fig. 12: a part of a model at a finer resolution than the rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Region {
    /// Its centre, in the tree's coordinates.
    pub center: DVec3,
    /// Its radius, in the tree's unit.
    pub radius: f64,
    /// The error allowed in it, in the tree's unit; where regions overlap the smallest counts.
    pub distance: f64,
}

impl Region {
    /// Whether any point of the surface lies in it.
    ///
    /// # Errors
    /// [`Error::Tree`] when the file is damaged where the walk comes by.
    pub fn meets(&self, tree: &Tree) -> Result<bool, Error> {
        let reader = tree.reader();
        let mut stack = vec![reader.whole()];
        while let Some(subtree) = stack.pop() {
            if let Child::Face(_) = subtree.child.kind() {
                let corners = reader.face(&subtree)?.map(|vertex| {
                    let record = reader.vertices().get(vertex as usize);
                    record.map_or(DVec3::NAN, |record| DVec3::from(record.position().map(f64::from)))
                });
                if distance_to_triangle(self.center, corners) <= self.radius {
                    return Ok(true);
                }
                continue;
            }
            let node = reader.node(&subtree)?;
            let apart = self.center.distance(DVec3::from(node.center.map(f64::from)));
            if apart <= self.radius + f64::from(node.radius) {
                stack.extend(reader.children(&subtree)?);
            }
        }
        Ok(false)
    }

    /// Refuses what is no ball or allows no distance; `number` is the region's place in the selection.
    pub(crate) fn check(&self, number: usize) -> Result<(), Error> {
        let Region { center, radius, distance } = self;
        let wrong = |what: String| Err(Error::Selection(format!("its regions[{number}] has a {what}")));
        if !center.is_finite() {
            return wrong(format!("center of {center}, which is not finite"));
        }
        if !(*radius >= 0.0 && radius.is_finite()) {
            return wrong(format!("radius of {radius}; it is a finite length of 0 or more"));
        }
        if *distance >= 0.0 {
            return Ok(());
        }
        wrong(format!("distance of {distance}; it is a length of 0 or more"))
    }
}

/// Distance of a point from a triangle.
fn distance_to_triangle(p: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let normal = (b - a).cross(c - a);
    let is_inside = |from: DVec3, to: DVec3| (to - from).cross(p - from).dot(normal) >= 0.0;
    if normal.length_squared() > 0.0 && is_inside(a, b) && is_inside(b, c) && is_inside(c, a) {
        return (p - a).dot(normal).abs() / normal.length();
    }
    let edges = [(a, b), (b, c), (c, a)].map(|(from, to)| distance_to_segment(p, from, to));
    edges.into_iter().fold(f64::INFINITY, f64::min)
}

/// Whether a sphere lies neither inside nor outside of every region.
pub(crate) fn crosses(regions: &[Region], center: DVec3, radius: f64) -> bool {
    regions.iter().any(|region| {
        let apart = region.center.distance(center);
        apart <= region.radius + radius && apart + radius > region.radius
    })
}

/// Whether any region has a point in common with a sphere.
#[inline]
pub(crate) fn touches(regions: &[Region], center: DVec3, radius: f64) -> bool {
    regions.iter().any(|region| region.center.distance(center) <= region.radius + radius)
}

/// The least error allowed in a sphere where regions lie over what `outside` allows.
///
/// It is what the regions that it touches allow, and what is allowed outside unless one region holds all of it.
/// A sphere inside another one touches no more regions, so it is allowed no less.
pub(crate) fn least(
    regions: &[Region],
    center: DVec3,
    radius: f64,
    outside: impl FnOnce() -> Option<f64>,
) -> Option<f64> {
    let mut least = f64::INFINITY;
    let mut is_inside = false;
    for region in regions {
        let apart = region.center.distance(center);
        if apart <= region.radius + radius {
            least = least.min(region.distance);
            is_inside |= apart + radius <= region.radius;
        }
    }
    if is_inside { Some(least) } else { Some(outside()?.min(least)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(x: f64, radius: f64, regions: &[Region]) -> Option<f64> {
        least(regions, DVec3::new(x, 0.0, 0.0), radius, || Some(1.0))
    }

    #[test]
    fn a_triangle_is_as_far_as_its_nearest_point() {
        let triangle = [DVec3::ZERO, DVec3::new(4.0, 0.0, 0.0), DVec3::new(0.0, 4.0, 0.0)];
        for (place, distance) in [
            ([1.0, 1.0, -3.0], 3.0),
            ([-3.0, -4.0, 0.0], 5.0),
            ([2.0, -1.0, 0.0], 1.0),
            ([4.0, 4.0, 0.0], 8.0_f64.sqrt()),
            ([7.0, 0.0, 4.0], 5.0),
        ] {
            assert!((distance_to_triangle(DVec3::from(place), triangle) - distance).abs() < 1e-12);
        }
        let line = [DVec3::ZERO, DVec3::X, 3.0 * DVec3::X];
        assert_eq!(distance_to_triangle(DVec3::new(2.0, 1.0, 0.0), line), 1.0);
    }

    #[test]
    fn a_region_counts_where_it_is_touched_and_alone_where_it_holds_all() {
        let region =
            |x: f64, distance: f64| Region { center: DVec3::new(x, 0.0, 0.0), radius: 2.0, distance };
        let fine = [region(0.0, 0.1)];
        assert_eq!(
            [at(0.0, 1.0, &fine), at(2.5, 1.0, &fine), at(4.0, 1.0, &fine)].map(Option::unwrap),
            [0.1, 0.1, 1.0]
        );
        let coarse = [region(0.0, 7.0)];
        assert_eq!([at(0.0, 1.0, &coarse), at(2.5, 1.0, &coarse)].map(Option::unwrap), [7.0, 1.0]);
        let both = [region(0.0, 7.0), region(1.0, 3.0)];
        assert_eq!([at(0.0, 1.0, &both), at(-1.5, 0.4, &both)].map(Option::unwrap), [3.0, 7.0]);
        assert_eq!(least(&fine, DVec3::X * 9.0, 1.0, || None), None);
        let crossed = [0.0, 1.0, 1.5, 2.9, 3.1].map(|x| crosses(&fine, DVec3::X * x, 1.0));
        assert_eq!(crossed, [false, false, true, true, false]);
    }
}
