//! The step down from a node above the pages, where nothing about it is strange.

use crate::child::{Child, ChildRef};
use crate::records::PAGE_BIT;
use crate::subtree::{Place, Subtree};
use crate::walk::{Reader, to_index};

/// A child of a node above the pages.
struct Half {
    first_face: u32,
    /// How many a page says that it owns.
    faces: Option<u32>,
    place: Place,
}

impl Reader<'_> {
    /// Reads a byte of the root of a subtree that is a whole page, and one of its loops, for whoever comes there later.
    ///
    /// They come from memory meanwhile, and need not be waited for then.
    #[inline]
    pub fn touch(&self, subtree: &Subtree) {
        let Place::Page { page, record, .. } = subtree.place else { return };
        let node = to_index(record).and_then(|record| self.nodes.get(record));
        let page = to_index(page).and_then(|page| self.pages.get(page));
        let first_loop = page.and_then(|page| to_index(page.first_loop.get()));
        let loops = first_loop.and_then(|first| self.loops.get(first));
        std::hint::black_box(node.map_or(0, |node| node.left_faces) ^ loops.copied().unwrap_or(0));
    }

    /// The children of a node above the pages; none if anything about them is strange.
    #[inline]
    pub(crate) fn halves_of_top(&self, subtree: &Subtree, index: u32) -> Option<[Subtree; 2]> {
        let record = self.tops.get(to_index(index)?)?;
        let (first, end) = (subtree.first_face, subtree.face_end);
        let left = self.child_of_top(record.left.get(), index)?;
        let right = self.child_of_top(record.right.get(), index)?;
        let split = right.first_face;
        let Child::Node(number) = subtree.child.kind() else { return None };
        let is_sound = first < split
            && split < end
            && left.first_face == first
            && left.faces.unwrap_or(split.saturating_sub(first)) == split.saturating_sub(first)
            && right.faces.unwrap_or(end.saturating_sub(split)) == end.saturating_sub(split);
        let has_single_top = left.faces.is_none() && split.saturating_sub(first) < 2
            || right.faces.is_none() && end.saturating_sub(split) < 2;
        if !is_sound || has_single_top {
            return None;
        }
        let half = |place, first: u32, end: u32, node: u32| Subtree {
            child: if end.saturating_sub(first) > 1 { ChildRef::node(node) } else { ChildRef::face(first) },
            first_face: first,
            face_end: end,
            place,
        };
        Some([
            half(left.place, first, split, number.saturating_add(1)),
            half(right.place, split, end, number.saturating_add(split.saturating_sub(first))),
        ])
    }

    #[inline]
    fn child_of_top(&self, child: u32, parent: u32) -> Option<Half> {
        if child & PAGE_BIT != 0 {
            let page = child & !PAGE_BIT;
            let record = self.pages.get(to_index(page)?)?;
            let first_face = record.first_face.get();
            let place = Place::Page { page, record: first_face.saturating_sub(page), loops: 0 };
            return Some(Half { first_face, faces: Some(u32::from(record.faces)), place });
        }
        let record = self.tops.get(to_index(child)?)?;
        let first_face = record.first_face.get();
        (child > parent).then_some(Half { first_face, faces: None, place: Place::Top { record: child } })
    }
}
