//! Puts the mesh instances of a scene together as one soup, a group each.

use gltf::Semantic;
use gltf::json::Root;
use gltf::json::accessor::{ComponentType, Type};
use gltf::json::mesh::{Mode, Primitive};
use gltf::json::validation::Checked;

use super::super::faces::{Faces, Vertices, reserve};
use super::super::soup::{Group, Positions, Soup};
use super::super::source::Source;
use super::super::tally::{MATERIALS, TEXTURES, Tally};
use super::accessor::{broken, find, whole};
use super::attributes::{Attributes, position_accessor};
use super::buffers::Buffers;
use super::nodes::{Instance, instances};
use super::transform::Transform;
use crate::error::{Error, ErrorKind};

/// Triangles of one primitive, or points and lines, which have none.
struct Piece {
    group: usize,
    triangles: Option<Vec<[u32; 3]>>,
    /// Indices at the end that make no triangle.
    leftover: bool,
}

/// Reads every mesh instance.
pub(super) fn assemble(
    root: &Root,
    buffers: &Buffers<'_>,
    source: &Source<'_>,
    tally: Tally,
) -> Result<Soup, Error> {
    let instances = instances(root)?;
    check_totals(root, &instances, source.max_faces())?;
    let mut faces = Faces::new(source.max_faces());
    faces.tally = tally;
    let keep_narrow = instances.iter().all(|i| i.transform == Transform::IDENTITY);
    let mut attributes = Attributes::default();
    let mut pieces = Vec::new();
    for (done, instance) in instances.iter().enumerate() {
        (source.progress())(share(source.size(), done as u64, instances.len() as u64), source.size());
        let determinant = instance.transform.determinant();
        if determinant == 0.0 {
            faces.tally.warn(
                "flattened_meshes",
                1,
                "meshes are flattened by a transform that scales by zero",
            );
        }
        if instance.skinned {
            faces.tally.warn(
                "ignored_skins",
                1,
                "skins are not applied; the meshes are read in their bind pose",
            );
        }
        let Some(mesh) = root.meshes.get(instance.mesh) else { continue };
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            let at = format!("meshes[{}].primitives[{p}]", instance.mesh);
            if primitive.targets.as_ref().is_some_and(|t| !t.is_empty()) {
                faces.tally.warn("ignored_morph_targets", 1, "morph targets are not applied");
            }
            let textured = |s: &Checked<Semantic>| matches!(s, Checked::Valid(Semantic::TexCoords(_)));
            if primitive.attributes.keys().any(textured) {
                faces.tally.warn("texture_coordinates", 1, TEXTURES);
            }
            if primitive.material.is_some() {
                faces.tally.warn("materials", 1, MATERIALS);
            }
            let mut piece = Piece { group: done, triangles: None, leftover: false };
            if let Some(mode) = surface_mode(primitive, &at)? {
                let first = attributes.count(keep_narrow);
                let count =
                    attributes.append(root, buffers, primitive, &instance.transform, keep_narrow, &at)?;
                let indices = read_indices(root, buffers, primitive, first, count, &at)?;
                let mut triangles = Vec::new();
                reserve(&mut triangles, triangle_count(mode, indices.len() as u64), "triangles")?;
                piece.leftover = to_triangles(mode, &indices, determinant < 0.0, &mut triangles);
                piece.triangles = Some(triangles);
            }
            pieces.push(piece);
        }
    }
    let [all, normals, colors] = attributes.having;
    for (having, code, what) in
        [(normals, "partial_normals", "normals"), (colors, "partial_colors", "colours")]
    {
        if having > 0 && having < all {
            faces.tally.warn(
                code,
                all.saturating_sub(having),
                format!("primitives have no {what} while others have"),
            );
        }
    }
    let normals = (normals > 0).then_some(attributes.normals);
    let colors = (colors > 0).then_some(attributes.colors);
    let positions =
        if keep_narrow { Positions::F32(attributes.narrow) } else { Positions::F64(attributes.wide) };

    let vertices = Vertices::new(&positions);
    let mut pieces = pieces.into_iter().peekable();
    let mut groups = Vec::new();
    for (index, instance) in instances.iter().enumerate() {
        let start = faces.triangles.len();
        while let Some(piece) = pieces.next_if(|p| p.group == index) {
            let Some(triangles) = piece.triangles else {
                faces.not_triangles();
                continue;
            };
            for triangle in &triangles {
                faces.polygon(&vertices, triangle)?;
            }
            if piece.leftover {
                faces.too_few();
            }
        }
        groups.push(Group { name: name(root, instance), triangles: start..faces.triangles.len() });
    }
    let (triangles, tally) = faces.finish(&vertices)?;
    Ok(Soup { positions, triangles, normals, colors, groups, tally })
}

fn share(size: u64, done: u64, of: u64) -> u64 {
    size.checked_div(of.max(1)).unwrap_or(0).saturating_mul(done)
}

fn name(root: &Root, instance: &Instance) -> String {
    let node = instance.node.and_then(|n| root.nodes.get(n)).and_then(|n| n.name.clone());
    let mesh = || root.meshes.get(instance.mesh).and_then(|m| m.name.clone());
    let named = node.filter(|n| !n.is_empty()).or_else(mesh).filter(|n| !n.is_empty());
    named.unwrap_or_else(|| format!("mesh {}", instance.mesh))
}

/// Refuses before the expansion what would not fit after it: a file of a kilobyte can place a mesh
/// a million times.
fn check_totals(root: &Root, instances: &[Instance], max_faces: u64) -> Result<(), Error> {
    let mut per_mesh = Vec::new();
    for (m, mesh) in root.meshes.iter().enumerate() {
        let (mut triangles, mut vertices) = (0u64, 0u64);
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            let at = format!("meshes[{m}].primitives[{p}]");
            let Some(mode) = surface_mode(primitive, &at)? else {
                // It makes no triangle, but a place in the books.
                triangles = triangles.saturating_add(1);
                continue;
            };
            let positions = find(root, position_accessor(primitive, &at)?, &at)?.count;
            let corners = match &primitive.indices {
                Some(index) => find(root, index.value(), &at)?.count,
                None => positions,
            };
            triangles = triangles.saturating_add(triangle_count(mode, corners));
            vertices = vertices.saturating_add(positions);
        }
        per_mesh.push((triangles, vertices));
    }
    let (mut triangles, mut vertices) = (0u64, 0u64);
    for (t, v) in instances.iter().filter_map(|i| per_mesh.get(i.mesh)) {
        triangles = triangles.saturating_add(*t);
        vertices = vertices.saturating_add(*v);
    }
    // A mesh of triangles uses at most three vertices each, so that more are no mesh either.
    let most = max_faces.saturating_mul(3).min((u32::MAX - 1).into());
    for (found, limit, what) in [(triangles, max_faces, "faces"), (vertices, most, "vertices")] {
        if found > limit {
            return Err(Error::new(
                ErrorKind::Limit,
                "FC501",
                format!(
                    "{} mesh instances have {found} {what}, more than the limit of {limit}",
                    instances.len()
                ),
            )
            .limit(limit, found)
            .remedy("export fewer instances or simpler meshes"));
        }
    }
    Ok(())
}

fn surface_mode(primitive: &Primitive, at: &str) -> Result<Option<Mode>, Error> {
    match primitive.mode {
        Checked::Valid(mode @ (Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan)) => Ok(Some(mode)),
        Checked::Valid(_) => Ok(None),
        Checked::Invalid => Err(broken("the mode is unknown", format!("{at}.mode"))),
    }
}

fn triangle_count(mode: Mode, corners: u64) -> u64 {
    match mode {
        Mode::Triangles => corners.checked_div(3).unwrap_or(0),
        _ => corners.saturating_sub(2),
    }
}

/// The corners of a primitive as numbers of the whole soup's vertices.
fn read_indices(
    root: &Root,
    buffers: &Buffers<'_>,
    primitive: &Primitive,
    first: u64,
    count: u64,
    at: &str,
) -> Result<Vec<u32>, Error> {
    let mut out = Vec::new();
    let outside = |index: u64, i: u64| {
        Error::bad_input("FC203", format!("index {i} uses vertex {index} of {count}"))
            .at_pointer(format!("{at}.indices"))
            .remedy("indices count from 0, and the highest one restarts nothing; export the file again")
    };
    let Some(indices) = &primitive.indices else {
        reserve(&mut out, count, "indices")?;
        for i in 0..count {
            out.push(
                u32::try_from(first.saturating_add(i))
                    .map_err(|_too_large: std::num::TryFromIntError| outside(i, i))?,
            );
        }
        return Ok(out);
    };
    let found = find(root, indices.value(), at)?;
    let unsigned = matches!(found.component, ComponentType::U8 | ComponentType::U16 | ComponentType::U32);
    if found.shape != Type::Scalar || !unsigned {
        return Err(broken(
            format!(
                "indices are {:?} of {:?}, not SCALAR of an unsigned integer",
                found.shape, found.component
            ),
            format!("accessors[{}].componentType", indices.value()),
        ));
    }
    reserve(&mut out, found.count, "indices")?;
    found.for_each(root, buffers, |element| {
        let index = whole(element, found.component).unwrap_or(u64::MAX);
        let global = u32::try_from(first.saturating_add(index)).ok().filter(|_| index < count);
        out.push(global.ok_or_else(|| outside(index, out.len() as u64))?);
        Ok(())
    })?;
    Ok(out)
}

/// Splits corners into triangles; true when some at the end make none.
fn to_triangles(mode: Mode, corners: &[u32], mirrored: bool, out: &mut Vec<[u32; 3]>) -> bool {
    let mut push = |[a, b, c]: [u32; 3]| out.push(if mirrored { [a, c, b] } else { [a, b, c] });
    match mode {
        Mode::Triangles => {
            let (whole, rest) = corners.as_chunks::<3>();
            whole.iter().copied().for_each(push);
            !rest.is_empty()
        }
        _ => {
            let fan = mode == Mode::TriangleFan;
            let apex = corners.first().copied().unwrap_or(0);
            for (i, window) in corners.windows(3).enumerate() {
                if let &[a, b, c] = window {
                    push(match (fan, i % 2) {
                        (true, _) => [apex, b, c],
                        (false, 0) => [a, b, c],
                        (false, _) => [b, a, c],
                    });
                }
            }
            corners.len() < 3
        }
    }
}
