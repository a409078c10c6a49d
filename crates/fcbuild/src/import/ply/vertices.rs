//! The vertex element of a PLY file: positions, and normals and colours where they are complete.

use super::super::faces::reserve;
use super::super::number::narrow;
use super::super::soup::Positions;
use super::body::lacking;
use super::header::{Element, Kind, Scalar};
use super::values::Values;
use crate::error::{Error, ErrorKind};

/// What is kept of the vertices.
pub(super) struct VertexData {
    pub(super) positions: Positions,
    pub(super) normals: Option<Vec<[f32; 3]>>,
    pub(super) colors: Option<Vec<[u8; 4]>>,
}

/// Where the values of a record go: coordinates 0 to 2, normal 3 to 5, colour 6 to 9.
const SLOTS: usize = 10;
const SLOT_NAMES: [&[&str]; SLOTS] = [
    &["x"],
    &["y"],
    &["z"],
    &["nx", "normal_x"],
    &["ny", "normal_y"],
    &["nz", "normal_z"],
    &["red", "r", "diffuse_red"],
    &["green", "g", "diffuse_green"],
    &["blue", "b", "diffuse_blue"],
    &["alpha", "a", "diffuse_alpha"],
];

enum Step {
    Keep { slot: usize, kind: Scalar },
    Skip(Kind),
}

/// Reads all records of the vertex element, whose count has been checked against the file's size.
pub(super) fn read<V: Values>(values: &mut V, element: &Element) -> Result<VertexData, Error> {
    if element.count > u64::from(u32::MAX - 1) {
        return Err(Error::new(
            ErrorKind::Limit,
            "FC501",
            format!("{} vertices do not fit 32-bit indices", element.count),
        )
        .remedy("split the model")
        .limit(u64::from(u32::MAX - 1), element.count));
    }
    let mut kinds: [Option<Scalar>; SLOTS] = [None; SLOTS];
    let mut steps = Vec::with_capacity(element.properties.len());
    for property in &element.properties {
        let slot = SLOT_NAMES.iter().position(|names| names.contains(&property.name.as_str()));
        let place = slot.and_then(|s| kinds.get_mut(s));
        steps.push(match (property.kind, slot, place) {
            (Kind::One(kind), Some(slot), Some(place @ None)) => {
                *place = Some(kind);
                Step::Keep { slot, kind }
            }
            (kind, ..) => Step::Skip(kind),
        });
    }
    let [x, y, z, nx, ny, nz, red, green, blue, alpha] = kinds;
    let (Some(x), Some(y), Some(z)) = (x, y, z) else {
        return Err(Error::bad_input(
            "FC208",
            format!("vertices need the scalar properties x, y and z; found: {}", element.listed()),
        )
        .at_line(element.line)
        .remedy("export the file again with positions"));
    };
    let mut narrow_positions = Vec::new();
    let mut wide_positions = Vec::new();
    let wide = ![x, y, z].into_iter().all(Scalar::fits_f32);
    if wide {
        reserve(&mut wide_positions, element.count, "vertices")?;
    } else {
        reserve(&mut narrow_positions, element.count, "vertices")?;
    }
    let mut normals = (nx.is_some() && ny.is_some() && nz.is_some()).then(Vec::new);
    let mut colors =
        red.zip(green).zip(blue).map(|((r, g), b)| (Vec::new(), [Some(r), Some(g), Some(b), alpha]));
    if let Some(list) = &mut normals {
        reserve(list, element.count, "normals")?;
    }
    if let Some((list, _)) = &mut colors {
        reserve(list, element.count, "colours")?;
    }

    let mut record = [0.0f64; SLOTS];
    for index in 0..element.count {
        for step in &steps {
            let outcome = match *step {
                Step::Keep { slot, kind } => values.float(kind).map(|value| {
                    if let Some(place) = record.get_mut(slot) {
                        *place = value;
                    }
                }),
                Step::Skip(kind) => super::body::skip(values, kind),
            };
            outcome.map_err(|lack| lacking(values, lack, element, index))?;
        }
        values.end_record().map_err(|lack| lacking(values, lack, element, index))?;
        let [x, y, z, nx, ny, nz, red, green, blue, alpha] = record;
        if wide {
            wide_positions.push([x, y, z]);
        } else {
            narrow_positions.push([x, y, z].map(narrow));
        }
        if let Some(list) = &mut normals {
            list.push([nx, ny, nz].map(narrow));
        }
        if let Some((list, [r, g, b, a])) = &mut colors {
            list.push([channel(red, *r), channel(green, *g), channel(blue, *b), channel(alpha, *a)]);
        }
    }
    let positions = if wide { Positions::F64(wide_positions) } else { Positions::F32(narrow_positions) };
    Ok(VertexData { positions, normals, colors: colors.map(|(list, _)| list) })
}

/// A colour channel as a byte: floats run from 0 to 1, 16-bit integers to 65,535, others to 255.
#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "the value is clamped; the cast saturates"
)]
fn channel(value: f64, kind: Option<Scalar>) -> u8 {
    let scaled = match kind {
        None => 255.0,
        Some(Scalar::F32 | Scalar::F64) => value * 255.0,
        Some(Scalar::U16) => value / 257.0,
        Some(_) => value,
    };
    (scaled.clamp(0.0, 255.0) + 0.5) as u8
}
