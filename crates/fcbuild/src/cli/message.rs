//! Errors and warnings in the two forms that `--message-format` names.
//!
//! # Codes
//! The library's codes stand in `fcbuild::error`; the command adds:
//!
//! | code | exit | meaning |
//! |------|------|---------|
//! | FC101 | 2 | an output is an input, or two outputs are one file |
//! | FC102 | 2 | standard input or output in place of a file |
//! | FC213 | 3 | `--strict` refuses what would be repaired |
//! | FC300 to FC325 | 0 | warnings, see [`warning_code`] |
//! | FC331 to FC335 | 0 | faces dropped, by reason |
//! | FC412 | 4 | the report cannot be written |
//! | FC413 | 4 | standard output cannot be written |
//! | FC471 | 4 | the tree cannot be written |
//! | FC472 | 4 | an output exists |
//! | FC473 | 4 | an output is no regular file |
//! | FC506 | 5 | the job needs more memory than allowed |
//! | FC507 | 5 | the threads cannot be started |
//! | FC571 | 5 | the tree is too large for the format |
//! | FC902 | 130, 143 | a signal stopped the job |

use super::bug;
use super::flags::MessageFormat;
use super::size;
use fcbuild::Error;
use fcbuild::import::{DropReason, Tally};
use serde_json::{Value, json};
use std::path::Path;

/// What was repaired or passed over, as the user and the report see it.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub(crate) struct Notice {
    /// Such as `FC303`.
    pub(crate) code: &'static str,
    /// Such as `non_finite_vertices`.
    pub(crate) name: &'static str,
    /// A sentence.
    pub(crate) message: String,
    /// How often.
    pub(crate) count: u64,
    /// Whether the sentence gives the count itself.
    #[serde(skip)]
    says_count: bool,
}

/// Everything in the books that is not as it should be: oddities, then faces dropped.
pub(crate) fn notices(tally: &Tally) -> Vec<Notice> {
    let oddities = tally.warnings.iter().map(|w| Notice {
        code: warning_code(w.code),
        name: w.code,
        message: w.message.clone(),
        count: w.count,
        says_count: w.count == 1,
    });
    let dropped = DropReason::ALL.into_iter().filter(|&r| tally.dropped.count(r) > 0).map(|reason| {
        let count = tally.dropped.count(reason);
        let ids = tally.dropped.first_ids(reason);
        let listed: Vec<_> = ids.iter().map(u64::to_string).collect();
        let more = if count > ids.len() as u64 { ", ..." } else { "" };
        let (code, why) = drop_code(reason);
        Notice {
            code,
            name: reason.as_str(),
            message: format!(
                "{} dropped: {why}; by number: {}{more}",
                size::counted(count, "face"),
                listed.join(", ")
            ),
            count,
            says_count: true,
        }
    });
    oddities.chain(dropped).collect()
}

/// The stable code of a warning that the readers name.
fn warning_code(name: &'static str) -> &'static str {
    match name {
        "trailing_bytes" => "FC301",
        "unused_vertices" => "FC302",
        "non_finite_vertices" => "FC303",
        "self_crossing_polygons" => "FC304",
        "too_complex_polygons" => "FC305",
        "flattened_meshes" => "FC311",
        "ignored_skins" => "FC312",
        "ignored_morph_targets" => "FC313",
        "partial_normals" => "FC314",
        "partial_colors" => "FC315",
        "lines_and_points" => "FC321",
        "free_form_geometry" => "FC322",
        "vertex_weights" => "FC323",
        "outside_material_files" => "FC324",
        "missing_material_files" => "FC325",
        code if code.starts_with("FC") => code,
        _ => "FC300",
    }
}

fn drop_code(reason: DropReason) -> (&'static str, &'static str) {
    match reason {
        DropReason::TooFewVertices => ("FC331", "fewer than three corners"),
        DropReason::RepeatedIndex => ("FC332", "two corners are one vertex"),
        DropReason::NonFinite => ("FC333", "a corner lies at NaN or infinity"),
        DropReason::Duplicate => ("FC334", "repeats of earlier faces"),
        DropReason::NotTriangles => ("FC335", "points or lines, which have no surface"),
    }
}

/// The line for a warning about `file`; without one when several files were read.
pub(crate) fn warning_line(format: MessageFormat, file: Option<&Path>, notice: &Notice) -> String {
    let Notice { code, name, message, count, says_count } = notice;
    match format {
        MessageFormat::Human => {
            let place = file.map(|f| format!("{}: ", f.display())).unwrap_or_default();
            let times =
                if *says_count { String::new() } else { format!(" ({} times)", size::grouped(*count)) };
            format!("warning[{code}]: {place}{message}{times}")
        }
        MessageFormat::Json => json!({
            "level": "warning", "code": code, "name": name, "message": message, "count": count,
            "path": file.map(Path::to_string_lossy),
        })
        .to_string(),
    }
}

/// The line for an error.
pub(crate) fn error_line(format: MessageFormat, error: &Error) -> String {
    let detail = if error.code() == bug::CODE { bug::last_panic() } else { None };
    match format {
        MessageFormat::Human => {
            let detail = detail.map(|d| format!(" ({d})")).unwrap_or_default();
            format!("error[{}]: {error}{detail}", error.code())
        }
        MessageFormat::Json => {
            let mut object: Value = serde_json::from_str(&error.to_json()).unwrap_or_default();
            if let Value::Object(keys) = &mut object {
                keys.insert("level".to_owned(), json!("error"));
                if let Some(detail) = detail {
                    keys.insert("detail".to_owned(), json!(detail));
                }
            }
            object.to_string()
        }
    }
}

/// The line for a stop by a signal.
pub(crate) fn interrupted_line(format: MessageFormat, exit: u8) -> String {
    const MESSAGE: &str = "stopped by a signal; nothing was written";
    match format {
        MessageFormat::Human => format!("error[FC902]: {MESSAGE}"),
        MessageFormat::Json => {
            json!({ "level": "error", "code": "FC902", "exit": exit, "message": MESSAGE }).to_string()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tally() -> Tally {
        let mut tally = Tally::default();
        tally.warn("non_finite_vertices", 3, "vertices at NaN");
        (0..12).for_each(|id| tally.dropped.add(DropReason::NonFinite, id, 1));
        tally
    }

    #[test]
    fn repairs_are_told_with_code_count_and_place() {
        let lines: Vec<_> = notices(&tally())
            .iter()
            .map(|n| warning_line(MessageFormat::Human, Some(Path::new("a.ply")), n))
            .collect();
        assert_eq!(
            lines,
            [
                "warning[FC303]: a.ply: vertices at NaN (3 times)",
                "warning[FC333]: a.ply: 12 faces dropped: a corner lies at NaN or infinity; by number: \
                 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, ..."
            ]
        );
    }

    #[test]
    fn json_lines_are_objects_with_a_level() {
        let read = |line: String| serde_json::from_str::<Value>(&line).unwrap();
        let warning = read(warning_line(MessageFormat::Json, None, &notices(&tally())[0]));
        assert_eq!((&warning["level"], &warning["count"]), (&json!("warning"), &json!(3)));
        let error = Error::bad_input("FC204", "short").at_byte(7);
        let error = read(error_line(MessageFormat::Json, &error));
        assert_eq!(
            (&error["level"], &error["byte"], &error["exit"]),
            (&json!("error"), &json!(7), &json!(3))
        );
        assert_eq!(read(interrupted_line(MessageFormat::Json, 130))["exit"], json!(130));
    }

    #[test]
    fn the_human_form_names_code_file_place_and_remedy() {
        let error = Error::bad_input("FC203", "face 7 uses vertex 90000 of 35947")
            .in_file(Path::new("scan.ply"))
            .at_byte(318)
            .remedy("export it again");
        assert_eq!(
            error_line(MessageFormat::Human, &error),
            "error[FC203]: scan.ply: byte 318: face 7 uses vertex 90000 of 35947; export it again"
        );
    }
}
