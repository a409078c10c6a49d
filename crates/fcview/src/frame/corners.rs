//! A cut as unindexed triangles: each cluster in a colour of its own or of its level, with outlines, or in the model's
//! colours with every edge drawn.

use crate::gpu::pipelines::ClusterVertex;
use fcextract::{Extraction, Part, Selection, Stats};

/// What is painted on unindexed triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Paint {
    pub(crate) color: PaintColor,
    /// Draw the edges of all triangles, not of clusters alone.
    pub(crate) wireframe: bool,
}

/// The colours of clusters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PaintColor {
    /// Those of the model's vertices, without outlines.
    Model,
    /// One for each cluster.
    Cluster,
    /// From blue for single faces to red for clusters of a million: how coarse the cut is.
    Level,
}

/// Adds the corners of all triangles of a cut of some parts, in its order: corner i is that of index i.
///
/// # Errors
/// As [`Part::divide`].
pub(crate) fn fill<'a>(
    tree: &fct::Tree,
    selection: &Selection,
    parts: impl Iterator<Item = &'a Part>,
    cut: &Extraction,
    paint: Paint,
    out: &mut Vec<ClusterVertex>,
) -> Result<(), fcextract::Error> {
    let mut levels = Vec::new();
    if paint.color == PaintColor::Level {
        // Walked once more, the clusters of the cut come in the same order.
        for part in parts {
            part.divide(
                tree,
                selection,
                &mut Stats::default(),
                |_, _| false,
                |cluster, _| {
                    levels.push(level_color(cluster.subtree.face_count()));
                },
            )?;
        }
    }
    let triangles = cut.indices.as_chunks::<3>().0;
    let ends = cut.clusters.iter().skip(1).copied().chain(std::iter::once(triangles.len() as u32));
    out.reserve(cut.indices.len());
    let mut edges = Vec::new();
    for (number, (start, end)) in cut.clusters.iter().zip(ends).enumerate() {
        let cluster = triangles.get(*start as usize..end as usize).unwrap_or(&[]);
        let color = match paint.color {
            PaintColor::Model => None,
            PaintColor::Cluster => {
                // The least vertex names the cluster: it seldom changes while the view does, so colours do not flicker.
                let name = cluster.iter().flatten().min().copied().unwrap_or(0);
                Some(color(name ^ (cluster.len() as u32) << 27))
            }
            PaintColor::Level => levels.get(number).copied(),
        };
        edges.clear();
        if !paint.wireframe {
            edges.extend(cluster.iter().flat_map(|[a, b, c]| [[*a, *b], [*b, *c], [*c, *a]]));
            edges.sort_unstable();
        }
        for triangle in cluster {
            paint_triangle(tree, *triangle, color, paint, &edges, out);
        }
    }
    Ok(())
}

/// The corners of a triangle; `edges` are all directed sides of its cluster, sorted.
fn paint_triangle(
    tree: &fct::Tree,
    [a, b, c]: [u32; 3],
    color: Option<[u8; 4]>,
    paint: Paint,
    edges: &[[u32; 2]],
    out: &mut Vec<ClusterVertex>,
) {
    // A side that another triangle of the cluster runs the other way is a diagonal, not a border.
    let drawn = [[b, c], [c, a], [a, b]].map(|[p, q]| match paint.color {
        _ if paint.wireframe => true,
        PaintColor::Model => false,
        PaintColor::Cluster | PaintColor::Level => edges.binary_search(&[q, p]).is_err(),
    });
    for (k, vertex) in [a, b, c].into_iter().enumerate() {
        let mut border = [255; 4];
        for (side, (value, drawn)) in border.iter_mut().zip(drawn).enumerate() {
            *value = if !drawn || side == k { 255 } else { 0 };
        }
        let place = tree.vertices().get(vertex as usize).map_or([0.0; 3], |v| v.position());
        let own = || tree.colors().and_then(|colors| colors.get(vertex as usize)).copied();
        let color = color.unwrap_or_else(|| own().unwrap_or(crate::gpu::vertices::CLAY));
        out.push(ClusterVertex { position: place, color, border });
    }
}

/// A colour for a number: bright, never dull, neighbours unlike.
fn color(number: u32) -> [u8; 4] {
    // Steps of the golden ratio keep consecutive hues apart; the hash keeps alike numbers apart.
    let hash = number.wrapping_mul(0x9E37_79B1).rotate_left(13).wrapping_mul(0x85EB_CA6B);
    let hue = f64::from(hash >> 8) / f64::from(1_u32 << 24);
    let light = 0.62 + 0.26 * f64::from(hash & 0xFF) / 255.0;
    let [red, green, blue] = ramp(hue, 0.55);
    [red * light, green * light, blue * light, 1.0].map(|channel| (255.0 * channel) as u8)
}

/// A colour for a cluster of so many faces: from blue over green and yellow to red, a step for each doubling.
fn level_color(faces: u32) -> [u8; 4] {
    /// A cluster of 2^20 faces, a million, and all above are red.
    const LEVELS: f64 = 20.0;
    let level = (f64::from(faces.max(1)).log2().floor() / LEVELS).min(1.0);
    let [red, green, blue] = ramp(2.0 / 3.0 * (1.0 - level), 0.25);
    [red, green, blue, 1.0].map(|channel| (225.0 * channel) as u8)
}

/// A hue in 0..1, red first, with at least `least` of each channel.
fn ramp(hue: f64, least: f64) -> [f64; 3] {
    [0.0, 2.0 / 3.0, 1.0 / 3.0].map(|offset| {
        let turn = (hue + offset).fract() * 6.0;
        least + (1.0 - least) * ((turn - 3.0).abs() - 1.0).clamp(0.0, 1.0)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_differ_and_are_never_dark() {
        let colors: Vec<_> = (0..64).map(color).collect();
        for (i, a) in colors.iter().enumerate() {
            assert!(a[..3].iter().any(|c| *c > 140), "{a:?}");
            let alike = colors.iter().skip(i + 1).filter(|b| *b == a).count();
            assert!(alike <= 1, "{a:?}");
        }
    }

    #[test]
    fn levels_run_from_blue_to_red() {
        let warm = |faces| {
            let [red, _, blue, _] = level_color(faces).map(i32::from);
            red - blue
        };
        let doublings: Vec<i32> = (0..=20).map(|k| warm(1 << k)).collect();
        assert!(doublings.is_sorted() && doublings[0] < -150 && doublings[20] > 150, "{doublings:?}");
        assert_eq!(level_color(1 << 21), level_color(1 << 20));
    }
}
