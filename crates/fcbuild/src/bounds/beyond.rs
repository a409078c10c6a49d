//! What is seen of the surface beyond a cluster's border in the hulls of its arcs, face by face.

use super::gaze::Seen;

/// Parts of faces, of each the corners: all of a part lies in their hull.
#[derive(Debug, Default)]
pub(super) struct Beyond {
    /// Whether anybody will ask.
    is_wanted: bool,
    points: Vec<Seen>,
    /// Where the corners of each part end.
    ends: Vec<usize>,
}

/// How much there was at some time.
pub(super) struct Mark {
    points: usize,
    ends: usize,
}

impl Beyond {
    /// Forgets all parts.
    pub(super) fn clear(&mut self, is_wanted: bool) {
        self.is_wanted = is_wanted;
        self.truncate(Mark { points: 0, ends: 0 });
    }

    #[inline]
    pub(super) fn is_wanted(&self) -> bool {
        self.is_wanted
    }

    /// Adds a corner of the part that is being collected.
    #[inline]
    pub(super) fn add(&mut self, corner: Seen) {
        if self.is_wanted {
            self.points.push(corner);
        }
    }

    /// The part is complete.
    #[inline]
    pub(super) fn end_part(&mut self) {
        if self.is_wanted {
            self.ends.push(self.points.len());
        }
    }

    pub(super) fn mark(&self) -> Mark {
        Mark { points: self.points.len(), ends: self.ends.len() }
    }

    /// Forgets the parts after a mark.
    pub(super) fn truncate(&mut self, mark: Mark) {
        self.points.truncate(mark.points);
        self.ends.truncate(mark.ends);
    }

    /// The corners of all parts.
    pub(super) fn corners(&self) -> &[Seen] {
        &self.points
    }

    /// The corners of each part.
    pub(super) fn parts(&self) -> impl Iterator<Item = &[Seen]> {
        let starts = std::iter::once(&0).chain(&self.ends);
        starts.zip(&self.ends).map(|(start, end)| &self.points[*start..*end])
    }
}
