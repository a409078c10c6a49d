//! What is refined and drawn beyond what a tolerance asks for.

/// Nodes that are refined and vertices that are drawn although no tolerance asks for them.
///
/// With it a selection can name any cut of the tree. A mesh has no crack as long as each node's ancestors are refined
/// too and the vertices that its split registers are drawn; [`crate::fit`] and [`crate::by_epsilon`] see
/// to that.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Extra {
    pub(crate) nodes: Bits,
    pub(crate) vertices: Bits,
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
}
