//! Several files become one soup.

use super::memory;
use super::progress::Stage;
use fcbuild::Error;
use fcbuild::error::ErrorKind;
use fcbuild::import::{self, DropReason, Group, ImportOptions, Positions, Soup, Tally};
use fcbuild::mesh::MAX_FACES;
use fct::{Progress, Size};
use std::path::PathBuf;

/// Reads all files; the faces and groups of each follow those of the files before it.
///
/// Normals and colours are kept when every file has them.
///
/// # Errors
/// As [`import::import`]; a limit when the sum has more faces or vertices than can be numbered, or more faces than
/// fit into `max_memory`.
pub(crate) fn read_all(
    paths: &[PathBuf],
    max_memory: Option<&Size>,
    progress: &Progress,
) -> Result<Soup, Error> {
    let by_memory = max_memory.map_or(u64::MAX, |limit| memory::faces_within(limit.bytes()));
    let mut whole: Option<Soup> = None;
    for path in paths {
        let so_far = whole.as_ref().map_or(0, |soup| soup.triangles.len() as u64);
        let options = ImportOptions {
            max_faces: by_memory.min(MAX_FACES).saturating_sub(so_far),
            progress: &|done, total| progress.tell(Stage::Import.into(), done, total),
        };
        let soup = import::import(path, &options).map_err(|e| {
            let ours = e.code() == "FC501"
                && by_memory < MAX_FACES
                && e.message().contains(&options.max_faces.to_string());
            match max_memory {
                Some(allowed) if ours => {
                    memory::too_many_faces(so_far.saturating_add(e.found().unwrap_or(0)), allowed)
                        .in_file(path)
                }
                _ => e,
            }
        })?;
        whole = Some(match whole {
            None => soup,
            Some(first) => joined(first, soup).map_err(|e| e.in_file(path))?,
        });
    }
    whole.ok_or_else(|| Error::new(ErrorKind::Usage, "FC102", "no input is given"))
}

/// Appends the second soup to the first.
fn joined(mut first: Soup, second: Soup) -> Result<Soup, Error> {
    let vertices = first.positions.len() as u64 + second.positions.len() as u64;
    let Ok(offset) = u32::try_from(first.positions.len()).map_err(drop) else {
        return Err(too_many(vertices));
    };
    if vertices >= u64::from(u32::MAX) {
        return Err(too_many(vertices));
    }
    let faces = first.triangles.len();
    first.positions = match (first.positions, second.positions) {
        (Positions::F32(mut a), Positions::F32(b)) => {
            a.extend(b);
            Positions::F32(a)
        }
        // Double precision in one file is worth the memory for all.
        (a, b) => {
            let mut all = wide(a);
            all.extend(wide(b));
            Positions::F64(all)
        }
    };
    first.triangles.extend(second.triangles.into_iter().map(|t| t.map(|v| v + offset)));
    first.groups.extend(
        second
            .groups
            .into_iter()
            .map(|g| Group { name: g.name, triangles: g.triangles.start + faces..g.triangles.end + faces }),
    );
    first.normals = both(first.normals, second.normals);
    first.colors = both(first.colors, second.colors);
    add_tally(&mut first.tally, second.tally);
    Ok(first)
}

fn too_many(vertices: u64) -> Error {
    Error::new(
        ErrorKind::Limit,
        "FC501",
        format!("with this file there are {vertices} vertices, more than 32-bit indices reach"),
    )
    .remedy("build several trees")
    .limit(u64::from(u32::MAX - 1), vertices)
}

fn wide(positions: Positions) -> Vec<[f64; 3]> {
    match positions {
        Positions::F32(v) => v.into_iter().map(|p| p.map(f64::from)).collect(),
        Positions::F64(v) => v,
    }
}

fn both<T>(first: Option<Vec<T>>, second: Option<Vec<T>>) -> Option<Vec<T>> {
    let (mut first, second) = (first?, second?);
    first.extend(second);
    Some(first)
}

/// Adds up the books; the ids of dropped faces count on from file to file.
fn add_tally(first: &mut Tally, second: Tally) {
    for reason in DropReason::ALL {
        let count = second.dropped.count(reason);
        let ids = second.dropped.first_ids(reason);
        for (i, id) in ids.iter().enumerate() {
            // The last id that is known stands for all that are not.
            let n = if i + 1 == ids.len() { count - i as u64 } else { 1 };
            first.dropped.add(reason, first.polygons_in.saturating_add(*id), n);
        }
    }
    first.polygons_in = first.polygons_in.saturating_add(second.polygons_in);
    first.faces_in = first.faces_in.saturating_add(second.faces_in);
    for warning in second.warnings {
        first.warn(warning.code, warning.count, warning.message);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn soup(positions: Positions, normals: bool) -> Soup {
        let n = positions.len();
        let mut tally = Tally { polygons_in: 5, faces_in: 6, ..Tally::default() };
        for id in 0..4 {
            tally.dropped.add(DropReason::NonFinite, id, 1);
        }
        tally.dropped.add(DropReason::NonFinite, 4, 8);
        tally.warn("odd", 2, "odd things");
        Soup {
            positions,
            triangles: vec![[0, 1, 2]],
            normals: normals.then(|| vec![[0.0, 0.0, 1.0]; n]),
            colors: None,
            groups: vec![Group { name: "g".to_owned(), triangles: 0..1 }],
            tally,
        }
    }

    #[test]
    fn indices_groups_and_books_count_on() {
        let narrow = Positions::F32(vec![[0.5, 0.0, 0.0]; 3]);
        let wide = Positions::F64(vec![[0.1, 0.0, 0.0]; 4]);
        let sum = joined(soup(narrow.clone(), true), soup(wide, true)).unwrap();
        assert_eq!(sum.triangles, [[0, 1, 2], [3, 4, 5]]);
        assert_eq!(sum.groups[1].triangles, 1..2);
        assert!(matches!(&sum.positions, Positions::F64(p) if p.len() == 7 && p[0] == [0.5, 0.0, 0.0]));
        assert_eq!(sum.normals.map(|n| n.len()), Some(7));
        assert_eq!((sum.tally.polygons_in, sum.tally.faces_in), (10, 12));
        assert_eq!(sum.tally.dropped.count(DropReason::NonFinite), 24);
        assert_eq!(sum.tally.dropped.first_ids(DropReason::NonFinite), [0, 1, 2, 3, 4, 5, 6, 7, 8, 9]);
        assert_eq!(sum.tally.warnings[0].count, 4);

        let narrow_only = joined(soup(narrow.clone(), true), soup(narrow, false)).unwrap();
        assert!(matches!(narrow_only.positions, Positions::F32(p) if p.len() == 6));
        assert!(narrow_only.normals.is_none(), "only one of the two has normals");
    }
}
