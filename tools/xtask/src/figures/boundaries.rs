//! The border between the two halves of a model, by partition and by merging.
//!
//! # Paper
//! `[TsujiJa]` figures 4 and 5.

use super::front::Front;
use super::model::Model;
use super::modes::{MERGE, Mode, PAPER};
use super::output::Output;
use super::page::{Panel, panels, three, verdict};
use super::palette;
use super::picture::{Lines, Scene, draw};
use super::view::Frame;
use fcbuild::mesh::NONE;
use fcgeom::{eigen, point_covariance};
use glam::DVec3;
use std::error::Error;

/// The border between two clusters, in parts of the diagonal.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Border {
    /// How long it is.
    pub(crate) length: f64,
    /// Root mean square distance of its vertices from the plane that fits them best.
    pub(crate) off_plane: f64,
}

/// The first two clusters of each model, by partition and, where the builder has it, by merging; returns the text
/// for the page.
///
/// # Errors
/// Those of the output folder.
pub(crate) fn section(models: &[&Model], out: &Output) -> Result<String, Box<dyn Error>> {
    let mut text = String::from(
        "## The border of the first two clusters ([TsujiJa] figures 4 and 5)\n\n\
         [TsujiJa] says that a partition by planes has smooth borders, and merging of faces ragged ones.\n\
         How far a border strays from the plane that fits it best says how ragged it is; its length depends on how much is cut off as well.\n",
    );
    let mut smoother = Vec::new();
    for model in models {
        eprintln!("halves of {}", model.name);
        let partition = halves(model, PAPER);
        let view = model.view.beside(between(model, &partition));
        let used = (0..model.faces()).flat_map(|f| model.corners(f));
        let frame = Frame::around(view, used, out.size[0], out.size[1]);
        let (panel, smooth) = panel(model, PAPER, partition, &frame, out)?;
        let mut list = vec![panel];
        if model.has(MERGE) {
            let (panel, ragged) = self::panel(model, MERGE, halves(model, MERGE), &frame, out)?;
            list.push(panel);
            smoother.push(smooth.off_plane < ragged.off_plane);
        }
        text.push('\n');
        text += &panels(&list, 2);
    }
    text += &if smoother.is_empty() {
        "\nThere is no tree by merging here to compare with.\n".to_owned()
    } else {
        format!(
            "\n- The border by partition keeps closer to a plane than that by merging.\n  {}\n",
            verdict(smoother.iter().all(|s| *s))
        )
    };
    Ok(text)
}

/// Which of the first two clusters each face belongs to.
fn halves(model: &Model, mode: Mode) -> Vec<u32> {
    let hierarchy = model.hierarchy(mode);
    let mut front = Front::new(&hierarchy);
    front.refine(2);
    let mut half = vec![0_u32; model.faces()];
    for (i, range) in front.ranges().into_iter().enumerate() {
        for f in &hierarchy.order[range] {
            half[*f as usize] = i as u32;
        }
    }
    half
}

/// From the middle of the first cluster to that of the second.
fn between(model: &Model, half: &[u32]) -> DVec3 {
    let (mut sum, mut area) = ([DVec3::ZERO; 2], [f64::MIN_POSITIVE; 2]);
    for (f, h) in half.iter().enumerate() {
        let weight = model.area(f);
        sum[*h as usize] += model.corners(f).iter().sum::<DVec3>() * (weight / 3.0);
        area[*h as usize] += weight;
    }
    sum[1] / area[1] - sum[0] / area[0]
}

/// The first two clusters in colours, and the border between them.
fn panel(
    model: &Model,
    mode: Mode,
    half: Vec<u32>,
    frame: &Frame,
    out: &Output,
) -> Result<(Panel, Border), Box<dyn Error>> {
    let border = border(model, &half);
    let areas = [0, 1].map(|k| {
        let of_this = half.iter().enumerate().filter(|(_, h)| **h == k);
        of_this.map(|(f, _)| model.area(f)).sum::<f64>()
    });
    let smaller_part = areas[0].min(areas[1]) / (areas[0] + areas[1]);
    let scene = Scene {
        triangles: (0..model.faces()).map(|f| model.corners(f)).collect(),
        normals: Some((0..model.faces()).map(|f| model.normals(f)).collect()),
        cluster: half,
        colors: palette::colors(2, &[(0, 1)]),
    };
    let file = format!("halves-{}-{}.png", model.name, mode.name());
    out.picture(&file, &draw(&scene, frame, Lines { clusters: true, triangles: false }))?;
    let (length, off) = (three(border.length), three(border.off_plane));
    let part = smaller_part * 100.0;
    let panel = Panel {
        file,
        alt: format!("{} in two clusters by {}", model.name, mode.name()),
        caption: format!(
            "`{}`: border {off} diagonals off its plane, {length} long; {part:.0} % of the area in the smaller part",
            mode.name()
        ),
    };
    Ok((panel, border))
}

fn border(model: &Model, half: &[u32]) -> Border {
    let (mut length, mut vertices) = (0.0, Vec::new());
    for f in 0..model.faces() {
        for e in 0..3 {
            let across = model.mesh.graph.opposite[f * 3 + e];
            if across == NONE || half[f] >= half[across as usize / 3] {
                continue;
            }
            let [from, to] = [e, (e + 1) % 3].map(|k| model.mesh.faces[f][k]);
            let place = |v: u32| model.mesh.positions[v as usize].as_dvec3();
            length += place(from).distance(place(to));
            vertices.extend([from, to]);
        }
    }
    vertices.sort_unstable();
    vertices.dedup();
    let points: Vec<DVec3> = vertices.iter().map(|v| model.mesh.positions[*v as usize].as_dvec3()).collect();
    let spread = eigen(&point_covariance(&points)).values[2].max(0.0);
    Border { length: model.per_diagonal(length), off_plane: model.per_diagonal(spread.sqrt()) }
}

#[cfg(test)]
mod tests {
    use super::super::sampling::ellipsoid;
    use super::*;

    /// Half a sphere of radius 1 ends in a circle: 2 pi long, in a plane; the box's diagonal is 2 sqrt 3.
    #[test]
    fn the_border_of_a_half_sphere_is_a_circle() {
        let (positions, faces) = ellipsoid(64, 64, [1.0; 3], 1.0);
        let model = Model::of_triangles("sphere", positions, faces).unwrap();
        let pole = super::super::sampling::pole();
        let half: Vec<u32> = (0..model.faces())
            .map(|f| u32::from(model.corners(f).iter().sum::<DVec3>().dot(pole) > 0.0))
            .collect();
        let b = border(&model, &half);
        let diagonal = 2.0 * 3.0_f64.sqrt();
        assert!((b.length * diagonal - std::f64::consts::TAU).abs() < 0.02, "{b:?}");
        assert!(b.off_plane < 1e-4, "{b:?}");
    }
}
