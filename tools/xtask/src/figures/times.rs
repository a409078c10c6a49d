//! How long the partition takes, by mode and by size of the mesh.
//!
//! # Paper
//! `[TsujiJa]` table 1.

use super::model::Model;
use super::modes;
use super::page::{listed, table, three, verdict, whole};
use std::error::Error;
use std::fmt::Write as _;

/// Times of one mesh; the median of these is shown.
const RUNS: usize = 3;

/// Seconds of the paper by number of faces: sphere, bottle, bunny and dragon.
const PAPERS: [(usize, f64); 4] = [(8_192, 0.156), (34_445, 0.906), (69_473, 1.992), (871_414, 23.125)];

/// Measures every mode on every mesh; the meshes ascend in size.
///
/// # Errors
/// When no pool of one thread can be made.
pub(crate) fn measure(models: &[&Model]) -> Result<String, Box<dyn Error>> {
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let threads = rayon::current_num_threads();
    let mut text = String::from(
        "# Times of the partition ([TsujiJa] table 1)\n\n\
         From a welded mesh in memory to the tree of clusters, without reading, boundaries, bounds and writing.\n",
    );
    let _ = writeln!(
        text,
        "Medians of {RUNS} runs, in seconds, on {} ({}) with {threads} threads; this file alone among the figures changes from run to run and from machine to machine.\n",
        std::env::consts::ARCH,
        std::env::consts::OS
    );
    let mut head = vec!["mesh".to_owned(), "faces".to_owned(), "vertices".to_owned()];
    head.extend(modes::ALL.iter().map(|m| format!("`{}`, 1 / {threads} threads", m.name())));
    let (mut rows, mut seconds) = (Vec::new(), Vec::new());
    for model in models {
        let mut row = vec![model.name.clone(), whole(model.faces()), whole(model.mesh.positions.len())];
        let single: Vec<f64> = modes::ALL.iter().map(|m| one.install(|| median(model, *m))).collect();
        let all = modes::ALL.iter().map(|m| median(model, *m));
        row.extend(single.iter().zip(all).map(|(one, all)| match one.is_finite() {
            true => format!("{} / {}", three(*one), three(all)),
            false => "–".to_owned(),
        }));
        eprintln!("times of {}: {} s", model.name, row[3..].join(", "));
        rows.push(row);
        seconds.push(single);
    }
    text += &table(&head.iter().map(String::as_str).collect::<Vec<_>>(), &rows);
    text.push('\n');
    text += &growth(models, &seconds);
    let papers: Vec<String> = PAPERS.iter().map(|(n, s)| format!("{s} s for {} faces", whole(*n))).collect();
    let _ = writeln!(text, "[TsujiJa] prints {}, by PCA alone on a Pentium 4 of 2 GHz.", listed(&papers));
    let [(n, first), (m, last)] = [PAPERS[0], PAPERS[3]];
    let _ = writeln!(
        text,
        "From its smallest mesh to its largest, time grows {} times there, and n log n {} times.",
        three(last / first),
        three(n_log_n(m) / n_log_n(n))
    );
    let slowest = seconds.iter().flatten().copied().filter(|s| s.is_finite()).fold(0.0, f64::max);
    let _ = writeln!(
        text,
        "\n- [TsujiJa] says that a model of about a million polygons takes less than a minute.\n  {}\n  \
         The slowest of all took {} s here; other programs that ran meanwhile are in these times.",
        verdict(slowest < 60.0),
        three(slowest)
    );
    Ok(text)
}

/// Seconds; not a number for a tree that fell back to another mode.
fn median(model: &Model, mode: modes::Mode) -> f64 {
    if !model.has(mode) {
        return f64::NAN;
    }
    let mut times: Vec<f64> = (0..RUNS).map(|_| model.partition_time(mode).as_secs_f64()).collect();
    times.sort_unstable_by(f64::total_cmp);
    times[RUNS / 2]
}

fn n_log_n(n: usize) -> f64 {
    n as f64 * (n as f64).ln()
}

/// How time grows from the smallest mesh to the largest, against n log n.
fn growth(models: &[&Model], seconds: &[Vec<f64>]) -> String {
    let (Some(small), Some(large)) = (models.first(), models.last()) else { return String::new() };
    let (Some(first), Some(last)) = (seconds.first(), seconds.last()) else { return String::new() };
    let grown: Vec<String> = modes::ALL
        .iter()
        .enumerate()
        .map(|(i, mode)| (last[i] / first[i], mode))
        .filter(|(times, _)| times.is_finite())
        .map(|(times, mode)| format!("{} for `{}`", three(times), mode.name()))
        .collect();
    format!(
        "From {} to {} faces n log n grows {} times; the time on one thread grows by a factor of {}.\n\n",
        whole(small.faces()),
        whole(large.faces()),
        three(n_log_n(large.faces()) / n_log_n(small.faces())),
        listed(&grown)
    )
}
