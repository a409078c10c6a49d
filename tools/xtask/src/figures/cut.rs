//! A cut of a tree in two ways: the faces of its clusters, and the polygons that stand for them.

use super::palette;
use super::picture::Scene;
use fcextract::{Budget, Extraction, Selection, extract, fit};
use fct::{Child, Subtree, Tree};
use glam::DVec3;
use std::error::Error;
use std::ops::Range;

/// What is drawn with a number of clusters.
#[derive(Debug)]
pub(crate) struct Cut {
    /// The input's triangles, and the cluster of each.
    pub(crate) faces: Scene,
    /// The triangles of the clusters' polygons, and the cluster of each.
    pub(crate) polygons: Scene,
    /// How many clusters there are.
    pub(crate) clusters: usize,
}

impl Cut {
    /// The finest cut in budget order of at most `clusters` clusters. Both scenes have the same colours.
    ///
    /// # Errors
    /// Those of the extraction, and when tree and extraction do not agree on the clusters.
    pub(crate) fn of(tree: &Tree, clusters: usize) -> Result<Cut, Box<dyn Error>> {
        let mut drawn = Extraction::default();
        let budget = Budget::Clusters(clusters as u64);
        let (selection, _) = fit(tree, Selection::by_budget(), budget, &mut drawn)?;
        let ranges = clusters_of(tree, &selection)?;
        if ranges.len() as u64 != drawn.stats.clusters {
            let (walked, drawn) = (ranges.len(), drawn.stats.clusters);
            return Err(format!("the walk found {walked} clusters and the extraction {drawn}").into());
        }
        let mut full = Extraction::default();
        extract(tree, &Selection::full(), &mut full)?;
        let mut faces = scene(tree, &full.indices);
        for (i, r) in ranges.iter().enumerate() {
            faces.cluster.resize(r.end as usize, i as u32);
        }
        faces.colors = palette::colors(ranges.len(), &touching(&full.indices, &faces.cluster));

        let mut polygons = scene(tree, &drawn.indices);
        for i in 0..drawn.clusters.len() {
            let end = drawn.clusters.get(i + 1).map_or(polygons.triangles.len(), |end| *end as usize);
            polygons.cluster.resize(end, i as u32);
        }
        polygons.colors.clone_from(&faces.colors);
        Ok(Cut { faces, polygons, clusters: ranges.len() })
    }

    /// Triangles drawn.
    pub(crate) fn triangles(&self) -> usize {
        self.polygons.triangles.len()
    }
}

/// The faces of each cluster that `selection`, which leaves nothing out, draws; in tree order.
fn clusters_of(tree: &Tree, selection: &Selection) -> Result<Vec<Range<u32>>, Box<dyn Error>> {
    let mut ranges = Vec::new();
    let mut stack: Vec<Subtree> = vec![tree.whole()];
    while let Some(subtree) = stack.pop() {
        if let Child::Node(_) = subtree.child.kind()
            && selection.refines_node(subtree.child, &tree.node(&subtree)?)
        {
            let [left, right] = tree.children(&subtree)?;
            stack.extend([right, left]);
        } else {
            ranges.push(subtree.first_face..subtree.face_end);
        }
    }
    Ok(ranges)
}

/// Triangles of a tree, at the places of its vertices.
pub(crate) fn scene(tree: &Tree, indices: &[u32]) -> Scene {
    let position = |v: u32| {
        let found = tree.vertices().get(v as usize).map(|r| r.position().map(f64::from));
        found.map_or(DVec3::ZERO, DVec3::from)
    };
    let triangles = indices.as_chunks::<3>().0.iter().map(|t| t.map(position)).collect();
    Scene { triangles, ..Scene::default() }
}

/// Pairs of clusters that share an edge.
fn touching(indices: &[u32], cluster: &[u32]) -> Vec<(u32, u32)> {
    let mut edges: Vec<([u32; 2], u32)> = Vec::with_capacity(indices.len());
    for (t, c) in indices.as_chunks::<3>().0.iter().zip(cluster) {
        for [a, b] in [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]] {
            edges.push(([a.min(b), a.max(b)], *c));
        }
    }
    edges.sort_unstable();
    let mut pairs: Vec<(u32, u32)> = edges
        .windows(2)
        .filter(|w| w[0].0 == w[1].0 && w[0].1 != w[1].1)
        .map(|w| (w[0].1.min(w[1].1), w[0].1.max(w[1].1)))
        .collect();
    pairs.sort_unstable();
    pairs.dedup();
    pairs
}

#[cfg(test)]
mod tests {
    use super::super::model::Model;
    use super::super::modes::PAPER;
    use super::super::sampling::ellipsoid;
    use super::*;

    /// Each cluster has faces and a polygon, neighbours differ in colour, and faces cover the input once.
    #[test]
    fn faces_and_polygons_are_of_the_same_clusters() {
        let (positions, faces) = ellipsoid(40, 40, [1.0, 0.7, 0.6], 1.0);
        let model = Model::of_triangles("ellipsoid", positions, faces).unwrap();
        let cut = Cut::of(&model.tree(PAPER).unwrap(), 60).unwrap();
        assert!((50..=60).contains(&cut.clusters), "{}", cut.clusters);
        assert_eq!(cut.faces.triangles.len(), model.faces());
        assert_eq!(cut.faces.cluster.len(), model.faces());
        let distinct = |s: &Scene| {
            let mut all = s.cluster.clone();
            all.dedup();
            all.len()
        };
        assert_eq!(distinct(&cut.faces), cut.clusters);
        assert_eq!(distinct(&cut.polygons), cut.clusters);
        assert!(cut.triangles() > cut.clusters && cut.triangles() < 8 * cut.clusters);
        // A polygon lies where its faces lie.
        let middle = |s: &Scene, c: u32| {
            let of: Vec<DVec3> =
                (0..s.triangles.len()).filter(|&i| s.cluster[i] == c).flat_map(|i| s.triangles[i]).collect();
            of.iter().sum::<DVec3>() / of.len() as f64
        };
        for c in 0..cut.clusters as u32 {
            assert!(middle(&cut.faces, c).distance(middle(&cut.polygons, c)) < 0.35);
        }
    }
}
