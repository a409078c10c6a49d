//! What the commands write for programs has a page, and the page has every member.

use fctests::commands::{accept, folder, refuse, run, sample};
use serde_json::Value;
use std::fs;
use std::path::Path;

/// The names of all members of a document: with dots for members of members, from anew in the elements of a list, and
/// `NAME` where the file decides.
fn members(document: &Value, above: &str, names: &mut Vec<String>) {
    match document {
        Value::Object(map) => {
            for (key, value) in map {
                let own = ["sections.", "dropped."].iter().any(|list| above.ends_with(list));
                let name = format!("{above}{}", if own { "NAME" } else { key });
                members(value, &format!("{name}."), names);
                names.push(name);
            }
        }
        Value::Array(list) => list.iter().for_each(|value| members(value, "", names)),
        _ => {}
    }
}

/// Fails if the section of the page lacks a member of the documents.
fn described(section: &str, documents: &[Value]) {
    let page =
        fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/json.md")).expect("a page");
    let text = page.split("\n## ").find(|text| text.starts_with(section)).expect("a section");
    let mut names = Vec::new();
    documents.iter().for_each(|document| members(document, "", &mut names));
    assert!(names.len() > 3, "{section}: {names:?}");
    let missing: Vec<_> = names.iter().filter(|name| !text.contains(&format!("`{name}`"))).collect();
    assert!(missing.is_empty(), "{section} of docs/json.md does not describe {missing:?}");
}

fn read(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|error| panic!("{error}: {text}"))
}

#[test]
fn every_member_of_every_document_is_described() {
    let folder = folder();
    let at = folder.path();
    let said = accept(at, "fcbuild nan.ply -o x.fct --report r.json --message-format json");
    let mut messages: Vec<Value> = said.err.lines().map(read).collect();
    for line in [
        "fcbuild cut.ply -o y.fct --message-format json",
        "fcbuild cut.ply --message-format json",
        "fct export lost.fct -o y.ply --message-format json",
        "fct export good.fct -o new.ply --error 9 --message-format json",
        "fct look --message-format=json",
    ] {
        let lines: Vec<Value> = run(at, line).err.lines().map(read).collect();
        assert_eq!(lines.len(), 1, "{line}");
        messages.extend(lines);
    }
    for message in &messages {
        let level = message["level"].as_str().expect("a level");
        assert!(message["code"].as_str().expect("a code").starts_with("FC"), "{message}");
        assert_eq!(message["exit"].is_u64(), level == "error", "{message}");
    }
    described("Messages", &messages);

    let report = read(&fs::read_to_string(at.join("r.json")).expect("a report"));
    assert!(report["dropped"][0].is_object() && report["warnings"][0].is_object());
    let info = ["x.fct", "good.fct"].map(|file| read(&accept(at, &format!("fct info {file} --json")).out));
    let valid = read(&accept(at, "fct verify good.fct --json").out);
    let invalid = read(&run(at, "fct verify good.ply --json").out);
    let lods = "fct export good.fct -o lod_{n}.ply --triangles 2,1 --json --force";
    let export = read(&accept(at, &lods.replace("2,1", "2")).out);
    for document in [&report, &info[0], &valid, &invalid, &export] {
        assert_eq!(document["schema"], 1, "{document}");
    }
    // One number has one name in all of them.
    assert_eq!(info[0]["counts"]["faces_kept"], report["counts"]["faces_kept"]);
    assert_eq!(info[0]["counts"]["groups"], report["counts"]["groups"]);
    described("Report", &[report]);
    described("Info", &info);
    described("Verify", &[valid, invalid]);
    described("Export", &[export]);
}

#[test]
fn an_export_says_what_each_mesh_has_come_to() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let at = folder.path();
    accept(at, &format!("fcbuild {} -o a.fct", sample("sculpture.ply").display()));
    let lods = read(&accept(at, "fct export a.fct -o lod_{n}.ply --triangles 5000,500 --json").out);
    let meshes = lods["meshes"].as_array().expect("a list");
    for (mesh, asked) in meshes.iter().zip([5000, 500]) {
        assert_eq!((&mesh["asked"], &mesh["path"]), (&asked.into(), &format!("lod_{asked}.ply").into()));
        assert!((asked - 4..=asked).contains(&mesh["triangles"].as_i64().expect("a number")), "{mesh}");
        assert!(mesh["bound"].as_f64().expect("a number") > 0.0 && mesh["chosen_by"] == "budget", "{mesh}");
    }
    assert_eq!(meshes.len(), 2);
    // A percentage is one of the diagonal of the box.
    let info = read(&accept(at, "fct info a.fct --json").out);
    let corner = |name: &str, k: usize| info[name][k].as_f64().expect("a number");
    let diagonal =
        (0..3).map(|k| (corner("bounds_max", k) - corner("bounds_min", k)).powi(2)).sum::<f64>().sqrt();
    let count = |error: &str| {
        let line = format!("fct export a.fct -o e.ply --error {error} --json --force");
        read(&accept(at, &line).out)["meshes"][0]["triangles"].clone()
    };
    assert_eq!(count("0.5%"), count(&(0.005 * diagonal).to_string()));
    // An error that is large beside the box is told, on its own stream.
    let said = accept(at, "fct export a.fct -o big.ply --error 3 --json");
    assert!(said.err.starts_with("warning[FC351]: a.fct: ") && said.err.contains("box"), "{}", said.err);
    assert_eq!(read(&said.out)["meshes"][0]["chosen_by"], "bound");
    assert!(accept(at, "fct export a.fct -o fine.ply --error 0.01").err.is_empty());
    refuse(at, "fct export a.fct -o x.ply --error 5%%", 2, &["percentage"]);
}
