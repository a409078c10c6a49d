//! The stages in a row: from a soup to the records of a tree file.

use crate::arcs::activity::Asking;
use crate::arcs::corners::{self, Registered};
use crate::arcs::curves::{self, Curves};
use crate::arcs::{ClusterTree, activity, flaps, holes, loops::Loops};
use crate::colors::{self, Weights};
use crate::displacement::{self, promised};
use crate::error::Error;
use crate::import::{Soup, Tally};
use crate::mesh::{Components, Mesh, Weld};
use crate::partition::{self, Hierarchy, SplitMode};
use crate::records::Records;
use crate::tree_order::TreeMesh;
use crate::{bounds, clusters, groups};
use fct::{Meta, TreeData};
use rayon::prelude::*;
use std::time::{Duration, Instant};

/// A stage of the build, as progress and times name it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// Welding, repair and the dual graph.
    Mesh,
    /// Splitting clusters in two.
    Partition,
    /// Boundary loops of all clusters.
    Boundaries,
    /// Corners, error bounds, spheres, cones and bounding polygons.
    Bounds,
    /// Turning everything into records.
    Records,
}

impl Phase {
    /// The name in reports.
    pub fn as_str(self) -> &'static str {
        match self {
            Phase::Mesh => "mesh",
            Phase::Partition => "partition",
            Phase::Boundaries => "boundaries",
            Phase::Bounds => "bounds",
            Phase::Records => "records",
        }
    }
}

/// How to build.
#[derive(Clone, Copy)]
pub struct BuildOptions<'a> {
    /// How clusters are cut.
    pub split: SplitMode,
    /// Which vertices become one.
    pub weld: Weld,
    /// How much colours count: a patch that is drawn black in place of white counts as an error of so many times its
    /// width. With 0 only places count.
    pub color_weight: f64,
    /// Told of a phase, the faces it is done with, and all faces; from any thread. Partition and bounds count, of the
    /// others only the begin is told.
    pub progress: &'a (dyn Fn(Phase, u64, u64) + Sync),
}

impl Default for BuildOptions<'_> {
    /// The tree of best quality; equal positions become one, colours count, and nobody is told of progress.
    fn default() -> Self {
        let (split, weld) = (SplitMode::Quality, Weld::Exact);
        BuildOptions { split, weld, color_weight: 0.5, progress: &|_, _, _| {} }
    }
}

/// A tree, ready to be written.
#[derive(Debug)]
pub struct Built {
    /// Description for the file; the caller adds what only it knows (source names, generator).
    pub meta: Meta,
    /// What was read, dropped and warned about.
    pub tally: Tally,
    /// Wall time of each phase, in order.
    pub times: Vec<(Phase, Duration)>,
    records: Records,
}

impl Built {
    /// The tree as the writer takes it.
    pub fn data(&self) -> TreeData<'_> {
        let r = &self.records;
        TreeData {
            meta: &self.meta,
            clusters: &r.clusters,
            vertices: &r.vertices,
            weld: &r.weld,
            bounding_polygons: &r.polygons,
            normals: Some(&r.normals),
            colors: r.colors.as_deref(),
            groups: &r.groups,
            chunks: Some(&r.chunks),
        }
    }

    /// Divides the tree anew into chunks, the parts that can be read alone, of at most `faces` faces.
    ///
    /// # Errors
    /// A limit when a section would be too long.
    pub fn set_chunk_faces(&mut self, faces: u32) -> Result<(), Error> {
        let r = &mut self.records;
        r.chunks = fct::ChunkData::with_faces(
            &r.clusters,
            &r.vertices,
            Some(&r.normals),
            r.colors.as_deref(),
            faces,
        )
        .map_err(clusters::pack_error)?;
        Ok(())
    }
}

/// Builds the tree of `soup` on the current rayon pool.
///
/// # Errors
/// Those of [`Prepared::new`] and [`Prepared::build`].
pub fn build(soup: Soup, options: &BuildOptions<'_>) -> Result<Built, Error> {
    Prepared::new(soup, options)?.build(options)
}

/// A welded mesh before the long work: now it is known how much there is of it.
#[derive(Debug)]
pub struct Prepared {
    mesh: Mesh,
    components: Components,
    clock: Clock,
    faces_in: u64,
}

/// How large a surface is, as memory counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Extent {
    /// Faces kept.
    pub faces: u64,
    /// Vertices, copies along seams counted.
    pub vertices: u64,
    /// Edges of faces that no other face is adjacent across.
    pub border_edges: u64,
}

impl Prepared {
    /// Welds and repairs `soup` and finds its connected components, on the current rayon pool.
    ///
    /// # Errors
    /// Bad input when no face is left after repair, or when coordinates leave the range of single precision; a limit
    /// when there are more faces than the format can number.
    pub fn new(soup: Soup, options: &BuildOptions<'_>) -> Result<Prepared, Error> {
        let mut clock = Clock { last: Instant::now(), times: Vec::new() };
        let faces_in = soup.triangles.len() as u64;
        if faces_in > crate::mesh::MAX_FACES {
            return Err(Error::new(
                crate::error::ErrorKind::Limit,
                "FC501",
                format!("{faces_in} faces are more than the format can number ({})", crate::mesh::MAX_FACES),
            ));
        }
        (options.progress)(Phase::Mesh, 0, faces_in);
        let mesh = Mesh::from_soup(soup, options.weld)?;
        let components = Components::of(&mesh);
        clock.lap(Phase::Mesh);
        Ok(Prepared { mesh, components, clock, faces_in })
    }

    /// Whether the faces enclose a volume and look into it; [`Soup::flip`] turns them over.
    pub fn looks_inwards(&self) -> bool {
        self.mesh.tally.warnings.iter().any(|warning| warning.code == "FC293")
    }

    /// How much there is to build.
    pub fn extent(&self) -> Extent {
        Extent {
            faces: self.mesh.faces.len() as u64,
            vertices: self.mesh.positions.len() as u64,
            border_edges: self.mesh.graph.boundary_edges + self.mesh.graph.seams.len() as u64,
        }
    }

    /// Builds the tree on the current rayon pool.
    ///
    /// # Errors
    /// Bad input when spheres or squares of lengths leave the range of single precision; a limit when a section is too
    /// long for the format.
    pub fn build(self, options: &BuildOptions<'_>) -> Result<Built, Error> {
        let Prepared { mesh, components, clock, faces_in } = self;
        build_prepared(mesh, components, clock, faces_in, options)
    }
}

fn build_prepared(
    mut mesh: Mesh,
    components: Components,
    mut clock: Clock,
    faces_in: u64,
    options: &BuildOptions<'_>,
) -> Result<Built, Error> {
    let tell = |phase, done| (options.progress)(phase, done, faces_in);
    let mut meta = describe(&mesh, &components, options);
    let mut tally = std::mem::take(&mut mesh.tally);
    let faces = mesh.faces.len() as u64;
    let counter = |phase| {
        let done = std::sync::atomic::AtomicU64::new(0);
        move |n: u64| {
            let before = done.fetch_add(n, std::sync::atomic::Ordering::Relaxed);
            (options.progress)(phase, before + n, faces);
        }
    };
    let weights = Weights::of(&mesh, options.color_weight);
    let hierarchy =
        partition::partition(&mesh, &components, options.split, weights, &counter(Phase::Partition));
    meta.depth = hierarchy.depth;
    if hierarchy.mode != options.split {
        meta.split = hierarchy.mode.as_str().to_owned();
        let message = "merging made a tree deeper than the format allows; it was split from the top instead";
        tally.warn("FC296", 1, message);
    }
    clock.lap(Phase::Partition);

    tell(Phase::Boundaries, 0);
    let (groups, group_names) = groups::records(&mesh, &hierarchy, &mut tally);
    meta.group_names = group_names;
    let component_count = components.len();
    let mut component = vec![0; hierarchy.order.len()];
    if component_count > 1 {
        let of_face = components.of_faces();
        component.par_iter_mut().zip(&hierarchy.order).for_each(|(own, &f)| *own = of_face[f as usize]);
    }
    drop(components);
    let Hierarchy { splits, order, mode, .. } = hierarchy;
    let mut mesh = TreeMesh::new(mesh, order);
    let mut loops = Loops::of(&mesh, &splits);
    clock.lap(Phase::Boundaries);

    tell(Phase::Bounds, 0);
    let Curves { mut ends, stretches } = curves::find(&mesh, &component, component_count);
    drop(component);
    let mut anchored = vec![false; mesh.positions.len()];
    for r in ends.iter().filter(|r| r.bound == f64::INFINITY) {
        anchored[r.vertex as usize] = true;
    }
    for v in 0..anchored.len() {
        anchored[v] |= anchored[mesh.weld[v] as usize];
    }
    // The walk takes about seven tenths of the stage; what follows has no faces to count.
    let measured = counter(Phase::Bounds);
    let tenths = |n: u64| (options.progress)(Phase::Bounds, (faces * n).div_ceil(10), faces);
    let Registered { registrations, anchors, mut nodes, cones, supports } =
        corners::register(&mesh, &splits, &loops, &anchored, &|n| measured(n * 7 / 10));
    drop(anchored);
    ends.extend(anchors);
    if mode == SplitMode::Quality {
        bounds::raise_keys(&mut nodes);
    }
    if let Some(weights) = weights {
        colors::raise_keys(&mesh, &splits, &loops, weights, &mut nodes);
    }
    mesh.forget_normals();
    let clusters = clusters::pack(&mesh, &splits, &loops, &mut nodes, cones)?;
    tenths(8);
    let mut activity = {
        let (registrations, curves) = (&registrations, &ends);
        let asking = Asking {
            mesh: &mesh,
            splits: &splits,
            registrations,
            curves,
            nodes: &nodes,
            clusters: &clusters,
        };
        activity::gather(&asking)
    };
    drop((registrations, ends));
    let unkeyed = ClusterTree { mesh: &mesh, splits: &splits, loops: &loops, nodes: &nodes, keys: &[] };
    let uncovered = flaps::records(ClusterTree { keys: &activity, ..unkeyed });
    activity::raise(&uncovered, &mut activity);
    drop(uncovered);
    let around_holes = holes::records(ClusterTree { keys: &activity, ..unkeyed });
    activity::raise(&around_holes, &mut activity);
    drop(around_holes);
    curves::straighten(&mesh, &stretches, &mut activity);
    drop(stretches);
    activity::share(&mesh.weld, &mut activity);
    if splits.is_empty() {
        activity::always(&mesh.positions, &mut activity);
    }
    let shares = promised::unasked(&mesh);
    mesh.forget_adjacency();
    tenths(9);
    loops.starts_at_end = Vec::new();
    let tree = ClusterTree { mesh: &mesh, splits: &splits, loops: &loops, nodes: &nodes, keys: &activity };
    let mut displaced = displacement::displacements(tree);
    promised::share_out(tree, &supports, &shares, &mut displaced);
    drop((nodes, shares, supports));
    clock.lap(Phase::Bounds);

    tell(Phase::Records, 0);
    let mut records = Records::new(mesh, &splits, loops, clusters, activity, displaced)?;
    records.groups = groups;
    for v in &records.vertices {
        for (axis, x) in v.position.iter().enumerate() {
            meta.bounds_min[axis] = meta.bounds_min[axis].min(x.get());
            meta.bounds_max[axis] = meta.bounds_max[axis].max(x.get());
        }
    }
    let mut built = Built { meta, tally, times: Vec::new(), records };
    built.set_chunk_faces(fct::CHUNK_FACES)?;
    clock.lap(Phase::Records);
    built.times = clock.times;
    Ok(built)
}

#[derive(Debug)]
struct Clock {
    last: Instant,
    times: Vec<(Phase, Duration)>,
}

impl Clock {
    fn lap(&mut self, phase: Phase) {
        let now = Instant::now();
        self.times.push((phase, now - self.last));
        self.last = now;
    }
}

fn describe(mesh: &Mesh, components: &Components, options: &BuildOptions<'_>) -> Meta {
    let dropped = &mesh.tally.dropped;
    Meta {
        split: options.split.as_str().to_owned(),
        origin: mesh.units.origin.to_array(),
        weld: match options.weld {
            Weld::Exact => "exact".to_owned(),
            Weld::Off => "off".to_owned(),
            Weld::Within(distance) => distance.to_string(),
        },
        faces_in: mesh.tally.faces_in,
        faces_kept: mesh.faces.len() as u64,
        dropped: crate::import::DropReason::ALL
            .iter()
            .map(|&reason| (reason.as_str().to_owned(), dropped.count(reason)))
            .filter(|(_, n)| *n > 0)
            .collect(),
        closed: mesh.graph.boundary_edges == 0 && mesh.graph.seams.is_empty(),
        boundary_edges: mesh.graph.boundary_edges,
        seam_edges: mesh.graph.seam_edges,
        components: components.len() as u64,
        bounds_min: [f32::INFINITY; 3],
        bounds_max: [f32::NEG_INFINITY; 3],
        ..Meta::default()
    }
}
