//! Line plots as SVG; heights are logarithmic.

use super::page::whole;
use std::fmt::Write as _;

/// A curve, or a cloud of points.
#[derive(Clone, Debug)]
pub(crate) struct Series {
    /// For the legend.
    pub(crate) name: String,
    /// As SVG takes it.
    pub(crate) color: &'static str,
    /// Dashes as SVG takes them; empty for an unbroken line.
    pub(crate) dashes: &'static str,
    /// A dot for each point in the place of a line, for points that follow one another in no order.
    pub(crate) dots: bool,
    /// Positive numbers, ascending in x for a line; others are left out.
    pub(crate) points: Vec<(f64, f64)>,
}

/// How an axis runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Scale {
    Linear,
    Logarithmic,
}

/// A plot.
#[derive(Clone, Debug)]
pub(crate) struct Plot {
    /// Above it.
    pub(crate) title: String,
    /// Below it, with the unit.
    pub(crate) x_label: String,
    /// At its left, with the unit.
    pub(crate) y_label: String,
    /// How the lower axis runs.
    pub(crate) x_scale: Scale,
    /// In the order of the legend.
    pub(crate) series: Vec<Series>,
}

const WIDTH: f64 = 640.0;
const HEIGHT: f64 = 420.0;
/// Left, right, upper and lower edge of the axes.
const BOX: [f64; 4] = [78.0, 610.0, 62.0, 364.0];

/// From a number, or its logarithm, to a place.
#[derive(Clone, Copy)]
struct Axis {
    scale: Scale,
    low: f64,
    high: f64,
    from: f64,
    to: f64,
}

impl Axis {
    /// Round numbers below and above all values: 1, 2 or 5 times a power of ten.
    fn over(values: impl Iterator<Item = f64>, from: f64, to: f64) -> Axis {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for x in values {
            low = low.min(x);
            high = high.max(x);
        }
        if low > high {
            (low, high) = (1.0, 10.0);
        }
        let ticks = |x: f64| {
            let decade = x.log10().floor() as i32;
            (decade - 1..=decade + 1).flat_map(|d| [1.0, 2.0, 5.0].map(|m| m * ten_to(d)))
        };
        // A thousandth of slack: a value that is a tick up to rounding needs no other.
        let below = ticks(low).filter(|t| *t <= low * 1.001).fold(low / 10.0, f64::max);
        let above = ticks(high).filter(|t| *t * 1.001 >= high).fold(high * 10.0, f64::min);
        Axis { scale: Scale::Logarithmic, low: below.log10(), high: above.log10(), from, to }
    }

    /// From nought to a little above all values.
    fn from_nought(values: impl Iterator<Item = f64>, from: f64, to: f64) -> Axis {
        let most = values.fold(0.0, f64::max);
        Axis { scale: Scale::Linear, low: 0.0, high: if most > 0.0 { 1.02 * most } else { 1.0 }, from, to }
    }

    fn place(&self, x: f64) -> f64 {
        let x = if self.scale == Scale::Linear { x } else { x.log10() };
        self.from + (x - self.low) / (self.high - self.low) * (self.to - self.from)
    }

    /// Which multiples of powers of ten have names: the fewer powers there are, the more.
    fn named_parts(&self) -> &'static [i32] {
        match self.decades().count() {
            0 | 1 => &[1, 2, 3, 5, 7],
            2 | 3 => &[1, 2, 5],
            _ => &[1],
        }
    }

    /// The grid of a linear axis: four to ten round steps.
    fn steps(&self, out: &mut String, top: f64, bottom: f64) {
        let decade = ten_to(self.high.log10().floor() as i32 - 1);
        let step = [1.0, 2.0, 5.0, 10.0, 20.0].map(|m| m * decade).into_iter().find(|s| self.high / s <= 8.0);
        let step = step.unwrap_or(self.high).max(1.0);
        for k in 0..=(self.high / step) as usize {
            let x = self.place(k as f64 * step);
            let _ = writeln!(
                out,
                "<line x1=\"{x:.1}\" y1=\"{top}\" x2=\"{x:.1}\" y2=\"{bottom}\" stroke=\"#ccc\"/>\n\
                 <text x=\"{x:.1}\" y=\"{}\" text-anchor=\"middle\">{}</text>",
                bottom + 18.0,
                whole((k as f64 * step) as usize)
            );
        }
    }

    /// Powers of ten in the axis.
    fn decades(&self) -> std::ops::RangeInclusive<i32> {
        (self.low - 1e-6).ceil() as i32..=(self.high + 1e-6).floor() as i32
    }
}

/// Logarithms are of positive numbers.
fn shown((x, y): &(f64, f64)) -> bool {
    *x > 0.0 && *y > 0.0 && x.is_finite() && y.is_finite()
}

fn ten_to(exponent: i32) -> f64 {
    10.0_f64.powi(exponent)
}

impl Plot {
    /// The SVG; the same text for the same numbers.
    pub(crate) fn to_svg(&self) -> String {
        let [left, right, top, bottom] = BOX;
        let points = || self.series.iter().flat_map(|s| s.points.iter().copied()).filter(shown);
        let x_axis = match self.x_scale {
            Scale::Linear => Axis::from_nought(points().map(|p| p.0), left, right),
            Scale::Logarithmic => Axis::over(points().map(|p| p.0), left, right),
        };
        let y_axis = Axis::over(points().map(|p| p.1), bottom, top);
        let mut out = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{WIDTH}\" height=\"{HEIGHT}\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" font-family=\"Helvetica, Arial, sans-serif\" font-size=\"13\" fill=\"#222\">\n\
             <rect width=\"{WIDTH}\" height=\"{HEIGHT}\" fill=\"#fff\"/>\n\
             <text x=\"{}\" y=\"24\" font-size=\"15\" text-anchor=\"middle\">{}</text>\n",
            (left + right) / 2.0,
            escaped(&self.title)
        );
        self.grid(&mut out, x_axis, y_axis);
        for s in &self.series {
            let places = s.points.iter().filter(|p| shown(p)).map(|p| (x_axis.place(p.0), y_axis.place(p.1)));
            if s.dots {
                for (x, y) in places {
                    let _ = writeln!(out, "{}", dot(x, y, s.color));
                }
                continue;
            }
            let line: Vec<String> = places.map(|(x, y)| format!("{x:.1},{y:.1}")).collect();
            let dashes = dash_attribute(s.dashes);
            let _ = writeln!(
                out,
                "<polyline fill=\"none\" stroke=\"{}\" stroke-width=\"2\" stroke-linejoin=\"round\"{dashes} points=\"{}\"/>",
                s.color,
                line.join(" ")
            );
        }
        self.legend(&mut out);
        out.push_str("</svg>\n");
        out
    }

    fn grid(&self, out: &mut String, x_axis: Axis, y_axis: Axis) {
        let [left, right, top, bottom] = BOX;
        let (x_parts, y_parts) = (x_axis.named_parts(), y_axis.named_parts());
        if self.x_scale == Scale::Linear {
            x_axis.steps(out, top, bottom);
        }
        let decades = x_axis.decades();
        let logarithmic = self.x_scale == Scale::Logarithmic;
        for d in (*decades.start() - 1..=*decades.end()).filter(|_| logarithmic) {
            for m in 1..10 {
                let value = f64::from(m) * ten_to(d);
                let x = x_axis.place(value);
                if x < left - 0.01 || x > right + 0.01 {
                    continue;
                }
                let named = x_parts.contains(&m);
                let _ = writeln!(
                    out,
                    "<line x1=\"{x:.1}\" y1=\"{top}\" x2=\"{x:.1}\" y2=\"{bottom}\" stroke=\"{}\"/>",
                    if named { "#ccc" } else { "#eee" }
                );
                if named {
                    let _ = writeln!(
                        out,
                        "<text x=\"{x:.1}\" y=\"{}\" text-anchor=\"middle\">{}</text>",
                        bottom + 18.0,
                        named_number(m, d)
                    );
                }
            }
        }
        for d in *y_axis.decades().start() - 1..=*y_axis.decades().end() {
            for m in 1..10 {
                let y = y_axis.place(f64::from(m) * ten_to(d));
                if y < top - 0.01 || y > bottom + 0.01 {
                    continue;
                }
                let named = y_parts.contains(&m);
                let _ = writeln!(
                    out,
                    "<line x1=\"{left}\" y1=\"{y:.1}\" x2=\"{right}\" y2=\"{y:.1}\" stroke=\"{}\"/>",
                    if named { "#ccc" } else { "#eee" }
                );
                if named {
                    let _ = writeln!(
                        out,
                        "<text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
                        left - 7.0,
                        y + 4.5,
                        named_number(m, d)
                    );
                }
            }
        }
        let _ = writeln!(
            out,
            "<rect x=\"{left}\" y=\"{top}\" width=\"{}\" height=\"{}\" fill=\"none\" stroke=\"#444\"/>",
            right - left,
            bottom - top
        );
        let _ = writeln!(
            out,
            "<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">{}</text>",
            (left + right) / 2.0,
            bottom + 42.0,
            escaped(&self.x_label)
        );
        let middle = (top + bottom) / 2.0;
        let _ = writeln!(
            out,
            "<text x=\"14\" y=\"{middle}\" text-anchor=\"middle\" transform=\"rotate(-90 14 {middle})\">{}</text>",
            escaped(&self.y_label)
        );
    }

    /// In a row between the title and the axes, where no curve is.
    fn legend(&self, out: &mut String) {
        let [left, right, top, _] = BOX;
        let step = (right - left) / self.series.len().max(1) as f64;
        let y = top - 16.0;
        for (i, s) in self.series.iter().enumerate() {
            // About as wide as it will be, to stand in the middle of its part of the row.
            let wide = 40.0 + 7.0 * s.name.chars().count() as f64;
            let x = left + step * (i as f64 + 0.5) - 0.5 * wide;
            let mark = match s.dots {
                true => dot(x + 16.0, y, s.color),
                false => format!(
                    "<line x1=\"{x:.1}\" y1=\"{y}\" x2=\"{:.1}\" y2=\"{y}\" stroke=\"{}\" stroke-width=\"2.5\"{}/>",
                    x + 32.0,
                    s.color,
                    dash_attribute(s.dashes)
                ),
            };
            let _ = writeln!(
                out,
                "{mark}\n<text x=\"{:.1}\" y=\"{}\">{}</text>",
                x + 39.0,
                y + 4.5,
                escaped(&s.name)
            );
        }
    }
}

/// A dot that lets others below it show.
fn dot(x: f64, y: f64, color: &str) -> String {
    format!("<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3\" fill=\"{color}\" fill-opacity=\"0.7\"/>")
}

fn dash_attribute(dashes: &str) -> String {
    if dashes.is_empty() { String::new() } else { format!(" stroke-dasharray=\"{dashes}\"") }
}

/// `m` times ten to the `d`: in full from 0.01 to 100 000, else as a power.
fn named_number(m: i32, d: i32) -> String {
    if (0..6).contains(&d) {
        return whole(m as usize * 10_usize.pow(d as u32));
    }
    if (-2..0).contains(&d) {
        return format!("{:.*}", d.unsigned_abs() as usize, f64::from(m) * ten_to(d));
    }
    let raised: String = d
        .to_string()
        .chars()
        .map(|c| match c {
            '-' => '⁻',
            c => "⁰¹²³⁴⁵⁶⁷⁸⁹".chars().nth(c.to_digit(10).unwrap_or(0) as usize).unwrap_or('⁰'),
        })
        .collect();
    if m == 1 { format!("10{raised}") } else { format!("{m}·10{raised}") }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plot() -> Plot {
        Plot {
            title: "a < b".to_owned(),
            x_label: "clusters".to_owned(),
            y_label: "error".to_owned(),
            x_scale: Scale::Logarithmic,
            series: vec![Series {
                name: "pca".to_owned(),
                color: "#d50",
                dashes: "",
                dots: false,
                points: vec![(1.0, 1e-2), (10.0, 1e-3), (100.0, 1e-4), (200.0, 0.0)],
            }],
        }
    }

    #[test]
    fn the_same_numbers_give_the_same_bytes() {
        let svg = plot().to_svg();
        assert_eq!(svg, plot().to_svg());
        assert!(svg.contains("a &lt; b") && !svg.contains("NaN") && !svg.contains("inf"), "{svg}");
    }

    /// A power law is a straight line from corner to corner, and what is not positive is left out.
    #[test]
    fn a_power_law_is_straight() {
        let mut p = plot();
        p.series[0].points.pop();
        let svg = p.to_svg();
        assert!(svg.contains("points=\"78.0,62.0 344.0,213.0 610.0,364.0\""), "{svg}");
    }

    #[test]
    fn a_cloud_of_points_has_a_dot_each_and_no_line() {
        let mut p = plot();
        p.series[0].dots = true;
        let svg = p.to_svg();
        // Three that are positive, and one in the legend.
        assert_eq!((svg.matches("<circle").count(), svg.matches("<polyline").count()), (4, 0));
    }

    #[test]
    fn numbers_are_named_as_people_write_them() {
        let cases = [
            (1, 0, "1"),
            (2, 3, "2,000"),
            (1, 4, "10,000"),
            (5, -1, "0.5"),
            (1, -6, "10⁻⁶"),
            (2, -12, "2·10⁻¹²"),
        ];
        for (m, d, name) in cases {
            assert_eq!(named_number(m, d), name);
        }
    }
}
