//! `fct info`: what a file says about itself.

use crate::SCHEMA;
use crate::counted::counted;
use fct::Tree;
use fct::grouped;
use serde_json::json;
use std::fmt::Write as _;

/// Names of groups listed for people; the JSON form has them all.
const LISTED_GROUPS: usize = 8;

/// For people.
pub(crate) fn to_text(tree: &Tree) -> String {
    let (header, meta) = (tree.header(), tree.meta());
    let faces = header.face_count.max(1);
    let mut text = format!("{}\n", tree.path().display());
    let mut line = |name: &str, value: String| {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "  {name:10} {value}");
    };
    line("format", format!("fct {}.{}, {} bytes", header.major, header.minor, grouped(header.file_len)));
    let [generator, split, weld] = [&meta.generator, &meta.split, &meta.weld].map(|text| printable(text));
    line("made by", format!("{generator} (--split {split}, --weld {weld})"));
    line("made of", printable(&meta.source));
    let dropped: Vec<_> = meta
        .dropped
        .iter()
        .map(|(why, n)| format!(", {} dropped: {}", grouped(*n), printable(why)))
        .collect();
    line(
        "faces",
        format!(
            "{} of {} in the input{}",
            grouped(meta.faces_kept),
            grouped(meta.faces_in),
            dropped.concat()
        ),
    );
    line("vertices", grouped(header.vertex_count));
    line("tree", format!("{}, depth {}", counted(header.node_count, "node", "nodes"), meta.depth));
    let kind = if meta.closed { "closed" } else { "open" };
    line(
        "surface",
        format!(
            "{kind}, {}, {}, {}",
            counted(meta.components, "component", "components"),
            counted(meta.boundary_edges, "boundary edge", "boundary edges"),
            counted(meta.seam_edges, "seam edge", "seam edges")
        ),
    );
    let extras: Vec<_> = [("normals", tree.normals().is_some()), ("colours", tree.colors().is_some())]
        .into_iter()
        .filter_map(|(name, there)| there.then_some(name))
        .collect();
    line("attributes", if extras.is_empty() { "none".to_owned() } else { extras.join(", ") });
    let corner = |c: [f32; 3]| [0, 1, 2].map(|k| sum_in_words(meta.origin[k], c[k])).join(" ");
    line("box", format!("{} to {}", corner(meta.bounds_min), corner(meta.bounds_max)));
    if meta.origin != [0.0; 3] {
        let [x, y, z] = meta.origin;
        line(
            "origin",
            format!("{x} {y} {z}, from which the file counts; the box is in coordinates of the input"),
        );
    }
    if !meta.group_names.is_empty() {
        let names: Vec<_> = meta.group_names.iter().take(LISTED_GROUPS).map(|n| printable(n)).collect();
        let more = if meta.group_names.len() > LISTED_GROUPS { ", ..." } else { "" };
        line("groups", format!("{}: {}{more}", meta.group_names.len(), names.join(", ")));
    }
    line("content id", format!("{:032x}", header.content_id));
    line("source id", format!("{:032x}", header.source_id));
    for s in tree.sections() {
        line(
            &format!("  {}", s.tag),
            format!("{:>15} bytes, {:>6.2} a face", grouped(s.length), s.length as f64 / faces as f64),
        );
    }
    line(
        "  all",
        format!(
            "{:>15} bytes, {:>6.2} a face",
            grouped(header.file_len),
            header.file_len as f64 / faces as f64
        ),
    );
    text.trim_end().to_owned()
}

/// For programs.
pub(crate) fn to_json(tree: &Tree) -> String {
    let (header, meta) = (tree.header(), tree.meta());
    let sections: serde_json::Map<_, _> = tree
        .sections()
        .iter()
        .map(|s| {
            let entry = json!({ "offset": s.offset, "bytes": s.length, "elements": s.elem_count });
            (s.tag.to_string(), entry)
        })
        .collect();
    let input = |c: [f32; 3]| [0, 1, 2].map(|k| meta.origin[k] + f64::from(c[k]));
    let object = json!({
        "schema": SCHEMA,
        "path": tree.path().to_string_lossy(),
        "version": [header.major, header.minor],
        "bytes": header.file_len,
        "generator": meta.generator,
        "source": meta.source,
        "split": meta.split,
        "weld": meta.weld,
        "counts": {
            "faces_in": meta.faces_in,
            "faces": header.face_count,
            "faces_kept": header.face_count,
            "vertices": header.vertex_count,
            "nodes": header.node_count,
            "depth": meta.depth,
            "components": meta.components,
            "groups": meta.group_names.len().max(1),
            "boundary_edges": meta.boundary_edges,
            "seam_edges": meta.seam_edges,
        },
        "dropped": meta.dropped.iter().map(|(why, n)| (why.clone(), json!(n))).collect::<serde_json::Map<_, _>>(),
        "closed": meta.closed,
        "normals": tree.normals().is_some(),
        "colors": tree.colors().is_some(),
        "origin": meta.origin,
        "bounds_min": meta.bounds_min,
        "bounds_max": meta.bounds_max,
        "input_min": input(meta.bounds_min),
        "input_max": input(meta.bounds_max),
        "groups": meta.group_names,
        "content_id": format!("{:032x}", header.content_id),
        "source_id": format!("{:032x}", header.source_id),
        "sections": sections,
    });
    format!("{object:#}")
}

/// A coordinate of the input with as many digits after the point as the origin and the stored number have.
fn sum_in_words(origin: f64, stored: f32) -> String {
    if origin == 0.0 {
        return stored.to_string();
    }
    let digits = |text: String| text.split_once('.').map_or(0, |(_, digits)| digits.len());
    let most = digits(origin.to_string()).max(digits(stored.to_string()));
    let sum = format!("{:.most$}", origin + f64::from(stored));
    if sum.contains('.') { sum.trim_end_matches('0').trim_end_matches('.').to_owned() } else { sum }
}

/// Characters of a text from a file that are shown; the JSON form has them all.
const SHOWN: usize = 200;

/// A text from a file without what would steer the terminal, turn its direction or flood it.
fn printable(text: &str) -> String {
    let mut out = String::new();
    for (number, c) in text.chars().enumerate() {
        if number == SHOWN {
            out.push_str("...");
            break;
        }
        if c.is_control() || matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}') {
            out.extend(c.escape_default());
        } else {
            out.push(c);
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::{SHOWN, printable, sum_in_words};

    #[test]
    fn coordinates_have_the_digits_that_they_came_with() {
        assert_eq!(sum_in_words(0.0, 0.1), "0.1");
        assert_eq!(sum_in_words(4_500_000.0, -1.0), "4499999");
        assert_eq!(sum_in_words(4_500_000.25, 0.003), "4500000.253");
        assert_eq!(sum_in_words(0.0, 1e30), 1e30_f32.to_string());
        assert_eq!([sum_in_words(0.0, 300.0), sum_in_words(0.5, -0.5)], ["300", "0"]);
    }

    #[test]
    fn a_name_cannot_steer_the_terminal() {
        assert_eq!(printable("ear \u{1b}[2J\nÄ"), "ear \\u{1b}[2J\\nÄ");
        assert_eq!(printable("a\u{202e}b"), "a\\u{202e}b");
        assert_eq!(printable(&"Ä".repeat(1 << 20)), "Ä".repeat(SHOWN) + "...");
    }
}
