//! Binary STL: 80 bytes of anything, a count, and 50 bytes a triangle.

use super::super::faces::{Faces, Vertices, reserve};
use super::super::soup::{Group, Positions, Soup};
use super::super::source::Source;
use crate::error::{Error, ErrorKind};

const HEADER: u64 = 84;
const RECORD: u64 = 50;
/// Three vertices a triangle must fit 32-bit indices.
const MAX_TRIANGLES: u64 = (u32::MAX as u64 - 1) / 3;

/// Whether the size is exactly that of the triangles which the count after the header declares.
///
/// This rule wins over the word `solid`, which many programs write into binary headers.
pub(in super::super) fn size_fits(head: &[u8], size: u64) -> bool {
    declared(head).is_some_and(|n| n > 0 && size_for(n) == size)
}

fn declared(head: &[u8]) -> Option<u64> {
    head.get(80..84)?.first_chunk::<4>().map(|b| u32::from_le_bytes(*b).into())
}

fn size_for(n: u64) -> u64 {
    HEADER.saturating_add(RECORD.saturating_mul(n))
}

/// Reads a binary STL file into one group named after the file.
pub(in super::super) fn read(source: &mut Source<'_>) -> Result<Soup, Error> {
    let head = source.first_bytes(HEADER)?;
    let size = source.size();
    let Some(n) = declared(&head) else {
        return Err(Error::bad_input(
            "FC204",
            format!("a binary STL file has at least {HEADER} bytes, this one {size}"),
        )
        .at_byte(size)
        .remedy("the file is cut off; copy or export it again"));
    };
    if size_for(n) != size {
        let holds = size.saturating_sub(HEADER).checked_div(RECORD).unwrap_or(0);
        return Err(Error::bad_input(
            "FC205",
            format!("the header declares {n} triangles, the size of {size} bytes is that of {holds}"),
        )
        .at_byte(80)
        .limit(holds, n)
        .remedy("the file is cut off or damaged; copy or export it again"));
    }
    if n > MAX_TRIANGLES {
        return Err(Error::new(
            ErrorKind::Limit,
            "FC501",
            format!("{n} triangles have vertices beyond 32-bit indices"),
        )
        .limit(MAX_TRIANGLES, n)
        .remedy("split the model"));
    }
    let mut faces = Faces::new(source.max_faces());
    faces.reserve(n)?;
    let mut points: Vec<[f32; 3]> = Vec::new();
    reserve(&mut points, n.saturating_mul(3), "vertices")?;
    let name = source.stem();
    let mut window = source.window();
    window.skip(HEADER);
    for index in 0..n {
        let Some(record) = window.take::<50>() else {
            let byte = window.offset();
            return Err(match window.take_failure() {
                Some(e) => source.read_error(&e),
                None => Error::bad_input("FC204", format!("the file ends in triangle {index} of {n}"))
                    .at_byte(byte),
            });
        };
        for corner in record.get(12..48).unwrap_or_default().as_chunks::<12>().0 {
            let mut point = [0.0; 3];
            for (x, bytes) in point.iter_mut().zip(corner.as_chunks::<4>().0) {
                *x = f32::from_le_bytes(*bytes);
            }
            points.push(point);
        }
    }
    let positions = Positions::F32(points);
    let vertices = Vertices::new(&positions);
    for triangle in 0..u32::try_from(n).unwrap_or(0) {
        let first = triangle.saturating_mul(3);
        faces.polygon(&vertices, &[first, first.saturating_add(1), first.saturating_add(2)])?;
    }
    let (triangles, tally) = faces.finish(&vertices)?;
    let groups = vec![Group { name, triangles: 0..triangles.len() }];
    Ok(Soup { positions, triangles, normals: None, colors: None, groups, tally })
}
