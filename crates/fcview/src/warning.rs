//! What a user should know about a run that does what was asked.

use crate::cli::Cli;
use crate::inwards::looks_inwards;
use crate::scene::Scene;
use crate::stats::{AdapterStats, RunStats, coarser_in_words, median_total};
use fct::{MessageFormat, counted, grouped};
use serde_json::json;

/// A warning.
///
/// | code | name | |
/// |---|---|---|
/// | FC293 | `inward_faces` | a model shows its far side alone, as `fcbuild` warns too |
/// | FC591 | `over_budget` | not even the coarsest meshes keep to the budget |
/// | FC592 | `coarser_in_memory` | the graphics memory did not hold the vertices of some frames |
/// | FC593 | `below_fps` | frames take longer than they may, however coarse they are |
/// | FC691 | `software_adapter` | no graphics card draws |
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Warning {
    /// Such as `FC691`.
    pub code: &'static str,
    /// Such as `software_adapter`.
    pub name: &'static str,
    /// The file that it is about.
    pub file: Option<String>,
    /// A sentence.
    pub text: String,
}

impl Warning {
    /// The line in which it is told.
    pub fn line(&self, format: MessageFormat) -> String {
        let Warning { code, name, file, text } = self;
        match format {
            MessageFormat::Human => {
                let place = file.as_ref().map(|file| format!("{file}: ")).unwrap_or_default();
                format!("warning[{code}]: {place}{text}")
            }
            MessageFormat::Json => json!({
                "level": "warning", "code": code, "name": name, "message": text, "count": 1, "path": file,
            })
            .to_string(),
        }
    }

    /// A machine has only a software adapter.
    pub(crate) fn of_software(adapter: &AdapterStats) -> Warning {
        let AdapterStats { name, backend, .. } = adapter;
        let text = format!("no graphics card; {name} draws on the CPU by {backend}, slowly");
        Warning { code: "FC691", name: "software_adapter", file: None, text }
    }

    /// A model looks hollow, because its faces look inwards.
    pub(crate) fn of_hollow(cli: &Cli, scene: &Scene) -> Option<Warning> {
        let model = scene.models.iter().find(|model| !cli.two_sided && looks_inwards(model))?;
        let text = "the faces look inwards, so that the model looks hollow; draw it with --two-sided, or build it again \
                    with fcbuild --flip"
            .to_owned();
        Some(Warning { code: "FC293", name: "inward_faces", file: Some(model.name.clone()), text })
    }

    /// The graphics memory did not hold the vertices of some frames; `None` where it held all.
    pub(crate) fn of_memory(run: &RunStats) -> Option<Warning> {
        let coarser: Vec<f64> =
            run.frames.iter().map(|frame| frame.memory.coarser).filter(|factor| *factor > 1.0).collect();
        let most = coarser.iter().copied().reduce(f64::max)?;
        let (what, remedy) = match run.settings.gpu_memory {
            Some(_) => ("--gpu-memory", "; allow more"),
            None => ("the graphics memory", ""),
        };
        let frames = counted(coarser.len() as u64, "frame");
        let how = coarser_in_words(most);
        let text = format!("{what} does not hold the vertices of {frames}, at the worst drawn {how}{remedy}");
        Some(Warning { code: "FC592", name: "coarser_in_memory", file: None, text })
    }

    /// Frames that are steered to a time take longer all the same; told of the second half, when they have settled.
    pub(crate) fn of_pace(run: &RunStats) -> Option<Warning> {
        let fps = run.settings.fps?;
        let settled = run.frames.get(run.frames.len() / 2..).filter(|frames| frames.len() >= SETTLED)?;
        let time = median_total(settled);
        let pixels = settled.last()?.gain?;
        let is_late = time > LATE * 1e3 / fps;
        let text =
            format!("--fps {fps} is not reached: frames take {time:.1} ms at {pixels:.1} pixels of error");
        is_late.then_some(Warning { code: "FC593", name: "below_fps", file: None, text })
    }

    /// Not even the coarsest meshes keep to the budget of triangles; `None` where they do.
    pub(crate) fn of_budget(run: &RunStats) -> Option<Warning> {
        let over: Vec<u64> = run
            .frames
            .iter()
            .filter_map(|frame| frame.budget.filter(|b| !b.within).map(|b| b.selected))
            .collect();
        let most = over.iter().max()?;
        let frames = counted(over.len() as u64, "frame");
        let text = format!(
            "--triangles is less than the coarsest meshes of {frames} have: {} at the most",
            grouped(*most)
        );
        Some(Warning { code: "FC591", name: "over_budget", file: None, text })
    }
}

/// So many frames tell whether a time is kept to.
const SETTLED: usize = 10;

/// How many times the time asked for frames may take: steering rests within less.
const LATE: f64 = 1.2;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_warning_is_a_line_for_people_or_for_programs() {
        let file = Some("a.fct".to_owned());
        let warning = Warning { code: "FC293", name: "inward_faces", file, text: "hollow".to_owned() };
        assert_eq!(warning.line(MessageFormat::Human), "warning[FC293]: a.fct: hollow");
        let line: serde_json::Value = serde_json::from_str(&warning.line(MessageFormat::Json)).unwrap();
        assert_eq!((&line["level"], &line["path"]), (&json!("warning"), &json!("a.fct")));
        let nowhere = Warning { file: None, ..warning };
        assert_eq!(nowhere.line(MessageFormat::Human), "warning[FC293]: hollow");
    }
}
