//! meshoptimizer's cluster LOD: a graph of groups of clusters, cut at an error.

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
        let mut lod = ClusterLod { errors: Vec::new(), clusters: Vec::new() };
        let Some(vertices) = positions(mesh) else { return lod };
        let input = ClodMesh::new(mesh.faces.as_flattened(), &vertices);
        clod_build(clod_default_config(CLUSTER), &input, |group, clusters| {
            let id = lod.errors.len();
            lod.errors.push(group.simplified.error);
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
        assert!(!same_faces(&full, &lod.within(3_000, &mesh)));
    }
}
