//! The panel: what a frame cost and drew, and the switches.

use crate::options::{ColorMode, Detail, FrameOptions, Occlusion};
use crate::stats::FrameStats;
use egui::{RichText, Slider, Ui};

/// Width of the panel's contents, points.
const WIDTH: f32 = 230.0;

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
        egui::Window::new("facetree")
            .default_pos([12.0, 12.0])
            .default_width(WIDTH)
            .default_height(640.0)
            .resizable(false)
            .vscroll(true)
            .show(root.ctx(), |ui| {
                ui.set_max_width(WIDTH);
                ui.spacing_mut().item_spacing.y = 4.0;
                self.summary(ui, stats);
                ui.separator();
                self.switches(ui);
                ui.separator();
                egui::CollapsingHeader::new("Counts").default_open(true).show(ui, |ui| counts(ui, stats));
                egui::CollapsingHeader::new("Times, ms").default_open(true).show(ui, |ui| times(ui, stats));
                ui.separator();
                ui.horizontal(|ui| {
                    wishes.fit = ui.button("Fit (F)").clicked();
                    wishes.screenshot = ui.button("Save (P)").clicked();
                    ui.checkbox(&mut self.turning, "Turn");
                });
                if !self.message.is_empty() {
                    ui.label(RichText::new(&self.message).small());
                }
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

fn table(ui: &mut Ui, rows: &[(&str, String)]) {
    ui.spacing_mut().item_spacing.y = 0.0;
    for (name, value) in rows {
        ui.horizontal(|ui| {
            ui.label(RichText::new(*name).size(SMALL));
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                ui.label(RichText::new(value).size(SMALL).monospace().strong());
            });
        });
    }
}

/// A number with its thousands set apart.
fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::with_capacity(digits.len() * 4 / 3);
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::grouped;

    #[test]
    fn thousands_are_set_apart() {
        let cases = [(0, "0"), (999, "999"), (1000, "1,000"), (1_234_567, "1,234,567")];
        for (number, text) in cases {
            assert_eq!(grouped(number), text);
        }
    }
}
