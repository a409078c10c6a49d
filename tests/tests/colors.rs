//! Promise: colours of vertices count. A painted wall keeps its picture, however a cut is chosen.

use fcbuild::BuildOptions;
use fcbuild::import::{Positions, Soup};
use fcextract::{Budget, Extraction, Order, Selection, extract, fit};
use fcmeasure::{Distance, Reference, Surface};
use fct::Tree;
use fctests::cracks::Borders;
use fctests::{meshes, trees};

/// Quads along a side of the wall.
const SIDE: u32 = 96;

/// What the wall shows at a place of the unit square: a disc, bars and a line on a shaded ground.
fn picture(x: f32, y: f32) -> [u8; 4] {
    let bars = y > 0.65 && ((x * 10.0) as u32).is_multiple_of(2);
    if (x - 0.3).hypot(y - 0.3) < 0.17 {
        [190, 30, 30, 255]
    } else if bars {
        [20, 20, 20, 255]
    } else if (x - 0.75).abs() < 0.02 {
        [20, 40, 160, 255]
    } else {
        [230, (150.0 + 60.0 * x) as u8, (120.0 + 90.0 * y) as u8, 255]
    }
}

/// A wall that is flat but for a grain of a thousandth of a quad, and painted.
fn wall(paint: impl Fn(f32, f32) -> [u8; 4]) -> Soup {
    let mut soup = meshes::grid(SIDE, 3);
    let Positions::F32(positions) = &mut soup.positions else { panic!("single precision") };
    positions.iter_mut().for_each(|p| p[2] *= 1e-3);
    soup.colors = Some(positions.iter().map(|p| paint(p[0], p[1])).collect());
    soup
}

fn tree(soup: Soup, color_weight: f64) -> Tree {
    let options = BuildOptions { color_weight, ..BuildOptions::default() };
    trees::tree_with(soup, &options)
}

/// How far a cut, which has no cracks, is from the whole wall.
fn apart(tree: &Tree, cut: &Extraction, selection: &Selection) -> Distance {
    assert!(Borders::of(tree).cracks(&cut.indices).is_empty());
    let mesh = |cut: &Extraction, selection: &Selection| {
        let mut mesh = fcextract::Mesh::default();
        mesh.fill(tree, cut, selection).unwrap();
        mesh
    };
    let (mut all, full) = (Extraction::default(), Selection::full());
    extract(tree, &full, &mut all).unwrap();
    let (whole, drawn) = (mesh(&all, &full), mesh(cut, selection));
    Reference::new(surface(&whole), 20_000).distance(surface(&drawn))
}

fn surface(mesh: &fcextract::Mesh) -> Surface<'_> {
    Surface { positions: &mesh.positions, faces: mesh.indices.as_chunks().0, colors: &mesh.colors }
}

fn within(tree: &Tree, triangles: u64) -> f64 {
    let mut cut = Extraction::default();
    let (selection, fitted) =
        fit(tree, Selection::by_budget(), Budget::Triangles(triangles), &mut cut).unwrap();
    assert!(fitted.within && cut.stats.triangles + 4 >= triangles, "{fitted:?}");
    apart(tree, &cut, &selection).color_rms.unwrap()
}

#[test]
fn a_budget_is_spent_on_the_picture() {
    let [weighed, plain] = [0.5, 0.0].map(|weight| within(&tree(wall(picture), weight), 1_500));
    println!("colours: {weighed:.4}, without weight {plain:.4}");
    assert!(weighed < 0.25 * plain, "{weighed} {plain}");
}

/// With a weight of a half, what a cluster draws wrong is a black patch in place of a white one, twice as wide as the
/// tolerance, or what counts as much.
#[test]
fn a_tolerance_holds_the_picture() {
    let tree = tree(wall(picture), 0.5);
    let mut last = f64::INFINITY;
    for distance in [0.04, 0.02, 0.01, 0.005] {
        let selection = Selection::uniform(distance, Order::Bound);
        let mut cut = Extraction::default();
        extract(&tree, &selection, &mut cut).unwrap();
        let found = apart(&tree, &cut, &selection).color_rms.unwrap();
        println!("within {distance}: {} triangles, colours {found:.4}", cut.stats.triangles);
        // The wall has an area of 1.
        let most = (cut.stats.clusters as f64).sqrt() * 2.0 * distance;
        assert!(found < last && found < most, "{distance}: {found}, {most}");
        last = found;
    }
    assert!(last < 0.04, "{last}");
}

/// Colours that are linear in space are drawn right by any triangles: they cost none.
#[test]
fn linear_shades_cost_no_triangles() {
    let ramp =
        |x: f32, y: f32| [(255.0 * x) as u8, (255.0 * y) as u8, (100.0 + 50.0 * x + 50.0 * y) as u8, 255];
    let count = |weight: f64| {
        let mut cut = Extraction::default();
        extract(&tree(wall(ramp), weight), &Selection::uniform(0.01, Order::Bound), &mut cut).unwrap();
        cut.stats.triangles
    };
    let (weighed, plain) = (count(0.5), count(0.0));
    assert!(weighed <= plain + plain / 4 + 8, "{weighed} {plain}");
}

#[test]
fn a_weight_of_zero_is_a_tree_without_colors() {
    let mut bare = wall(picture);
    bare.colors = None;
    let (painted, bare) = (tree(wall(picture), 0.0), tree(bare, 0.5));
    let drawn = |tree: &Tree, distance: f64| {
        let mut cut = Extraction::default();
        extract(tree, &Selection::uniform(distance, Order::Bound), &mut cut).unwrap();
        cut.indices
    };
    for distance in [1e-6, 1e-5, 1e-3] {
        assert_eq!(drawn(&painted, distance), drawn(&bare, distance));
    }
}
