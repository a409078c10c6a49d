//! Promise: no damage goes unnoticed, and none makes a reader panic.

mod sample;

use fct::{Rule, Tree};
use sample::{Sample, Split};

fn refusal(bytes: &[u8]) -> Option<Rule> {
    match Tree::from_bytes(bytes.to_vec()).and_then(|tree| tree.verify()) {
        Ok(_) => None,
        Err(error) => Some(error.rule().expect("damage is a broken rule")),
    }
}

#[test]
fn every_truncation_is_refused_on_opening() {
    let bytes = Sample::patches(3, 2, 6).bytes();
    for len in 0..bytes.len() {
        let error = Tree::from_bytes(bytes[..len].to_vec()).unwrap_err();
        let rule = error.rule().unwrap();
        let expected = if len < 128 { Rule::TooShort } else { Rule::FileLength };
        assert_eq!(rule, expected, "{len} bytes");
        assert_eq!(error.exit_code(), 7);
    }
}

#[test]
fn an_appended_byte_is_refused_on_opening() {
    let mut bytes = Sample::patches(3, 2, 6).bytes();
    for appended in [0, 1, 0xFF] {
        bytes.push(appended);
        let error = Tree::from_bytes(bytes.clone()).unwrap_err();
        assert_eq!(error.rule(), Some(Rule::FileLength));
        bytes.pop();
    }
}

#[test]
fn every_flipped_bit_is_found() {
    let mut bytes = Sample::patches(2, 2, 10).bytes();
    assert_eq!(refusal(&bytes), None);
    for at in 0..bytes.len() {
        for bit in 0..8 {
            bytes[at] ^= 1 << bit;
            assert!(refusal(&bytes).is_some(), "bit {bit} of byte {at}");
            bytes[at] ^= 1 << bit;
        }
    }
}

#[test]
fn every_flipped_bit_of_header_and_table_is_found_on_opening() {
    let mut bytes = Sample::fan(3, Split::Halves).bytes();
    let table_end = 128 + 64 * 9;
    for at in 0..table_end {
        for bit in 0..8 {
            bytes[at] ^= 1 << bit;
            assert!(Tree::from_bytes(bytes.clone()).is_err(), "bit {bit} of byte {at}");
            bytes[at] ^= 1 << bit;
        }
    }
}

#[test]
fn swapped_and_zeroed_sectors_are_found() {
    let bytes = Sample::patches(4, 3, 24).bytes();
    for start in (0..bytes.len()).step_by(512) {
        let end = (start + 512).min(bytes.len());
        let mut zeroed = bytes.clone();
        zeroed[start..end].fill(0);
        if zeroed != bytes {
            assert!(refusal(&zeroed).is_some(), "zeros from {start} on");
        }
        let mut reversed = bytes.clone();
        reversed[start..end].reverse();
        if reversed != bytes {
            assert!(refusal(&reversed).is_some(), "reversed from {start} on");
        }
    }
}
