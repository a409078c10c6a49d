//! How far two surfaces lie apart.

use crate::{Nearest, Surface, sample};
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
    samples: Vec<DVec3>,
    vertices: Vec<DVec3>,
}

/// Of one way.
#[derive(Debug, Clone, Copy)]
struct OneWay {
    mean_square: f64,
    max_square: f64,
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
        }
    }

    /// The diagonal of the reference's bounding box.
    pub fn diagonal(&self) -> f64 {
        self.diagonal
    }
}

impl Points {
    fn of(mesh: Surface<'_>, samples: usize) -> Points {
        let vertices = mesh.positions.iter().map(|p| Vec3::from_array(*p).as_dvec3()).collect();
        Points { samples: sample(mesh, samples), vertices }
    }

    fn distance(&self, other: &Nearest) -> OneWay {
        let (sum, max) = sum_and_max(&self.samples, other);
        let (_, of_vertices) = sum_and_max(&self.vertices, other);
        // A surface without area has only its vertices; its mean counts for nothing.
        OneWay { mean_square: sum / self.samples.len().max(1) as f64, max_square: max.max(of_vertices) }
    }
}

/// Sum and maximum of the squared distances, summed in the order of the points for any number of threads.
fn sum_and_max(points: &[DVec3], other: &Nearest) -> (f64, f64) {
    let runs: Vec<(f64, f64)> = points
        .par_chunks(RUN)
        .map(|run| {
            let mut hint = u32::MAX;
            run.iter().fold((0.0, 0.0_f64), |(sum, max), p| {
                let hit = other.find(*p, hint);
                hint = hit.triangle;
                (sum + hit.squared, max.max(hit.squared))
            })
        })
        .collect();
    runs.iter().fold((0.0, 0.0), |(sum, max), run| (sum + run.0, max.max(run.1)))
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
            let mean = points.samples.iter().map(far).sum::<f64>() / n as f64;
            (mean, points.samples.iter().chain(&points.vertices).map(far).fold(0.0, f64::max))
        };
        let ((m, x), (n, y)) = (one_way(&a, &b, 400), one_way(&b, &a, 400));
        let reference = Reference::new(a.surface(), 400);
        let with = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| reference.distance(b.surface()))
        };
        let found = with(1);
        assert_eq!(found, with(3));
        let expected = Distance { rms: ((m + n) / 2.0).sqrt(), max: x.max(y).sqrt() };
        assert!((found.rms - expected.rms).abs() < 1e-9 * expected.rms, "{found:?} {expected:?}");
        assert_eq!(found.max, expected.max);
        let fine = Reference::new(a.surface(), 400_000).distance(b.surface()).rms;
        let coarse = Reference::new(a.surface(), 50_000).distance(b.surface()).rms;
        assert!((fine - coarse).abs() < 0.01 * fine, "{fine} {coarse}");
    }
}
