//! A cut as unindexed triangles, each cluster in a colour of its own with its outline marked.

use super::cut::Slot;
use crate::gpu::pipelines::ClusterVertex;
use rayon::prelude::*;

/// The corners of all triangles of a cut, in its order: corner i is that of index i.
pub(crate) fn corners(tree: &fct::Tree, slot: &Slot) -> Vec<ClusterVertex> {
    let triangles = slot.extraction.indices.as_chunks::<3>().0;
    let starts = &slot.extraction.clusters;
    let ends = starts.iter().skip(1).copied().chain(std::iter::once(triangles.len() as u32));
    let spans: Vec<_> = starts.iter().copied().zip(ends).collect();
    spans
        .par_iter()
        .flat_map_iter(|(start, end)| {
            let cluster = triangles.get(*start as usize..*end as usize).unwrap_or(&[]);
            paint(tree, cluster)
        })
        .collect()
}

/// The corners of one cluster's triangles.
fn paint(tree: &fct::Tree, cluster: &[[u32; 3]]) -> Vec<ClusterVertex> {
    let mut edges: Vec<[u32; 2]> =
        cluster.iter().flat_map(|[a, b, c]| [[*a, *b], [*b, *c], [*c, *a]]).collect();
    edges.sort_unstable();
    // The least vertex names the cluster: it seldom changes while the view does, so colours do not flicker.
    let name = cluster.iter().flatten().min().copied().unwrap_or(0);
    let color = color(name ^ (cluster.len() as u32) << 27);
    let position = |i: u32| {
        let record = tree.vertices().get(i as usize);
        record.map_or([0.0; 3], |v| v.position())
    };
    let mut corners = Vec::with_capacity(3 * cluster.len());
    for triangle in cluster {
        let [a, b, c] = *triangle;
        // A side that another triangle of the cluster runs the other way is a diagonal, not a border.
        let inner = [[b, c], [c, a], [a, b]].map(|[p, q]| edges.binary_search(&[q, p]).is_ok());
        for (k, vertex) in [a, b, c].into_iter().enumerate() {
            let mut border = [255; 4];
            for (side, (value, inner)) in border.iter_mut().zip(inner).enumerate() {
                *value = if inner || side == k { 255 } else { 0 };
            }
            corners.push(ClusterVertex { position: position(vertex), color, border });
        }
    }
    corners
}

/// A colour for a number: bright, never dull, neighbours unlike.
fn color(number: u32) -> [u8; 4] {
    // Steps of the golden ratio keep consecutive hues apart; the hash keeps alike numbers apart.
    let hash = number.wrapping_mul(0x9E37_79B1).rotate_left(13).wrapping_mul(0x85EB_CA6B);
    let hue = f64::from(hash >> 8) / f64::from(1_u32 << 24);
    let light = 0.62 + 0.26 * f64::from(hash & 0xFF) / 255.0;
    let channel = |offset: f64| {
        let turn = (hue + offset).fract() * 6.0;
        let ramp = ((turn - 3.0).abs() - 1.0).clamp(0.0, 1.0);
        (255.0 * light * (0.55 + 0.45 * ramp)) as u8
    };
    [channel(0.0), channel(2.0 / 3.0), channel(1.0 / 3.0), 255]
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
}
