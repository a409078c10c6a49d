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
    /// Bytes of an element.
    size: u64,
    run: Option<Run>,
    index: usize,
    accessor: &'a Accessor,
}

/// Looks up an accessor and checks it against the document; its buffer is not opened yet.
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
    let size = (component.0.size() as u64).saturating_mul(shape.multiplicity() as u64);
    let offset = accessor.byte_offset.map_or(0, |o| o.0);
    let run = accessor.buffer_view.map(|v| Run { view: v.value(), offset, count, size, may_stride: true });
    if let Some(run) = run {
        run.check(root, &at("count"))?;
    }
    Ok(Found {
        count,
        component: component.0,
        normalized: accessor.normalized,
        shape,
        size,
        run,
        index,
        accessor,
    })
}

impl Found<'_> {
    /// Calls `take` with the bytes of each element, in order, sparse values in place.
    pub(super) fn for_each(
        &self,
        root: &Root,
        buffers: &Buffers<'_>,
        mut take: impl FnMut(&[u8]) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let size = self.size;
        let at = |field: &str| format!("accessors[{}].{field}", self.index);
        let base = match self.run {
            Some(run) => Some(run.open(root, buffers, &at("count"))?),
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
        let run = |view: usize, offset: u64, size: u64| Run { view, offset, count, size, may_stride: false };
        let indices = run(indices.buffer_view.value(), indices.byte_offset.0, wide);
        let indices = indices.open(root, buffers, &at("indices"))?;
        let values = run(values.buffer_view.value(), values.byte_offset.0, size);
        let values = values.open(root, buffers, &at("values"))?;
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

/// A run of elements in a buffer view.
#[derive(Clone, Copy)]
struct Run {
    view: usize,
    offset: u64,
    count: u64,
    /// Bytes of an element.
    size: u64,
    /// Whether the view's stride applies; for sparse data it does not.
    may_stride: bool,
}

impl Run {
    /// The stride, once the view as it is declared is known to hold the run.
    fn check(&self, root: &Root, from: &str) -> Result<u64, Error> {
        let Self { view, offset, count, size, .. } = *self;
        let Some(found) = root.buffer_views.get(view) else {
            return Err(broken(format!("refers to buffer view {view} of {}", root.buffer_views.len()), from));
        };
        let stride = match found.byte_stride {
            Some(stride) if self.may_stride && stride.0 > 0 => stride.0 as u64,
            _ => size,
        };
        if stride < size {
            return Err(broken(
                format!("a stride of {stride} bytes is less than the {size} of an element"),
                format!("bufferViews[{view}].byteStride"),
            ));
        }
        let steps = count.checked_sub(1).and_then(|n| n.checked_mul(stride));
        let end =
            steps.and_then(|n| n.checked_add(size)).and_then(|n| n.checked_add(offset)).unwrap_or(u64::MAX);
        let length = found.byte_length.0;
        if end > length {
            return Err(broken(
                format!(
                    "{count} elements from byte {offset} on do not lie in the buffer view of {length} bytes"
                ),
                from,
            )
            .limit(length, end));
        }
        Ok(stride)
    }

    /// The elements, once the view is known to lie in its buffer.
    fn open<'b>(&self, root: &Root, buffers: &'b Buffers<'_>, from: &str) -> Result<Strided<'b>, Error> {
        let stride = self.check(root, from)?;
        let at = format!("bufferViews[{}].byteLength", self.view);
        let Some(found) = root.buffer_views.get(self.view) else {
            return Err(broken("there is no such view", at));
        };
        let buffer = buffers.get(found.buffer.value())?;
        let (start, length) = (found.byte_offset.map_or(0, |o| o.0), found.byte_length.0);
        let range = start
            .checked_add(length)
            .and_then(|end| Some(usize::try_from(start).ok()?..usize::try_from(end).ok()?));
        let view = range.and_then(|range| buffer.get(range));
        match view.and_then(|bytes| bytes.get(usize::try_from(self.offset).ok()?..)) {
            Some(bytes) => Ok(Strided { bytes, stride, size: self.size }),
            None => Err(broken(
                format!(
                    "{length} bytes from byte {start} on do not lie in the buffer of {} bytes",
                    buffer.len()
                ),
                at,
            )),
        }
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
