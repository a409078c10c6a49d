//! What an uneven sampling does to principal components: of points, and of the surface.
//!
//! # Paper
//! `[Tsuji07, eq. 1, 2]` against `[Tsuji07, eq. 3, 4]`, the latter as sums over triangles by eq. 8.

use super::approximations::frame_of;
use super::model::Model;
use super::output::Output;
use super::page::{Panel, panels, table, verdict, whole};
use super::palette;
use super::picture::{Lines, Scene, draw};
use crate::data::circle;
use fcgeom::{Moments, eigen, pca_axis, point_covariance};
use glam::DVec3;
use std::error::Error;

/// Half axes of the ellipsoid: the longest one is X.
const RADII: [f64; 3] = [1.0, 0.85, 0.6];

/// How many times closer together its rings are at one pole than in an even mesh.
const DENSITY: f64 = 8.0;

/// Of the meshes that are compared.
const RINGS: u32 = 60;
const SEGMENTS: u32 = 48;

/// Where the dense pole is: between the longest axis and the next.
pub(crate) fn pole() -> DVec3 {
    DVec3::new(0.55, 0.75, 0.35).normalize_or_zero()
}

/// A closed ellipsoid of rings around [`pole`], which cut a sphere into bands of equal area if `density` is 1.
///
/// A larger one brings the rings closer together at the pole, that many times, and spreads them at the other.
pub(crate) fn ellipsoid(
    rings: u32,
    segments: u32,
    radii: [f64; 3],
    density: f64,
) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let (x, y) = fcgeom::tangent_frame(pole());
    let place = |p: DVec3| (p * DVec3::from(radii)).as_vec3().to_array();
    let mut positions = vec![place(pole())];
    for ring in 1..rings {
        let u = f64::from(ring) / f64::from(rings);
        let z = 1.0 - 2.0 * u / (density - (density - 1.0) * u);
        let r = ((1.0 - z) * (1.0 + z)).max(0.0).sqrt();
        for segment in 0..segments {
            // Every other ring is turned by half a segment, for triangles of better shape.
            let (c, s) = circle((f64::from(segment) + 0.5 * f64::from(ring % 2)) / f64::from(segments));
            positions.push(place(pole() * z + (x * c + y * s) * r));
        }
    }
    positions.push(place(-pole()));
    let last = positions.len() as u32 - 1;
    let at = |ring: u32, segment: u32| 1 + (ring - 1) * segments + segment % segments;
    let mut faces = Vec::new();
    for s in 0..segments {
        faces.push([0, at(1, s), at(1, s + 1)]);
        for ring in 1..rings - 1 {
            let odd = ring % 2;
            // The corner of the next ring that stands between the two corners of this one, or the other way round.
            if odd == 1 {
                faces.push([at(ring, s), at(ring + 1, s), at(ring + 1, s + 1)]);
                faces.push([at(ring, s), at(ring + 1, s + 1), at(ring, s + 1)]);
            } else {
                faces.push([at(ring, s), at(ring + 1, s), at(ring, s + 1)]);
                faces.push([at(ring, s + 1), at(ring + 1, s), at(ring + 1, s + 1)]);
            }
        }
        faces.push([last, at(rings - 1, s + 1), at(rings - 1, s)]);
    }
    (positions, faces)
}

/// A principal axis, and the cut through the mean that it leads to.
#[derive(Debug)]
struct Analysis {
    axis: DVec3,
    mean: DVec3,
    /// 1 where a face lies on the side that the axis points to.
    side: Vec<u32>,
}

impl Analysis {
    fn new(model: &Model, axis: DVec3, mean: DVec3) -> Analysis {
        let side = (0..model.faces())
            .map(|f| u32::from((model.corners(f).iter().sum::<DVec3>() / 3.0 - mean).dot(axis) > 0.0))
            .collect();
        Analysis { axis, mean, side }
    }

    /// By the vertices, each as good as another.
    fn of_points(model: &Model) -> Analysis {
        let points: Vec<DVec3> = model.mesh.positions.iter().map(|p| p.as_dvec3()).collect();
        let mean = points.iter().sum::<DVec3>() / points.len() as f64;
        Analysis::new(model, eigen(&point_covariance(&points)).vectors[0], mean)
    }

    /// By the surface.
    fn of_surface(model: &Model) -> Analysis {
        let m = moments(model, |_| true);
        Analysis::new(model, pca_axis(&m), m.centroid())
    }

    /// Angle between the axis and the longest one of the ellipsoid, in degrees.
    fn tilt(&self) -> f64 {
        self.axis.x.abs().min(1.0).acos().to_degrees()
    }

    /// Share of the area in the larger part.
    fn larger_share(&self, model: &Model) -> f64 {
        let part = moments(model, |f| self.side[f] == 1).area / moments(model, |_| true).area;
        part.max(1.0 - part)
    }

    /// Mean modelling error of the two parts, per squared diagonal.
    fn mean_error(&self, model: &Model) -> f64 {
        let parts = [0, 1].map(|k| moments(model, |f| self.side[f] == k));
        let sum: f64 = parts.iter().map(|m| m.area * m.epsilon()).sum();
        model.per_square_diagonal(sum / (parts[0].area + parts[1].area))
    }
}

fn moments(model: &Model, of: impl Fn(usize) -> bool) -> Moments {
    let mut sum = Moments::ZERO;
    for f in (0..model.faces()).filter(|f| of(*f)) {
        let [a, b, c] = model.corners(f);
        sum += Moments::of_triangle(a, b, c);
    }
    sum
}

/// Analyses an even and an uneven mesh of one ellipsoid, and draws the uneven one; returns the text for the page.
///
/// # Errors
/// Those of the builder and of the output folder.
pub(crate) fn section(out: &Output) -> Result<String, Box<dyn Error>> {
    let model = |name: &str, density| {
        let (positions, faces) = ellipsoid(RINGS, SEGMENTS, RADII, density);
        Model::of_triangles(name, positions, faces)
    };
    let (even, uneven) = (model("even", 1.0)?, model("uneven", DENSITY)?);
    let (by_points, by_surface) = (Analysis::of_points(&uneven), Analysis::of_surface(&uneven));
    let row = |m: &Model, by: &str, a: &Analysis| {
        vec![
            format!("{} mesh, {by}", m.name),
            format!("{:.1}", a.tilt()),
            format!("{:.3}", m.per_diagonal(a.mean.length())),
            format!("{:.1} %", 100.0 * a.larger_share(m)),
            format!("{:.2}", 1e3 * a.mean_error(m)),
        ]
    };
    let rows = [
        row(&even, "points (eq. 1, 2)", &Analysis::of_points(&even)),
        row(&even, "surface (eq. 3, 4)", &Analysis::of_surface(&even)),
        row(&uneven, "points (eq. 1, 2)", &by_points),
        row(&uneven, "surface (eq. 3, 4)", &by_surface),
    ];
    let head = [
        "ellipsoid, covariance of",
        "principal axis off the longest one, degrees",
        "mean off the centre, diagonals",
        "area of the larger part",
        "mean error of the two parts, 10⁻³ squared diagonals",
    ];
    let holds = 2.0 * by_surface.tilt() < by_points.tilt()
        && by_surface.larger_share(&uneven) < by_points.larger_share(&uneven)
        && by_surface.mean_error(&uneven) < by_points.mean_error(&uneven);
    let frame = frame_of(&uneven, out.size);
    let mut list = Vec::new();
    for (file, cut, caption) in [
        ("sampling-mesh.png", None, format!("the uneven mesh, {} triangles", whole(uneven.faces()))),
        ("sampling-points.png", Some(by_points), "first cut by points".to_owned()),
        ("sampling-surface.png", Some(by_surface), "first cut by surface".to_owned()),
    ] {
        let mut scene =
            Scene { triangles: (0..uneven.faces()).map(|f| uneven.corners(f)).collect(), ..Scene::default() };
        let lines = Lines { clusters: cut.is_some(), triangles: true };
        if let Some(analysis) = cut {
            scene.cluster = analysis.side;
            scene.colors = palette::colors(2, &[(0, 1)]);
        }
        out.picture(file, &draw(&scene, &frame, lines))?;
        list.push(Panel { file: file.to_owned(), alt: caption.clone(), caption });
    }
    Ok(format!(
        "## Principal components of points and of the surface ([Tsuji07] equations 1, 2 and 3, 4)\n\n\
         Two meshes of one ellipsoid, with half axes {}, {} and {}: one of even density, one {DENSITY} times denser at a pole that lies between the axes than in an even mesh.\n\
         The covariance of the vertices follows the samples: mean and principal axis are drawn to the dense side, and the first cut halves the samples, not the surface.\n\
         The covariance integrated over the triangles stays, but for what the coarse side loses of the shape.\n\n\
         {}\n{}\n\
         - [TsujiJa] says that points lead the principal axis astray where their density varies, and that the integral over the faces does not.\n  {}\n",
        RADII[0],
        RADII[1],
        RADII[2],
        panels(&list, 3),
        table(&head, &rows),
        verdict(holds)
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn model(density: f64) -> Model {
        let (positions, faces) = ellipsoid(RINGS, SEGMENTS, RADII, density);
        Model::of_triangles("ellipsoid", positions, faces).unwrap()
    }

    /// Closed, outward, and of the area of the ellipsoid it is cut from, however uneven.
    #[test]
    fn the_surface_is_the_same_however_it_is_sampled() {
        let areas = [1.0, DENSITY].map(|density| {
            let m = model(density);
            assert_eq!(m.mesh.graph.boundary_edges, 0);
            let sum = moments(&m, |_| true);
            assert!(sum.normal.length() < 1e-5);
            let volume: f64 = (0..m.faces())
                .map(|f| {
                    let [a, b, c] = m.corners(f);
                    a.dot(b.cross(c)) / 6.0
                })
                .sum();
            assert!(volume > 0.0);
            sum.area
        });
        assert!((areas[0] / areas[1] - 1.0).abs() < 0.02, "{areas:?}");
    }

    /// The claim: the axis of the surface stays where it is, that of the points follows the samples.
    #[test]
    fn only_the_points_follow_the_sampling() {
        let (even, uneven) = (model(1.0), model(DENSITY));
        assert!(Analysis::of_surface(&even).tilt() < 2.0);
        assert!(Analysis::of_surface(&uneven).tilt() < 4.0);
        assert!(Analysis::of_points(&uneven).tilt() > 10.0);
    }
}
