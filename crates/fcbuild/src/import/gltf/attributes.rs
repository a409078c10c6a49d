//! The vertices of the primitives, moved to their places: positions, normals and colours.

use gltf::Semantic;
use gltf::json::Root;
use gltf::json::accessor::{ComponentType, Type};
use gltf::json::mesh::Primitive;
use gltf::json::validation::Checked;

use super::super::faces::reserve;
use super::super::number::narrow;
use super::accessor::{self, broken, find, float};
use super::buffers::Buffers;
use super::transform::Transform;
use crate::error::Error;

/// Vertices of all instances so far.
#[derive(Default)]
pub(super) struct Attributes {
    pub(super) narrow: Vec<[f32; 3]>,
    pub(super) wide: Vec<[f64; 3]>,
    pub(super) normals: Vec<[f32; 3]>,
    pub(super) colors: Vec<[u8; 4]>,
    /// How many primitives have positions, normals, colours.
    pub(super) having: [u64; 3],
}

impl Attributes {
    /// How many vertices there are.
    pub(super) fn count(&self, keep_narrow: bool) -> u64 {
        if keep_narrow { self.narrow.len() as u64 } else { self.wide.len() as u64 }
    }

    /// Appends the vertices of a primitive and returns how many they are.
    pub(super) fn append(
        &mut self,
        root: &Root,
        buffers: &Buffers<'_>,
        primitive: &Primitive,
        transform: &Transform,
        keep_narrow: bool,
        at: &str,
    ) -> Result<u64, Error> {
        let quantized = root.extensions_used.iter().any(|e| e == "KHR_mesh_quantization");
        let positions = find(root, position_accessor(primitive, at)?, at)?;
        if positions.shape != Type::Vec3 || !(positions.component == ComponentType::F32 || quantized) {
            return Err(Error::bad_input(
                "FC208",
                format!("POSITION is {:?} of {:?}, not VEC3 of FLOAT", positions.shape, positions.component),
            )
            .at_pointer(format!("{at}.attributes.POSITION"))
            .remedy("export the file again"));
        }
        let triple = |element: &[u8], from: &accessor::Found<'_>| {
            [0, 1, 2].map(|i| float(element, from.component, from.normalized, i))
        };
        if keep_narrow {
            reserve(&mut self.narrow, positions.count, "vertices")?;
        } else {
            reserve(&mut self.wide, positions.count, "vertices")?;
        }
        positions.for_each(root, buffers, |element| {
            let point = triple(element, &positions);
            if keep_narrow {
                self.narrow.push(point.map(narrow));
            } else {
                self.wide.push(transform.point(point));
            }
            Ok(())
        })?;

        let [all, with_normals, with_colors] = &mut self.having;
        *all = all.saturating_add(1);
        let total = if keep_narrow { self.narrow.len() } else { self.wide.len() };
        let start = total.saturating_sub(usize::try_from(positions.count).unwrap_or(0));
        if let Some(index) = primitive.attributes.get(&Checked::Valid(Semantic::Normals)) {
            *with_normals = with_normals.saturating_add(1);
            let normals = find(root, index.value(), at)?;
            same_count(&normals, positions.count, Type::Vec3, &format!("{at}.attributes.NORMAL"))?;
            // Earlier primitives without normals get zero ones.
            self.normals.resize(start, [0.0; 3]);
            normals.for_each(root, buffers, |element| {
                self.normals.push(transform.normal(triple(element, &normals)).map(narrow));
                Ok(())
            })?;
        } else if *with_normals > 0 {
            self.normals.resize(total, [0.0; 3]);
        }
        if let Some(index) = primitive.attributes.get(&Checked::Valid(Semantic::Colors(0))) {
            *with_colors = with_colors.saturating_add(1);
            let colors = find(root, index.value(), at)?;
            let opaque = colors.shape == Type::Vec3;
            let shape = if opaque { Type::Vec3 } else { Type::Vec4 };
            same_count(&colors, positions.count, shape, &format!("{at}.attributes.COLOR_0"))?;
            self.colors.resize(start, [255; 4]);
            colors.for_each(root, buffers, |element| {
                let channel = |i: usize| byte(float(element, colors.component, true, i));
                let alpha = if opaque { 255 } else { channel(3) };
                self.colors.push([channel(0), channel(1), channel(2), alpha]);
                Ok(())
            })?;
        } else if *with_colors > 0 {
            self.colors.resize(total, [255; 4]);
        }
        Ok(positions.count)
    }
}

/// A channel from 0..1 as a byte.
#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "the value is clamped; the cast saturates"
)]
fn byte(x: f64) -> u8 {
    (x.clamp(0.0, 1.0) * 255.0 + 0.5) as u8
}

fn same_count(found: &accessor::Found<'_>, count: u64, shape: Type, at: &str) -> Result<(), Error> {
    if found.count != count {
        return Err(broken(format!("there are {} values for {count} positions", found.count), at));
    }
    if found.shape != shape {
        return Err(broken(format!("the type {:?} does not fit", found.shape), at));
    }
    Ok(())
}

/// The accessor of the positions, which every primitive must have.
pub(super) fn position_accessor(primitive: &Primitive, at: &str) -> Result<usize, Error> {
    match primitive.attributes.get(&Checked::Valid(Semantic::Positions)) {
        Some(index) => Ok(index.value()),
        None => Err(Error::bad_input("FC208", "the primitive has no POSITION")
            .at_pointer(format!("{at}.attributes"))
            .remedy("export the file again")),
    }
}
