//! What `bench build` found: its table and its rows to keep.

use std::io::{self, Write};

use super::ledger::Entry;
use super::peers::Nexus;
use super::table::{Table, three};
use super::targets;

/// What one mesh took.
#[derive(Debug)]
pub(crate) struct Cost {
    /// The mesh.
    pub(crate) name: String,
    /// Its faces.
    pub(crate) faces: usize,
    /// How it was split.
    pub(crate) split: String,
    /// Median of whole processes.
    pub(crate) seconds: f64,
    /// Median processor time of all threads.
    pub(crate) processor: Option<f64>,
    /// Largest peak of the runs, in bytes.
    pub(crate) peak: Option<u64>,
    /// Bytes of the file.
    pub(crate) file: u64,
    /// Median time of cluster LOD in memory on one thread.
    pub(crate) cluster_lod: f64,
    /// One run of the Nexus builder.
    pub(crate) nexus: Option<Nexus>,
}

/// All meshes.
#[derive(Debug)]
pub(crate) struct Costs {
    threads: u32,
    runs: u32,
    costs: Vec<Cost>,
}

impl Cost {
    fn per_second(&self) -> f64 {
        self.faces as f64 / self.seconds
    }

    fn per_face(&self, bytes: u64) -> f64 {
        bytes as f64 / self.faces as f64
    }

    /// Nanoseconds for each face and each halving of the faces: constant where time grows as n log n.
    ///
    /// Of a processor's time where it is known: what else runs on the machine changes it least.
    fn per_n_log_n(&self) -> f64 {
        self.processor.unwrap_or(self.seconds) * 1e9 / (self.faces as f64 * (self.faces as f64).log2())
    }

    /// The figures that are missed. Small meshes have none: what a process costs anyway would be judged.
    fn missed(&self, smallest: Option<&Cost>) -> Vec<String> {
        if self.faces < targets::LARGE {
            return Vec::new();
        }
        let mut missed = Vec::new();
        if self.per_second() < targets::FACES_PER_SECOND {
            missed.push(format!("< {} faces/s", targets::FACES_PER_SECOND));
        }
        if self.seconds > self.cluster_lod {
            missed.push("slower than cluster LOD".to_owned());
        }
        if self.peak.is_some_and(|peak| self.per_face(peak) > targets::PEAK) {
            missed.push(format!("memory > {} bytes/face", targets::PEAK));
        }
        if self.per_face(self.file) > targets::FILE {
            missed.push(format!("file > {} bytes/face", targets::FILE));
        }
        if smallest.is_some_and(|s| self.per_n_log_n() > targets::GROWTH * s.per_n_log_n()) {
            missed.push("grows faster than n log n".to_owned());
        }
        missed
    }
}

impl Costs {
    /// Of so many threads, each the median of so many runs.
    pub(crate) fn new(threads: u32, runs: u32) -> Costs {
        Costs { threads, runs, costs: Vec::new() }
    }

    /// Adds a mesh.
    pub(crate) fn add(&mut self, cost: Cost) {
        self.costs.push(cost);
    }

    /// Growth is held against the smallest generated mesh: meshes of one kind.
    fn smallest(&self, cost: &Cost) -> Option<&Cost> {
        let kind = |c: &Cost| c.name.starts_with("sculpture-");
        self.costs.iter().filter(|c| kind(c) && kind(cost)).min_by_key(|c| c.faces)
    }

    /// Writes the table.
    ///
    /// # Errors
    /// Those of `out`.
    pub(crate) fn print(&self, out: &mut impl Write) -> io::Result<()> {
        writeln!(out, "\nfcbuild with {} threads, median of {}\n", self.threads, self.runs)?;
        let mut table = Table::new(&[
            "mesh",
            "faces",
            "split",
            "s",
            "processor s",
            "faces/s",
            "ns/n log2 n",
            "peak MB",
            "bytes/face",
            "file bytes/face",
            "cluster LOD s",
            "time/cluster LOD",
            "Nexus s",
            "Nexus faces/s",
            "Nexus file bytes/face",
            "missed",
        ]);
        let or_dash = |x: Option<f64>| x.map_or_else(|| "-".to_owned(), three);
        for c in &self.costs {
            table.row(vec![
                c.name.clone(),
                c.faces.to_string(),
                c.split.clone(),
                three(c.seconds),
                or_dash(c.processor),
                format!("{:.0}", c.per_second()),
                three(c.per_n_log_n()),
                or_dash(c.peak.map(|b| b as f64 / 1e6)),
                or_dash(c.peak.map(|b| c.per_face(b))),
                three(c.per_face(c.file)),
                three(c.cluster_lod),
                format!("{:.2}", c.seconds / c.cluster_lod),
                or_dash(c.nexus.map(|n| n.seconds)),
                or_dash(c.nexus.map(|n| (c.faces as f64 / n.seconds).round())),
                or_dash(c.nexus.map(|n| c.per_face(n.file))),
                c.missed(self.smallest(c)).join(", "),
            ]);
        }
        table.print(out)
    }

    /// Rows to keep.
    pub(crate) fn entries(&self) -> Vec<Entry> {
        let how = format!("cargo xtask bench build, whole process, median of {}", self.runs);
        let mut entries = Vec::new();
        for c in &self.costs {
            let mut add = |what: &str, value: Option<f64>, unit: &'static str, setting: String, how: &str| {
                entries.extend(value.map(|value| Entry {
                    what: what.to_owned(),
                    input: format!("{} ({} faces)", c.name, c.faces),
                    setting,
                    value: three(value),
                    unit,
                    how: how.to_owned(),
                }));
            };
            let ours = || format!("--split {} --threads {}", c.split, self.threads);
            add("fcbuild wall time", Some(c.seconds), "s", ours(), &how);
            add("fcbuild processor time", c.processor, "s", ours(), "the same runs");
            add(
                "fcbuild peak memory",
                c.peak.map(|b| c.per_face(b)),
                "bytes a face",
                ours(),
                "largest of the same runs",
            );
            add("file size", Some(c.per_face(c.file)), "bytes a face", ours(), "the same runs");
            let memory = "cargo xtask bench build, in memory, in turns with fcbuild";
            add("cluster LOD wall time", Some(c.cluster_lod), "s", "1 thread".to_owned(), memory);
            let once = "cargo xtask bench build, through pymeshlab, one run";
            let set = || "as pymeshlab sets it".to_owned();
            add("Nexus builder wall time", c.nexus.map(|n| n.seconds), "s", set(), once);
            let file = c.nexus.map(|n| c.per_face(n.file));
            add("Nexus file size", file, "bytes a face", set(), "the same run, not compressed");
        }
        entries
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cost(name: &str, faces: usize, seconds: f64) -> Cost {
        Cost {
            name: name.into(),
            faces,
            split: "paper".into(),
            seconds,
            processor: Some(2.0 * seconds),
            peak: Some(150 * faces as u64),
            file: 40 * faces as u64,
            cluster_lod: 1.5 * seconds,
            nexus: None,
        }
    }

    #[test]
    fn figures_are_judged_one_by_one() {
        assert!(cost("a", 4_000_000, 5.0).missed(None).is_empty());
        assert!(cost("small", 10_000, 5.0).missed(None).is_empty());
        let bad = Cost { peak: Some(1 << 40), file: 1 << 40, cluster_lod: 1.0, ..cost("a", 4_000_000, 50.0) };
        assert_eq!(bad.missed(Some(&cost("b", 1_000_000, 1.0))).len(), 5);
    }

    /// 4 million faces in 4.4 times the time of 1 million are n log n; in 6 times they are not.
    #[test]
    fn growth_is_held_against_the_smallest_of_the_kind() {
        let mut costs = Costs::new(2, 3);
        for (name, faces, seconds) in
            [("dragon", 900_000, 0.1), ("sculpture-1m", 1_000_000, 1.0), ("sculpture-4m", 4_000_000, 4.4)]
        {
            costs.add(cost(name, faces, seconds));
        }
        let missed = |c: &Costs| c.costs[2].missed(c.smallest(&c.costs[2]));
        assert!(missed(&costs).is_empty());
        costs.costs[2].processor = Some(12.0);
        assert_eq!(missed(&costs), ["grows faster than n log n"]);
        assert!(costs.entries().iter().all(|e| e.value != "-") && costs.entries().len() == 15);
    }
}
