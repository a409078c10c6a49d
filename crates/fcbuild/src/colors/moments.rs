//! Integrals of colours over a surface, and the linear colours nearest to them.

use fcgeom::SymMat3;
use glam::{DMat3, DVec3, DVec4};
use std::fmt::Debug;

/// What is known of the colours of a cluster: [`Colors`], or nothing where a mesh has none.
pub trait Coloring: Copy + Debug + Send + Sync {
    /// Those of two clusters together: `share` of the area is the other's, whose centroid is `apart` from this one's,
    /// and `weight` is this one's area times that share.
    #[must_use]
    fn union(&self, other: &Self, share: f64, apart: DVec3, weight: f64) -> Self;

    /// The integral of the squared difference of the colours from linear ones, for a cluster of this spread.
    fn squared_loss(&self, spread: &SymMat3) -> f64;
}

impl Coloring for () {
    #[inline(always)]
    fn union(&self, (): &Self, _: f64, _: DVec3, _: f64) -> Self {}

    #[inline(always)]
    fn squared_loss(&self, _: &SymMat3) -> f64 {
        0.0
    }
}

/// Moments of colours over a surface, about the mean colour and the centroid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Colors {
    mean: DVec4,
    /// The integral of `c x^T`, a row for each channel.
    together: [DVec3; 4],
    /// The integral of `|c|^2`.
    square: f64,
}

/// A part of a surface with its colours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Part {
    /// The area.
    pub area: f64,
    /// The mean position.
    pub centroid: DVec3,
    /// The integral of the outer products of positions, counted from the centroid.
    pub spread: SymMat3,
    /// The colours.
    pub colors: Colors,
}

impl Part {
    /// A triangle, between whose corners colours are linear.
    pub fn of_triangle(points: [DVec3; 3], colors: [DVec4; 3]) -> Part {
        let [a, b, c] = points;
        let area = 0.5 * (b - a).cross(c - a).length();
        // The integral of a product of functions that are linear and zero in the mean.
        let weight = area / 12.0;
        let centroid = (a + b + c) / 3.0;
        let [x, y, z] = points.map(|p| SymMat3::outer(p - centroid));
        let mean = colors.iter().sum::<DVec4>() / 3.0;
        let of_channel = |i: usize| -> DVec3 {
            points.iter().zip(&colors).map(|(x, c)| (x - centroid) * (c - mean)[i]).sum::<DVec3>()
        };
        let colors = Colors {
            mean,
            together: [0, 1, 2, 3].map(|i| of_channel(i) * weight),
            square: colors.iter().map(|c| (c - mean).length_squared()).sum::<f64>() * weight,
        };
        Part { area, centroid, spread: (x + y + z) * weight, colors }
    }

    /// Both parts as one.
    #[must_use]
    pub fn and(&self, other: &Part) -> Part {
        let area = self.area + other.area;
        // Two parts without area count the same.
        let share = if area > 0.0 { other.area / area } else { 0.5 };
        let apart = other.centroid - self.centroid;
        let weight = self.area * share;
        Part {
            area,
            centroid: self.centroid + apart * share,
            spread: self.spread + other.spread + SymMat3::outer(apart) * weight,
            colors: self.colors.union(&other.colors, share, apart, weight),
        }
    }

    /// The linear colours nearest to its own.
    pub fn fit(&self) -> Fit {
        self.colors.fit(self.centroid, &self.spread)
    }

    /// The integral of the squared difference from those.
    pub fn squared_loss(&self) -> f64 {
        self.colors.squared_loss(&self.spread)
    }
}

impl Colors {
    /// The linear colours nearest to those of a cluster of this centroid and spread. Across a thin one they are level.
    fn fit(&self, centroid: DVec3, spread: &SymMat3) -> Fit {
        Fit { centroid, mean: self.mean, slopes: self.slopes(spread) }
    }

    fn slopes(&self, spread: &SymMat3) -> [DVec3; 4] {
        let level = DMat3::from_diagonal(DVec3::splat(LEVEL * spread.trace()));
        let inverse = (spread.to_dmat3() + level).inverse();
        let slopes = self.together.map(|row| inverse * row);
        // A cluster without extent has one colour.
        if slopes.iter().all(|row| row.is_finite()) { slopes } else { [DVec3::ZERO; 4] }
    }
}

impl Coloring for Colors {
    #[inline]
    fn union(&self, other: &Self, share: f64, apart: DVec3, weight: f64) -> Self {
        let difference = other.mean - self.mean;
        let weighed = (difference * weight).to_array();
        Colors {
            mean: self.mean + difference * share,
            together: [0, 1, 2, 3].map(|i| self.together[i] + other.together[i] + apart * weighed[i]),
            square: self.square + other.square + difference.length_squared() * weight,
        }
    }

    fn squared_loss(&self, spread: &SymMat3) -> f64 {
        let of_channel =
            |(row, together): (&DVec3, &DVec3)| spread.quadratic(*row) - 2.0 * row.dot(*together);
        let explained: f64 = self.slopes(spread).iter().zip(&self.together).map(of_channel).sum();
        (self.square + explained).max(0.0)
    }
}

/// How much thinner than long, squared, a cluster must be for its colours to be level across it.
const LEVEL: f64 = 1e-4;

/// Colours linear in space.
#[derive(Clone, Copy, Debug)]
pub struct Fit {
    centroid: DVec3,
    mean: DVec4,
    slopes: [DVec3; 4],
}

impl Fit {
    /// The square of how far a colour is from the one that is due at a point.
    pub fn squared_difference(&self, point: DVec3, color: DVec4) -> f64 {
        let x = point - self.centroid;
        let slope = DVec4::from(self.slopes.map(|row| row.dot(x)));
        (color - self.mean - slope).length_squared()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A bent strip of triangles coloured by a function of places.
    fn strip(color: impl Fn(DVec3) -> DVec4) -> Vec<[(DVec3, DVec4); 3]> {
        let at = |i: usize, y: f64| {
            let x = i as f64 * 0.1;
            let point = DVec3::new(x, y, 0.2 * x * x);
            (point, color(point))
        };
        (0..20)
            .flat_map(|i| {
                let [a, b, c, d] = [at(i, 0.0), at(i + 1, 0.0), at(i, 0.3), at(i + 1, 0.3)];
                [[a, b, c], [c, b, d]]
            })
            .collect()
    }

    fn whole(strip: &[[(DVec3, DVec4); 3]]) -> Part {
        let of = |t: &[(DVec3, DVec4); 3]| Part::of_triangle(t.map(|v| v.0), t.map(|v| v.1));
        strip.iter().map(of).reduce(|a, b| a.and(&b)).unwrap()
    }

    #[test]
    fn linear_colors_lose_nothing() {
        let linear = |p: DVec3| DVec4::new(0.3 + 0.2 * p.x, 0.7 - 0.1 * p.y, 0.1 * p.x + 0.4 * p.y, 1.0);
        let part = whole(&strip(linear));
        assert!(part.squared_loss() < 1e-6 * part.area, "{}", part.squared_loss());
        let fit = part.fit();
        for x in [DVec3::ZERO, DVec3::new(1.0, 0.2, 0.2)] {
            assert!(fit.squared_difference(x, linear(x)) < 1e-5);
        }
    }

    #[test]
    fn the_loss_is_the_integral_of_the_squared_difference() {
        let wild = |p: DVec3| DVec4::new((7.0 * p.x).sin(), (9.0 * p.y).cos(), p.x * p.y, 0.5);
        let strip = strip(wild);
        let part = whole(&strip);
        let fit = part.fit();
        // The middles of the sides integrate what is quadratic, as the difference squared is within a triangle.
        let integral: f64 = strip
            .iter()
            .map(|t| {
                let [a, b, c] = t.map(|v| v.0);
                let area = 0.5 * (b - a).cross(c - a).length();
                let middle = |i: usize, j: usize| ((t[i].0 + t[j].0) * 0.5, (t[i].1 + t[j].1) * 0.5);
                [middle(0, 1), middle(1, 2), middle(2, 0)]
                    .map(|(x, c)| fit.squared_difference(x, c))
                    .iter()
                    .sum::<f64>()
                    * area
                    / 3.0
            })
            .sum();
        let loss = part.squared_loss();
        assert!((loss - integral).abs() < 1e-9 * integral, "{loss} {integral}");
        assert!(loss > 0.01);
    }

    #[test]
    fn a_point_has_one_color() {
        let part = Part::of_triangle([DVec3::ONE; 3], [DVec4::ONE, DVec4::ZERO, DVec4::ZERO]);
        assert_eq!(part.squared_loss(), 0.0);
        assert!(part.fit().squared_difference(DVec3::ONE, DVec4::ONE).is_finite());
    }
}
