//! What a mesh is bounded by that was chosen by something else than its bound.
//!
//! The bounds of the clusters count on vertices that a budget may leave out. Where one is left out its chord is measured:
//! the border from one drawn vertex to the next is then like an arc that is not covered, see `docs/bound.md`.

use crate::extraction::Stats;
use crate::part::Part;
use crate::{Error, Mesh, Order, Selection, Tolerance};
use fcgeom::distance_to_segment;
use fct::{Loops, Node, Tree, VertexRecord};
use glam::DVec3;

/// A cone's cosine over this is that of a cluster whose bound is the height of a slab, if it has one loop: of one that
/// does not fold over. The bound of one with several loops may be a distance from its corners.
const FACING: f32 = 0.02;

impl Selection {
    /// What the mesh that was drawn, without displacements, is bounded by: no point of the surface is farther from it, and
    /// no point of it from the surface. A length in the tree's unit; `drawn` are the counts of its extraction.
    ///
    /// All borders of the cut are walked. Where they leave out a vertex that the bounds count on, its distance from the
    /// chord is added.
    ///
    /// # Errors
    /// [`Error::Tree`] when the file is damaged where the walk comes by.
    pub fn bound(&self, tree: &Tree, drawn: &Stats) -> Result<f32, Error> {
        let reader = tree.reader();
        let mut chords = Chords {
            selection: self,
            records: tree.vertices(),
            enough: drawn.bound,
            undrawn: 0.0,
            kept: Vec::new(),
        };
        let mut loops = Loops::default();
        let mut read = Ok(());
        let measure = |part: Part, node: Option<&Node>| {
            let Some(node) = node.filter(|_| read.is_ok()) else { return };
            read = reader.read_loops(&part.subtree, &mut loops);
            let is_slab = loops.ends.len() == 1 && node.cos() > FACING;
            for border in loops.iter() {
                chords.measure(border, &loops, node.bound, is_slab);
            }
        };
        Part::whole(tree, self).divide(tree, self, &mut Stats::default(), |_, _| false, measure)?;
        read?;
        Ok(if chords.undrawn > 0.0 {
            fcgeom::round_up(f64::from(chords.enough) + chords.undrawn)
        } else {
            chords.enough
        })
    }
}

impl Selection {
    /// The same for a mesh in buffers, whose vertices may lie beside their places; `mesh` is filled with the extraction.
    ///
    /// In [`Order::Bound`] a vertex keeps to its own tolerance in every cluster that is bounded by no more, see
    /// `docs/bound.md`, section 8. In views a cluster may be bounded by more, and then the step is added, as all steps are
    /// in [`Order::Budget`].
    ///
    /// # Errors
    /// As [`Selection::bound`].
    pub fn bound_of(&self, tree: &Tree, drawn: &Stats, mesh: &Mesh) -> Result<f64, Error> {
        let in_place = f64::from(self.bound(tree, drawn)?);
        let loose = in_place + mesh.longest_step;
        if self.order == Order::Budget || mesh.longest_step == 0.0 {
            return Ok(loose);
        }
        let is_view = matches!(self.tolerance, Tolerance::Perspective(_));
        let (mut kept, mut added) = (in_place, 0.0_f64);
        for (vertex, step) in mesh.steps() {
            let Some(record) = tree.vertices().get(vertex as usize).filter(|_| step > 0.0) else { continue };
            let sphere = || (DVec3::from_array(record.center()), record.radius());
            match self.allowed(sphere).unwrap_or(0.0) {
                allowed if is_view && allowed < in_place => added = added.max(step),
                allowed => kept = kept.max(allowed),
            }
        }
        Ok(loose.min(kept.max(in_place + added)))
    }
}

/// Borders of clusters, one after the other.
struct Chords<'a> {
    selection: &'a Selection,
    records: &'a [VertexRecord],
    /// The bound so far.
    enough: f32,
    /// What clusters add of which nothing is drawn, as tunnels that are closed at both ends: whoever is next to one of them
    /// may be another one.
    undrawn: f64,
    /// Places on the border of the vertices that are drawn.
    kept: Vec<usize>,
}

impl Chords<'_> {
    /// Raises the bound for the chords of one of the `loops` around a cluster of some bound.
    fn measure(&mut self, border: &[u32], loops: &Loops, bound: f32, is_slab: bool) {
        let Chords { selection, records, kept, .. } = self;
        let record = |place: usize| border.get(place % border.len()).and_then(|v| records.get(*v as usize));
        kept.clear();
        kept.extend((0..border.len()).filter(|place| {
            let vertex = border.get(*place).copied().unwrap_or(0);
            record(*place).is_some_and(|record| selection.activates(vertex, record))
        }));
        let first = kept.first().copied();
        kept.extend(first.map(|first| first + border.len()));
        let key = |places: std::ops::Range<usize>| {
            places.filter_map(record).map(VertexRecord::bound).fold(0.0, f32::max)
        };
        if kept.is_empty() {
            // No part of the border says where the mesh is; the polygon lies over a hole.
            let mut reach = key(0..border.len());
            if loops.ends.len() > 1 {
                let radius = radius_of(loops, records);
                let across = f64::from(bound) + 2.0 * radius;
                let draws = |v: &u32| records.get(*v as usize).is_some_and(|r| selection.activates(*v, r));
                if loops.iter().flatten().any(draws) {
                    // The mesh passes a corner of another border: all that this one leaves out is that near.
                    reach = reach.min(fcgeom::round_up(across));
                } else if reach.is_infinite() {
                    self.undrawn += across;
                    reach = 0.0;
                }
                reach = reach.max(fcgeom::round_up(radius));
            }
            self.enough = self.enough.max(reach);
            return;
        }
        let mut radius = None;
        for ends in kept.windows(2) {
            let [from, to] = *ends else { continue };
            let highest = key(from + 1..to);
            let Some((a, b)) = record(from).zip(record(to)) else { continue };
            if selection.order == Order::Bound {
                // The corners of a cluster that is drawn are drawn.
                self.enough = self.enough.max(highest);
                continue;
            }
            // A key above the cluster's bound may be that of a corner that the bound counts on.
            if highest <= bound {
                continue;
            }
            let inner = (from + 1..to).filter_map(record);
            let off = inner.map(|p| distance_to_segment(place(p), place(a), place(b))).fold(0.0, f64::max);
            let bound = f64::from(bound);
            let reach = if is_slab { bound.hypot(off) } else { bound + off };
            // Without its corners a polygon may overlap itself: then it is as near as its own vertices are.
            let reach = reach.max(*radius.get_or_insert_with(|| radius_of(loops, records)));
            self.enough = self.enough.max(fcgeom::round_up(reach));
        }
    }
}

/// The radius of a ball around all vertices of a border: a triangle between some of them has no point farther from its
/// nearest corner.
fn radius_of(loops: &Loops, records: &[VertexRecord]) -> f64 {
    let places = || loops.iter().flatten().filter_map(|v| records.get(*v as usize)).map(place);
    let low = places().fold(DVec3::INFINITY, DVec3::min);
    let high = places().fold(DVec3::NEG_INFINITY, DVec3::max);
    places().map(|p| p.distance(0.5 * (low + high))).fold(0.0, f64::max)
}

fn place(record: &VertexRecord) -> DVec3 {
    DVec3::from_array(record.position().map(f64::from))
}
