//! How far two surfaces lie apart.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::nearest::Nearest;
use super::sampling::sample;
use crate::data::ply_out::Mesh;

/// Points in a run; one thread takes a run, and each point starts from the answer of the one before.
const RUN: usize = 1024;

/// Distances between a mesh and the reference, in 1e-4 of the diagonal of the reference's bounding box.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Distance {
    /// Root of the mean square distance, the mean over the area of either surface, both counted alike.
    pub(crate) rms: f64,
    /// Largest distance of a sample or a vertex of one surface from the other.
    pub(crate) max: f64,
}

/// A surface that others are compared with.
#[derive(Debug)]
pub(crate) struct Reference {
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
    pub(crate) fn new(mesh: &Mesh, samples: usize) -> Reference {
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for p in &mesh.positions {
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
    pub(crate) fn distance(&self, mesh: &Mesh) -> Distance {
        let there = self.points.distance(&Nearest::of(mesh));
        let back = Points::of(mesh, self.samples).distance(&self.nearest);
        let unit = 1e4 / self.diagonal;
        Distance {
            rms: ((there.mean_square + back.mean_square) / 2.0).sqrt() * unit,
            max: there.max_square.max(back.max_square).sqrt() * unit,
        }
    }
}

impl Points {
    fn of(mesh: &Mesh, samples: usize) -> Points {
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
    use crate::bench::nearest::squared_distance;
    use crate::data::sculpture::sculpture;

    /// A square of side 1 in a plane of constant z, in `n` by `n` quads.
    fn square(n: u32, z: f64) -> Mesh {
        let mut mesh = Mesh::default();
        for j in 0..=n {
            for i in 0..=n {
                mesh.vertex(DVec3::new(f64::from(i) / f64::from(n), f64::from(j) / f64::from(n), z));
            }
        }
        for j in 0..n {
            for i in 0..n {
                let at = j * (n + 1) + i;
                mesh.quad(at, at + 1, at + n + 2, at + n + 1);
            }
        }
        mesh
    }

    #[test]
    fn parallel_squares_are_their_offset_apart() {
        let d = Reference::new(&square(3, 0.0), 1_000).distance(&square(5, 0.125));
        let expected = 0.125 / 2.0_f64.sqrt() * 1e4;
        assert!((d.rms - expected).abs() < 1e-6 && (d.max - expected).abs() < 1e-6, "{d:?}");
    }

    /// One spike in a corner shows in the maximum, whichever surface has it.
    #[test]
    fn the_maximum_sees_a_single_vertex_of_either_surface() {
        let (flat, mut spiked) = (square(20, 0.0), square(20, 0.0));
        spiked.positions[0][2] = 0.1;
        let expected = 0.1 / (2.0 + 0.01_f64).sqrt() * 1e4;
        for (a, b) in [(&flat, &spiked), (&spiked, &flat)] {
            let d = Reference::new(a, 50).distance(b);
            assert!((d.max - expected).abs() < 0.01 * expected, "{d:?} {expected}");
        }
    }

    #[test]
    fn a_surface_is_at_distance_zero_from_itself_and_far_from_nothing() {
        let mesh = sculpture(3_000).unwrap();
        let reference = Reference::new(&mesh, 2_000);
        assert!(reference.distance(&mesh).max < 1e-3);
        assert!(reference.distance(&Mesh::default()).max.is_infinite());
    }

    /// All pairs, with the same samples; and the samples meet the integral within a percent.
    #[test]
    fn agrees_with_brute_force_for_any_number_of_threads() {
        let (a, b) = (sculpture(2_500).unwrap(), sculpture(2_100).unwrap());
        let triangles = |m: &Mesh| -> Vec<[Vec3; 3]> {
            m.faces.iter().map(|f| f.map(|v| Vec3::from_array(m.positions[v as usize]))).collect()
        };
        let one_way = |from: &Mesh, to: &Mesh, n: usize| {
            let (points, to) = (Points::of(from, n), triangles(to));
            let far = |p: &DVec3| to.iter().map(|t| squared_distance(*p, t)).fold(f64::INFINITY, f64::min);
            let mean = points.samples.iter().map(far).sum::<f64>() / n as f64;
            (mean, points.samples.iter().chain(&points.vertices).map(far).fold(0.0, f64::max))
        };
        let ((m, x), (n, y)) = (one_way(&a, &b, 400), one_way(&b, &a, 400));
        let reference = Reference::new(&a, 400);
        let unit = 1e4 / reference.diagonal;
        let with = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| reference.distance(&b))
        };
        let found = with(1);
        assert_eq!(found, with(3));
        let expected = Distance { rms: ((m + n) / 2.0).sqrt() * unit, max: x.max(y).sqrt() * unit };
        assert!((found.rms - expected.rms).abs() < 1e-9 * expected.rms, "{found:?} {expected:?}");
        assert_eq!(found.max, expected.max);
        let fine = Reference::new(&a, 400_000).distance(&b).rms;
        let coarse = Reference::new(&a, 50_000).distance(&b).rms;
        assert!((fine - coarse).abs() < 0.01 * fine, "{fine} {coarse}");
    }
}
