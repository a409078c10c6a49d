//! The elements of a PLY file after its header, in whatever order they come.

use super::super::faces::{Faces, MAX_CORNERS, Vertices};
use super::super::tally::TEXTURES;
use super::super::words::Lack;
use super::header::{Element, Encoding, Header, Kind, Scalar};
use super::values::Values;
use super::vertices::{self, VertexData};
use crate::error::{Error, ErrorKind};

/// The most corners a polygon may have, as lengths in a file are counted.
const CORNER_LIMIT: u64 = MAX_CORNERS as u64;

/// How programs call texture coordinates, of vertices and of faces.
const TEXTURE_NAMES: [&str; 9] =
    ["s", "t", "u", "v", "texture_u", "texture_v", "texture_s", "texture_t", "texcoord"];

/// Reads all elements; the triangles go to `faces`.
pub(super) fn read<V: Values>(
    values: &mut V,
    header: &Header,
    faces: &mut Faces,
) -> Result<VertexData, Error> {
    let vertex_count = header.elements.iter().find(|e| e.name == "vertex").map(|e| e.count);
    let Some(vertex_count) = vertex_count else {
        let names: Vec<&str> = header.elements.iter().take(20).map(|e| e.name.as_str()).collect();
        return Err(Error::bad_input(
            "FC208",
            format!("there is no element vertex; found: {}", names.join(", ")),
        )
        .remedy("export the file again as a mesh"));
    };
    let mut data = None;
    let mut waiting = Waiting::default();
    for element in &header.elements {
        check_room(values, header.encoding, element)?;
        let of_surface = matches!(element.name.as_str(), "vertex" | "face");
        if of_surface
            && element.properties.iter().any(|property| TEXTURE_NAMES.contains(&property.name.as_str()))
        {
            faces.tally.warn("texture_coordinates", element.count, TEXTURES);
        }
        match element.name.as_str() {
            "vertex" => data = Some(vertices::read(values, element)?),
            "face" | "tristrips" => {
                let known = data.as_ref().map(|d: &VertexData| Vertices::new(&d.positions));
                let mut polygons = Polygons { faces, known, waiting: &mut waiting, vertex_count };
                if element.name == "face" {
                    polygons.read_faces(values, element)?;
                } else {
                    polygons.read_strips(values, element)?;
                }
            }
            _ => skip_element(values, element)?,
        }
    }
    let Some(data) = data else {
        return Err(Error::bad_input("FC208", "there is no element vertex"));
    };
    waiting.deliver(faces, &data)?;
    if values.has_more() {
        faces.tally.warn(
            "trailing_bytes",
            1,
            format!("{} bytes after the last element are ignored", values.remaining()),
        );
    }
    Ok(data)
}

/// Refuses a count that the rest of the file cannot hold, before any room is made for it.
fn check_room<V: Values>(values: &V, encoding: Encoding, element: &Element) -> Result<(), Error> {
    let Element { name, count, properties, line } = element;
    if *count == 0 {
        return Ok(());
    }
    if properties.is_empty() {
        return Err(Error::bad_input(
            "FC202",
            format!("element {name} declares {count} records without properties"),
        )
        .at_line(*line)
        .remedy("correct the header or export the file again"));
    }
    let smallest = element.smallest_record(encoding).max(1);
    let room = values.remaining().saturating_add(values.slack()).checked_div(smallest).unwrap_or(0);
    if *count > room {
        let least = if properties.iter().all(|p| matches!(p.kind, Kind::One(_))) { "" } else { "at most " };
        return Err(values.locate(
            Error::bad_input(
                "FC205",
                format!("the header declares {count} {name} records, the file has room for {least}{room}"),
            )
            .limit(room, *count)
            .remedy("the file is cut off or its header is wrong; copy or export it again"),
        ));
    }
    Ok(())
}

/// The error for a record that cannot be read.
#[cold]
pub(super) fn lacking<V: Values>(values: &V, lack: Lack, element: &Element, index: u64) -> Error {
    values.locate(match lack {
        Lack::Bad(error) => error,
        Lack::End => Error::bad_input(
            "FC204",
            format!("the file ends in {} {index} of {}", element.name, element.count),
        )
        .remedy("the file is cut off; copy or export it again"),
    })
}

/// Steps over one value or list.
pub(super) fn skip<V: Values>(values: &mut V, kind: Kind) -> Result<(), Lack> {
    match kind {
        Kind::One(scalar) => values.skip(scalar, 1),
        Kind::List { count, item } => {
            let n = list_length(values, count, item)?;
            values.skip(item, n)
        }
    }
}

fn skip_element<V: Values>(values: &mut V, element: &Element) -> Result<(), Error> {
    for index in 0..element.count {
        for property in &element.properties {
            skip(values, property.kind).map_err(|lack| lacking(values, lack, element, index))?;
        }
        values.end_record().map_err(|lack| lacking(values, lack, element, index))?;
    }
    Ok(())
}

/// Reads the length of a list and compares it with what is left of the file.
#[inline]
fn list_length<V: Values>(values: &mut V, count: Scalar, item: Scalar) -> Result<u64, Lack> {
    let n = values.integer(count)?;
    let Ok(n) = u64::try_from(n) else {
        return Err(Lack::Bad(
            Error::bad_input("FC206", format!("a list of length {n}")).remedy("export the file again"),
        ));
    };
    // Short lists need no check: the file ends soon enough.
    if n > 256 {
        let needed = values.smallest(item, n);
        let room = values.remaining().saturating_add(values.slack());
        if needed > room {
            return Err(Lack::Bad(
                Error::bad_input(
                    "FC205",
                    format!("a list of {n} values needs {needed} bytes, the file has {room} left"),
                )
                .limit(room, needed)
                .remedy("the file is cut off or damaged; copy or export it again"),
            ));
        }
    }
    Ok(n)
}

/// Polygons that came before the vertices.
#[derive(Default)]
struct Waiting {
    corners: Vec<u32>,
    ends: Vec<usize>,
}

impl Waiting {
    fn push(&mut self, corners: &[u32]) {
        self.corners.extend_from_slice(corners);
        self.ends.push(self.corners.len());
    }

    fn deliver(self, faces: &mut Faces, data: &VertexData) -> Result<(), Error> {
        let vertices = Vertices::new(&data.positions);
        let mut start = 0;
        for end in self.ends {
            faces.polygon(&vertices, self.corners.get(start..end).unwrap_or_default())?;
            start = end;
        }
        Ok(())
    }
}

/// Where polygons go: at once to the mesh when the vertices are known, otherwise they wait.
struct Polygons<'f, 'p> {
    faces: &'f mut Faces,
    known: Option<Vertices<'p>>,
    waiting: &'f mut Waiting,
    vertex_count: u64,
}

impl Polygons<'_, '_> {
    #[inline]
    fn push(&mut self, corners: &[u32]) -> Result<(), Error> {
        match &self.known {
            Some(vertices) => self.faces.polygon(vertices, corners),
            None => {
                self.waiting.push(corners);
                Ok(())
            }
        }
    }

    #[inline]
    fn check_index(&self, element: &Element, record: u64, index: i64) -> Result<u32, Error> {
        match u32::try_from(index) {
            Ok(small) if u64::from(small) < self.vertex_count => Ok(small),
            _ => Err(Error::bad_input(
                "FC203",
                format!("{} {record} uses vertex {index} of {}", element.name, self.vertex_count),
            )
            .remedy("vertices count from 0; export the file again")),
        }
    }

    fn read_faces<V: Values>(&mut self, values: &mut V, element: &Element) -> Result<(), Error> {
        let Some((which, count, item)) = index_list(element)? else { return Ok(()) };
        let before = element.properties.get(..which).unwrap_or_default();
        let after = element.properties.get(which.saturating_add(1)..).unwrap_or_default();
        self.faces.check_limit(element.count)?;
        let triangle = values.smallest(count, 1).saturating_add(values.smallest(item, 3)).max(1);
        let room = values.remaining().checked_div(triangle).unwrap_or(0).saturating_add(1);
        if self.known.is_some() {
            self.faces.reserve(element.count.min(room))?;
        }
        let mut corners: Vec<u32> = Vec::new();
        for record in 0..element.count {
            let mut read = |values: &mut V| -> Result<Result<(), Error>, Lack> {
                for property in before {
                    skip(values, property.kind)?;
                }
                let n = list_length(values, count, item)?;
                if n > CORNER_LIMIT {
                    return Ok(Err(too_many_corners(element, record, n)));
                }
                corners.clear();
                for _ in 0..n {
                    let index = values.integer(item)?;
                    match self.check_index(element, record, index) {
                        Ok(index) => corners.push(index),
                        Err(e) => return Ok(Err(e)),
                    }
                }
                for property in after {
                    skip(values, property.kind)?;
                }
                values.end_record()?;
                Ok(Ok(()))
            };
            match read(values) {
                Ok(Ok(())) => {}
                Ok(Err(e)) => return Err(values.locate(e)),
                Err(lack) => return Err(lacking(values, lack, element, record)),
            }
            self.push(&corners)?;
        }
        Ok(())
    }

    /// Reads strips: each corner after two makes a triangle, of alternating winding; -1 starts anew.
    fn read_strips<V: Values>(&mut self, values: &mut V, element: &Element) -> Result<(), Error> {
        let Some((which, count, item)) = index_list(element)? else { return Ok(()) };
        let restart_at_max = if item == Scalar::U32 { i64::from(u32::MAX) } else { -1 };
        for record in 0..element.count {
            for (i, property) in element.properties.iter().enumerate() {
                if i != which {
                    skip(values, property.kind).map_err(|lack| lacking(values, lack, element, record))?;
                    continue;
                }
                let n = list_length(values, count, item)
                    .map_err(|lack| lacking(values, lack, element, record))?;
                let mut strip = Strip::default();
                for _ in 0..n {
                    let index =
                        values.integer(item).map_err(|lack| lacking(values, lack, element, record))?;
                    if index == -1 || index == restart_at_max {
                        strip = Strip::default();
                        continue;
                    }
                    let index = self.check_index(element, record, index).map_err(|e| values.locate(e))?;
                    if let Some(triangle) = strip.next(index) {
                        self.push(&triangle)?;
                    }
                }
            }
            values.end_record().map_err(|lack| lacking(values, lack, element, record))?;
        }
        Ok(())
    }
}

/// The last two corners of a strip, and whether the next triangle is turned round.
#[derive(Default)]
struct Strip {
    last: [Option<u32>; 2],
    turned: bool,
}

impl Strip {
    fn next(&mut self, index: u32) -> Option<[u32; 3]> {
        let [before, last] = self.last;
        self.last = [last, Some(index)];
        let (before, last) = before.zip(last)?;
        let triangle = if self.turned { [last, before, index] } else { [before, last, index] };
        self.turned = !self.turned;
        Some(triangle)
    }
}

/// The list of vertex indices of a face or strip element: its place, length type and item type.
fn index_list(element: &Element) -> Result<Option<(usize, Scalar, Scalar)>, Error> {
    let found = element.properties.iter().enumerate().find_map(|(i, p)| match p.kind {
        Kind::List { count, item } if matches!(p.name.as_str(), "vertex_indices" | "vertex_index") => {
            Some((i, count, item))
        }
        _ => None,
    });
    match found {
        Some(list) if list.2.is_integer() => Ok(Some(list)),
        None if element.count == 0 => Ok(None),
        Some(_) => {
            Err(Error::bad_input("FC202", format!("the indices of element {} are no integers", element.name))
                .at_line(element.line)
                .remedy("export the file again"))
        }
        None => Err(Error::bad_input(
            "FC208",
            format!(
                "element {} needs a list vertex_indices or vertex_index; found: {}",
                element.name,
                element.listed()
            ),
        )
        .at_line(element.line)
        .remedy("export the file again as a mesh")),
    }
}

fn too_many_corners(element: &Element, record: u64, n: u64) -> Error {
    Error::new(
        ErrorKind::Limit,
        "FC503",
        format!("{} {record} has {n} corners, more than {MAX_CORNERS}", element.name),
    )
    .limit(CORNER_LIMIT, n)
    .remedy("split the polygon; if it should be small, the file is damaged")
}
