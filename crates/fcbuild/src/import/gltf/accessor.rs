//! Reading arrays of numbers out of buffers, every offset checked in 64 bits.

use gltf::json::accessor::{ComponentType, Type};
use gltf::json::validation::Checked;
use gltf::json::{Accessor, Root};

use super::super::faces::reserve;
use super::buffers::Buffers;
use crate::error::{Error, ErrorKind};

/// Most elements of an accessor without a buffer view, which takes no bytes of the file per element.
const MAX_ZEROS: u64 = 1 << 20;

/// An accessor whose type and place have been checked.
pub(super) struct Found<'a> {
    pub(super) count: u64,
    pub(super) component: ComponentType,
    pub(super) normalized: bool,
    pub(super) shape: Type,
    index: usize,
    accessor: &'a Accessor,
}

/// Looks up an accessor and its types.
pub(super) fn find<'a>(root: &'a Root, index: usize, from: &str) -> Result<Found<'a>, Error> {
    let Some(accessor) = root.accessors.get(index) else {
        return Err(broken(format!("refers to accessor {index} of {}", root.accessors.len()), from));
    };
    let at = |field: &str| format!("accessors[{index}].{field}");
    let Checked::Valid(component) = accessor.component_type else {
        return Err(broken("the component type is unknown", at("componentType")));
    };
    let Checked::Valid(shape) = accessor.type_ else {
        return Err(broken("the type is unknown", at("type")));
    };
    let count = accessor.count.0;
    if count == 0 {
        return Err(broken("there are no elements", at("count")));
    }
    if accessor.buffer_view.is_none() && count > MAX_ZEROS {
        return Err(Error::new(ErrorKind::Limit, "FC504", format!("{count} elements without data"))
            .at_pointer(at("count"))
            .limit(MAX_ZEROS, count)
            .remedy("export the file again"));
    }
    Ok(Found { count, component: component.0, normalized: accessor.normalized, shape, index, accessor })
}

impl Found<'_> {
    /// Calls `take` with the bytes of each element, in order, sparse values in place.
    pub(super) fn for_each(
        &self,
        root: &Root,
        buffers: &Buffers<'_>,
        mut take: impl FnMut(&[u8]) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let size = (self.component.size() as u64).saturating_mul(self.shape.multiplicity() as u64);
        let at = |field: &str| format!("accessors[{}].{field}", self.index);
        let base = match self.accessor.buffer_view {
            Some(view) => {
                let offset = self.accessor.byte_offset.map_or(0, |o| o.0);
                Some(slice(root, buffers, view.value(), offset, self.count, size, true, &at("count"))?)
            }
            None => None,
        };
        let zeros = [0u8; 64];
        let zero = zeros.get(..usize::try_from(size).unwrap_or(usize::MAX)).unwrap_or_default();
        let mut sparse = self.sparse(root, buffers, size)?.into_iter().peekable();
        for i in 0..self.count {
            let element = match sparse.next_if(|(place, _)| *place == i) {
                Some((_, value)) => value,
                None => base.as_ref().map_or(Some(zero), |b| b.element(i)).unwrap_or_default(),
            };
            take(element)?;
        }
        Ok(())
    }

    /// The elements that replace those of the base, by rising index.
    fn sparse<'b>(
        &self,
        root: &Root,
        buffers: &'b Buffers<'_>,
        size: u64,
    ) -> Result<Vec<(u64, &'b [u8])>, Error> {
        let Some(sparse) = &self.accessor.sparse else { return Ok(Vec::new()) };
        let at = |field: &str| format!("accessors[{}].sparse.{field}", self.index);
        let count = sparse.count.0;
        if count == 0 || count > self.count {
            return Err(broken(format!("{count} of {} elements are sparse", self.count), at("count")));
        }
        let Checked::Valid(kind) = sparse.indices.component_type else {
            return Err(broken("the component type is unknown", at("indices.componentType")));
        };
        let wide = kind.0.size() as u64;
        let (indices, values) = (&sparse.indices, &sparse.values);
        let view = indices.buffer_view.value();
        let indices = slice(root, buffers, view, indices.byte_offset.0, count, wide, false, &at("indices"))?;
        let view = values.buffer_view.value();
        let values = slice(root, buffers, view, values.byte_offset.0, count, size, false, &at("values"))?;
        let mut out = Vec::new();
        reserve(&mut out, count, "sparse elements")?;
        let mut least = 0;
        for i in 0..count {
            let index = indices.element(i).and_then(|b| whole(b, kind.0)).unwrap_or(u64::MAX);
            if index < least || index >= self.count {
                return Err(broken(
                    format!("index {index} is out of order or beyond {} elements", self.count),
                    at("indices"),
                ));
            }
            least = index.saturating_add(1);
            out.push((index, values.element(i).unwrap_or_default()));
        }
        Ok(out)
    }
}

/// Elements at a fixed distance in a buffer, all within it.
struct Strided<'b> {
    bytes: &'b [u8],
    stride: u64,
    size: u64,
}

impl<'b> Strided<'b> {
    #[inline]
    fn element(&self, i: u64) -> Option<&'b [u8]> {
        let start = i.checked_mul(self.stride)?;
        let end = start.checked_add(self.size)?;
        self.bytes.get(usize::try_from(start).ok()?..usize::try_from(end).ok()?)
    }
}

#[allow(clippy::too_many_arguments, reason = "the numbers of one bounds check")]
fn slice<'b>(
    root: &Root,
    buffers: &'b Buffers<'_>,
    view: usize,
    offset: u64,
    count: u64,
    size: u64,
    may_stride: bool,
    from: &str,
) -> Result<Strided<'b>, Error> {
    let at = |field: &str| format!("bufferViews[{view}].{field}");
    let Some(found) = root.buffer_views.get(view) else {
        return Err(broken(format!("refers to buffer view {view} of {}", root.buffer_views.len()), from));
    };
    let buffer = buffers.get(found.buffer.value())?;
    let start = found.byte_offset.map_or(0, |o| o.0);
    let end = start.checked_add(found.byte_length.0);
    let bounds = end.and_then(|end| Some(usize::try_from(start).ok()?..usize::try_from(end).ok()?));
    let Some(view_bytes) = bounds.and_then(|range| buffer.get(range)) else {
        return Err(broken(
            format!(
                "{} bytes from byte {start} on do not lie in the buffer of {} bytes",
                found.byte_length.0,
                buffer.len()
            ),
            at("byteLength"),
        ));
    };
    let stride = match found.byte_stride {
        Some(stride) if may_stride && stride.0 > 0 => stride.0 as u64,
        _ => size,
    };
    if stride < size {
        return Err(broken(
            format!("a stride of {stride} bytes is less than the {size} of an element"),
            at("byteStride"),
        ));
    }
    let needed = count.checked_sub(1).and_then(|n| n.checked_mul(stride)).and_then(|n| n.checked_add(size));
    let bytes = usize::try_from(offset).ok().and_then(|o| view_bytes.get(o..));
    match (bytes, needed) {
        (Some(bytes), Some(needed)) if needed <= bytes.len() as u64 => Ok(Strided { bytes, stride, size }),
        _ => Err(broken(
            format!(
                "{count} elements from byte {offset} on do not lie in the buffer view of {} bytes",
                view_bytes.len()
            ),
            from,
        )
        .limit(view_bytes.len() as u64, needed.unwrap_or(u64::MAX))),
    }
}

/// A whole number of an unsigned type.
pub(super) fn whole(bytes: &[u8], kind: ComponentType) -> Option<u64> {
    match kind {
        ComponentType::U8 => bytes.first().map(|&b| b.into()),
        ComponentType::U16 => bytes.first_chunk().map(|b| u16::from_le_bytes(*b).into()),
        ComponentType::U32 => bytes.first_chunk().map(|b| u32::from_le_bytes(*b).into()),
        _ => None,
    }
}

/// Component `i` of an element as a float; normalized integers run from 0 or -1 to 1.
pub(super) fn float(bytes: &[u8], kind: ComponentType, normalized: bool, i: usize) -> f64 {
    let part = bytes.get(i.saturating_mul(kind.size())..).unwrap_or_default();
    let (value, one) = match kind {
        ComponentType::F32 => return part.first_chunk().map_or(0.0, |b| f32::from_le_bytes(*b).into()),
        ComponentType::I8 => (part.first_chunk().map_or(0.0, |b| i8::from_le_bytes(*b).into()), 127.0),
        ComponentType::U8 => (part.first_chunk().map_or(0.0, |b| u8::from_le_bytes(*b).into()), 255.0),
        ComponentType::I16 => (part.first_chunk().map_or(0.0, |b| i16::from_le_bytes(*b).into()), 32767.0),
        ComponentType::U16 => (part.first_chunk().map_or(0.0, |b| u16::from_le_bytes(*b).into()), 65535.0),
        ComponentType::U32 => {
            (part.first_chunk().map_or(0.0, |b| u32::from_le_bytes(*b).into()), 4_294_967_295.0)
        }
    };
    if normalized { f64::max(value / one, -1.0) } else { value }
}

pub(super) fn broken(message: impl Into<String>, pointer: impl Into<String>) -> Error {
    Error::bad_input("FC211", message).at_pointer(pointer).remedy("export the file again")
}
