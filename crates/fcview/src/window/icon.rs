//! The window's icon: a hexagon of six facets, drawn here.

use winit::window::Icon;

/// Pixels a side.
const SIDE: u32 = 64;

/// Samples a side of a pixel.
const FINE: u32 = 4;

/// Brightness of the facets, counter-clockwise from the right: lit from the upper left.
const FACETS: [f64; 6] = [0.62, 0.86, 1.0, 0.80, 0.52, 0.40];

/// The icon; `None` where the system takes none.
pub(super) fn icon() -> Option<Icon> {
    Icon::from_rgba(pixels(), SIDE, SIDE).ok()
}

/// RGBA, rows from the top.
fn pixels() -> Vec<u8> {
    let mut out = Vec::with_capacity((SIDE * SIDE * 4) as usize);
    for y in 0..SIDE {
        for x in 0..SIDE {
            let mut sum = [0.0; 4];
            for sample in 0..FINE * FINE {
                let place = |pixel: u32, part: u32| {
                    let fine = f64::from(pixel) + (f64::from(part) + 0.5) / f64::from(FINE);
                    2.0 * fine / f64::from(SIDE) - 1.0
                };
                if let Some(color) = facet(place(x, sample % FINE), -place(y, sample / FINE)) {
                    for (sum, part) in sum.iter_mut().zip(color) {
                        *sum += part;
                    }
                    sum[3] += 1.0;
                }
            }
            let [r, g, b, covered] = sum;
            let mean = |part: f64| if covered > 0.0 { (255.0 * part / covered).round() as u8 } else { 0 };
            let alpha = (255.0 * covered / f64::from(FINE * FINE)).round() as u8;
            out.extend([mean(r), mean(g), mean(b), alpha]);
        }
    }
    out
}

/// The colour at a place of the square from -1 to 1, or `None` outside the hexagon.
fn facet(x: f64, y: f64) -> Option<[f64; 3]> {
    let sector = std::f64::consts::TAU / 6.0;
    let angle = y.atan2(x).rem_euclid(std::f64::consts::TAU);
    let number = ((angle / sector) as usize).min(5);
    let within = angle - (number as f64 + 0.5) * sector;
    let out = x.hypot(y) * within.cos();
    // A dark seam between the facets, as clusters have.
    let seam = x.hypot(y) * (0.5 * sector - within.abs()).sin();
    let light = if seam < 0.02 { 0.16 } else { *FACETS.get(number)? };
    (out <= 0.82).then_some([0.93 * light, 0.80 * light, 0.62 * light])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_icon_is_a_hexagon_of_several_shades_on_nothing() {
        let pixels = pixels();
        let at = |x: u32, y: u32| {
            let first = ((y * SIDE + x) * 4) as usize;
            [pixels[first], pixels[first + 1], pixels[first + 2], pixels[first + 3]]
        };
        assert_eq!(at(0, 0)[3], 0, "the corner is clear");
        let shades = [at(50, 26), at(32, 16), at(14, 26), at(14, 38), at(32, 48), at(50, 38)];
        assert!(shades.iter().all(|shade| shade[3] == 255));
        for pair in shades.windows(2) {
            assert!(pair[0] != pair[1], "{shades:?}");
        }
        assert!(icon().is_some());
    }
}
