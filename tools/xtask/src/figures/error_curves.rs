//! Mean modelling error against the number of clusters.
//!
//! # Paper
//! `[Tsuji07]` figure 9, and the three means of figure 10.

use super::front::mean_errors;
use super::model::Model;
use super::modes;
use super::output::Output;
use super::page::{Panel, listed, panels, table, three, verdict, whole};
use super::plot::{Plot, Scale, Series};
use std::error::Error;
use std::fmt::Write as _;

/// Clusters of figure 10.
const COUNT: usize = 250;

/// The paper's means of figure 10 by PCA, CCA and both; their unit is not given, so ratios are compared.
const PAPERS_MEANS: [f64; 3] = [53.4, 33.7, 24.4];

/// Curves start here; below, a cluster is half of the model.
const FIRST: usize = 10;

/// Numbers of clusters, twelve to a decade, up to an eighth of the faces.
fn counts(faces: usize) -> Vec<usize> {
    let (mut counts, mut x) = (Vec::new(), FIRST as f64);
    while x <= faces as f64 / 8.0 {
        counts.push(x.round() as usize);
        // The twelfth root of ten.
        x *= 1.211_527_658_628_588_6;
    }
    counts
}

/// The means of a model at [`COUNT`] clusters, and how often the paper's order holds along the curves.
struct Outcome {
    means: Vec<f64>,
    in_order: usize,
    both_best: usize,
    quality_best: usize,
    of: usize,
}

/// Plots the curves of each model; returns the text for the page.
///
/// # Errors
/// Those of the output folder.
pub(crate) fn section(models: &[&Model], out: &Output) -> Result<String, Box<dyn Error>> {
    let mut text = String::from(
        "## Mean modelling error against the number of clusters ([Tsuji07] figure 9)\n\n\
         The cluster of the largest epsilon is split until there are so many clusters; epsilon is the mean square distance of a cluster from its plane.\n\
         The mean is the sum of area times epsilon over the sum of areas, here divided by the square of the diagonal of the model's box, so that it has no unit: 10⁻⁶ is a root mean square of a thousandth of the diagonal.\n\
         On the right the same curves stand over that of PCA.\n\n",
    );
    let (mut list, mut rows, mut outcomes) = (Vec::new(), Vec::new(), Vec::new());
    for model in models {
        let outcome = curves(model, out)?;
        for (what, words) in [("error", "mean modelling error"), ("ratio", "error over that of PCA")] {
            list.push(Panel {
                file: format!("{what}-{}.svg", model.name),
                alt: format!("{} of {}, a curve a mode, against clusters", words, model.name),
                caption: format!("{}: {words}", model.name),
            });
        }
        let means = &outcome.means;
        let mut row = vec![format!("{} ({} faces)", model.name, whole(model.faces()))];
        row.extend(means.iter().map(|m| match m.is_finite() {
            true => format!("{} ({})", three(m * 1e6), three(m / means[0])),
            false => "–".to_owned(),
        }));
        rows.push(row);
        outcomes.push((model.name.clone(), outcome));
    }
    let mut paper = vec!["bunny as printed (unit not given)".to_owned()];
    paper.extend(PAPERS_MEANS.map(|m| format!("{m} ({})", three(m / PAPERS_MEANS[0]))));
    paper.resize(modes::ALL.len() + 1, "–".to_owned());
    rows.push(paper);
    let names: Vec<String> = modes::ALL.iter().map(|m| format!("`{}`", m.name())).collect();
    let mut head = vec!["mean error of 250 clusters, in 10⁻⁶ squared diagonals (over that of PCA)"];
    head.extend(names.iter().map(String::as_str));
    let _ = write!(text, "{}\n{}\n{}", panels(&list, 2), table(&head, &rows), judged(&outcomes));
    Ok(text)
}

fn curves(model: &Model, out: &Output) -> Result<Outcome, Box<dyn Error>> {
    let mut counts = counts(model.faces());
    if let Err(place) = counts.binary_search(&COUNT) {
        counts.insert(place, COUNT);
    }
    let mut all = Vec::new();
    for mode in modes::ALL {
        eprintln!("mean errors of {}, {}", model.name, mode.name());
        all.push(if model.has(*mode) {
            mean_errors(model, &model.hierarchy(*mode), &counts)
        } else {
            vec![f64::NAN; counts.len()]
        });
    }
    let plot = |what: &str, y_label: &str, value: &dyn Fn(usize, usize) -> f64| {
        let series = modes::ALL.iter().enumerate().map(|(m, mode)| Series {
            name: mode.name().to_owned(),
            color: mode.color,
            dashes: mode.dashes,
            dots: false,
            points: counts.iter().enumerate().map(|(i, c)| (*c as f64, value(m, i))).collect(),
        });
        let plot = Plot {
            title: format!("{}, {} faces", model.name, whole(model.faces())),
            x_label: "clusters".to_owned(),
            y_label: y_label.to_owned(),
            x_scale: Scale::Logarithmic,
            series: series.filter(|s| s.points.iter().any(|p| p.1.is_finite())).collect(),
        };
        out.write(&format!("{what}-{}.svg", model.name), plot.to_svg().as_bytes())
    };
    plot("error", "mean modelling error, squared diagonals", &|m, i| all[m][i])?;
    plot("ratio", "mean modelling error over that of PCA", &|m, i| all[m][i] / all[0][i])?;
    let at = |name: &str, i: usize| {
        let mode = modes::ALL.iter().position(|m| m.name() == name);
        mode.and_then(|m| all.get(m)).map_or(f64::NAN, |means| means[i])
    };
    let count_where = |holds: &dyn Fn(usize) -> bool| (0..counts.len()).filter(|i| holds(*i)).count();
    let place = counts.iter().position(|c| *c == COUNT).unwrap_or(0);
    Ok(Outcome {
        means: all.iter().map(|means| means[place]).collect(),
        in_order: count_where(&|i| at("cca", i) < at("pca", i)),
        both_best: count_where(&|i| at("paper", i) < at("pca", i) && at("paper", i) < at("cca", i)),
        quality_best: count_where(&|i| at("quality", i) < at("paper", i)),
        of: counts.len(),
    })
}

/// What the paper says of figures 9 and 10, held against the curves.
fn judged(outcomes: &[(String, Outcome)]) -> String {
    let claim = |said: &str, held: &dyn Fn(&Outcome) -> usize, remark: &str| {
        let exact = outcomes.iter().all(|(_, o)| held(o) == o.of);
        let mostly = outcomes.iter().all(|(_, o)| held(o) * 2 > o.of);
        let shares: Vec<String> =
            outcomes.iter().map(|(n, o)| format!("{} of {} ({n})", held(o), o.of)).collect();
        let stands = if !exact && mostly { "**Reproduces mostly.**" } else { verdict(exact) };
        format!("- {said}\n  {stands}\n  It holds at {} numbers of clusters.\n{remark}", listed(&shares))
    };
    let mut out = claim(
        "[Tsuji07] says that PCA and CCA together have a lower error than either alone.",
        &|o| o.both_best,
        "  The choice between two cuts looks one level ahead, so it may lose further down.\n",
    );
    out += &claim("[Tsuji07] says that CCA has in general a lower error than PCA.", &|o| o.in_order, "");
    let shares: Vec<String> =
        outcomes.iter().map(|(n, o)| format!("{} of {} ({n})", o.quality_best, o.of)).collect();
    let _ = writeln!(
        out,
        "- This project's own mode, `quality`, has a lower error than the paper's at {} numbers of clusters.\n  \
         It is not built for this measure: it merges where the error rises least for each triangle saved, and refines in an order of its own, which this front by epsilon ignores.",
        listed(&shares)
    );
    let close = outcomes.iter().find(|(n, _)| n == "bunny").map(|(_, o)| {
        let ours: Vec<String> = o.means.iter().take(3).map(|m| three(m / o.means[0])).collect();
        let papers = PAPERS_MEANS.map(|m| three(m / PAPERS_MEANS[0]));
        format!(
            "- [Tsuji07] prints means for 250 clusters of the bunny that stand like {}, by PCA, CCA and both; here they stand like {}.\n",
            papers.join(" : "),
            ours.join(" : ")
        )
    });
    out += &close.unwrap_or_default();
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_ascend_and_stay_below_the_faces() {
        let c = counts(70_000);
        assert!(c.windows(2).all(|w| w[0] < w[1]), "{c:?}");
        assert_eq!(c[0], 10);
        assert_eq!(c[12], 100);
        assert!(*c.last().unwrap() <= 8_750);
    }
}
