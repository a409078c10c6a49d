//! The panel: what a frame cost and drew, and the switches.

use crate::options::{ColorMode, Detail, FrameOptions, Occlusion};
use crate::stats::{FrameStats, grouped};
use egui::{RichText, Slider, Ui};

/// Width of the panel's contents, points.
const WIDTH: f32 = 230.0;

/// Height of the panel where the window has room for it, points; what is beyond is scrolled to.
const HEIGHT: f32 = 684.0;

/// Space between the panel and the window's edges, points.
const GAP: f32 = 12.0;

/// Size of the tables' text, points.
const SMALL: f32 = 12.0;

/// What the panel shows and sets.
pub(super) struct Panel {
    /// How frames are drawn.
    pub(super) options: FrameOptions,
    /// Tolerance, kept while full resolution is on.
    pixels: f64,
    /// Turn around the scene by itself, frame after frame.
    pub(super) turning: bool,
    /// Whether detail and culling are held.
    pub(super) frozen: bool,
    /// A line about the last thing done.
    pub(super) message: String,
    /// The adapter's name.
    pub(super) adapter: String,
    /// The faces of all instances at full resolution.
    pub(super) faces: u64,
    /// A smoothed frame time, milliseconds.
    smoothed: f64,
}

/// What the user asked for with a button.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Wishes {
    /// See everything.
    pub(super) fit: bool,
    /// Save the picture.
    pub(super) screenshot: bool,
}

impl Panel {
    pub(super) fn new(options: FrameOptions, pixels: f64, faces: u64) -> Panel {
        Panel {
            options,
            pixels,
            turning: false,
            frozen: false,
            message: String::new(),
            adapter: String::new(),
            faces,
            smoothed: 0.0,
        }
    }

    /// Notes a frame's time for the display.
    pub(super) fn note(&mut self, stats: &FrameStats) {
        let total = stats.milliseconds.total;
        // A new picture of a quite different cost shows at once.
        let near = self.smoothed > 0.0 && (0.5..2.0).contains(&(total / self.smoothed));
        self.smoothed = if near { 0.8 * self.smoothed + 0.2 * total } else { total };
    }

    /// Lays the panel out.
    pub(super) fn show(&mut self, root: &mut Ui, stats: &FrameStats) -> Wishes {
        let mut wishes = Wishes::default();
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
                self.summary(ui, stats);
                ui.horizontal(|ui| {
                    wishes.fit = ui.button("Fit (F)").clicked();
                    wishes.screenshot = ui.button("Save (P)").clicked();
                    ui.checkbox(&mut self.turning, "Turn");
                });
                if !self.message.is_empty() {
                    ui.label(RichText::new(&self.message).small());
                }
                ui.separator();
                self.switches(ui);
                ui.separator();
                egui::CollapsingHeader::new("Counts").default_open(true).show(ui, |ui| counts(ui, stats));
                egui::CollapsingHeader::new("Times, ms").default_open(false).show(ui, |ui| times(ui, stats));
                egui::CollapsingHeader::new("Mouse and keys").default_open(true).show(ui, keys);
                ui.separator();
                ui.label(RichText::new(&self.adapter).small().weak());
            });
        wishes
    }

    fn summary(&self, ui: &mut Ui, stats: &FrameStats) {
        let fps = if self.smoothed > 0.0 { 1e3 / self.smoothed } else { 0.0 };
        ui.label(RichText::new(format!("{:.1} ms   {fps:.0} fps", self.smoothed)).strong().size(17.0));
        let drawn = stats.counts.triangles_drawn;
        let part = if self.faces > 0 { 100.0 * drawn as f64 / self.faces as f64 } else { 0.0 };
        ui.label(format!("{} of {} triangles ({part:.1} %)", grouped(drawn), grouped(self.faces)));
    }

    fn switches(&mut self, ui: &mut Ui) {
        let mut lod = self.options.detail != Detail::Full;
        ui.checkbox(&mut lod, "Level of detail");
        ui.add_enabled(
            lod,
            Slider::new(&mut self.pixels, 0.1..=64.0).logarithmic(true).suffix(" px").text("error"),
        );
        self.options.detail = if lod { Detail::Pixels(self.pixels) } else { Detail::Full };
        ui.checkbox(&mut self.options.frustum, "Frustum culling");
        ui.add_enabled(
            !self.options.two_sided,
            egui::Checkbox::new(&mut self.options.backface, "Normal cone culling"),
        );
        let mut occlusion = self.options.occlusion == Occlusion::Exact;
        ui.checkbox(&mut occlusion, "Occlusion culling");
        self.options.occlusion = if occlusion { Occlusion::Exact } else { Occlusion::Off };
        ui.checkbox(&mut self.options.two_sided, "Two-sided");
        let mut smooth = self.options.samples > 1;
        ui.checkbox(&mut smooth, "Smooth edges (4 samples)");
        self.options.samples = if smooth { 4 } else { 1 };
        ui.checkbox(&mut self.frozen, "Hold detail and culling");
        ui.horizontal(|ui| {
            ui.label("Colour");
            ui.selectable_value(&mut self.options.color, ColorMode::Shaded, "shaded");
            ui.selectable_value(&mut self.options.color, ColorMode::Clusters, "clusters");
        });
    }
}

fn counts(ui: &mut Ui, stats: &FrameStats) {
    let counts = &stats.counts;
    let outside = format!("{} of {}", grouped(counts.instances_outside), grouped(counts.instances));
    table(
        ui,
        &[
            ("instances out of sight", outside),
            ("nodes visited", grouped(counts.nodes_visited)),
            ("culled by frustum", grouped(counts.nodes_culled_frustum)),
            ("culled by cone", grouped(counts.nodes_culled_cone)),
            ("clusters", grouped(counts.clusters)),
            ("triangles selected", grouped(counts.triangles_selected)),
            ("triangles folded", grouped(counts.triangles_folded)),
            ("pieces", grouped(counts.batches)),
            ("queries", grouped(counts.queries)),
            ("pieces hidden", grouped(counts.batches_culled_occlusion)),
            ("triangles drawn", grouped(counts.triangles_drawn)),
        ],
    );
}

fn times(ui: &mut Ui, stats: &FrameStats) {
    let times = &stats.milliseconds;
    let ms = |time: f64| format!("{time:.2}");
    table(
        ui,
        &[
            ("cut", ms(times.cut)),
            ("upload", ms(times.upload)),
            ("occluders", ms(times.occluders)),
            ("queries", ms(times.queries)),
            ("draw", ms(times.draw)),
        ],
    );
}

/// What the mouse and the keys do.
fn keys(ui: &mut Ui) {
    table(
        ui,
        &[
            ("turn", "drag".to_owned()),
            ("pan", "Shift or right drag".to_owned()),
            ("zoom", "wheel".to_owned()),
            ("fit, save a picture", "F, P".to_owned()),
            ("quit", "Q, Esc".to_owned()),
        ],
    );
}

fn table(ui: &mut Ui, rows: &[(&str, String)]) {
    ui.spacing_mut().item_spacing.y = 0.0;
    // Rows as high as their text, not as a button.
    ui.spacing_mut().interact_size.y = SMALL;
    for (name, value) in rows {
        ui.horizontal(|ui| {
            ui.label(RichText::new(*name).size(SMALL));
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                ui.label(RichText::new(value).size(SMALL).monospace().strong());
            });
        });
    }
}
