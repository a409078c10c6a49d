//! The report: what was read, kept, dropped, warned about, written, and how long it took, as JSON.

use super::job::Made;
use super::message::{Notice, notices};
use super::settings::Settings;
use super::{memory, summary};
use fcbuild::import::DropReason;
use fct::Written;
use serde::{Serialize, Serializer};
use std::time::Duration;

/// Raised when a key changes its meaning or goes away; new keys do not raise it.
const SCHEMA: u32 = 1;

/// Everything that is known when the tree is in its place. Serialised as it stands.
#[derive(Debug, Serialize)]
pub(crate) struct Report {
    schema: u32,
    generator: String,
    inputs: Vec<String>,
    output: String,
    settings: SettingsPart,
    pub(crate) counts: Counts,
    pub(crate) dropped: Vec<Dropped>,
    warnings: Vec<Notice>,
    pub(crate) seconds: Seconds,
    pub(crate) memory: Memory,
    pub(crate) file: FilePart,
}

#[derive(Debug, Serialize)]
struct SettingsPart {
    split: String,
    weld: String,
    color_weight: f64,
    flip: bool,
    join_groups: bool,
    threads: usize,
    max_memory: Option<u64>,
    chunk_faces: u32,
    strict: bool,
}

#[derive(Debug, Serialize)]
pub(crate) struct Counts {
    pub(crate) polygons_in: u64,
    pub(crate) vertices_in: u64,
    /// `faces_kept` plus the sum of what was dropped.
    pub(crate) faces_in: u64,
    pub(crate) faces_kept: u64,
    pub(crate) faces_dropped: u64,
    pub(crate) vertices: u64,
    pub(crate) nodes: u64,
    pub(crate) depth: u32,
    pub(crate) components: u64,
    pub(crate) groups: u64,
    pub(crate) boundary_edges: u64,
    pub(crate) seam_edges: u64,
    pub(crate) closed: bool,
}

/// Faces dropped for one reason.
#[derive(Debug, Serialize)]
pub(crate) struct Dropped {
    pub(crate) reason: &'static str,
    pub(crate) count: u64,
    first_ids: Vec<u64>,
}

/// Wall time.
#[derive(Debug, Serialize)]
pub(crate) struct Seconds {
    pub(crate) total: f64,
    /// In the order of the work: import, the phases of the build, write.
    #[serde(flatten, serialize_with = "as_map")]
    pub(crate) phases: Vec<(&'static str, f64)>,
}

/// Bytes of memory; null where the system does not tell.
#[derive(Debug, Serialize)]
pub(crate) struct Memory {
    pub(crate) peak_bytes: Option<u64>,
    pub(crate) estimated_bytes: u64,
    limit_bytes: Option<u64>,
}

#[derive(Debug, Serialize)]
pub(crate) struct FilePart {
    pub(crate) bytes: u64,
    pub(crate) bytes_per_face: f64,
    #[serde(serialize_with = "as_map")]
    sections: Vec<(String, u64)>,
    pub(crate) content_id: String,
    source_id: String,
}

impl Report {
    /// Gathers everything; `write` and `total` are wall times.
    pub(crate) fn new(
        settings: &Settings,
        made: &Made,
        written: &Written,
        write: Duration,
        total: Duration,
    ) -> Report {
        let (meta, tally) = (&made.built.meta, &made.built.tally);
        let data = made.built.data();
        let mut phases = vec![("import", made.import.as_secs_f64())];
        phases.extend(made.built.times.iter().map(|(phase, time)| (phase.as_str(), time.as_secs_f64())));
        phases.push(("write", write.as_secs_f64()));
        Report {
            schema: SCHEMA,
            generator: meta.generator.clone(),
            inputs: settings.inputs.iter().map(|p| p.to_string_lossy().into_owned()).collect(),
            output: settings.output.to_string_lossy().into_owned(),
            settings: SettingsPart {
                split: meta.split.clone(),
                weld: meta.weld.clone(),
                color_weight: settings.color_weight,
                flip: settings.flip,
                join_groups: settings.join_groups,
                threads: settings.threads,
                max_memory: settings.max_memory.as_ref().map(|limit| limit.bytes()),
                chunk_faces: settings.chunk_faces,
                strict: settings.strict,
            },
            counts: Counts {
                polygons_in: tally.polygons_in,
                vertices_in: made.vertices_in,
                faces_in: tally.faces_in,
                faces_kept: meta.faces_kept,
                faces_dropped: tally.dropped.total(),
                vertices: data.vertices.len() as u64,
                nodes: meta.faces_kept.saturating_sub(1),
                depth: meta.depth,
                components: meta.components,
                groups: data.groups.len().max(1) as u64,
                boundary_edges: meta.boundary_edges,
                seam_edges: meta.seam_edges,
                closed: meta.closed,
            },
            dropped: DropReason::ALL
                .into_iter()
                .filter(|&reason| tally.dropped.count(reason) > 0)
                .map(|reason| Dropped {
                    reason: reason.as_str(),
                    count: tally.dropped.count(reason),
                    first_ids: tally.dropped.first_ids(reason).to_vec(),
                })
                .collect(),
            warnings: notices(tally),
            seconds: Seconds { total: total.as_secs_f64(), phases },
            memory: Memory {
                peak_bytes: memory::peak(),
                estimated_bytes: made.estimate,
                limit_bytes: settings.max_memory.as_ref().map(|limit| limit.bytes()),
            },
            file: FilePart {
                bytes: written.bytes,
                bytes_per_face: written.bytes as f64 / meta.faces_kept.max(1) as f64,
                sections: written.sections.clone(),
                content_id: format!("{:032x}", written.content_id),
                source_id: format!("{:032x}", made.source_id),
            },
        }
    }

    /// The text of the file.
    pub(crate) fn to_json(&self) -> String {
        // Serialising numbers and text cannot fail; an empty report would still be seen as one.
        serde_json::to_string_pretty(self).unwrap_or_default() + "\n"
    }

    /// The summary for people.
    pub(crate) fn to_text(&self) -> String {
        summary::of(&self.output, self)
    }
}

/// Pairs as an object that keeps their order.
fn as_map<K: Serialize, V: Serialize, S: Serializer>(pairs: &[(K, V)], to: S) -> Result<S::Ok, S::Error> {
    to.collect_map(pairs.iter().map(|(key, value)| (key, value)))
}
