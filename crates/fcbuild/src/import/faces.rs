//! Collects checked polygons as triangles and keeps the books.

use super::soup::Positions;
use super::tally::{DropReason, Tally};
use super::triangulate::{Triangulator, Verdict};
use crate::error::{Error, ErrorKind};

/// Most corners that a polygon may have; a longer one is taken for damage.
pub(super) const MAX_CORNERS: usize = 65_536;

/// Where vertices have no place, in words: readers take what is too large for the coordinates of a tree for infinite.
const NOWHERE: &str = "at NaN or infinity, or beyond 3.4e38, where single precision ends";

/// Triangles of a mesh under construction.
pub(super) struct Faces {
    /// The triangles so far.
    pub(super) triangles: Vec<[u32; 3]>,
    /// The books so far.
    pub(super) tally: Tally,
    max_faces: u64,
    triangulator: Triangulator,
    self_crossing: u64,
    unfinished: u64,
}

/// Vertices against which polygons are checked.
pub(super) struct Vertices<'a> {
    positions: &'a Positions,
    /// Whether any vertex is non-finite, so that the usual mesh pays nothing for the question.
    tainted: bool,
}

impl<'a> Vertices<'a> {
    /// Looks once through all positions.
    pub(super) fn new(positions: &'a Positions) -> Self {
        let tainted = match positions {
            Positions::F32(v) => v.iter().flatten().any(|c| !c.is_finite()),
            Positions::F64(v) => v.iter().flatten().any(|c| !c.is_finite()),
        };
        Self { positions, tainted }
    }

    fn finite(&self, corners: &[u32]) -> bool {
        !self.tainted
            || corners
                .iter()
                .all(|&c| self.positions.get(c as usize).is_some_and(|p| p.iter().all(|x| x.is_finite())))
    }

    /// How many vertices have a coordinate that is NaN or infinite, and the first of them.
    fn non_finite(&self) -> (u64, usize) {
        let bad = |i: &usize| self.positions.get(*i).is_some_and(|p| p.iter().any(|x| !x.is_finite()));
        let all = if self.tainted { self.positions.len() } else { 0 };
        let mut found = (0..all).filter(bad);
        let first = found.next();
        (first.map_or(0, |_| 1_u64.saturating_add(found.count() as u64)), first.unwrap_or_default())
    }
}

impl Faces {
    /// Starts with no face; `max_faces` triangles are the limit.
    pub(super) fn new(max_faces: u64) -> Self {
        Self {
            triangles: Vec::new(),
            tally: Tally::default(),
            max_faces,
            triangulator: Triangulator::default(),
            self_crossing: 0,
            unfinished: 0,
        }
    }

    /// Makes room for `count` triangles, a number that the file's size has vouched for.
    pub(super) fn reserve(&mut self, count: u64) -> Result<(), Error> {
        self.check_limit(count)?;
        reserve(&mut self.triangles, count, "triangles")
    }

    /// Refuses when `more` triangles would exceed the limit.
    pub(super) fn check_limit(&self, more: u64) -> Result<(), Error> {
        let found = (self.triangles.len() as u64).saturating_add(more);
        if found > self.max_faces {
            return Err(Error::new(
                ErrorKind::Limit,
                "FC501",
                format!("{found} faces are more than the limit of {}", self.max_faces),
            )
            .remedy("simplify or split the model, or raise the limit")
            .limit(self.max_faces, found));
        }
        Ok(())
    }

    /// Takes a polygon whose indices are all below the number of vertices.
    #[inline]
    pub(super) fn polygon(&mut self, vertices: &Vertices<'_>, corners: &[u32]) -> Result<(), Error> {
        let id = self.tally.polygons_in;
        self.tally.polygons_in = id.saturating_add(1);
        if !vertices.finite(corners) {
            self.drop_one(DropReason::NonFinite, id);
            return Ok(());
        }
        if let &[a, b, c] = corners {
            self.check_limit(1)?;
            self.tally.faces_in = self.tally.faces_in.saturating_add(1);
            self.triangles.push([a, b, c]);
            return Ok(());
        }
        self.other_polygon(vertices, corners, id)
    }

    fn other_polygon(&mut self, vertices: &Vertices<'_>, corners: &[u32], id: u64) -> Result<(), Error> {
        let count = corners.len();
        if count < 3 {
            self.drop_one(DropReason::TooFewVertices, id);
            return Ok(());
        }
        self.check_limit((count as u64).saturating_sub(2))?;
        let before = self.triangles.len();
        let verdict = self.triangulator.triangulate(
            |i| vertices.positions.get(i as usize).unwrap_or_default(),
            corners,
            &mut self.triangles,
        );
        match verdict {
            Verdict::Simple => {}
            Verdict::SelfCrossing => self.self_crossing = self.self_crossing.saturating_add(1),
            Verdict::TooComplex => self.unfinished = self.unfinished.saturating_add(1),
        }
        let made = self.triangles.len().saturating_sub(before) as u64;
        self.tally.faces_in = self.tally.faces_in.saturating_add(made);
        Ok(())
    }

    /// Counts a polygon with fewer than three corners that a reader has met.
    pub(super) fn too_few(&mut self) {
        let id = self.tally.polygons_in;
        self.tally.polygons_in = id.saturating_add(1);
        self.drop_one(DropReason::TooFewVertices, id);
    }

    /// Counts a primitive that has no surface.
    pub(super) fn not_triangles(&mut self) {
        let id = self.tally.polygons_in;
        self.tally.polygons_in = id.saturating_add(1);
        self.drop_one(DropReason::NotTriangles, id);
    }

    fn drop_one(&mut self, reason: DropReason, id: u64) {
        self.tally.faces_in = self.tally.faces_in.saturating_add(1);
        self.tally.dropped.add(reason, id, 1);
    }

    /// Closes the books and hands over the triangles; fails when nothing is left to build from.
    pub(super) fn finish(mut self, vertices: &Vertices<'_>) -> Result<(Vec<[u32; 3]>, Tally), Error> {
        let tally = &mut self.tally;
        let (count, first) = vertices.non_finite();
        let non_finite = match count {
            1 => format!("vertex {first}, counted from 0, lies {NOWHERE}"),
            _ => format!("{count} vertices lie {NOWHERE}, the first is vertex {first}, counted from 0"),
        };
        tally.warn(
            "non_finite_vertices",
            count,
            format!("{non_finite}; faces that use such a vertex are dropped"),
        );
        tally.warn(
            "self_crossing_polygons",
            self.self_crossing,
            "polygons cross themselves; they are triangulated as well as can be",
        );
        tally.warn(
            "too_complex_polygons",
            self.unfinished,
            "polygons are too tangled to triangulate in bounded time; the rest of each is a fan",
        );
        if self.triangles.is_empty() {
            let lost = tally.dropped.count(DropReason::NonFinite);
            let message = match tally.polygons_in {
                0 => "the file has no faces".to_owned(),
                1 => "the file's only face cannot be used".to_owned(),
                n => format!("none of the file's {n} faces can be used"),
            };
            if lost > 0 {
                let share = if lost == tally.polygons_in {
                    String::new()
                } else {
                    format!(", and {lost} of the faces use such vertices")
                };
                return Err(Error::bad_input("FC207", format!("{message}: {non_finite}{share}"))
                    .remedy("mend the coordinates, scale the model down, or export it again"));
            }
            return Err(Error::bad_input("FC207", message)
                .remedy("fcbuild needs polygons; reconstruct a surface from points or lines first"));
        }
        Ok((self.triangles, self.tally))
    }
}

/// Reserves room for `count` more items, or fails with a limit error where memory is short.
pub(super) fn reserve<T>(list: &mut Vec<T>, count: u64, what: &str) -> Result<(), Error> {
    let room = usize::try_from(count).ok();
    if room.is_some_and(|n| list.try_reserve_exact(n).is_ok()) {
        return Ok(());
    }
    Err(Error::new(ErrorKind::Limit, "FC505", format!("no memory for {count} {what}"))
        .remedy("free some memory, or split the model")
        .limit(list.capacity() as u64, count))
}
