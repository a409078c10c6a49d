//! ASCII STL: one or several `solid` blocks of facets.

use super::super::faces::{Faces, Vertices};
use super::super::number;
use super::super::soup::{Group, Positions, Soup};
use super::super::source::Source;
use super::super::words::{Lack, Words};
use crate::error::{Error, ErrorKind};

/// Whether the start of a file looks like text STL and not like a binary one whose header says `solid`.
pub(in super::super) fn looks_like_text(head: &[u8]) -> bool {
    let head: Vec<u8> = head.iter().map(u8::to_ascii_lowercase).collect();
    let has = |word: &[u8]| head.windows(word.len()).any(|w| w == word);
    head.starts_with(b"solid") && !head.contains(&0) && (head.len() < 84 || has(b"facet") || has(b"endsolid"))
}

/// Reads a text STL file; each solid is a group.
pub(in super::super) fn read(source: &mut Source<'_>) -> Result<Soup, Error> {
    let stem = source.stem();
    let max_faces = source.max_faces();
    let mut window = source.window();
    if window.peek(3).starts_with(b"\xef\xbb\xbf") {
        window.consume(3);
    }
    let mut words = Words::new(&mut window, 1);
    let parsed = parse(&mut words, &stem, max_faces);
    let parsed = parsed.map_err(|lack| match lack {
        Lack::Bad(e) => words.locate(e),
        Lack::End => words.locate(
            Error::bad_input("FC204", "the file ends within a solid")
                .remedy("the file is cut off; copy or export it again"),
        ),
    });
    if let Some(e) = window.take_failure() {
        return Err(source.read_error(&e));
    }
    let (points, solids) = parsed?;

    let facets = (0..points.len()).step_by(3).map(|i| [0, 1, 2].map(|k: usize| i.saturating_add(k)));
    let positions = Positions::narrow_if_harmless(points, facets);
    let vertices = Vertices::new(&positions);
    let mut faces = Faces::new(max_faces);
    let mut groups: Vec<Group> = Vec::new();
    let mut corner = 0u32;
    for (name, facets) in solids {
        let start = faces.triangles.len();
        for _ in 0..facets {
            let [a, b, c] = [0, 1, 2].map(|k| corner.saturating_add(k));
            faces.polygon(&vertices, &[a, b, c])?;
            corner = corner.saturating_add(3);
        }
        groups.push(Group { name, triangles: start..faces.triangles.len() });
    }
    let (triangles, tally) = faces.finish(&vertices)?;
    Ok(Soup { positions, triangles, normals: None, colors: None, groups, tally })
}

type Solids = Vec<(String, u64)>;

fn parse(words: &mut Words<'_, '_>, stem: &str, max_faces: u64) -> Result<(Vec<[f64; 3]>, Solids), Lack> {
    let mut points = Vec::new();
    let mut solids = Solids::new();
    let mut total = 0u64;
    while words.has_more() {
        keyword(words, "solid")?;
        let name = String::from_utf8_lossy(&words.rest_of_line()).into_owned();
        let mut facets = 0u64;
        loop {
            match one_of(words, "facet", "endsolid")? {
                Which::Second => break,
                Which::First => facet(words, &mut points)?,
            }
            facets = facets.saturating_add(1);
            total = total.saturating_add(1);
            if total > max_faces || points.len() as u64 >= u64::from(u32::MAX - 3) {
                return Err(Lack::Bad(
                    Error::new(
                        ErrorKind::Limit,
                        "FC501",
                        format!("more faces than the limit of {max_faces}"),
                    )
                    .limit(max_faces, total)
                    .remedy("simplify or split the model, or raise the limit"),
                ));
            }
        }
        words.rest_of_line();
        solids.push((if name.is_empty() { stem.to_owned() } else { name }, facets));
    }
    Ok((points, solids))
}

fn facet(words: &mut Words<'_, '_>, points: &mut Vec<[f64; 3]>) -> Result<(), Lack> {
    keyword(words, "normal")?;
    // The normal is recomputed, so that a wrong one, or text that is no number, does no harm.
    for _ in 0..3 {
        words.next("a number", |_| Some(()))?;
    }
    keyword(words, "outer")?;
    keyword(words, "loop")?;
    for _ in 0..3 {
        keyword(words, "vertex")?;
        let mut point = [0.0; 3];
        for x in &mut point {
            *x = words.next("a number", number::coordinate)?;
        }
        points.push(point);
    }
    keyword(words, "endloop")?;
    keyword(words, "endfacet")
}

enum Which {
    First,
    Second,
}

fn one_of(words: &mut Words<'_, '_>, first: &str, second: &str) -> Result<Which, Lack> {
    words.next(&format!("`{first}` or `{second}`"), |w| {
        if w.eq_ignore_ascii_case(first.as_bytes()) {
            Some(Which::First)
        } else {
            w.eq_ignore_ascii_case(second.as_bytes()).then_some(Which::Second)
        }
    })
}

fn keyword(words: &mut Words<'_, '_>, keyword: &str) -> Result<(), Lack> {
    words.next(&format!("`{keyword}`"), |w| w.eq_ignore_ascii_case(keyword.as_bytes()).then_some(()))
}
