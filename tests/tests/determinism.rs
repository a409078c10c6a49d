//! Promise: the file depends on the input and the options alone.

use fcbuild::SplitMode;
use fcbuild::import::{Positions, Soup};
use fctests::{meshes, trees};

fn on_threads(threads: usize, soup: &Soup, split: SplitMode) -> Vec<u8> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap_or_else(|e| panic!("{e}"));
    pool.install(|| trees::bytes_of(soup.clone(), split))
}

fn check(name: &str, soup: Soup) {
    for split in [SplitMode::Quality, SplitMode::Paper, SplitMode::Pca, SplitMode::Cca, SplitMode::Merge] {
        let one = on_threads(1, &soup, split);
        for threads in [2, 7] {
            assert!(
                on_threads(threads, &soup, split) == one,
                "{name}, {split:?}: {threads} threads give other bytes"
            );
        }
        assert!(on_threads(1, &soup, split) == one, "{name}, {split:?}: a second run gives other bytes");
    }
}

/// The terrain with stripes, and shades that are not linear.
fn painted() -> Soup {
    let mut soup = trees::read(&trees::data("terrain.ply"));
    let Positions::F32(positions) = &soup.positions else { panic!("single precision") };
    let byte = |x: f32| (x * x * 37.0) as u8;
    let color =
        |p: &[f32; 3]| [byte(p[0]), byte(p[1] + p[2]), if p[2].fract() > 0.3 { 200 } else { 20 }, 255];
    soup.colors = Some(positions.iter().map(color).collect());
    soup
}

#[test]
fn same_bytes_for_any_number_of_threads() {
    check("sculpture.ply", trees::read(&trees::data("sculpture.ply")));
    check("parts.ply", trees::read(&trees::data("parts.ply")));
    check("painted terrain", painted());
    check("tangle", meshes::tangle(300, 4000, 2));
}

#[test]
fn the_modes_differ() {
    let soup = trees::read(&trees::data("terrain.ply"));
    let [paper, pca, cca] =
        [SplitMode::Paper, SplitMode::Pca, SplitMode::Cca].map(|s| trees::bytes_of(soup.clone(), s));
    assert!(paper != pca && pca != cca && cca != paper);
}

/// Exponents change, nothing else: the tree has the same shape and its lengths are the same, scaled.
#[test]
fn a_mesh_scaled_by_a_power_of_two_gives_the_scaled_tree() {
    for soup in [trees::read(&trees::data("terrain.ply")), painted()] {
        scaled(&soup);
    }
}

fn scaled(soup: &Soup) {
    let one = trees::tree_of(soup.clone());
    for factor in [0.125_f32, 1024.0] {
        let mut scaled = soup.clone();
        if let Positions::F32(p) = &mut scaled.positions {
            p.iter_mut().flatten().for_each(|x| *x *= factor);
        }
        let other = trees::tree_of(scaled);
        assert_eq!(one.faces().ok(), other.faces().ok());
        let mut stack = vec![(one.whole(), other.whole())];
        while let Some((a, b)) = stack.pop() {
            assert_eq!(a, b);
            if a.face_count() == 1 {
                continue;
            }
            let [n, m] = [one.node(&a), other.node(&b)].map(|node| node.unwrap_or_else(|e| panic!("{e}")));
            assert_eq!(n.center.map(|x| x * factor), m.center);
            assert_eq!(n.radius * factor, m.radius);
            assert_eq!(n.bound * factor, m.bound);
            assert_eq!((n.axis(), n.cos()), (m.axis(), m.cos()));
            // Below the normal range single precision drops digits of its own.
            let [e, f] = [n.epsilon() * factor * factor, m.epsilon()];
            assert!(e == f || e.max(f) < f32::MIN_POSITIVE * 1024.0, "{e} {f}");
            assert_eq!(one.loops_of(&a).ok(), other.loops_of(&b).ok());
            let below = [one.children(&a), other.children(&b)].map(|c| c.unwrap_or_else(|e| panic!("{e}")));
            stack.extend(below[0].into_iter().zip(below[1]));
        }
        for (a, b) in one.vertices().iter().zip(other.vertices()) {
            assert_eq!(a.position().map(|x| x * factor), b.position());
            for (a, b) in [(a.bound(), b.bound()), (a.budget(), b.budget())] {
                assert!(a * factor == b || b < f32::MIN_POSITIVE * 1024.0, "{a} {b}");
            }
            assert_eq!((a.radius() * f64::from(factor), a.offset), (b.radius(), b.offset));
        }
    }
}
