//! The summary on standard output.

use super::report::Report;
use fct::{Size, counted, grouped};

/// A few lines for people, from the numbers of the report.
pub(crate) fn of(output: &str, report: &Report) -> String {
    let c = &report.counts;
    let mut lines = vec![format!("wrote {output}")];
    let mut line = |name: &str, text: String| lines.push(format!("  {name:8} {text}"));

    let dropped: Vec<_> =
        report.dropped.iter().map(|d| format!("{} {}", d.reason, grouped(d.count))).collect();
    let by_reason = if dropped.is_empty() { String::new() } else { format!(" ({})", dropped.join(", ")) };
    line(
        "faces",
        format!(
            "{} in, {} kept, {} dropped{by_reason}",
            grouped(c.faces_in),
            grouped(c.faces_kept),
            grouped(c.faces_dropped)
        ),
    );
    let kind = if c.closed { "closed" } else { "open" };
    line(
        "surface",
        format!(
            "{kind}, {}, {}, {}, {}",
            counted(c.components, "component"),
            counted(c.groups, "group"),
            counted(c.boundary_edges, "boundary edge"),
            counted(c.seam_edges, "seam edge")
        ),
    );
    line("tree", format!("{}, depth {}", counted(c.nodes, "node"), c.depth));
    line(
        "file",
        format!("{}, {:.1} bytes a face", Size::of_bytes(report.file.bytes), report.file.bytes_per_face),
    );
    let estimated = Size::of_bytes(report.memory.estimated_bytes);
    line(
        "memory",
        match report.memory.peak_bytes {
            Some(peak) => format!("{} at the peak, {estimated} estimated", Size::of_bytes(peak)),
            None => format!("{estimated} estimated"),
        },
    );
    let total = report.seconds.total;
    let phases: Vec<_> =
        report.seconds.phases.iter().map(|(name, seconds)| format!("{name} {seconds:.2}")).collect();
    let rate = if total > 0.0 { c.faces_in as f64 / total } else { 0.0 };
    line("time", format!("{total:.2} s, {} faces a second ({})", grouped(rate as u64), phases.join(", ")));
    lines.join("\n") + "\n"
}
