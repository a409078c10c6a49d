//! How far two surfaces lie apart, and how far their colours.

use crate::sampling::{Sample, samples};
use crate::{Nearest, Surface};
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// Points in a run; one thread takes a run, and each point starts from the answer of the one before.
const RUN: usize = 1024;

/// Distances between a mesh and the reference.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Distance {
    /// Root of the mean square distance, the mean over the area of either surface, both counted alike.
    pub rms: f64,
    /// Largest distance of a sample or a vertex of one surface from the other.
    pub max: f64,
    /// The same mean for colours, each against that of the nearest place; none if either surface has no colours.
    pub color_rms: Option<f64>,
}

/// A surface that others are compared with.
#[derive(Debug)]
pub struct Reference {
    nearest: Nearest,
    points: Points,
    diagonal: f64,
    samples: usize,
}

/// Where distances are taken: samples for the mean, vertices too for the maximum.
#[derive(Debug)]
struct Points {
    samples: Vec<Sample>,
    vertices: Vec<DVec3>,
}

/// Of one way.
#[derive(Debug, Clone, Copy)]
struct OneWay {
    mean_square: f64,
    max_square: f64,
    color_mean_square: Option<f64>,
}

impl Reference {
    /// Prepares comparisons with `mesh`, by so many samples each way.
    ///
    /// Every vertex of the mesh is expected to be used by a face.
    pub fn new(mesh: Surface<'_>, samples: usize) -> Reference {
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for p in mesh.positions {
            let p = Vec3::from_array(*p).as_dvec3();
            (low, high) = (low.min(p), high.max(p));
        }
        Reference {
            nearest: Nearest::of(mesh),
            points: Points::of(mesh, samples),
            diagonal: (high - low).length(),
            samples,
        }
    }

    /// Measures both ways; infinite when `mesh` has no faces.
    pub fn distance(&self, mesh: Surface<'_>) -> Distance {
        let there = self.points.distance(&Nearest::of(mesh));
        let back = Points::of(mesh, self.samples).distance(&self.nearest);
        Distance {
            rms: ((there.mean_square + back.mean_square) / 2.0).sqrt(),
            max: there.max_square.max(back.max_square).sqrt(),
            color_rms: there
                .color_mean_square
                .zip(back.color_mean_square)
                .map(|(there, back)| ((there + back) / 2.0).sqrt()),
        }
    }

    /// The diagonal of the reference's bounding box.
    pub fn diagonal(&self) -> f64 {
        self.diagonal
    }
}

impl Points {
    fn of(mesh: Surface<'_>, count: usize) -> Points {
        let vertices = mesh.positions.iter().map(|p| Vec3::from_array(*p).as_dvec3()).collect();
        Points { samples: samples(mesh, count), vertices }
    }

    fn distance(&self, other: &Nearest) -> OneWay {
        let found = sums(&self.samples, other);
        let vertices: Vec<Sample> =
            self.vertices.iter().map(|&point| Sample { point, color: None }).collect();
        // A surface without area has only its vertices; its mean counts for nothing.
        let mean = |sum: f64| sum / self.samples.len().max(1) as f64;
        OneWay {
            mean_square: mean(found.squares),
            max_square: found.most.max(sums(&vertices, other).most),
            color_mean_square: found.colors.filter(|_| !self.samples.is_empty()).map(mean),
        }
    }
}

/// Of the squared distances of some points.
#[derive(Debug, Clone, Copy)]
struct Sums {
    squares: f64,
    most: f64,
    /// The squared differences of colour, if all have colours.
    colors: Option<f64>,
}

impl Sums {
    const ZERO: Sums = Sums { squares: 0.0, most: 0.0, colors: Some(0.0) };

    fn and(self, other: Sums) -> Sums {
        Sums {
            squares: self.squares + other.squares,
            most: self.most.max(other.most),
            colors: self.colors.zip(other.colors).map(|(a, b)| a + b),
        }
    }
}

/// Summed in the order of the points for any number of threads.
fn sums(points: &[Sample], other: &Nearest) -> Sums {
    let runs: Vec<Sums> = points
        .par_chunks(RUN)
        .map(|run| {
            let mut hint = u32::MAX;
            run.iter().fold(Sums::ZERO, |sums, sample| {
                let hit = other.find(sample.point, hint);
                hint = hit.triangle;
                let color = sample.color.and_then(|own| {
                    other.color(sample.point, hit).map(|there| own.squared_difference(there))
                });
                sums.and(Sums { squares: hit.squared, most: hit.squared, colors: color })
            })
        })
        .collect();
    runs.into_iter().fold(Sums::ZERO, Sums::and)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::squared_distance;
    use crate::tests::Mesh;

    #[test]
    fn parallel_squares_are_their_offset_apart() {
        let (one, other) = (Mesh::grid(3, |_, _| 0.0), Mesh::grid(5, |_, _| 0.125));
        let d = Reference::new(one.surface(), 1_000).distance(other.surface());
        assert!((d.rms - 0.125).abs() < 1e-9 && (d.max - 0.125).abs() < 1e-9, "{d:?}");
    }

    /// One spike in a corner shows in the maximum, whichever surface has it.
    #[test]
    fn the_maximum_sees_a_single_vertex_of_either_surface() {
        let (flat, mut spiked) = (Mesh::grid(20, |_, _| 0.0), Mesh::grid(20, |_, _| 0.0));
        spiked.positions[0][2] = 0.1;
        for (a, b) in [(&flat, &spiked), (&spiked, &flat)] {
            let d = Reference::new(a.surface(), 50).distance(b.surface());
            assert!((d.max - 0.1).abs() < 1e-3, "{d:?}");
        }
    }

    #[test]
    fn a_surface_is_at_distance_zero_from_itself_and_far_from_nothing() {
        let mesh = Mesh::grid(30, |x, y| 0.1 * x * y);
        let reference = Reference::new(mesh.surface(), 2_000);
        assert!(reference.distance(mesh.surface()).max < 1e-6);
        assert!(reference.distance(Mesh::default().surface()).max.is_infinite());
    }

    /// A ramp from black to white, and one that is a quarter darker.
    #[test]
    fn colors_are_compared_at_the_nearest_place() {
        let ramp = |n: u32, most: f64| {
            let mut mesh = Mesh::grid(n, |_, _| 0.0);
            let byte = |x: f32| (f64::from(x) * most).round() as u8;
            mesh.colors = mesh.positions.iter().map(|p| [byte(p[0]), byte(p[0]), byte(p[0]), 255]).collect();
            mesh
        };
        let (one, same, darker) = (ramp(5, 255.0), ramp(15, 255.0), ramp(3, 191.25));
        let reference = Reference::new(one.surface(), 4_000);
        let apart = |mesh: &Mesh| reference.distance(mesh.surface()).color_rms;
        assert!(apart(&same).unwrap() < 1e-6);
        // A quarter of x, whose mean square is a third.
        let found = apart(&darker).unwrap();
        assert!((found - 0.25 / 3.0_f64.sqrt()).abs() < 2e-3, "{found}");
        assert_eq!(apart(&Mesh::grid(4, |_, _| 0.0)), None);
    }

    /// All pairs, with the same samples; and the samples meet the integral within a percent.
    #[test]
    fn agrees_with_brute_force_for_any_number_of_threads() {
        let (a, b) = (Mesh::grid(31, |x, y| 0.1 * x * y), Mesh::grid(7, |x, y| 0.1 * x * y + 0.02 * x * x));
        let triangles = |m: &Mesh| -> Vec<[Vec3; 3]> {
            m.faces.iter().map(|f| f.map(|v| Vec3::from_array(m.positions[v as usize]))).collect()
        };
        let one_way = |from: &Mesh, to: &Mesh, n: usize| {
            let (points, to) = (Points::of(from.surface(), n), triangles(to));
            let far = |p: &DVec3| to.iter().map(|t| squared_distance(*p, t)).fold(f64::INFINITY, f64::min);
            let mean = points.samples.iter().map(|s| far(&s.point)).sum::<f64>() / n as f64;
            (
                mean,
                points.samples.iter().map(|s| &s.point).chain(&points.vertices).map(far).fold(0.0, f64::max),
            )
        };
        let ((m, x), (n, y)) = (one_way(&a, &b, 400), one_way(&b, &a, 400));
        let reference = Reference::new(a.surface(), 400);
        let with = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| reference.distance(b.surface()))
        };
        let found = with(1);
        assert_eq!(found, with(3));
        let expected = Distance { rms: ((m + n) / 2.0).sqrt(), max: x.max(y).sqrt(), color_rms: None };
        assert!((found.rms - expected.rms).abs() < 1e-9 * expected.rms, "{found:?} {expected:?}");
        assert_eq!(found.max, expected.max);
        let fine = Reference::new(a.surface(), 400_000).distance(b.surface()).rms;
        let coarse = Reference::new(a.surface(), 50_000).distance(b.surface()).rms;
        assert!((fine - coarse).abs() < 0.01 * fine, "{fine} {coarse}");
    }
}
