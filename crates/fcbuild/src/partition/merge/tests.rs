use super::*;
use crate::import::{Positions, Soup, Tally};
use crate::mesh::Weld;
use crate::partition::hierarchy::depth;
use crate::partition::partition;

/// A bumpy sheet of `n` by `n` quads.
fn sheet(n: u32) -> Mesh {
    let mut positions = Vec::new();
    for y in 0..=n {
        for x in 0..=n {
            let bump = ((x * 7 + y * 13) % 11) as f32 / 11.0 + ((x * x + 3 * y) % 17) as f32 / 17.0;
            positions.push([x as f32, y as f32, bump]);
        }
    }
    let mut triangles = Vec::new();
    for y in 0..n {
        for x in 0..n {
            let a = y * (n + 1) + x;
            triangles.push([a, a + 1, a + n + 2]);
            triangles.push([a, a + n + 2, a + n + 1]);
        }
    }
    mesh_of(&positions, triangles)
}

fn mesh_of(positions: &[[f32; 3]], triangles: Vec<[u32; 3]>) -> Mesh {
    let soup = Soup {
        tally: Tally::default(),
        positions: Positions::F32(positions.to_vec()),
        triangles,
        normals: None,
        colors: None,
        groups: Vec::new(),
    };
    Mesh::from_soup(soup, Weld::Exact).unwrap()
}

/// Every cluster of the tree, by its faces, must be connected.
fn assert_connected(mesh: &Mesh, tree: &Hierarchy) {
    let mut stack = vec![(0, 0, tree.order.len())];
    while let Some((node, first, faces)) = stack.pop() {
        if faces < 2 {
            continue;
        }
        let split = &tree.splits[node];
        let inside: std::collections::BTreeSet<u32> =
            tree.order[first..first + faces].iter().copied().collect();
        if !split.joins_components {
            let mut seen = std::collections::BTreeSet::from([tree.order[first]]);
            let mut open = vec![tree.order[first]];
            while let Some(f) = open.pop() {
                for e in 0..3 {
                    let across = mesh.graph.opposite[3 * f as usize + e];
                    if across != NONE && inside.contains(&(across / 3)) && seen.insert(across / 3) {
                        open.push(across / 3);
                    }
                }
            }
            assert_eq!(seen.len(), faces);
        }
        let left = split.left_faces as usize;
        stack.push((node + left, first + left, faces - left));
        stack.push((node + 1, first, left));
    }
}

#[test]
fn trees_hold_every_face_once_in_connected_clusters_for_any_number_of_threads() {
    let mesh = sheet(70);
    let components = Components::of(&mesh);
    for rule in [Rule::Quality, Rule::Garland] {
        let build = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| merge_all(&mesh, &components, rule, None, &|_| ()).unwrap())
        };
        let tree = build(1);
        let mut order = tree.order.clone();
        order.sort_unstable();
        assert!(order.iter().copied().eq(0..mesh.faces.len() as u32));
        assert_connected(&mesh, &tree);
        // Noise is the worst there is: flat islands in a rough sea.
        assert!(tree.depth <= DEPTH_LIMIT, "{rule:?}: {}", tree.depth);
        assert_eq!(tree.depth, depth(&tree.splits));
        let again = build(3);
        assert_eq!((tree.order, tree.splits), (again.order, again.splits));
    }
}

/// Greedy fronts of either tree, the cluster of largest error split first.
#[test]
fn fronts_are_flatter_than_those_of_splitting() {
    let mesh = sheet(9);
    let components = Components::of(&mesh);
    let tree = merge_all(&mesh, &components, Rule::Quality, None, &|_| ()).unwrap();
    let error = |tree: &Hierarchy, clusters: usize| {
        let mut front: Vec<(f64, usize, usize)> = vec![(f64::INFINITY, 0, tree.order.len())];
        while front.len() < clusters {
            front.sort_by(|a, b| a.0.total_cmp(&b.0));
            let (_, node, faces) = front.pop().unwrap();
            let left = tree.splits[node].left_faces as usize;
            for (child, n) in [(node + 1, left), (node + left, faces - left)] {
                let epsilon = if n > 1 { f64::from(tree.splits[child].epsilon) } else { 0.0 };
                front.push((epsilon * n as f64, child, n));
            }
        }
        front.iter().map(|f| f.0).sum::<f64>()
    };
    let paper = partition(&mesh, &components, SplitMode::Paper, None, &|_| ());
    for clusters in [10, 20, 40] {
        assert!(error(&tree, clusters) < error(&paper, clusters));
    }
}

#[test]
fn components_are_joined_and_a_soup_of_triangles_is_a_tree_of_joins() {
    let mut positions = Vec::new();
    let mut triangles = Vec::new();
    for i in 0..300_u32 {
        let x = (i * 37 % 101) as f32;
        positions.extend([[x, i as f32, 0.0], [x + 0.5, i as f32, 0.0], [x, i as f32 + 0.5, 0.3]]);
        triangles.push([3 * i, 3 * i + 1, 3 * i + 2]);
    }
    let mesh = mesh_of(&positions, triangles);
    let components = Components::of(&mesh);
    assert_eq!(components.len(), 300);
    let tree = merge_all(&mesh, &components, Rule::Quality, None, &|_| ()).unwrap();
    assert!(tree.splits.iter().all(|s| s.joins_components && s.key == f32::INFINITY));
    assert!(tree.depth <= 10);
    assert_eq!(tree.depth, depth(&tree.splits));
}

/// A flat strip has nothing but ties: it must not become a comb.
#[test]
fn ties_make_even_trees() {
    let n = 400_u32;
    let positions: Vec<[f32; 3]> = (0..2 * n).map(|i| [(i / 2) as f32, (i % 2) as f32, 0.0]).collect();
    let triangles = (0..2 * n - 2).map(|i| if i % 2 == 0 { [i, i + 2, i + 1] } else { [i, i + 1, i + 2] });
    let mesh = mesh_of(&positions, triangles.collect());
    let components = Components::of(&mesh);
    for rule in [Rule::Quality, Rule::Garland] {
        let depth = merge_all(&mesh, &components, rule, None, &|_| ()).unwrap().depth;
        assert!(depth <= 22, "{rule:?}: {depth}");
    }
}

/// Positions as far apart as they go: the curve keeps neighbours together and loses nobody.
#[test]
fn the_curve_visits_all_and_keeps_neighbours_near() {
    let points: Vec<DVec3> = (0..4096).map(|i| DVec3::new((i % 64) as f64, (i / 64) as f64, 0.0)).collect();
    let order = cells::along_curve(points.par_iter().copied());
    let mut sorted = order.clone();
    sorted.sort_unstable();
    assert!(sorted.into_iter().eq(0..4096));
    let steps = order.windows(2).map(|w| points[w[0] as usize].distance(points[w[1] as usize]));
    assert!(steps.sum::<f64>() < 2.0 * 4096.0);
}

/// Two faces that share two edges, and three around a point: parallel edges must not tie a cluster to itself.
#[test]
fn faces_that_meet_along_several_edges_merge_once() {
    let positions = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.2, 0.2, 0.5]];
    for triangles in [vec![[0, 1, 2], [0, 2, 1]], vec![[0, 1, 3], [1, 2, 3], [2, 0, 3], [0, 2, 1]]] {
        let mesh = mesh_of(&positions, triangles);
        let components = Components::of(&mesh);
        let tree = merge_all(&mesh, &components, Rule::Quality, None, &|_| ()).unwrap();
        let mut order = tree.order.clone();
        order.sort_unstable();
        assert!(order.into_iter().eq(0..mesh.faces.len() as u32));
        assert_connected(&mesh, &tree);
    }
}
