//! Times of the last frames by stage: a plot and a table.

use super::panel::SMALL;
use crate::stats::Milliseconds;
use egui::{Color32, Rect, RichText, Sense, Ui, pos2, vec2};
use std::collections::VecDeque;

/// Frames in the plot.
const FRAMES: usize = 115;

/// Height of the plot, points.
const HEIGHT: f32 = 46.0;

/// A stage's name, colour and time.
type Stage = (&'static str, Color32, fn(&Milliseconds) -> f64);

/// The stages of a frame, in their order.
const STAGES: [Stage; 5] = [
    ("cut", Color32::from_rgb(0xE0, 0xB0, 0x5A), |times| times.cut),
    ("upload", Color32::from_rgb(0x7F, 0xB0, 0x69), |times| times.upload),
    ("occluders", Color32::from_rgb(0x5B, 0x9B, 0xC8), |times| times.occluders),
    ("queries", Color32::from_rgb(0xA8, 0x84, 0xC8), |times| times.queries),
    ("draw", Color32::from_rgb(0xCF, 0x74, 0x60), |times| times.draw),
];

/// The last frames' times.
#[derive(Default)]
pub(super) struct History {
    frames: VecDeque<Milliseconds>,
}

impl History {
    /// Adds a frame.
    pub(super) fn note(&mut self, times: Milliseconds) {
        if self.frames.len() >= FRAMES {
            self.frames.pop_front();
        }
        self.frames.push_back(times);
    }

    /// A frame time that holds still enough to be read: the median of the last frames, milliseconds. A picture of
    /// quite another cost than the last shows at once.
    pub(super) fn typical(&self) -> f64 {
        let Some(last) = self.frames.back().map(|times| times.total) else { return 0.0 };
        let alike = |total: &f64| (0.5..2.0).contains(&(total / last));
        let mut totals: Vec<f64> =
            self.frames.iter().rev().map(|times| times.total).take_while(alike).take(9).collect();
        totals.sort_by(f64::total_cmp);
        totals.get(totals.len() / 2).copied().unwrap_or(last)
    }

    /// A time that nine of ten frames keep to: the plot's height is not for the odd one out, such as the first.
    fn usual_worst(&self) -> f64 {
        let mut totals: Vec<f64> = self.frames.iter().map(|times| times.total).collect();
        totals.sort_by(f64::total_cmp);
        totals.get(totals.len() * 9 / 10).copied().unwrap_or(0.0)
    }

    /// Lays plot and table out.
    pub(super) fn show(&self, ui: &mut Ui) {
        let (area, _) = ui.allocate_exact_size(vec2(ui.available_width(), HEIGHT), Sense::hover());
        let painter = ui.painter_at(area);
        painter.rect_filled(area, 3.0, ui.visuals().extreme_bg_color);
        let full = full_scale(self.usual_worst());
        let bar = area.width() / FRAMES as f32;
        let first = FRAMES - self.frames.len().min(FRAMES);
        for (place, times) in (first..).zip(&self.frames) {
            let left = area.left() + bar * place as f32;
            let mut bottom = area.bottom();
            for (_, color, time) in STAGES {
                let top = bottom - area.height() * (time(times) / full) as f32;
                let part = Rect::from_min_max(pos2(left, top.max(area.top())), pos2(left + bar, bottom));
                painter.rect_filled(part, 0.0, color);
                if top <= area.top() {
                    break;
                }
                bottom = top;
            }
        }
        let at = area.left_top() + vec2(4.0, 2.0);
        let font = egui::FontId::monospace(10.0);
        painter.text(at, egui::Align2::LEFT_TOP, format!("{full} ms"), font, ui.visuals().weak_text_color());
        let last = self.frames.back().copied().unwrap_or_default();
        ui.spacing_mut().item_spacing.y = 0.0;
        ui.spacing_mut().interact_size.y = SMALL;
        for (name, color, time) in STAGES {
            ui.horizontal(|ui| {
                let (square, _) = ui.allocate_exact_size(vec2(8.0, SMALL), Sense::hover());
                ui.painter().rect_filled(Rect::from_center_size(square.center(), vec2(7.0, 7.0)), 1.0, color);
                ui.label(RichText::new(name).size(SMALL));
                ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                    ui.label(
                        RichText::new(format!("{:.2} ms", time(&last))).size(SMALL).monospace().strong(),
                    );
                });
            });
        }
    }
}

/// The time at the top of the plot: the next of 1, 2, 5, 10 and so on.
fn full_scale(largest: f64) -> f64 {
    let mut decade = 1.0;
    while decade < 1e9 {
        for step in [1.0, 2.0, 5.0] {
            if largest <= step * decade {
                return step * decade;
            }
        }
        decade *= 10.0;
    }
    decade
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(total: f64) -> Milliseconds {
        Milliseconds { total, ..Milliseconds::default() }
    }

    #[test]
    fn the_scale_is_round_and_never_too_small() {
        for (largest, full) in [(0.0, 1.0), (1.0, 1.0), (1.1, 2.0), (4.0, 5.0), (51.0, 100.0), (166.0, 200.0)]
        {
            assert_eq!(full_scale(largest), full);
        }
        assert!(full_scale(f64::INFINITY).is_finite());
    }

    #[test]
    fn the_typical_time_ignores_a_hiccup_and_follows_a_change() {
        let mut history = History::default();
        assert_eq!(history.typical(), 0.0);
        for time in [10.0, 11.0, 12.0, 11.0, 15.0, 11.0] {
            history.note(frame(time));
        }
        assert_eq!(history.typical(), 11.0);
        history.note(frame(40.0));
        assert_eq!(history.typical(), 40.0);
        for _ in 0..500 {
            history.note(frame(3.0));
        }
        history.note(frame(1000.0));
        assert_eq!(history.usual_worst(), 3.0);
        assert_eq!(history.frames.len(), FRAMES);
    }
}
