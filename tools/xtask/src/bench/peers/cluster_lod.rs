//! meshoptimizer's cluster LOD: a graph of groups of clusters, cut at an error.

use glam::DVec3;
use meshopt::{ClodMesh, clod_build, clod_default_config};

use super::{over, positions};
use crate::data::ply_out::Mesh;

/// Triangles in a cluster at most: what its authors recommend for drawing.
const CLUSTER: usize = 128;

/// A hierarchy over a mesh.
#[derive(Debug)]
pub(crate) struct ClusterLod {
    /// The error of each group's simplification.
    errors: Vec<f32>,
    /// The sphere around each group: centre and radius. One that is made of others holds theirs.
    spheres: Vec<(DVec3, f64)>,
    clusters: Vec<Cluster>,
}

#[derive(Debug)]
struct Cluster {
    /// Drawn while the error of this group is over the threshold.
    group: usize,
    /// And that of the group it was made of is not; of the input when there is none.
    refined: Option<usize>,
    indices: Vec<u32>,
}

/// Builds the hierarchy, throws it away and returns the number of groups: what its time is measured by.
pub(crate) fn build_only(mesh: &Mesh) -> usize {
    let mut groups = 0;
    let Some(vertices) = positions(mesh) else { return groups };
    clod_build(clod_default_config(CLUSTER), &ClodMesh::new(mesh.faces.as_flattened(), &vertices), |_, _| {
        groups += 1;
        groups as i32 - 1
    });
    groups
}

impl ClusterLod {
    /// Builds the hierarchy with its default settings, on one thread.
    pub(crate) fn build(mesh: &Mesh) -> ClusterLod {
        let mut lod = ClusterLod { errors: Vec::new(), spheres: Vec::new(), clusters: Vec::new() };
        let Some(vertices) = positions(mesh) else { return lod };
        let input = ClodMesh::new(mesh.faces.as_flattened(), &vertices);
        clod_build(clod_default_config(CLUSTER), &input, |group, clusters| {
            let id = lod.errors.len();
            lod.errors.push(group.simplified.error);
            let center = DVec3::from_array(group.simplified.center.map(f64::from));
            lod.spheres.push((center, f64::from(group.simplified.radius)));
            lod.clusters.extend(clusters.iter().map(|c| Cluster {
                group: id,
                refined: usize::try_from(c.refined).ok(),
                indices: c.indices.to_vec(),
            }));
            id as i32
        });
        lod
    }

    fn is_drawn(&self, cluster: &Cluster, threshold: f32) -> bool {
        let error = |group: usize| self.errors.get(group).copied().unwrap_or(f32::MAX);
        error(cluster.group) > threshold && cluster.refined.is_none_or(|g| error(g) <= threshold)
    }

    fn triangles(&self, threshold: f32) -> u64 {
        let drawn = self.clusters.iter().filter(|c| self.is_drawn(c, threshold));
        drawn.map(|c| c.indices.len() as u64 / 3).sum()
    }

    /// The clusters of its cut for a view, of which `allowed` says how much error it allows in a sphere.
    ///
    /// As its authors do: a cluster is drawn if its group's error is too much and that of the group that it was made of
    /// is not. All clusters are looked at; each group's error is compared once.
    pub(crate) fn select(&self, allowed: &impl Fn(DVec3, f64) -> f64, out: &mut Vec<usize>) {
        let groups = self.errors.iter().zip(&self.spheres);
        let is_over: Vec<bool> =
            groups.map(|(e, (center, radius))| f64::from(*e) > allowed(*center, *radius)).collect();
        let over = |group: usize| is_over.get(group).copied().unwrap_or(true);
        out.clear();
        let drawn = |c: &Cluster| over(c.group) && c.refined.is_none_or(|g| !over(g));
        out.extend(self.clusters.iter().enumerate().filter(|(_, c)| drawn(c)).map(|(i, _)| i));
    }

    /// The mesh of that cut.
    pub(crate) fn seen(&self, allowed: &impl Fn(DVec3, f64) -> f64, mesh: &Mesh) -> Mesh {
        let mut drawn = Vec::new();
        self.select(allowed, &mut drawn);
        let clusters = drawn.iter().filter_map(|i| self.clusters.get(*i));
        let indices: Vec<u32> = clusters.flat_map(|c| c.indices.iter().copied()).collect();
        over(&mesh.positions, &indices)
    }

    /// Its cut at the least error that has at most so many triangles; the coarsest that there is, if all have more.
    pub(crate) fn within(&self, triangles: u64, mesh: &Mesh) -> Mesh {
        let mut errors: Vec<f32> = self.errors.iter().copied().filter(|e| *e < f32::MAX).collect();
        errors.sort_unstable_by(f32::total_cmp);
        errors.dedup();
        // Groups do not grow when they are simplified, so the count falls with the error.
        let at = errors.partition_point(|e| self.triangles(*e) > triangles);
        let threshold = errors.get(at).or(errors.last()).copied().unwrap_or(0.0);
        let drawn = self.clusters.iter().filter(|c| self.is_drawn(c, threshold));
        let indices: Vec<u32> = drawn.flat_map(|c| c.indices.iter().copied()).collect();
        over(&mesh.positions, &indices)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::input::{open_edges, same_faces};
    use crate::data::sculpture::sculpture;

    #[test]
    fn cuts_are_closed_and_keep_to_the_number() {
        let mesh = sculpture(12_000).unwrap();
        let lod = ClusterLod::build(&mesh);
        assert_eq!(lod.errors.len(), build_only(&mesh));
        let full = lod.within(u64::MAX, &mesh);
        assert_eq!(lod.triangles(-1.0), mesh.faces.len() as u64);
        assert!(full.faces.len() <= mesh.faces.len());
        let mut last = u64::MAX;
        for wanted in [9_000, 6_000, 3_000] {
            let cut = lod.within(wanted, &mesh);
            assert_eq!(open_edges(&cut), 0, "{wanted}");
            let found = cut.faces.len() as u64;
            assert!(found <= wanted && found < last && found > wanted / 4, "{wanted}: {found}");
            last = found;
        }
        // Where nothing depends on the place, a view's cut is that of an error.
        let threshold = lod.errors.iter().copied().filter(|e| *e < f32::MAX).fold(0.0, f32::max) * 0.3;
        let seen = lod.seen(&|_, _| f64::from(threshold), &mesh);
        assert_eq!(lod.triangles(threshold), seen.faces.len() as u64);
        // Half the mesh fine, half coarse, is closed too.
        let halves = |center: DVec3, radius: f64| if center.x < radius { 0.0 } else { f64::from(threshold) };
        let mixed = lod.seen(&halves, &mesh);
        assert_eq!(open_edges(&mixed), 0);
        assert!(mixed.faces.len() > seen.faces.len());
        assert!(!same_faces(&full, &lod.within(3_000, &mesh)));
    }
}
