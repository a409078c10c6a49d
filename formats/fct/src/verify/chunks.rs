//! Chunks: made again, and compared.

use zerocopy::FromBytes;

use crate::chunk::{CrownHead, Source, build};
use crate::error::Violation;
use crate::rule::Rule;
use crate::tree::Tree;

/// Compares sections `CRPG` and `CHTP` with what follows from the tree, if the file has them.
pub(super) fn check(tree: &Tree) -> Result<(), Box<Violation>> {
    let Some((crown, mut tops)) = tree.chunk_sections() else { return Ok(()) };
    let differs = |section: &str, at: usize| {
        let found = format!("it differs from what follows from the tree, from byte {at} on");
        Violation::new(Rule::Chunk, format!("section {section}"), found)
    };
    let Ok((head, _)) = CrownHead::ref_from_prefix(crown) else { return Err(differs("CRPG", 0)) };
    let source = Source { reader: tree.reader(), normals: tree.normals(), colors: tree.colors() };
    let all = tops.len();
    let made = build(&source, head.chunk_faces.get(), &mut |expected| {
        let Some(rest) = tops.strip_prefix(expected) else {
            return Err(differs("CHTP", all.saturating_sub(tops.len())));
        };
        tops = rest;
        Ok(())
    })?;
    if made != crown {
        let same = made.iter().zip(crown).take_while(|(a, b)| a == b).count();
        return Err(differs("CRPG", same));
    }
    if !tops.is_empty() {
        return Err(differs("CHTP", all.saturating_sub(tops.len())));
    }
    Ok(())
}
