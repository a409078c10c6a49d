//! Section `META`: what a person wants to know about a file, and the origin of its coordinates.

use bincode::config;
use serde::{Deserialize, Serialize};

use crate::error::Violation;
use crate::rule::Rule;

/// The most bytes section `META` may take; the decoder allocates no more.
pub const MAX_META_LEN: usize = 1 << 20;

/// The contents of section `META`, encoded by serde and bincode 2 (`config::standard()`).
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Meta {
    /// The program that wrote the file, with its version, and what it was told beside the rules below: `--flip`.
    pub generator: String,
    /// The rule by which clusters were split, as the builder's option names it.
    pub split: String,
    /// Add to stored positions for the input's coordinates (length).
    pub origin: [f64; 3],
    /// How vertices were welded, as the builder's option names it.
    pub weld: String,
    /// The names of the input files, without folders.
    pub source: String,
    /// Triangles in the input: `faces_kept` plus all of `dropped`.
    pub faces_in: u64,
    /// Triangles in this file.
    pub faces_kept: u64,
    /// Triangles left out, by reason.
    pub dropped: Vec<(String, u64)>,
    /// Names of the component groups in section `GRUP`.
    pub group_names: Vec<String>,
    /// Whether every edge has a face on both sides.
    pub closed: bool,
    /// Edges with one face.
    pub boundary_edges: u64,
    /// Edges that were cut because more than two faces met there, or two that wind against each other.
    pub seam_edges: u64,
    /// Connected components, counted after cutting.
    pub components: u64,
    /// Lower corner of the box of the stored positions (length).
    pub bounds_min: [f32; 3],
    /// Upper corner of the box of the stored positions (length).
    pub bounds_max: [f32; 3],
    /// Child references on the longest way from the root to a face: 0 for a single face.
    pub depth: u32,
}

impl Meta {
    /// The section's bytes, or what is wrong when they pass [`MAX_META_LEN`].
    pub(crate) fn encode(&self) -> Result<Vec<u8>, String> {
        let bytes = bincode::serde::encode_to_vec(self, config::standard())
            .map_err(|e| format!("the description cannot be encoded: {e}"))?;
        // By reading it back: the decoder charges more for many short strings than they take.
        if bytes.len() > MAX_META_LEN || Self::decode(&bytes).is_err() {
            return Err(format!(
                "the description (file names, group names, dropped faces) takes {} bytes, more than a reader accepts",
                bytes.len()
            ));
        }
        Ok(bytes)
    }

    pub(crate) fn decode(bytes: &[u8]) -> Result<Self, Box<Violation>> {
        let limited = config::standard().with_limit::<MAX_META_LEN>();
        let broken = |found: String| Violation::new(Rule::MetaReadable, "section META".to_owned(), found);
        let (meta, used) = bincode::serde::decode_from_slice::<Self, _>(bytes, limited)
            .map_err(|e| broken(format!("its {} bytes cannot be decoded: {e}", bytes.len())))?;
        if used != bytes.len() {
            return Err(broken(format!("{} of its {} bytes were used", used, bytes.len())));
        }
        if meta.origin.iter().any(|x| !x.is_finite()) {
            return Err(broken(format!("the origin is {:?}", meta.origin)));
        }
        Ok(meta)
    }
}

#[cfg(test)]
mod tests {
    use super::{MAX_META_LEN, Meta};

    fn sample() -> Meta {
        Meta {
            generator: "fcbuild 0.1.0".to_owned(),
            group_names: vec!["a".to_owned(), "Größe".to_owned()],
            dropped: vec![("repeated index".to_owned(), 108)],
            origin: [0.5, -1e300, 4e6],
            depth: 40,
            ..Meta::default()
        }
    }

    #[test]
    fn survives_the_round_trip() {
        let bytes = sample().encode().unwrap();
        assert_eq!(Meta::decode(&bytes).unwrap(), sample());
    }

    #[test]
    fn refuses_every_truncation_and_trailing_bytes() {
        let mut bytes = sample().encode().unwrap();
        for len in 0..bytes.len() {
            assert!(Meta::decode(&bytes[..len]).is_err(), "{len} bytes");
        }
        bytes.push(0);
        assert!(Meta::decode(&bytes).is_err());
    }

    #[test]
    fn refuses_a_claimed_length_without_allocating_it() {
        // 253 introduces a 64-bit length in bincode's variable encoding.
        let mut bytes = vec![253];
        bytes.extend_from_slice(&(1_u64 << 62).to_le_bytes());
        assert!(Meta::decode(&bytes).is_err());
    }

    #[test]
    fn refuses_to_write_what_no_reader_would_take() {
        let meta = Meta { source: "x".repeat(MAX_META_LEN), ..Meta::default() };
        assert!(meta.encode().is_err());
    }

    #[test]
    fn what_a_reader_would_refuse_is_not_written() {
        let many = Meta { group_names: vec!["a group".to_owned(); 100_000], ..sample() };
        assert!(many.encode().is_err());
        let nowhere = Meta { origin: [0.0, f64::NAN, 0.0], ..sample() };
        assert!(nowhere.encode().is_err());
    }
}
