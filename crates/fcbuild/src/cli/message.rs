//! Errors and warnings in the two forms that `--message-format` names.
//!
//! # Codes
//! The library's codes stand in `fcbuild::error`; the command adds:
//!
//! | code | exit | meaning |
//! |------|------|---------|
//! | FC100 | 2 | wrong usage, as JSON alone has a code for it |
//! | FC101 | 2 | an output is an input, or two outputs are one file |
//! | FC102 | 2 | standard input or output in place of a file |
//! | FC103 | 2 | a tree is to be written under the name of a mesh |
//! | FC213 | 3 | `--strict` refuses what would be repaired |
//! | FC291 | 0 | warning: welded vertices had different colours |
//! | FC293 | 0 | warning: the faces look inwards |
//! | FC294 | 0 | warning: the surface is cut at edges |
//! | FC295 | 0 | warning: more groups than a file names |
//! | FC296 | 0 | warning: a merged tree was too deep and was split from the top |
//! | FC297 | 0 | warning: groups of which no face is left |
//! | FC298 | 0 | warning: faces are small beside the rounding to single precision |
//! | FC300 | 0 | warning without a code of its own |
//! | FC301 | 0 | warning: bytes after the end of the content |
//! | FC302 | 0 | warning: vertices that no face uses |
//! | FC303 | 0 | warning: vertices at NaN or infinity, or beyond 3.4e38 |
//! | FC304 | 0 | warning: polygons that cross themselves |
//! | FC305 | 0 | warning: polygons too tangled to triangulate |
//! | FC311 to FC313 | 0 | warning: flattened meshes, ignored skins, ignored morph targets of a scene |
//! | FC314, FC315 | 0 | warning: normals or colours of some meshes only |
//! | FC321 to FC323 | 0 | warning: lines and points, free-form geometry, vertex weights of an OBJ |
//! | FC324, FC325 | 0 | warning: material files that are outside the folder, or missing |
//! | FC331 to FC335 | 0 | faces dropped: too few corners, a corner twice, at NaN or infinity, repeated, no surface |
//! | FC341 to FC344 | 0 | warning: texture coordinates, materials, normals of corners, groups in objects that are not kept |
//! | FC412 | 4 | the report cannot be written |
//! | FC413 | 4 | standard output cannot be written |
//! | FC471 | 4 | the tree cannot be written |
//! | FC472 | 4 | an output exists |
//! | FC473 | 4 | an output is no regular file |
//! | FC474 | 4 | the file to be replaced is neither tree nor report |
//! | FC506 | 5 | the job needs more memory than allowed |
//! | FC507 | 5 | the threads cannot be started |
//! | FC571 | 5 | the tree is too large for the format |
//! | FC902 | 129, 130, 131, 143, 152 | a signal stopped the job |

use super::bug;
use fcbuild::Error;
use fcbuild::import::{DropReason, Tally};
use fct::{MessageFormat, counted, grouped};
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
    /// Whether it is about the surface, and not about what a tree has no place for.
    #[serde(skip)]
    pub(crate) of_surface: bool,
    /// Whether the sentence gives the count itself.
    #[serde(skip)]
    says_count: bool,
}

/// Everything in the books that is not as it should be: oddities, then faces dropped.
pub(crate) fn notices(tally: &Tally) -> Vec<Notice> {
    let oddities = tally.warnings.iter().map(|w| {
        let (code, name) = warning_code(w.code);
        let says_count = w.count == 1 || w.message.starts_with(&format!("{} ", grouped(w.count)));
        let of_surface = !matches!(code, "FC341" | "FC342" | "FC343" | "FC344");
        Notice { code, name, message: w.message.clone(), count: w.count, of_surface, says_count }
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
                counted(count, "face"),
                listed.join(", ")
            ),
            count,
            of_surface: true,
            says_count: true,
        }
    });
    oddities.chain(dropped).collect()
}

/// The stable code and name of a warning; the readers give the name, the builder the code.
fn warning_code(given: &'static str) -> (&'static str, &'static str) {
    let code = match given {
        "FC291" => return ("FC291", "mixed_colors"),
        "FC293" => return ("FC293", "inward_faces"),
        "FC295" => return ("FC295", "nameless_groups"),
        "FC296" => return ("FC296", "split_instead"),
        "FC297" => return ("FC297", "lost_groups"),
        "FC298" => return ("FC298", "rounded_positions"),
        "seam_edges" => "FC294",
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
        "texture_coordinates" => "FC341",
        "materials" => "FC342",
        "mixed_normals" => "FC343",
        "groups_in_objects" => "FC344",
        code if code.starts_with("FC") => code,
        _ => "FC300",
    };
    (code, given)
}

fn drop_code(reason: DropReason) -> (&'static str, &'static str) {
    match reason {
        DropReason::TooFewVertices => ("FC331", "fewer than three corners"),
        DropReason::RepeatedIndex => ("FC332", "two corners are one vertex"),
        DropReason::NonFinite => ("FC333", "a corner lies at NaN or infinity, or beyond 3.4e38"),
        DropReason::Duplicate => ("FC334", "repeats of earlier faces"),
        DropReason::NotTriangles => ("FC335", "points or lines, which have no surface"),
    }
}

/// The line for a warning about `file`; without one when several files were read.
pub(crate) fn warning_line(format: MessageFormat, file: Option<&Path>, notice: &Notice) -> String {
    let Notice { code, name, message, count, says_count, .. } = notice;
    match format {
        MessageFormat::Human => {
            let place = file.map(|f| format!("{}: ", f.display())).unwrap_or_default();
            let times = match grouped(*count) {
                _ if *says_count => String::new(),
                // The files before the first of several had fewer.
                all if message.starts_with(|c: char| c.is_ascii_digit()) => format!(" ({all} in all)"),
                all => format!(" ({all} times)"),
            };
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

/// The line for a stop by a signal, and what there is now.
pub(crate) fn interrupted_line(format: MessageFormat, exit: u8, state: &str) -> String {
    let message = format!("stopped by a signal; {state}");
    match format {
        MessageFormat::Human => format!("error[FC902]: {message}"),
        MessageFormat::Json => {
            json!({ "level": "error", "code": "FC902", "exit": exit, "message": message }).to_string()
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
                "warning[FC333]: a.ply: 12 faces dropped: a corner lies at NaN or infinity, or beyond \
                 3.4e38; by number: 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, ..."
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
        assert_eq!(read(interrupted_line(MessageFormat::Json, 130, ""))["exit"], json!(130));
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
