//! The books of an import: faces in = faces kept + faces dropped, by reason.

/// Why a face is not in the mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum DropReason {
    /// A polygon with fewer than three corners.
    TooFewVertices,
    /// A triangle that uses one vertex twice.
    RepeatedIndex,
    /// A polygon with a corner at NaN or infinity, or beyond the numbers of single precision.
    NonFinite,
    /// A triangle with the same three vertices as an earlier one.
    Duplicate,
    /// A primitive of points or lines, which has no surface.
    NotTriangles,
}

impl DropReason {
    /// Every reason, in the order of a report.
    pub const ALL: [Self; 5] =
        [Self::TooFewVertices, Self::RepeatedIndex, Self::NonFinite, Self::Duplicate, Self::NotTriangles];

    /// The name in reports.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            Self::TooFewVertices => "too_few_vertices",
            Self::RepeatedIndex => "repeated_index",
            Self::NonFinite => "non_finite",
            Self::Duplicate => "duplicate",
            Self::NotTriangles => "not_triangles",
        }
    }
}

/// How many face ids are kept per reason, as a hint where to look.
pub const KEPT_IDS: usize = 10;

#[derive(Clone, Debug, Default, PartialEq, Eq)]
struct Slot {
    count: u64,
    ids: Vec<u64>,
}

/// What a tree has no place for, as warnings say it.
pub(crate) const TEXTURES: &str = "texture coordinates are not kept";
/// The same of materials.
pub(crate) const MATERIALS: &str = "materials are not kept";
/// The same of normals that belong to corners of faces, not to vertices.
pub(crate) const MIXED_NORMALS: &str =
    "vertices have different normals in different faces; their mean was taken, since a vertex has one normal";

/// Whether two unit normals tell of an edge: the cosine of 8 degrees leaves rounding and noise aside.
pub(crate) fn differ(a: [f32; 3], b: [f32; 3]) -> bool {
    a.iter().zip(b).map(|(a, b)| a * b).sum::<f32>() < 0.99
}

/// Dropped faces, counted by reason.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Drops([Slot; DropReason::ALL.len()]);

impl Drops {
    /// Counts `n` faces dropped for `reason`; `face_id` is the first of them, in file order from 0.
    ///
    /// The readers count polygons of the file; the welding counts triangles.
    pub fn add(&mut self, reason: DropReason, face_id: u64, n: u64) {
        if let Some(slot) = self.0.get_mut(reason as usize).filter(|_| n > 0) {
            slot.count = slot.count.saturating_add(n);
            if slot.ids.len() < KEPT_IDS {
                slot.ids.push(face_id);
            }
        }
    }

    /// How many faces were dropped for `reason`.
    #[must_use]
    pub fn count(&self, reason: DropReason) -> u64 {
        self.0.get(reason as usize).map_or(0, |slot| slot.count)
    }

    /// The first ids dropped for `reason`, at most [`KEPT_IDS`].
    #[must_use]
    pub fn first_ids(&self, reason: DropReason) -> &[u64] {
        self.0.get(reason as usize).map_or(&[], |slot| &slot.ids)
    }

    /// How many faces were dropped for any reason.
    #[must_use]
    pub fn total(&self) -> u64 {
        self.0.iter().fold(0, |sum, slot| sum.saturating_add(slot.count))
    }
}

/// A harmless oddity that was repaired or passed over, and how often.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Warning {
    /// A stable name, such as `trailing_bytes`.
    pub code: &'static str,
    /// What was met and what was done, as a sentence.
    pub message: String,
    /// How often.
    pub count: u64,
}

/// What an import read and what became of it.
///
/// `faces_in` equals the number of triangles kept plus `dropped.total()`, always.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Polygons, strips' triangles and skipped primitives that the file holds.
    pub polygons_in: u64,
    /// Triangles after triangulation, plus the polygons that were dropped before it.
    pub faces_in: u64,
    /// Faces that are not in the mesh.
    pub dropped: Drops,
    /// Counted oddities, in the order in which they were first met.
    pub warnings: Vec<Warning>,
}

impl Tally {
    /// Adds `count` to the warning `code`; the first call decides the message.
    pub fn warn(&mut self, code: &'static str, count: u64, message: impl Into<String>) {
        if count == 0 {
            return;
        }
        if let Some(known) = self.warnings.iter_mut().find(|w| w.code == code) {
            known.count = known.count.saturating_add(count);
        } else {
            self.warnings.push(Warning { code, message: message.into(), count });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn drops_count_all_and_keep_the_first_ids() {
        let mut drops = Drops::default();
        for id in 0..25 {
            drops.add(DropReason::NonFinite, id * 2, 1);
        }
        drops.add(DropReason::Duplicate, 7, 3);
        drops.add(DropReason::RepeatedIndex, 7, 0);
        assert_eq!(drops.count(DropReason::NonFinite), 25);
        assert_eq!(drops.first_ids(DropReason::NonFinite), [0, 2, 4, 6, 8, 10, 12, 14, 16, 18]);
        assert_eq!((drops.count(DropReason::Duplicate), drops.total()), (3, 28));
        assert!(drops.first_ids(DropReason::RepeatedIndex).is_empty());
    }

    #[test]
    fn reasons_have_distinct_names_and_slots() {
        for (i, reason) in DropReason::ALL.into_iter().enumerate() {
            assert_eq!(reason as usize, i);
            assert_eq!(DropReason::ALL.iter().filter(|r| r.as_str() == reason.as_str()).count(), 1);
        }
    }

    #[test]
    fn warnings_of_one_code_are_counted_together() {
        let mut tally = Tally::default();
        tally.warn("a", 2, "first");
        tally.warn("b", 0, "never");
        tally.warn("a", 3, "second");
        assert_eq!(tally.warnings, [Warning { code: "a", message: "first".into(), count: 5 }]);
    }
}
