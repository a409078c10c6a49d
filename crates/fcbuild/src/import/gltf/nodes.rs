//! Which meshes stand where: a walk over the node tree without recursion.

use gltf::json::Root;

use super::accessor::broken;
use super::transform::Transform;
use crate::error::{Error, ErrorKind};

/// Deepest chain of nodes.
const MAX_DEPTH: u32 = 1024;

/// A mesh at its place in the scene.
pub(super) struct Instance {
    pub(super) mesh: usize,
    pub(super) node: Option<usize>,
    pub(super) transform: Transform,
    pub(super) skinned: bool,
}

/// All mesh instances of the default scene, in the order of its tree.
pub(super) fn instances(root: &Root) -> Result<Vec<Instance>, Error> {
    let parents = parents(root)?;
    let mut stack: Vec<(usize, Transform, u32)> = Vec::new();
    match root.scene.as_ref().map_or(0, |s| s.value()) {
        index if index < root.scenes.len() => {
            let nodes = root.scenes.get(index).map(|s| s.nodes.as_slice()).unwrap_or_default();
            let mut seen = vec![false; root.nodes.len()];
            for (i, node) in nodes.iter().enumerate() {
                let at = format!("scenes[{index}].nodes[{i}]");
                let node = node.value();
                match (seen.get_mut(node), parents.get(node)) {
                    (Some(seen @ false), Some(None)) => *seen = true,
                    (Some(true), _) => {
                        return Err(broken(format!("node {node} stands twice in the scene"), at));
                    }
                    (_, Some(Some(parent))) => {
                        return Err(broken(
                            format!("node {node} is a child of node {parent}, so no root"),
                            at,
                        ));
                    }
                    _ => return Err(broken(format!("refers to node {node} of {}", root.nodes.len()), at)),
                }
                stack.push((node, Transform::IDENTITY, 1));
            }
        }
        0 => {
            // No scene: every root of the node trees.
            let roots = parents.iter().enumerate().filter(|(_, p)| p.is_none());
            stack.extend(roots.map(|(i, _)| (i, Transform::IDENTITY, 1)));
        }
        index => return Err(broken(format!("refers to scene {index} of {}", root.scenes.len()), "scene")),
    }
    stack.reverse();

    let mut out = Vec::new();
    while let Some((index, outer, depth)) = stack.pop() {
        let Some(node) = root.nodes.get(index) else { continue };
        if depth > MAX_DEPTH {
            return Err(Error::new(
                ErrorKind::Limit,
                "FC504",
                format!("the nodes nest deeper than {MAX_DEPTH}"),
            )
            .at_pointer(format!("nodes[{index}]"))
            .limit(MAX_DEPTH.into(), depth.into())
            .remedy("flatten the scene"));
        }
        let own = Transform::of(node).map_err(|what| broken(what, format!("nodes[{index}]")))?;
        let transform = outer.after(&own);
        if let Some(mesh) = node.mesh.as_ref().map(|m| m.value()) {
            if mesh >= root.meshes.len() {
                let at = format!("nodes[{index}].mesh");
                return Err(broken(format!("refers to mesh {mesh} of {}", root.meshes.len()), at));
            }
            out.push(Instance { mesh, node: Some(index), transform, skinned: node.skin.is_some() });
        }
        let children = node.children.iter().flatten().rev();
        stack.extend(children.map(|c| (c.value(), transform, depth.saturating_add(1))));
    }
    if root.nodes.is_empty() {
        let bare = |mesh| Instance { mesh, node: None, transform: Transform::IDENTITY, skinned: false };
        out.extend((0..root.meshes.len()).map(bare));
    }
    Ok(out)
}

/// The parent of each node. Fails unless the nodes are trees: a second parent or a cycle would make
/// a walk repeat itself or never end.
fn parents(root: &Root) -> Result<Vec<Option<usize>>, Error> {
    let count = root.nodes.len();
    let mut parents: Vec<Option<usize>> = vec![None; count];
    for (index, node) in root.nodes.iter().enumerate() {
        for (i, child) in node.children.iter().flatten().enumerate() {
            let at = format!("nodes[{index}].children[{i}]");
            let child = child.value();
            match parents.get_mut(child) {
                None => return Err(broken(format!("refers to node {child} of {count}"), at)),
                Some(Some(other)) => {
                    return Err(broken(format!("node {child} has two parents, {other} and {index}"), at));
                }
                Some(place) => *place = Some(index),
            }
        }
    }
    // With one parent at most, following parents from any node either ends or goes round a cycle.
    let mut settled = vec![false; count];
    let mut path = Vec::new();
    for start in 0..count {
        path.clear();
        let mut at = Some(start);
        while let Some(node) = at.filter(|&n| settled.get(n) == Some(&false)) {
            path.push(node);
            if let Some(mark) = settled.get_mut(node) {
                *mark = true;
            }
            at = parents.get(node).copied().flatten();
        }
        if let Some(from) = at.and_then(|node| path.iter().position(|&p| p == node)) {
            let cycle: Vec<String> = path.iter().skip(from).take(10).map(usize::to_string).collect();
            let at = format!("nodes[{}]", cycle.first().map_or("0", String::as_str));
            return Err(broken(
                format!("the nodes form a cycle: each of {} is a child of the next", cycle.join(", ")),
                at,
            ));
        }
    }
    Ok(parents)
}
