//! What `bench quality` found: its tables and its rows to keep.

use std::io::{self, Write};

use super::distance::Distance;
use super::input::Input;
use super::ledger::Entry;
use super::table::{Table, three};
use super::targets::{self, Size};

/// A peer's number of triangles may be so far from ours, as a share, before the comparison is unfair.
const EQUAL: f64 = 0.02;

/// Or so far in triangles: what one collapse may leave or take, twice.
const EQUAL_TRIANGLES: u64 = 4;

/// A mesh of ours.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ours {
    /// Triangles drawn.
    pub(crate) triangles: u64,
    /// From the input.
    pub(crate) distance: Distance,
}

/// A mesh of another program.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Peer {
    /// Triangles it reached.
    pub(crate) triangles: u64,
    /// From the input.
    pub(crate) distance: Distance,
}

/// One line of the table of cluster LOD, of the budget order, or of the guaranteed order.
#[derive(Debug)]
struct Line {
    mesh: String,
    faces: usize,
    split: String,
    size: String,
    ours: Ours,
    peers: [Option<Peer>; 3],
    /// The number of triangles is the peer's own, and what we leave of it is our loss.
    own_number: bool,
    missed: Vec<String>,
    judged: usize,
}

/// All lines, by table.
#[derive(Debug, Default)]
pub(crate) struct Scores {
    mesh: String,
    faces: usize,
    split: String,
    budget: Vec<Line>,
    guaranteed: Vec<Line>,
    cluster_lod: Vec<Line>,
}

impl Scores {
    /// The lines that follow are of this mesh.
    pub(crate) fn begin(&mut self, input: &Input, split: &str) {
        (self.mesh, self.faces, self.split) = (input.name.clone(), input.mesh.faces.len(), split.to_owned());
    }

    /// A cut in the budget order, and simplifications: the input's vertices, moved vertices, optimal placement.
    pub(crate) fn budget(&mut self, size: Size, ours: Ours, kept: Peer, moved: Peer, quadrics: Option<Peer>) {
        let mut line = self.line(size.to_string(), ours, [Some(kept), Some(moved), quadrics]);
        line.judge("RMS", line.rms(kept), targets::rms(&self.mesh, size));
        line.judge("max", line.max(kept), targets::MAX);
        if let Some(quadrics) = quadrics {
            line.judge("stretch", line.rms(quadrics), targets::STRETCH);
        }
        self.budget.push(line);
    }

    /// A cut in the guaranteed order, and simplification with the input's vertices.
    pub(crate) fn guaranteed(&mut self, size: Size, ours: Ours, kept: Peer) {
        let mut line = self.line(size.to_string(), ours, [Some(kept), None, None]);
        if let Some(limit) = targets::guaranteed_rms(size.of(self.faces)) {
            line.judge("RMS", line.rms(kept), limit);
        }
        self.guaranteed.push(line);
    }

    /// A cut in the budget order at the size of one of cluster LOD.
    pub(crate) fn cluster_lod(&mut self, ours: Ours, peer: Peer) {
        let mut line = self.line(peer.triangles.to_string(), ours, [Some(peer), None, None]);
        line.own_number = true;
        line.judge("RMS", line.rms(peer), targets::CLUSTER_LOD);
        self.cluster_lod.push(line);
    }

    fn line(&self, size: String, ours: Ours, peers: [Option<Peer>; 3]) -> Line {
        let (mesh, faces, split) = (self.mesh.clone(), self.faces, self.split.clone());
        Line { mesh, faces, split, size, ours, peers, own_number: false, missed: Vec::new(), judged: 0 }
    }

    /// Writes the tables and how many figures were met.
    ///
    /// # Errors
    /// Those of `out`.
    pub(crate) fn print(&self, out: &mut impl Write) -> io::Result<()> {
        writeln!(
            out,
            "\nBudget order; simplify: meshoptimizer with the input's vertices, moved: with moved ones,"
        )?;
        writeln!(out, "quadrics: MeshLab with optimal placement; distances in {}\n", super::quality::UNIT)?;
        let mut table = Table::new(&[
            "mesh",
            "size",
            "triangles",
            "RMS",
            "max",
            "simplify",
            "max",
            "moved",
            "max",
            "quadrics",
            "max",
            "RMS/simplify",
            "/moved",
            "/quadrics",
            "max/simplify",
            "missed",
        ]);
        for line in &self.budget {
            let mut cells = line.cells();
            cells.extend(line.peers.iter().flat_map(|p| peer_cells(*p)));
            cells.extend(line.peers.iter().map(|p| p.map_or_else(dash, |p| line.rms(p).to_string())));
            cells.push(line.peers[0].map_or_else(dash, |p| line.max(p).to_string()));
            cells.push(line.missed.join(", "));
            table.row(cells);
        }
        table.print(out)?;
        for (title, peer, lines) in [
            ("Guaranteed order", "simplify", &self.guaranteed),
            ("At the cuts of cluster LOD, budget order", "cluster LOD", &self.cluster_lod),
        ] {
            writeln!(out, "{title}\n")?;
            let ratio = format!("RMS/{peer}");
            let mut table = Table::new(&[
                "mesh",
                "size",
                "triangles",
                "RMS",
                "max",
                peer,
                "max",
                &ratio,
                "max ratio",
                "missed",
            ]);
            for line in lines {
                let mut cells = line.cells();
                cells.extend(peer_cells(line.peers[0]));
                cells.push(line.peers[0].map_or_else(dash, |p| line.rms(p).to_string()));
                cells.push(line.peers[0].map_or_else(dash, |p| line.max(p).to_string()));
                cells.push(line.missed.join(", "));
                table.row(cells);
            }
            table.print(out)?;
        }
        let lines = || [&self.budget, &self.guaranteed, &self.cluster_lod].into_iter().flatten();
        let judged: usize = lines().map(|l| l.judged).sum();
        let missed: usize = lines().map(|l| l.missed.len()).sum();
        writeln!(out, "{} of {judged} figures met", judged - missed)
    }

    /// Rows to keep, one a line of a table.
    pub(crate) fn entries(&self, samples: u32) -> Vec<Entry> {
        let how = format!("cargo xtask bench quality, {samples} samples each way");
        let entry = |line: &Line, what: &str, order: &str, peers: usize, value: fn(&Distance) -> f64| {
            let distances = line.peers[..peers].iter().map(|p| p.as_ref().map(|p| &p.distance));
            let all = std::iter::once(Some(&line.ours.distance)).chain(distances);
            Entry {
                what: what.to_owned(),
                input: format!("{} ({} faces)", line.mesh, line.faces),
                setting: format!(
                    "--split {}; {order}; size {}, {} triangles",
                    line.split, line.size, line.ours.triangles
                ),
                value: all.map(|d| d.map_or_else(dash, |d| three(value(d)))).collect::<Vec<_>>().join(" : "),
                unit: super::quality::UNIT,
                how: how.clone(),
            }
        };
        let mut entries = Vec::new();
        for line in &self.budget {
            let peers = "ours : simplify : moved : quadrics";
            entries.push(entry(line, &format!("RMS distance, {peers}"), "budget order", 3, |d| d.rms));
            entries.push(entry(line, &format!("largest distance, {peers}"), "budget order", 3, |d| d.max));
        }
        for line in &self.guaranteed {
            entries.push(entry(line, "RMS distance, ours : simplify", "guaranteed order", 1, |d| d.rms));
        }
        for line in &self.cluster_lod {
            entries.push(entry(line, "RMS distance, ours : cluster LOD", "budget order", 1, |d| d.rms));
        }
        entries
    }
}

impl Line {
    fn cells(&self) -> Vec<String> {
        let Distance { rms, max, .. } = self.ours.distance;
        vec![self.mesh.clone(), self.size.clone(), self.ours.triangles.to_string(), three(rms), three(max)]
    }

    fn rms(&self, peer: Peer) -> Ratio {
        Ratio { value: self.ours.distance.rms / peer.distance.rms, fair: self.is_fair(peer) }
    }

    fn max(&self, peer: Peer) -> Ratio {
        Ratio { value: self.ours.distance.max / peer.distance.max, fair: self.is_fair(peer) }
    }

    fn is_fair(&self, peer: Peer) -> bool {
        if self.own_number {
            return self.ours.triangles <= peer.triangles;
        }
        let difference = self.ours.triangles.abs_diff(peer.triangles);
        difference <= EQUAL_TRIANGLES || difference as f64 <= EQUAL * self.ours.triangles as f64
    }

    /// Remembers a ratio that is over its limit.
    fn judge(&mut self, what: &str, ratio: Ratio, limit: f64) {
        if ratio.fair {
            self.judged += 1;
            // A distance that is no number is over every limit.
            if ratio.value.is_nan() || ratio.value > limit {
                self.missed.push(format!("{what} > {limit}"));
            }
        }
    }
}

/// Ours over a peer's.
#[derive(Debug, Clone, Copy)]
struct Ratio {
    value: f64,
    /// Whether the numbers of triangles are about the same.
    fair: bool,
}

impl std::fmt::Display for Ratio {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}{:.2}", if self.fair { "" } else { "~" }, self.value)
    }
}

fn peer_cells(peer: Option<Peer>) -> [String; 2] {
    peer.map_or_else(|| [dash(), dash()], |p| [three(p.distance.rms), three(p.distance.max)])
}

fn dash() -> String {
    "-".to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ours(triangles: u64, rms: f64) -> Ours {
        Ours { triangles, distance: Distance { rms, max: 4.0 * rms, color_rms: None } }
    }

    fn peer(triangles: u64, rms: f64) -> Peer {
        Peer { triangles, distance: Distance { rms, max: 4.0 * rms, color_rms: None } }
    }

    fn scores() -> Scores {
        let mut scores =
            Scores { mesh: "bunny".into(), faces: 60_000, split: "paper".into(), ..Scores::default() };
        scores.budget(Size::Count(5_000), ours(4_998, 0.9), peer(4_998, 1.0), peer(4_998, 0.8), None);
        scores.budget(Size::Count(250), ours(250, 0.9), peer(400, 0.5), peer(250, 0.8), None);
        scores.guaranteed(Size::Count(5_000), ours(4_998, 1.5), peer(4_998, 1.0));
        scores.cluster_lod(ours(7_000, 0.5), peer(7_000, 1.0));
        scores
    }

    /// 0.9 is over 0.85; a peer that stopped at 400 of 250 triangles is shown but not judged.
    #[test]
    fn missed_figures_are_marked_and_unfair_ones_are_not() {
        let mut out = Vec::new();
        scores().print(&mut out).unwrap();
        let text = String::from_utf8(out).unwrap();
        assert!(
            text.contains("RMS > 0.85") && text.contains("~1.80") && text.contains("RMS > 1\n"),
            "{text}"
        );
        assert!(text.ends_with("2 of 4 figures met\n"), "{text}");
    }

    #[test]
    fn rows_to_keep_hold_every_line() {
        let entries = scores().entries(1_000);
        assert_eq!(entries.len(), 6);
        assert_eq!(entries[0].value, "0.900 : 1.00 : 0.800 : -");
        assert_eq!(entries[0].setting, "--split paper; budget order; size 5000, 4998 triangles");
    }
}
