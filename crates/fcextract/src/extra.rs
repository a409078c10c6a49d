//! What is refined and drawn beyond what a tolerance asks for.

use fct::{ChildRef, Subtree, VertexRecord};
use glam::DVec3;

/// Nodes that are refined and vertices that are drawn although no tolerance asks for them.
///
/// With it a selection can name any cut of the tree. A mesh has no crack as long as each node's ancestors are refined
/// too and the vertices that its split registers are drawn; [`crate::fit`] and [`crate::by_epsilon`] see
/// to that.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Extra {
    pub(crate) nodes: Bits,
    vertices: Bits,
    /// Where the vertices are.
    places: Places,
}

impl Extra {
    /// Whether nothing is added.
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty() && self.vertices.is_empty()
    }

    /// Forgets all of it, and keeps the memory.
    pub(crate) fn clear(&mut self) {
        self.nodes.clear();
        self.vertices.clear();
        self.places.clear();
    }

    #[inline]
    pub(crate) fn has_vertex(&self, index: u32) -> bool {
        self.vertices.has(index)
    }

    /// Adds a vertex; there is none without a record.
    pub(crate) fn add_vertex(&mut self, index: u32, record: Option<&VertexRecord>) {
        if let Some(record) = record
            && self.vertices.add(index)
        {
            self.places.add(record.position());
        }
    }

    /// Removes a vertex that was added.
    pub(crate) fn remove_vertex(&mut self, index: u32, record: Option<&VertexRecord>) {
        self.vertices.remove(index);
        if let Some(record) = record {
            self.places.remove(record.position());
        }
    }

    /// Whether none of the vertices lies in a sphere.
    #[inline]
    pub(crate) fn is_clear_of(&self, center: DVec3, radius: f64) -> bool {
        self.vertices.is_empty() || !self.places.any_within(center, radius)
    }

    /// Whether none of the nodes is in a subtree.
    #[inline]
    pub(crate) fn is_clear_of_nodes(&self, subtree: &Subtree) -> bool {
        let root = subtree.child.raw();
        // In preorder: as many as there are faces, but for one.
        self.nodes.is_empty()
            || subtree.child == ChildRef::face(subtree.first_face)
            || !self.nodes.any_from(root, subtree.face_count() - 1)
    }
}

/// Places by their first coordinate.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Places {
    sorted: Vec<[f32; 3]>,
    /// They were too many to keep: they may be anywhere.
    anywhere: bool,
}

/// More places than these are not kept: each is entered among those before.
const MOST_PLACES: usize = 4096;

impl Places {
    pub(crate) fn clear(&mut self) {
        self.sorted.clear();
        self.anywhere = false;
    }

    pub(crate) fn add(&mut self, place: [f32; 3]) {
        self.anywhere |= self.sorted.len() >= MOST_PLACES;
        if !self.anywhere {
            let at = self.sorted.partition_point(|p| p[0] < place[0]);
            self.sorted.insert(at, place);
        }
    }

    /// Removes one such place.
    fn remove(&mut self, place: [f32; 3]) {
        let from = self.sorted.partition_point(|p| p[0] < place[0]);
        if let Some(found) = self.sorted.iter().skip(from).position(|p| *p == place) {
            self.sorted.remove(from + found);
        }
    }

    /// Whether any of them may lie in a sphere.
    pub(crate) fn any_within(&self, center: DVec3, radius: f64) -> bool {
        let radius = radius * (1.0 + 1e-6);
        let from = self.sorted.partition_point(|p| f64::from(p[0]) < center.x - radius);
        let near = self.sorted.iter().skip(from).take_while(|p| f64::from(p[0]) <= center.x + radius);
        self.anywhere
            || near
                .map(|p| DVec3::from(p.map(f64::from)))
                .any(|p| p.distance_squared(center) <= radius * radius)
    }
}

/// A set of indices, a bit each, as long as its largest member needs.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Bits(Vec<u64>);

impl Bits {
    #[inline]
    pub(crate) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    #[inline]
    pub(crate) fn has(&self, index: u32) -> bool {
        self.0.get(index as usize / 64).is_some_and(|word| word >> (index % 64) & 1 == 1)
    }

    /// Whether it has one of so many indices from one on.
    fn any_from(&self, first: u32, count: u32) -> bool {
        let (first, end) = (first as usize, first as usize + count as usize);
        let words = self.0.iter().enumerate().skip(first / 64).take_while(|(i, _)| 64 * i < end);
        words.filter(|(_, word)| **word != 0).any(|(i, word)| {
            (0..64).any(|bit| word >> bit & 1 == 1 && (first..end).contains(&(64 * i + bit)))
        })
    }

    /// Adds an index; says whether it was not there.
    pub(crate) fn add(&mut self, index: u32) -> bool {
        let (word, bit) = (index as usize / 64, 1 << (index % 64));
        if word >= self.0.len() {
            self.0.resize(word + 1, 0);
        }
        let word = &mut self.0[word];
        let is_new = *word & bit == 0;
        *word |= bit;
        is_new
    }

    /// Removes an index that may be there.
    pub(crate) fn remove(&mut self, index: u32) {
        if let Some(word) = self.0.get_mut(index as usize / 64) {
            *word &= !(1 << (index % 64));
        }
    }

    pub(crate) fn clear(&mut self) {
        self.0.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_added_is_there_until_it_is_removed() {
        let mut bits = Bits::default();
        assert!(bits.is_empty() && !bits.has(7));
        assert!(bits.add(130) && bits.add(0) && !bits.add(130));
        assert!(bits.has(130) && bits.has(0) && !bits.has(129) && !bits.has(u32::MAX));
        bits.remove(130);
        bits.remove(u32::MAX);
        assert!(!bits.has(130) && bits.has(0) && !bits.is_empty());
    }

    #[test]
    fn ranges_are_searched_from_the_first_index_to_the_last() {
        let mut bits = Bits::default();
        bits.add(64);
        bits.add(200);
        for (first, count, found) in [
            (0, 64, false),
            (0, 65, true),
            (64, 1, true),
            (65, 135, false),
            (65, 136, true),
            (201, 999, false),
        ] {
            assert_eq!(bits.any_from(first, count), found, "{count} from {first}");
        }
        assert!(!bits.any_from(64, 0) && !Bits::default().any_from(0, u32::MAX));
    }

    #[test]
    fn places_are_found_in_spheres_that_hold_them() {
        let mut places = Places::default();
        for x in [3.0, -1.0, 2.0, 2.0] {
            places.add([x, 5.0, 0.0]);
        }
        let near = |places: &Places, x: f64, radius| places.any_within(DVec3::new(x, 5.0, 0.0), radius);
        assert!(near(&places, 3.5, 0.5) && near(&places, -3.0, 2.0) && near(&places, 2.0, 0.0));
        assert!(!near(&places, 0.5, 1.4) && !places.any_within(DVec3::new(2.0, 0.0, 0.0), 4.9));
        places.remove([2.0, 5.0, 0.0]);
        assert!(near(&places, 2.0, 0.0));
        places.remove([2.0, 5.0, 0.0]);
        places.remove([2.0, 6.0, 0.0]);
        assert!(!near(&places, 2.0, 0.9) && near(&places, 3.0, 0.0));
        for _ in 0..MOST_PLACES {
            places.add([0.0; 3]);
        }
        assert!(near(&places, 1e9, 0.0));
        places.clear();
        assert!(!near(&places, 0.0, 9.0));
    }
}
