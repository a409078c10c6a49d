//! Hashes, padding and the content id.

use crate::container::check_section_hash;
use crate::error::Violation;
use crate::hash::hash128_of;
use crate::header::HEADER_LEN;
use crate::rule::Rule;
use crate::tree::Tree;

/// Checks every byte that opening did not look at.
pub(crate) fn check(tree: &Tree) -> Result<(), Box<Violation>> {
    let bytes = tree.bytes();
    let header = tree.header();
    let table_len = u64::from(header.section_count).saturating_mul(u64::from(header.section_entry_size));
    let mut end = usize::try_from(table_len).unwrap_or(usize::MAX).saturating_add(HEADER_LEN);
    for section in tree.sections() {
        let range = section.range()?;
        let padding = bytes.get(end..range.start).unwrap_or_default();
        if let Some(at) = padding.iter().position(|b| *b != 0) {
            return Err(Violation::new(
                Rule::PaddingZero,
                format!("byte {}", end.saturating_add(at)),
                format!("padding before section {} is not zero", section.tag),
            ));
        }
        end = range.end;
        check_section_hash(section, bytes.get(range).unwrap_or_default())?;
    }
    let payloads = tree.sections().iter().map(|section| {
        let range = section.range().unwrap_or_default();
        bytes.get(range).unwrap_or_default()
    });
    let id = hash128_of(payloads);
    if id == header.content_id {
        return Ok(());
    }
    Err(Violation::in_header(
        Rule::ContentId,
        80,
        format!("it is {:032x}, computed {id:032x}", header.content_id),
    ))
}
