//! What a chunk's top holds beside its top nodes: copies of its pages' roots, and of the vertices to draw those with.

use zerocopy::IntoBytes;

use super::belongs;
use super::build::{Source, append_vertices, broken, count, vertex_of};
use crate::loops::{Loops, MORE_LOOPS, NO_LOOPS};
use crate::outline::stores_loops;
use crate::pack::push_varint;
use crate::subtree::{Place, Subtree};
use crate::walk::{Broken, Reader};

/// A chunk's part of section `CHTP`.
pub(super) fn of_chunk(source: &Source<'_>, chunk: &Subtree) -> Result<Vec<u8>, Broken> {
    let reader = &source.reader;
    let (mut out, mut roots, mut vertices) = (Vec::new(), Vec::new(), Vec::new());
    let mut loops = Loops::default();
    let mut stack = vec![*chunk];
    while let Some(subtree) = stack.pop() {
        if let Place::Page { page, record, .. } = subtree.place {
            let mut stored = false;
            if subtree.face_count() > 1 {
                let (_, node) = reader.page_node(page, record, &subtree)?;
                out.extend_from_slice(node.as_bytes());
                stored = stores_loops(node, subtree.face_count());
            }
            append_root(reader, &subtree, stored, &mut roots)?;
            vertices.push(reader.corner_of(&subtree)?);
        } else {
            let [left, right] = reader.split(&subtree)?;
            stack.push(right);
            stack.push(left);
        }
        // The chunk's root is drawn from the crown.
        if subtree.first_face == chunk.first_face && subtree.face_end == chunk.face_end {
            continue;
        }
        let keys = if subtree.face_count() > 1 {
            let node = reader.decode(&subtree)?;
            [node.bound, node.budget]
        } else {
            [0.0; 2]
        };
        if keys[0] == f32::INFINITY {
            continue;
        }
        reader.load_loops(&subtree, &mut loops)?;
        for &vertex in &loops.vertices {
            if belongs(vertex_of(reader, vertex, &subtree)?, keys) {
                vertices.push(vertex);
            }
        }
    }
    vertices.sort_unstable();
    vertices.dedup();
    out.append(&mut roots);
    push_varint(count(vertices.len())?.get(), &mut out);
    let mut before = 0_u32;
    for &vertex in &vertices {
        push_varint(vertex.saturating_sub(before), &mut out);
        before = vertex;
    }
    append_vertices(source, &vertices, &mut out)?;
    Ok(out)
}

/// Appends the first corner of a page's first face and the loops of its root, as local indices.
///
/// Loops that are stored are copied; those that follow from faces, which meet no vertex twice, begin with their lowest
/// vertex and stand in the order of those.
fn append_root(
    reader: &Reader<'_>,
    subtree: &Subtree,
    stored: bool,
    out: &mut Vec<u8>,
) -> Result<(), Broken> {
    let lost = || broken(subtree.to_string());
    let (page, root) = reader.page(subtree).ok_or_else(lost)?;
    let face = page.first_face(&root).ok_or_else(lost)?;
    let [corner, ..] = face;
    out.push(corner);
    let mut rings: Vec<Vec<u8>> = Vec::new();
    if subtree.face_count() == 1 {
        rings.push(face.to_vec());
    } else {
        page.rings(&root, |ring| rings.push(ring.to_vec())).ok_or_else(lost)?;
    }
    if !stored {
        for ring in &mut rings {
            let lowest = ring.iter().enumerate().min_by_key(|(_, vertex)| **vertex);
            let start = lowest.map_or(0, |(at, _)| at);
            ring.rotate_left(start);
        }
        rings.sort_unstable();
    }
    if rings.is_empty() {
        out.push(NO_LOOPS);
    }
    let mut left = rings.len();
    for ring in &rings {
        left = left.saturating_sub(1);
        if left > 0 {
            out.push(MORE_LOOPS);
        }
        out.push(u8::try_from(ring.len()).ok().filter(|n| *n > NO_LOOPS).ok_or_else(lost)?);
        out.extend_from_slice(ring);
    }
    Ok(())
}
