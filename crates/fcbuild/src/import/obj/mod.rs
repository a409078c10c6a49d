//! OBJ: parsed by `tobj`, behind our own walk over the lines.
//!
//! The walk (`feed`) knows line numbers, bounds every line and index and hides what the parser
//! stumbles over; material files are never opened, since the mesh keeps no materials.

mod feed;
mod lines;
mod parts;
mod statements;

use std::path::Path;

use feed::Feed;
use lines::Lines;
use statements::Findings;

use super::faces::{Faces, Vertices};
use super::number::narrow;
use super::soup::{Positions, Soup};
use super::source::Source;
use super::tally::{MATERIALS, MIXED_NORMALS, TEXTURES, Tally, differ};
use crate::error::Error;

/// Reads an OBJ file; each `o` is a group, or, where there is none, each name of a `g`.
pub(super) fn read(source: &mut Source<'_>) -> Result<Soup, Error> {
    let stem = source.stem();
    let max_faces = source.max_faces();
    let folder = source.path().parent().unwrap_or(Path::new(""));
    let mut feed = Feed::new(Lines::new(source.window()), folder, max_faces);
    let options = tobj::LoadOptions::default();
    let parsed = tobj::load_obj_buf(&mut feed, &options, |_| Ok(Default::default()));
    let (failure, findings) = feed.finish();
    if let Some(e) = failure {
        return Err(source.read_error(&e));
    }
    let findings = findings?;
    let mesh = match parsed {
        // Objects are ours to keep apart, so that the parser sees a single one.
        Ok((models, _)) => models.into_iter().next().map(|m| m.mesh).unwrap_or_default(),
        Err(e) => return Err(Error::bad_input("FC206", format!("the OBJ parser refuses the file: {e}"))),
    };
    assemble(mesh, &findings, &stem, max_faces)
}

fn assemble(mesh: tobj::Mesh, findings: &Findings, stem: &str, max_faces: u64) -> Result<Soup, Error> {
    let points = mesh.positions.as_chunks::<3>().0.to_vec();
    let corners = polygons(&mesh).flat_map(|polygon| polygon.array_windows::<3>());
    let positions = Positions::narrow_if_harmless(points, corners.map(|three| three.map(|v| v as usize)));
    let mut mixed = 0;
    let normals = findings.with_normals.then(|| average_normals(&mesh, positions.len(), &mut mixed));
    let colors = findings.colored.then(|| mesh.vertex_color.as_chunks::<3>().0.iter().map(color).collect());
    let vertices = Vertices::new(&positions);
    let mut faces = Faces::new(max_faces);
    let unused = findings.vertices.saturating_sub(positions.len() as u64);
    warn(&mut faces.tally, findings, unused);
    faces.tally.warn("mixed_normals", mixed, MIXED_NORMALS);

    let mut runs = Vec::new();
    let mut begins = findings.parts.begins().peekable();
    let mut part = None;
    let mut start = 0usize;
    for (polygon, corners) in (0_u64..).zip(polygons(&mesh)) {
        while let Some((next, _)) = begins.next_if(|(_, first)| *first <= polygon) {
            runs.push((part, start..faces.triangles.len()));
            start = faces.triangles.len();
            part = Some(next);
        }
        faces.polygon(&vertices, corners)?;
    }
    runs.push((part, start..faces.triangles.len()));
    let (triangles, tally) = faces.finish(&vertices)?;
    let (groups, triangles) = findings.parts.gather(runs, triangles, stem);
    Ok(Soup { positions, triangles, normals, colors, groups, tally })
}

/// The corners of each polygon.
fn polygons(mesh: &tobj::Mesh) -> impl Iterator<Item = &[u32]> {
    // Where the parser met triangles only, it gives no numbers of corners.
    let all_triangles = mesh.face_arities.is_empty();
    let count = if all_triangles { mesh.indices.len() / 3 } else { mesh.face_arities.len() };
    let mut rest = mesh.indices.as_slice();
    (0..count).map_while(move |polygon| {
        let corners =
            if all_triangles { 3 } else { mesh.face_arities.get(polygon).map_or(0, |&n| n as usize) };
        let (corners, after) = rest.split_at_checked(corners)?;
        rest = after;
        Some(corners)
    })
}

/// One normal per vertex: the mean direction over the corners, zero where there is none. `mixed` becomes the number of
/// vertices whose corners disagree.
fn average_normals(mesh: &tobj::Mesh, count: usize, mixed: &mut u64) -> Vec<[f32; 3]> {
    let stored = mesh.normals.as_chunks::<3>().0;
    let unit = |v: &[f64; 3]| {
        let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
        (length.is_finite() && length > 0.0).then(|| v.map(|x| x / length))
    };
    let corners = || {
        let corners = mesh.indices.iter().zip(&mesh.normal_indices);
        corners.filter_map(|(&vertex, &normal)| Some((vertex as usize, unit(stored.get(normal as usize)?)?)))
    };
    let mut sums = vec![[0.0f64; 3]; count];
    for (vertex, normal) in corners() {
        let Some(sum) = sums.get_mut(vertex) else { continue };
        for (s, x) in sum.iter_mut().zip(normal) {
            *s += x;
        }
    }
    let means: Vec<[f32; 3]> =
        sums.iter().map(|sum| unit(sum).map_or([0.0; 3], |mean| mean.map(narrow))).collect();
    let mut seen = vec![false; count];
    for (vertex, normal) in corners() {
        if let (Some(mean), Some(seen)) = (means.get(vertex), seen.get_mut(vertex))
            && !*seen
            && differ(normal.map(narrow), *mean)
        {
            *seen = true;
            *mixed = mixed.saturating_add(1);
        }
    }
    means
}

/// A colour from 0..1 as bytes, opaque.
#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "the walk clamps channels to 0..1"
)]
fn color(rgb: &[f64; 3]) -> [u8; 4] {
    let [r, g, b] = rgb.map(|x| (x * 255.0 + 0.5) as u8);
    [r, g, b, 255]
}

fn warn(tally: &mut Tally, findings: &Findings, unused: u64) {
    for (&code, &count) in &findings.oddities {
        let message = match code {
            "lines_and_points" => "statements that draw lines or points are ignored",
            "free_form_geometry" => {
                "statements of curves and free-form surfaces are ignored; export them as polygons"
            }
            "vertex_weights" => "weights of vertices are ignored, since polygons have none",
            "partial_colors" => {
                "vertices lack a colour where the first one has one, and become white, or have one where that lacks it, \
                 and lose it"
            }
            "outside_material_files" => "material files outside the input's folder are not looked for",
            "texture_coordinates" => TEXTURES,
            "materials" => MATERIALS,
            "missing_material_files" => "material files are missing; the geometry needs none",
            _ => "unknown statements are ignored",
        };
        tally.warn(code, count, message);
    }
    let nested = findings.parts.passed_over();
    tally.warn(
        "groups_in_objects",
        nested,
        "groups (`g`) of a file with objects (`o`) are not kept, the objects are",
    );
    tally.warn("unused_vertices", unused, "vertices that no face uses are left out");
}

#[cfg(test)]
mod tests;
