//! Promise: polygons with holes and many corners are covered once, and the border comes out right of whatever there is.

use super::Outline;
use super::bridge::Bridge;
use super::grid;
use super::triangulate::Triangulator;
use glam::DVec2;
use proptest::prelude::*;
use std::collections::BTreeMap;

/// Loops with the inside on their left.
type Loops = Vec<Vec<DVec2>>;

/// What came out: places of the triangles' corners as indices.
struct Covered {
    triangles: Vec<[u32; 3]>,
    /// Areas, and their absolute values, over the area inside the loops.
    area: f64,
    absolute: f64,
}

fn cover(loops: &Loops) -> Covered {
    let mut outline = Outline::default();
    for ring in loops {
        outline.points.extend(ring);
        outline.loop_ends.push(outline.points.len());
    }
    outline.vertices.extend(0..outline.points.len() as u32);
    let places = outline.points.clone();
    grid::snap(&mut outline.points);
    let mut triangulator = Triangulator::default();
    let mut out = Vec::new();
    for round in 0..2 {
        let mut outline = Outline {
            loop_ends: outline.loop_ends.clone(),
            vertices: outline.vertices.clone(),
            points: outline.points.clone(),
        };
        Bridge::default().join_loops(&mut outline, true);
        let heights = vec![0.0; outline.vertices.len()];
        let before = std::mem::take(&mut out);
        if !triangulator.find_best(&outline.vertices, &outline.points, &heights, &mut out) {
            triangulator.find_any(&outline.vertices, &outline.points, &heights, true, &mut out);
        }
        // What a polygon has left must not matter.
        assert!(round == 0 || before == out);
    }
    let triangles = out.as_chunks::<3>().0.to_vec();
    let double = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|k| places[k as usize]);
        (b - a).perp_dot(c - a)
    };
    let turns = |ring: &Vec<DVec2>| -> f64 {
        (0..ring.len()).map(|i| (ring[i] - ring[0]).perp_dot(ring[(i + 1) % ring.len()] - ring[0])).sum()
    };
    let whole: f64 = loops.iter().map(turns).sum();
    let area = triangles.iter().map(double).sum::<f64>() / whole;
    let absolute = triangles.iter().map(|t| double(t).abs()).sum::<f64>() / whole;
    Covered { triangles, area, absolute }
}

/// Each edge of the loops once, and nothing else.
fn has_border(loops: &Loops, triangles: &[[u32; 3]]) -> bool {
    let mut net = BTreeMap::new();
    let mut add = |a: u32, b: u32, n: i32| {
        *net.entry((a.min(b), a.max(b))).or_insert(0) += if a < b { n } else { -n };
    };
    for [a, b, c] in triangles {
        for (a, b) in [(*a, *b), (*b, *c), (*c, *a)] {
            add(a, b, 1);
        }
    }
    let mut first = 0;
    for ring in loops {
        let n = ring.len() as u32;
        for i in 0..n {
            add(first + i, first + (i + 1) % n, -1);
        }
        first += n;
    }
    net.values().all(|n| *n == 0)
}

fn triangle_count(loops: &Loops) -> usize {
    loops.iter().map(Vec::len).sum::<usize>() + 2 * (loops.len() - 1) - 2
}

/// Of loops around something that does not overlap itself: the right triangles, all the right way round.
fn check(loops: &Loops) {
    let covered = cover(loops);
    assert_eq!(covered.triangles.len(), triangle_count(loops), "{loops:?}");
    assert!(has_border(loops, &covered.triangles), "{loops:?}");
    let Covered { area, absolute, .. } = covered;
    assert!((area - 1.0).abs() < 1e-9 && absolute - area < 1e-9, "{area} {absolute}: {loops:?}");
}

/// Turns and moves places, with an angle of 0 not at all.
fn turned(loops: Loops, angle: f64) -> Loops {
    let place = |p: DVec2| {
        if angle == 0.0 { p } else { DVec2::from_angle(angle).rotate(p) + DVec2::new(0.3, -0.7) }
    };
    loops.into_iter().map(|ring| ring.into_iter().map(place).collect()).collect()
}

/// The loops around the cells of a square grid that hang together with the first one.
///
/// Where two of them meet in a point, loops touch themselves or others there. Corners on straight sides are left out
/// where `keeps` says so, one after the other.
fn around_cells(size: usize, is_cell: &[bool], mut keeps: impl FnMut() -> bool) -> Loops {
    let mut cells = vec![false; size * size];
    let Some(first) = is_cell.iter().position(|is| *is) else { return Loops::new() };
    let mut waiting = vec![first];
    while let Some(cell) = waiting.pop() {
        if !is_cell[cell] || std::mem::replace(&mut cells[cell], true) {
            continue;
        }
        let (x, y) = (cell % size, cell / size);
        waiting.extend((x > 0).then(|| cell - 1));
        waiting.extend((x + 1 < size).then_some(cell + 1));
        waiting.extend((y > 0).then(|| cell - size));
        waiting.extend((y + 1 < size).then_some(cell + size));
    }
    let has = |x: i32, y: i32| {
        let inside = |c: i32| (0..size as i32).contains(&c);
        inside(x) && inside(y) && cells[y as usize * size + x as usize]
    };
    // Sides with what is inside to the left of each: where they start, and one of four ways.
    const WAYS: [(i32, i32); 4] = [(1, 0), (0, 1), (-1, 0), (0, -1)];
    let mut sides: BTreeMap<((i32, i32), usize), bool> = BTreeMap::new();
    for (x, y) in (0..size as i32).flat_map(|y| (0..size as i32).map(move |x| (x, y))) {
        let corners = [(x, y), (x + 1, y), (x + 1, y + 1), (x, y + 1)];
        let across = [(x, y - 1), (x + 1, y), (x, y + 1), (x - 1, y)];
        for way in (0..4).filter(|way| has(x, y) && !has(across[*way].0, across[*way].1)) {
            sides.insert((corners[way], way), false);
        }
    }
    // Where two sides end and two start, turning left from both makes loops that do not cross, and so does right.
    let mut turns = BTreeMap::new();
    let mut loops = Loops::new();
    while let Some(start) = sides.iter().find(|(_, is_done)| !**is_done).map(|(side, _)| *side) {
        let mut ring = Vec::new();
        let mut side = start;
        loop {
            sides.insert(side, true);
            let ((x, y), way) = side;
            let at = (x + WAYS[way].0, y + WAYS[way].1);
            let [left, right] = [1, 3].map(|turn| (at, (way + turn) % 4));
            let goes_left = match [left, right].map(|side| sides.contains_key(&side)) {
                [true, true] => *turns.entry(at).or_insert_with(&mut keeps),
                [is_left, _] => is_left,
            };
            let turned = if goes_left { left } else { right };
            side = if sides.contains_key(&turned) { turned } else { (at, way) };
            if side.1 != way || keeps() {
                ring.push(DVec2::new(f64::from(at.0), f64::from(at.1)));
            }
            if side == start {
                break;
            }
        }
        loops.push(ring);
    }
    loops
}

/// Around a place, at growing angles; as a hole the other way.
fn star(middle: DVec2, radii: &[f64], is_hole: bool) -> Vec<DVec2> {
    let n = radii.len() as f64;
    let at = |(i, r): (usize, &f64)| middle + DVec2::from_angle(std::f64::consts::TAU * i as f64 / n) * *r;
    let mut ring: Vec<DVec2> = radii.iter().enumerate().map(at).collect();
    if is_hole {
        ring.reverse();
    }
    ring
}

/// A band wound up, with a hole in every so many of its pieces.
fn spiral(pieces: usize, width: f64, hole_every: usize) -> Loops {
    let at = |t: f64, off: f64| DVec2::from_angle(t) * (1.0 + 0.2 * t + off);
    let angle = |i: usize| 0.4 * i as f64;
    let mut outline: Vec<DVec2> = (0..=pieces).map(|i| at(angle(i), width)).collect();
    outline.extend((0..=pieces).rev().map(|i| at(angle(i), 0.0)));
    let mut loops = vec![outline];
    for i in (0..pieces).step_by(hole_every) {
        let [a, b] = [i, i + 1].map(|i| [at(angle(i), 0.0), at(angle(i), width)]);
        let within =
            |(along, across): (f64, f64)| a[0].lerp(a[1], across).lerp(b[0].lerp(b[1], across), along);
        loops.push([(0.2, 0.4), (0.8, 0.4), (0.8, 0.6), (0.2, 0.6)].map(within).to_vec());
    }
    loops
}

/// A plate with teeth on one side, and a slit behind each of them.
fn comb(teeth: usize, gap: f64) -> Loops {
    let mut outline = vec![DVec2::new(0.0, 3.0), DVec2::new(0.0, 1.0)];
    let mut loops = Vec::new();
    for i in 0..teeth {
        let x = i as f64;
        let tooth = [(x, 0.0), (x + 1.0 - gap, 0.0), (x + 1.0 - gap, 1.0), (x + 1.0, 1.0)];
        outline.extend(tooth.map(DVec2::from));
        let slit = [(x + 0.1, 1.2), (x + 0.1, 2.9), (x + 0.2, 2.9), (x + 0.2, 1.2)];
        loops.push(slit.map(DVec2::from).to_vec());
    }
    outline.push(DVec2::new(teeth as f64, 3.0));
    loops.push(outline);
    loops
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn cells_of_a_grid(
        size in 2_usize..11,
        share in 0.4_f64..0.95,
        keeps in prop::sample::select(vec![0.0, 0.3, 1.0]),
        numbers in prop::collection::vec(0.0_f64..1.0, 100),
        others in prop::collection::vec(0.0_f64..1.0, 400),
        angle in prop::sample::select(vec![0.0, 0.3, 1.1, 2.5]),
    ) {
        let is_cell: Vec<bool> = numbers.iter().take(size * size).map(|x| *x < share).collect();
        let mut others = others.iter().cycle();
        let loops = around_cells(size, &is_cell, || others.next().is_some_and(|x| *x < keeps));
        if !loops.is_empty() {
            check(&turned(loops, angle));
        }
    }

    #[test]
    fn stars_with_stars_in_them(
        outer in prop::collection::vec(2.0_f64..5.0, 3..90),
        holes in prop::collection::vec(prop::collection::vec(0.05_f64..0.45, 3..12), 0..5),
    ) {
        // Stars around five places that are far enough from each other and from the rim.
        let places = [(0.0, 0.0), (1.0, 0.0), (-0.5, 0.866), (-0.5, -0.866), (0.3, 0.92)];
        let scaled = |radii: &Vec<f64>| radii.iter().map(|r| r.max(0.01)).collect::<Vec<f64>>();
        let rim = 1.0 / (std::f64::consts::PI / outer.len() as f64).cos();
        let outer: Vec<f64> = outer.iter().map(|r| r * rim).collect();
        let mut loops = vec![star(DVec2::ZERO, &outer, false)];
        loops.extend(holes.iter().zip(places).map(|(radii, place)| star(DVec2::from(place), &scaled(radii), true)));
        check(&loops);
    }

    #[test]
    fn spirals_and_combs(
        pieces in 3_usize..120,
        width in 0.01_f64..1.0,
        hole_every in 1_usize..40,
        gap in prop::sample::select(vec![0.0, 1e-9, 0.1, 0.9]),
        angle in 0.0_f64..6.0,
    ) {
        check(&turned(spiral(pieces, width, hole_every), angle));
        check(&turned(comb(pieces / 2 + 1, gap), angle));
    }

    /// Corners anywhere: what is inside means nothing, but the mesh stays closed.
    #[test]
    fn garbage_keeps_its_border(
        loops in prop::collection::vec(prop::collection::vec([0_i32..12, 0_i32..12], 3..60), 1..5),
        angle in prop::sample::select(vec![0.0, 0.3]),
    ) {
        let place = |[x, y]: &[i32; 2]| DVec2::new(f64::from(*x), f64::from(*y));
        let loops: Loops = loops.iter().map(|ring| ring.iter().map(place).collect()).collect();
        let loops = turned(loops, angle);
        let covered = cover(&loops);
        // Those that have a corner twice are left out.
        prop_assert!(covered.triangles.len() <= triangle_count(&loops));
        prop_assert!(has_border(&loops, &covered.triangles));
    }

    /// Two corners of a star change places: no more is turned over than the crossing needs, which is about twice as much
    /// as the whole star at worst.
    #[test]
    fn a_crossing_turns_little_over(
        radii in prop::collection::vec(1.0_f64..1.5, 20..60),
        holes in 1_usize..4,
        at in 0_usize..60,
    ) {
        let mut loops = vec![star(DVec2::ZERO, &radii, false)];
        let n = radii.len();
        loops[0].swap(at % n, (at + 1) % n);
        let places = [(0.5, 0.0), (-0.4, 0.4), (-0.4, -0.4)];
        loops.extend(places.iter().take(holes).map(|p| star(DVec2::from(*p), &[0.2; 7], true)));
        let covered = cover(&loops);
        prop_assert!(has_border(&loops, &covered.triangles));
        // The triangles of three neighbours are all that needs to overlap.
        let few = 8.0 * 1.5 * 1.5 / n as f64;
        prop_assert!(covered.absolute - covered.area < few, "{} {}", covered.absolute, covered.area);
    }
}

#[test]
fn many_corners_and_no_number() {
    // More than are tried in all ways, crossing at one place.
    let mut ring = star(DVec2::ZERO, &[1.0; 400], false);
    ring.swap(7, 8);
    let loops = vec![ring, star(DVec2::ZERO, &[0.5; 100], true)];
    let covered = cover(&loops);
    assert!(has_border(&loops, &covered.triangles) && covered.absolute - covered.area < 0.01);
    let loops = vec![vec![DVec2::NAN; 30], vec![DVec2::INFINITY; 14], vec![DVec2::ZERO; 3]];
    assert!(has_border(&loops, &cover(&loops).triangles));
}
