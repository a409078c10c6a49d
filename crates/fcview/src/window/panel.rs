//! The panel: what a frame cost and drew, and the switches.

use super::history::History;
use super::input::KEYS;
use super::navigation::{Mode, Navigation};
use crate::options::{ColorMode, Detail, FrameOptions, Occlusion};
use crate::stats::{FrameStats, coarser_in_words};
use crate::steering::Steering;
use egui::{CollapsingHeader, RichText, Slider, Ui};
use fct::grouped;

/// Width of the panel's contents, points.
const WIDTH: f32 = 262.0;

/// Height of the panel where the window has room for it, points; what is beyond is scrolled to.
const HEIGHT: f32 = 684.0;

/// Space between the panel and the window's edges, points.
const GAP: f32 = 12.0;

/// Size of the tables' text, points.
pub(super) const SMALL: f32 = 12.0;

/// Tolerances that can be set, pixels.
const PIXELS: std::ops::RangeInclusive<f64> = 0.1..=64.0;

/// What can colour the surface.
const COLORS: [(ColorMode, &str); 4] = [
    (ColorMode::Shaded, "shaded"),
    (ColorMode::Clusters, "clusters"),
    (ColorMode::Depth, "depth"),
    (ColorMode::Level, "level"),
];

/// Budgets that can be set, triangles.
const TRIANGLES: std::ops::RangeInclusive<f64> = 1e3..=1e7;

/// Frames a second that can be set.
const FPS: std::ops::RangeInclusive<f64> = 1.0..=120.0;

/// What says how much detail is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Goal {
    Error,
    Triangles,
    Rate,
    Full,
}

/// What the panel shows and sets.
pub(super) struct Panel {
    /// How frames are drawn.
    pub(super) options: FrameOptions,
    goal: Goal,
    /// Tolerance, budget and rate, each kept while another one counts.
    pixels: f64,
    triangles: f64,
    fps: f64,
    steering: Steering,
    /// Whether detail and culling are held.
    pub(super) frozen: bool,
    /// Whether the panel is there.
    pub(super) shown: bool,
    /// A line about the last thing done.
    pub(super) message: String,
    /// The adapter's name.
    pub(super) adapter: String,
    /// The faces of all instances at full resolution.
    pub(super) faces: u64,
    history: History,
    stats: FrameStats,
}

/// What the user asked for with a button.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Wishes {
    /// See everything.
    pub(super) fit: bool,
    /// Go back to the first view.
    pub(super) reset: bool,
    /// Save the picture.
    pub(super) screenshot: bool,
    /// Begin or end a recording.
    pub(super) record: bool,
    /// Choose another file.
    pub(super) open: bool,
    /// Move in another way.
    pub(super) mode: Option<Mode>,
}

impl Panel {
    pub(super) fn new(options: FrameOptions, pixels: f64, fps: Option<f64>, faces: u64) -> Panel {
        let (goal, triangles) = match options.detail {
            _ if fps.is_some() => (Goal::Rate, 1e5),
            Detail::Full => (Goal::Full, 1e5),
            Detail::Triangles(triangles) => (Goal::Triangles, triangles as f64),
            Detail::Pixels(_) | Detail::Gain(_) | Detail::Distance(_) => (Goal::Error, 1e5),
        };
        let fps = fps.unwrap_or(30.0);
        Panel {
            options,
            goal,
            pixels,
            triangles,
            fps,
            steering: Steering::new(fps),
            frozen: false,
            shown: true,
            message: String::new(),
            adapter: String::new(),
            faces,
            history: History::default(),
            stats: FrameStats::default(),
        }
    }

    /// Notes a frame for the display.
    ///
    /// True if the next frame is to have another budget.
    pub(super) fn note(&mut self, stats: &FrameStats) -> bool {
        self.history.note(stats.milliseconds);
        self.stats = *stats;
        let steered = self.goal == Goal::Rate && self.steering.note(stats.milliseconds.total);
        self.options.detail = self.detail();
        steered
    }

    /// How much detail the goal asks for.
    fn detail(&self) -> Detail {
        match self.goal {
            Goal::Error => Detail::Pixels(self.pixels),
            Goal::Triangles => Detail::Triangles(self.triangles as u64),
            Goal::Rate => self.steering.detail(),
            Goal::Full => Detail::Full,
        }
    }

    /// Makes the tolerance so many times coarser. False if it is as coarse as can be.
    pub(super) fn coarsen(&mut self, factor: f64) -> bool {
        let before = self.options.detail;
        match self.goal {
            Goal::Error => self.pixels = (self.pixels * factor).clamp(*PIXELS.start(), *PIXELS.end()),
            Goal::Triangles => {
                self.triangles = (self.triangles / factor).clamp(*TRIANGLES.start(), *TRIANGLES.end());
            }
            Goal::Rate | Goal::Full => self.goal = Goal::Error,
        }
        self.options.detail = self.detail();
        before != self.options.detail
    }

    /// Lays the panel out.
    pub(super) fn show(&mut self, root: &mut Ui, navigation: &mut Navigation, recording: bool) -> Wishes {
        let mut wishes = Wishes::default();
        if !self.shown {
            return wishes;
        }
        let height = HEIGHT.min(root.ctx().content_rect().height() - 2.0 * GAP).max(0.0);
        let margin = root.spacing().window_margin.sum().x + 2.0;
        egui::Window::new("facetree")
            .default_pos([GAP, GAP])
            // Fixed anew each frame: otherwise it would shrink with the window but never grow again.
            .fixed_size([WIDTH + margin, height])
            .vscroll(true)
            .show(root.ctx(), |ui| {
                ui.set_width(WIDTH);
                ui.spacing_mut().item_spacing.y = 4.0;
                self.summary(ui);
                if !self.message.is_empty() {
                    ui.label(RichText::new(&self.message).strong());
                }
                ui.separator();
                camera(ui, navigation, recording, &mut wishes);
                ui.separator();
                self.switches(ui);
                ui.separator();
                let times = CollapsingHeader::new("Times").default_open(true);
                let open = times.show(ui, |ui| self.history.show(ui)).fully_open();
                // Waiting after each stage makes their times true; who does not look is not made to wait.
                self.options.measure = open;
                CollapsingHeader::new("Counts").default_open(true).show(ui, |ui| counts(ui, &self.stats));
                CollapsingHeader::new("Mouse and keys").default_open(false).show(ui, |ui| {
                    table(ui, KEYS.iter().map(|(keys, does)| (*does, (*keys).to_owned())));
                });
                ui.separator();
                ui.label(RichText::new(&self.adapter).small().weak());
            });
        wishes
    }

    fn summary(&self, ui: &mut Ui) {
        let typical = self.history.typical();
        let fps = if typical > 0.0 { 1e3 / typical } else { 0.0 };
        ui.label(RichText::new(format!("{typical:.1} ms   {fps:.0} fps")).strong().size(17.0));
        let drawn = self.stats.counts.triangles_drawn;
        let part = if self.faces > 0 { 100.0 * drawn as f64 / self.faces as f64 } else { 0.0 };
        ui.label(format!("{} of {} triangles ({part:.1} %)", grouped(drawn), grouped(self.faces)));
        let coarser = self.stats.memory.coarser;
        if coarser > 1.0 {
            let text = format!("graphics memory is full: {}", coarser_in_words(coarser));
            ui.label(RichText::new(text).color(ui.visuals().warn_fg_color));
        }
        if self.stats.budget.is_some_and(|budget| !budget.within) {
            let text = "the coarsest meshes have more triangles";
            ui.label(RichText::new(text).color(ui.visuals().warn_fg_color));
        }
    }

    fn switches(&mut self, ui: &mut Ui) {
        ui.horizontal(|ui| {
            ui.label("Detail");
            ui.selectable_value(&mut self.goal, Goal::Error, "error");
            ui.selectable_value(&mut self.goal, Goal::Triangles, "triangles");
            ui.selectable_value(&mut self.goal, Goal::Rate, "fps");
            ui.selectable_value(&mut self.goal, Goal::Full, "full");
        });
        match self.goal {
            Goal::Error => {
                ui.add(Slider::new(&mut self.pixels, PIXELS).logarithmic(true).suffix(" px").text("error"));
            }
            Goal::Triangles => {
                let slider = Slider::new(&mut self.triangles, TRIANGLES).logarithmic(true).integer();
                ui.add(slider.text("triangles"));
            }
            Goal::Rate => {
                let slider = Slider::new(&mut self.fps, FPS).logarithmic(true).integer().text("fps");
                if ui.add(slider).changed() {
                    self.steering = Steering::new(self.fps);
                }
            }
            Goal::Full => {
                ui.label("every face of the input");
            }
        }
        self.options.detail = self.detail();
        ui.checkbox(&mut self.options.frustum, "Frustum culling");
        ui.add_enabled(
            !self.options.two_sided,
            egui::Checkbox::new(&mut self.options.backface, "Normal cone culling"),
        );
        let mut occlusion = self.options.occlusion != Occlusion::Off;
        ui.horizontal(|ui| {
            ui.checkbox(&mut occlusion, "Occlusion culling");
            ui.add_enabled(occlusion, egui::Checkbox::new(&mut self.options.show_questions, "show it"))
                .on_hover_text("what occlusion culling asks about: red was hidden, blue may show");
        });
        self.options.occlusion = match (occlusion, self.options.occlusion) {
            (false, _) => Occlusion::Off,
            (true, Occlusion::Off) => Occlusion::Exact,
            (true, as_asked) => as_asked,
        };
        ui.checkbox(&mut self.frozen, "Freeze the cut, look from elsewhere");
        ui.horizontal(|ui| {
            ui.checkbox(&mut self.options.two_sided, "Two-sided");
            let mut smooth = self.options.samples > 1;
            ui.checkbox(&mut smooth, "4 samples").on_hover_text("smooth edges");
            self.options.samples = if smooth { 4 } else { 1 };
            ui.checkbox(&mut self.options.wireframe, "Wireframe");
        });
        ui.horizontal(|ui| {
            for (mode, name) in COLORS {
                ui.selectable_value(&mut self.options.color, mode, name);
            }
        });
    }

    /// What colours the surface next.
    pub(super) fn next_color(&mut self) {
        let now = COLORS.iter().position(|(mode, _)| *mode == self.options.color).unwrap_or(0);
        if let Some((mode, _)) = COLORS.iter().cycle().nth(now + 1) {
            self.options.color = *mode;
        }
    }
}

/// How the camera moves, and what can be done with it.
fn camera(ui: &mut Ui, navigation: &mut Navigation, recording: bool, wishes: &mut Wishes) {
    ui.horizontal(|ui| {
        for (mode, name) in [(Mode::Orbit, "Orbit"), (Mode::Fly, "Fly")] {
            if ui.selectable_label(navigation.mode() == mode, name).clicked() {
                wishes.mode = Some(mode);
            }
        }
        match navigation.mode() {
            Mode::Orbit => ui.checkbox(&mut navigation.turning, "turn"),
            Mode::Fly => ui.label(RichText::new(format!("speed {:.2}", navigation.speed)).weak()),
        };
    });
    ui.horizontal(|ui| {
        wishes.fit = ui.button("Fit").clicked();
        wishes.reset = ui.button("Reset").clicked();
        wishes.screenshot = ui.button("Save").on_hover_text("a picture without this panel").clicked();
        let record = if recording { "Stop" } else { "Record" };
        wishes.record = ui.button(record).on_hover_text("the camera's path, for --camera").clicked();
        wishes.open = ui.button("Open").clicked();
    });
}

fn counts(ui: &mut Ui, stats: &FrameStats) {
    let (counts, memory) = (&stats.counts, &stats.memory);
    let outside = format!("{} of {}", grouped(counts.instances_outside), grouped(counts.instances));
    let rows = [
        ("instances out of sight", outside),
        ("nodes visited", grouped(counts.nodes_visited)),
        ("culled by frustum", grouped(counts.nodes_culled_frustum)),
        ("culled by cone", grouped(counts.nodes_culled_cone)),
        ("clusters", grouped(counts.clusters)),
        ("triangles folded", grouped(counts.triangles_folded)),
        ("pieces", grouped(counts.batches)),
        ("queries", grouped(counts.queries)),
        ("instances hidden", grouped(counts.instances_hidden)),
        ("pieces hidden", grouped(counts.batches_culled_occlusion.saturating_sub(counts.instances_hidden))),
        ("faces hidden", grouped(counts.faces_hidden)),
        ("triangles drawn", grouped(counts.triangles_drawn)),
        ("vertices, MB", format!("{:.1}", memory.bytes as f64 / 1e6)),
        ("pages there", format!("{} of {}", grouped(memory.pages_resident), grouped(memory.pages))),
        ("pages uploaded", grouped(memory.pages_uploaded)),
        ("pages evicted", grouped(memory.pages_evicted)),
    ];
    table(ui, rows.into_iter());
}

fn table<'a>(ui: &mut Ui, rows: impl Iterator<Item = (&'a str, String)>) {
    ui.spacing_mut().item_spacing.y = 0.0;
    // Rows as high as their text, not as a button.
    ui.spacing_mut().interact_size.y = SMALL;
    for (name, value) in rows {
        ui.horizontal(|ui| {
            ui.label(RichText::new(name).size(SMALL));
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                ui.label(RichText::new(value).size(SMALL).monospace().strong());
            });
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coarser_ends_at_the_slider_s_end() {
        let mut panel =
            Panel::new(FrameOptions { detail: Detail::Full, ..FrameOptions::default() }, 1.0, None, 0);
        assert!(panel.coarsen(2.0));
        assert_eq!(panel.options.detail, Detail::Pixels(1.0), "first there is level of detail at all");
        for _ in 0..6 {
            assert!(panel.coarsen(2.0));
        }
        assert_eq!(panel.options.detail, Detail::Pixels(64.0));
        assert!(!panel.coarsen(2.0));
    }
}
