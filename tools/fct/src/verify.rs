//! `fct verify`: the result of the complete check.

use crate::SCHEMA;
use crate::counted::counted;
use fct::Verified;
use serde_json::json;
use std::path::Path;

/// For people; what breaks a rule is told as an error.
pub(crate) fn to_text(file: &Path, verified: &Verified) -> String {
    format!(
        "{}: valid; {}, {}, {}, {}, {}, depth {}, content id {:032x}",
        file.display(),
        counted(verified.bytes, "byte", "bytes"),
        counted(verified.faces, "face", "faces"),
        counted(verified.nodes, "node", "nodes"),
        counted(verified.vertices, "vertex", "vertices"),
        counted(verified.loop_entries, "loop entry", "loop entries"),
        verified.depth,
        verified.content_id
    )
}

/// For programs; `valid` is false when a rule is broken and null when the file could not be checked.
pub(crate) fn to_json(file: &Path, outcome: &Result<Verified, fct::Error>) -> String {
    let object = match outcome {
        Ok(v) => json!({
            "schema": SCHEMA,
            "path": file.to_string_lossy(),
            "valid": true,
            "bytes": v.bytes,
            "faces": v.faces,
            "nodes": v.nodes,
            "vertices": v.vertices,
            "loop_entries": v.loop_entries,
            "depth": v.depth,
            "content_id": format!("{:032x}", v.content_id),
        }),
        Err(e) => json!({
            "schema": SCHEMA,
            "path": file.to_string_lossy(),
            "valid": e.rule().map(|_| false),
            "code": e.code(),
            "exit": e.exit_code(),
            "rule": e.rule().map(fct::Rule::name),
            "message": e.to_string(),
        }),
    };
    format!("{object:#}")
}
