//! PLY: ASCII and both byte orders, any element order, polygons and triangle strips.
//!
//! The file is streamed: memory is bounded by what its size can hold, because every count is
//! compared with the bytes that are left before room is made for it.

mod body;
mod header;
mod values;
mod vertices;

use header::Encoding;
use values::{Binary, Text};

use super::faces::{Faces, Vertices};
use super::soup::{Group, Soup};
use super::source::Source;
use super::window::Window;
use crate::error::Error;

/// Reads a PLY file into one group named after the file.
pub(super) fn read(source: &mut Source<'_>) -> Result<Soup, Error> {
    let name = source.stem();
    let mut faces = Faces::new(source.max_faces());
    let mut window = source.window();
    let read = read_window(&mut window, &mut faces);
    // A failing disk looks like an early end to the parser: its error is the truer one.
    if let Some(e) = window.take_failure() {
        return Err(source.read_error(&e));
    }
    let vertices = read?;
    let (triangles, tally) = faces.finish(&Vertices::new(&vertices.positions))?;
    Ok(Soup {
        positions: vertices.positions,
        normals: vertices.normals,
        colors: vertices.colors,
        groups: vec![Group { name, triangles: 0..triangles.len() }],
        triangles,
        tally,
    })
}

fn read_window(window: &mut Window<'_>, faces: &mut Faces) -> Result<vertices::VertexData, Error> {
    let header = header::read(window)?;
    let line = header.lines.saturating_add(1);
    match header.encoding {
        Encoding::Ascii => body::read(&mut Text::new(window, line), &header, faces),
        Encoding::Little => body::read(&mut Binary::<false>::new(window), &header, faces),
        Encoding::Big => body::read(&mut Binary::<true>::new(window), &header, faces),
    }
}

#[cfg(test)]
mod tests;
