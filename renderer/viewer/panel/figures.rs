//! What the samples took, and where the light went.

use egui::{Color32, Pos2, Rect, RichText, Sense, Ui, Vec2};

use super::{BAD, form, milliseconds, row};
use crate::viewer::history::{History, LENGTH};
use crate::viewer::session::Session;

const PLOT_HEIGHT: f32 = 90.0;
/// Samples that the list of passes is the mean of.
const MEAN_OF: usize = 16;
/// Passes that are listed by name.
const LISTED: usize = 7;

/// Of passes, the longest first.
const COLORS: [Color32; 8] = [
    Color32::from_rgb(86, 156, 214),
    Color32::from_rgb(230, 159, 0),
    Color32::from_rgb(97, 184, 142),
    Color32::from_rgb(240, 228, 110),
    Color32::from_rgb(204, 121, 167),
    Color32::from_rgb(213, 94, 60),
    Color32::from_rgb(150, 130, 220),
    Color32::from_rgb(170, 170, 170),
];

/// A bar a sample, its passes on top of each other, and the means of the latest samples.
pub fn times(ui: &mut Ui, history: &History) {
    let (area, response) = ui.allocate_exact_size(Vec2::new(ui.available_width(), PLOT_HEIGHT), Sense::hover());
    let painter = ui.painter_at(area);
    painter.rect_filled(area, 3.0, Color32::from_gray(20));
    let mut sums: Vec<f32> = history.columns.iter().map(|column| column.iter().sum()).collect();
    sums.sort_by(f32::total_cmp);
    // The first sample after a change can take many times as long; its bar is cut off, and the others stay to be seen.
    let most = sums.get(sums.len().saturating_sub(1) * 9 / 10).copied().unwrap_or(0.0);
    if most <= 0.0 {
        painter.text(area.center(), egui::Align2::CENTER_CENTER, "no times yet", Default::default(), Color32::GRAY);
        return;
    }
    let top = nice(most);
    // The longest passes get colours of their own, the others share the last one.
    let means = history.means(LENGTH);
    let mut order: Vec<usize> = (0..means.len()).collect();
    order.sort_by(|a, b| means[*b].total_cmp(&means[*a]));
    let color = |pass: usize| {
        let rank = order.iter().position(|p| *p == pass).unwrap_or(COLORS.len());
        COLORS[rank.min(COLORS.len() - 1)]
    };
    let step = area.width() / LENGTH as f32;
    let first = area.right() - step * history.columns.len() as f32;
    for (index, column) in history.columns.iter().enumerate() {
        let left = first + step * index as f32;
        let mut bottom = area.bottom();
        for (pass, time) in column.iter().enumerate() {
            let height = time / top * area.height();
            let bar = Rect::from_min_max(Pos2::new(left, bottom - height), Pos2::new(left + step, bottom));
            painter.rect_filled(bar, 0.0, color(pass));
            bottom -= height;
        }
    }
    let corner = area.left_top() + Vec2::new(5.0, 3.0);
    let text = format!("{} a sample", milliseconds(top));
    painter.text(corner, egui::Align2::LEFT_TOP, text, egui::FontId::proportional(11.0), Color32::from_gray(190));
    response.on_hover_text("Times of passes on the device, one bar a sample at full size, the latest on the right");
    list(ui, history, &order, color);
}

fn list(ui: &mut Ui, history: &History, order: &[usize], color: impl Fn(usize) -> Color32) {
    let means = history.means(MEAN_OF);
    egui::Grid::new("passes").num_columns(2).spacing([16.0, 2.0]).min_col_width(170.0).show(ui, |ui| {
        for &pass in order.iter().take(LISTED) {
            ui.horizontal(|ui| {
                let (dot, _) = ui.allocate_exact_size(Vec2::splat(9.0), Sense::hover());
                ui.painter().rect_filled(dot, 2.0, color(pass));
                ui.label(RichText::new(&history.names[pass]).small());
            });
            ui.label(RichText::new(milliseconds(means[pass])).small());
            ui.end_row();
        }
        if order.len() > LISTED {
            let rest: f32 = order.iter().skip(LISTED).map(|pass| means[*pass]).sum();
            ui.label(RichText::new(format!("{} others", order.len() - LISTED)).small());
            ui.label(RichText::new(milliseconds(rest)).small());
            ui.end_row();
        }
    });
}

/// The next of 1, 2, 5, 10, 20, ... above.
fn nice(value: f32) -> f32 {
    let power = 10f32.powf(value.log10().floor());
    [1.0, 2.0, 5.0, 10.0].map(|m| m * power).into_iter().find(|top| *top >= value).unwrap_or(value)
}

/// Device, tier, noise, counters, ledger and warnings.
pub fn figures(ui: &mut Ui, session: &Session) {
    let info = &session.device.info;
    let tier = session.left.renderer().tier();
    form(ui, "device", |ui| {
        for (name, value) in [("device", info.name.as_str()), ("driver", &info.driver_version), ("tier", &tier)] {
            row(ui, name, "", |ui| {
                ui.add(egui::Label::new(value).wrap());
            });
        }
    });
    ui.weak(session.left.renderer().trace_choice());
    let Some(stats) = &session.left.stats else { return };
    form(ui, "figures", |ui| {
        row(ui, "memory", "Held on the device at most", |ui| {
            ui.label(format!("{:.0} MiB", stats.peak_memory_bytes as f64 / (1 << 20) as f64));
        });
        for entry in &stats.ledger {
            row(ui, entry.name, "Where the light went", |ui| {
                ui.label(format!("{:.4} W", entry.watts));
            });
        }
        for entry in &stats.counters {
            row(ui, entry.name, "Counted by the technique", |ui| {
                ui.label(format!("{}", (entry.value * 1000.0).round() / 1000.0));
            });
        }
    });
    for warning in &stats.warnings {
        ui.add(egui::Label::new(RichText::new(warning).color(BAD)).wrap());
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn scales_are_round_numbers() {
        for (value, top) in [(0.9, 1.0), (1.1, 2.0), (430.0, 500.0), (6000.0, 10000.0)] {
            assert_eq!(super::nice(value), top);
        }
    }
}
