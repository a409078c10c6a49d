//! A number that tells what a tree was made of.

use fcbuild::SplitMode;
use fcbuild::import::{Positions, Soup};
use fcbuild::mesh::Weld;
use xxhash_rust::xxh3::Xxh3;

/// Hashes the geometry as it was read and the settings that shape the tree.
///
/// Equal numbers mean equal trees, whatever the format and the names of the files were. The names of several groups
/// count, since the tree keeps them; they may be those of files.
pub(crate) fn source_id(soup: &Soup, split: SplitMode, weld: Weld, color_weight: f64) -> u128 {
    let mut hash = Hash(Xxh3::new());
    hash.text(split.as_str());
    match weld {
        Weld::Exact => hash.text("exact"),
        Weld::Off => hash.text("off"),
        Weld::Within(distance) => hash.list(&[distance.to_bits()], |bits| bits.to_le_bytes()),
    }
    match &soup.positions {
        Positions::F32(v) => hash.list(v.as_flattened(), |x| x.to_le_bytes()),
        Positions::F64(v) => hash.list(v.as_flattened(), |x| x.to_le_bytes()),
    }
    hash.list(soup.triangles.as_flattened(), |x| x.to_le_bytes());
    hash.list(soup.normals.as_deref().unwrap_or_default().as_flattened(), |x| x.to_le_bytes());
    hash.list(soup.colors.as_deref().unwrap_or_default(), |x| *x);
    if soup.colors.is_some() {
        hash.list(&[color_weight.to_bits()], |bits| bits.to_le_bytes());
    }
    // A single group has the name of the file, and is none to the tree.
    if let [_, _, ..] = soup.groups.as_slice() {
        for group in &soup.groups {
            hash.text(&group.name);
            hash.list(&[group.triangles.end as u64], |end| end.to_le_bytes());
        }
    }
    hash.0.digest128()
}

struct Hash(Xxh3);

impl Hash {
    /// The length goes first, so that no two series of lists look alike.
    fn list<T, const N: usize>(&mut self, items: &[T], bytes: impl Fn(&T) -> [u8; N]) {
        self.0.update(&(items.len() as u64).to_le_bytes());
        let mut block = Vec::with_capacity(N * 1024);
        for chunk in items.chunks(1024) {
            block.clear();
            block.extend(chunk.iter().flat_map(&bytes));
            self.0.update(&block);
        }
    }

    fn text(&mut self, text: &str) {
        self.list(text.as_bytes(), |b| [*b]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fcbuild::import::{Group, Tally};

    fn soup() -> Soup {
        Soup {
            positions: Positions::F32(vec![[0.0, 1.0, 2.0]; 3000]),
            triangles: vec![[0, 1, 2]; 2000],
            normals: None,
            colors: None,
            groups: vec![Group { name: "a".to_owned(), triangles: 0..2000 }],
            tally: Tally::default(),
        }
    }

    #[test]
    fn every_part_of_the_tree_counts() {
        let id = |soup: &Soup| source_id(soup, SplitMode::Paper, Weld::Exact, 1.0);
        let base = id(&soup());
        assert_eq!(id(&soup()), base);
        let mut moved = soup();
        moved.positions = Positions::F32([vec![[0.0, 1.0, 2.0]; 2999], vec![[0.0, 1.0, 3.0]]].concat());
        let mut turned = soup();
        turned.triangles[1999] = [1, 2, 0];
        let mut halves = soup();
        halves.groups = [("a", 0..1000), ("b", 1000..2000)]
            .map(|(name, triangles)| Group { name: name.to_owned(), triangles })
            .into();
        let mut renamed = halves.clone();
        renamed.groups[1].name = "c".to_owned();
        assert_ne!(id(&renamed), id(&halves));
        let mut colored = soup();
        colored.colors = Some(vec![[0; 4]; 3000]);
        let weighed = |soup: &Soup, weight| source_id(soup, SplitMode::Paper, Weld::Exact, weight);
        assert_ne!(weighed(&colored, 0.5), weighed(&colored, 1.0));
        assert_eq!(weighed(&soup(), 0.5), base, "there is nothing to weigh");
        for other in [moved, turned, halves, renamed, colored] {
            assert_ne!(id(&other), base);
        }
        let mut of_another_file = soup();
        of_another_file.groups[0].name = "b".to_owned();
        assert_eq!(id(&of_another_file), base);
        assert_ne!(source_id(&soup(), SplitMode::Pca, Weld::Exact, 1.0), base);
        assert_ne!(source_id(&soup(), SplitMode::Paper, Weld::Within(0.5), 1.0), base);
    }
}
