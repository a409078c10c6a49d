//! Promise: the buffers of a mesh that was streamed are those of the tree in memory: each vertex once, no crack, and no
//! triangle that a step beside its place turns around.

#![allow(clippy::print_stdout, reason = "the counts are part of the promise")]

use fcextract::{Extraction, Mesh, Order, Perspective, Piece, Selection, Streamed, extract};
use fctests::cracks::Borders;
use fctests::parts::{Model, size};
use fctests::random::Random;
use fctests::{meshes, trees};
use glam::DVec3;
use std::collections::{BTreeMap, BTreeSet};

fn models() -> Vec<Model> {
    vec![
        Model::new("sculpture.ply", trees::read(&trees::data("sculpture.ply")), 700),
        Model::new("terrain.ply", trees::read(&trees::data("terrain.ply")), 300),
        Model::new("parts.ply", trees::read(&trees::data("parts.ply")), 300),
        // Seams, so that vertices have copies.
        Model::new("three sheets", meshes::three_sheets(12), 30),
        Model::new("moebius strip", meshes::moebius(60), 20),
        Model::new("tangle", meshes::tangle(40, 160, 2), 6),
    ]
}

/// A tolerance from much to almost no detail, everywhere or as seen, with vertices beside their places.
fn random_selection(random: &mut Random, model: &Model) -> Selection {
    let (center, size) = size(&model.tree);
    let order = if random.below(2) == 0 { Order::Bound } else { Order::Budget };
    let fraction = 10_f64.powf(random.between(-4.0, -1.0));
    let eye = center + random.direction() * size * random.between(0.4, 2.0);
    let view = Perspective::new(eye, center - eye, 1.0, [1600.0, 900.0], 1000.0 * fraction);
    let shape = match random.below(2) {
        0 => Selection::uniform(size * fraction, order),
        _ => Selection::perspective(view, order),
    };
    Selection { displaced: true, ..shape }
}

/// The triangles by the names of their vertices, each from its lowest on, in order.
fn triangles(mesh: &Mesh, name: impl Fn(u32) -> u32) -> Vec<[u32; 3]> {
    let named = |corners: &[u32; 3]| {
        let mut corners = corners.map(|v| name(mesh.sources[v as usize]));
        let lowest = (0..3).min_by_key(|i| corners[*i]).unwrap_or(0);
        corners.rotate_left(lowest);
        corners
    };
    let mut all: Vec<_> = mesh.indices.as_chunks::<3>().0.iter().map(named).collect();
    all.sort_unstable();
    all
}

type Vertex = ([u32; 3], Option<([u32; 3], Option<[u8; 4]>)>);

/// What each vertex is drawn with, to the bit; of copies along a seam any one gives normal and colour.
fn vertices(model: &Model, mesh: &Mesh) -> BTreeMap<u32, Vertex> {
    let copied: BTreeSet<u32> = model.tree.weld().iter().map(|copy| copy.representative.get()).collect();
    let bits = |of: &[[f32; 3]], i: usize| of.get(i).map_or([0; 3], |v| v.map(f32::to_bits));
    let of = |(i, source): (usize, &u32)| {
        let name = model.tree.original(*source);
        let attributes = (bits(&mesh.normals, i), mesh.colors.get(i).copied());
        (name, (bits(&mesh.positions, i), (!copied.contains(&name)).then_some(attributes)))
    };
    mesh.sources.iter().enumerate().map(of).collect()
}

/// How many triangles face the other way than they would with all vertices in place.
fn turned(model: &Model, mesh: &Mesh, position: impl Fn(usize) -> DVec3) -> usize {
    let home =
        |i: usize| DVec3::from(model.tree.vertices()[mesh.sources[i] as usize].position().map(f64::from));
    let normal = |corners: &[u32; 3], place: &dyn Fn(usize) -> DVec3| {
        let [a, b, c] = corners.map(|v| place(v as usize));
        (b - a).cross(c - a)
    };
    let is_turned = |t: &&[u32; 3]| normal(t, &home).dot(normal(t, &position)) < 0.0;
    mesh.indices.as_chunks::<3>().0.iter().filter(is_turned).count()
}

#[test]
fn with_all_pieces_they_are_those_of_the_tree() {
    let (mut equal, mut looked, mut turned_by_steps) = (0, 0, 0);
    let (mut whole, mut cut) = (Mesh::default(), Extraction::default());
    let (mut streamed, mut mesh) = (Streamed::default(), Mesh::default());
    for model in models() {
        let mut random = Random::new(17);
        let name = |vertex: u32| model.tree.original(vertex);
        for view in 0..30 {
            let selection = random_selection(&mut random, &model);
            extract(&model.tree, &selection, &mut cut).unwrap_or_else(|e| panic!("{e}"));
            whole.fill(&model.tree, &cut, &selection).unwrap_or_else(|e| panic!("{e}"));
            model.streamed(&|_| true, &selection, &mut streamed);
            mesh.fill_streamed(model.file.crown(), &streamed, &selection).unwrap_or_else(|e| panic!("{e}"));
            let once: BTreeSet<u32> = mesh.sources.iter().map(|source| name(*source)).collect();
            assert_eq!(once.len(), mesh.positions.len(), "{}, view {view}: each vertex once", model.name);
            assert_eq!(mesh.normals.len(), mesh.positions.len());
            assert_eq!(turned(&model, &mesh, |i| DVec3::from(mesh.positions[i].map(f64::from))), 0);
            turned_by_steps += turned(&model, &mesh, |i| {
                selection.position(&model.tree.vertices()[mesh.sources[i] as usize])
            });
            looked += 1;
            // Of equally good diagonals a streamed mesh may choose another, and then other steps are taken back.
            if triangles(&mesh, name) == triangles(&whole, name) {
                equal += 1;
                let same = vertices(&model, &mesh) == vertices(&model, &whole);
                assert!(same, "{}, view {view}", model.name);
                assert_eq!([mesh.collapsed, whole.collapsed], [mesh.collapsed; 2]);
                assert_eq!(mesh.longest_step, whole.longest_step);
            }
        }
    }
    println!("{equal} of {looked} meshes have the same triangles; steps alone turn {turned_by_steps}");
    assert!(3 * equal > looked && turned_by_steps > 0);
}

#[test]
fn missing_pieces_leave_no_crack_in_them() {
    let (mut streamed, mut mesh) = (Streamed::default(), Mesh::default());
    let mut coarser = 0;
    for model in models() {
        let borders = Borders::of(&model.tree);
        let mut random = Random::new(29);
        for view in 0..20 {
            let selection = random_selection(&mut random, &model);
            let seed = random.bits();
            let there = |piece: Piece| {
                let (Piece::Chunk(number) | Piece::Page(number)) = piece;
                Random::new(seed ^ u64::from(number)).unit() < 0.6
            };
            model.streamed(&there, &selection, &mut streamed);
            mesh.fill_streamed(model.file.crown(), &streamed, &selection).unwrap_or_else(|e| panic!("{e}"));
            // A piece that nothing can be drawn for takes whole components with it.
            if !streamed.missing.iter().all(|wish| model.is_drawable(wish.piece)) {
                continue;
            }
            let named: Vec<u32> = mesh.indices.iter().map(|v| mesh.sources[*v as usize]).collect();
            let cracks = borders.cracks(&named);
            assert!(cracks.is_empty(), "{}, view {view}: {} cracks", model.name, cracks.len());
            coarser += usize::from(!streamed.missing.is_empty());
        }
    }
    assert!(coarser > 30, "{coarser} meshes with something missing");
}
