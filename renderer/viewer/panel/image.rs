//! How the picture is shown and kept.

use egui::{ComboBox, DragValue, Ui};

use super::{BAD, form, row, slider};
use crate::scene::ToneCurve;
use crate::taa;
use crate::viewer::heat::Heat;
use crate::viewer::pane;
use crate::viewer::session::{Scale, Session};

/// Exposure goes so far either way.
pub const STOPS: f32 = 12.0;

pub fn show(ui: &mut Ui, session: &mut Session) {
    form(ui, "picture", |ui| {
        row(ui, "exposure", "Stops; of what is shown and of PNG files", |ui| {
            ui.add(slider(&mut session.look.exposure, -STOPS..=STOPS).fixed_decimals(2));
        });
        row(ui, "tone curve", "What becomes of values above 1", |ui| {
            let curve = &mut session.look.tone_curve;
            ui.selectable_value(curve, ToneCurve::Linear, "linear");
            ui.selectable_value(curve, ToneCurve::Reinhard, "Reinhard");
        });
        row(ui, "size", "Pixels of the picture", |ui| size(ui, session));
        row(ui, "in motion", "Part of the size each way while things move; auto goes by the time of a sample", |ui| {
            let scales =
                [("auto", Scale::Auto), ("1", Scale::Fixed(1)), ("1/2", Scale::Fixed(2)), ("1/4", Scale::Fixed(4))];
            for (name, scale) in scales {
                ui.selectable_value(&mut session.scale, scale, name);
            }
        });
        let about = "Temporal anti-aliasing: pictures that one is made of while things move, those shown before it among them; 1 for \
                     none but itself";
        row(ui, "made of", about, |ui| {
            ui.add(slider(&mut session.wish.taa, 1..=*taa::FRAMES.end()).logarithmic(true));
        });
        row(ui, "samples", "After so many the picture is left as it is", |ui| {
            ui.add(DragValue::new(&mut session.limit).range(1..=1_000_000).clamp_existing_to_range(false));
        });
    });
    if let Some(heat) = &mut session.heat {
        heat_map(ui, heat);
    }
    if ui.button("save as PNG and EXR").on_hover_text("In the folder that the program was started in (P)").clicked() {
        session.screenshot();
    }
}

/// A size takes effect when it is let go.
fn size(ui: &mut Ui, session: &mut Session) {
    let id = ui.id().with("size");
    let mut held = ui.data(|data| data.get_temp(id)).unwrap_or(session.wish.size);
    let most = pane::most_side(&session.device);
    let drag =
        |pixels| DragValue::new(pixels).range(1..=most).clamp_existing_to_range(false).update_while_editing(false);
    let width = ui.add(drag(&mut held.0));
    ui.label("x");
    let height = ui.add(drag(&mut held.1));
    if width.dragged() || height.dragged() {
        ui.data_mut(|data| data.insert_temp(id, held));
    } else {
        ui.data_mut(|data| data.remove::<(u32, u32)>(id));
        session.wish.size = held;
    }
    let film = (session.scene.film.width, session.scene.film.height);
    if session.wish.size != film && ui.small_button("x").on_hover_text("Back to the scene's size").clicked() {
        session.wish.size = film;
    }
}

fn heat_map(ui: &mut Ui, heat: &mut Heat) {
    ui.horizontal(|ui| {
        ui.checkbox(&mut heat.shown, "error map")
            .on_hover_text(format!("Blue is too dark, red too bright, white agrees with {} (M)", heat.name()));
        ComboBox::from_id_salt("layer").selected_text(heat.layer.as_str()).show_ui(ui, |ui| {
            for layer in &heat.layers {
                ui.selectable_value(&mut heat.layer, layer.clone(), layer);
            }
        });
    });
    match heat.map.as_ref().filter(|_| heat.shown).map(|map| &map.result) {
        Some(Ok((error, scale))) => {
            ui.label(format!("relRMSE {:.2} %, full colour at {scale:.3}", 100.0 * error));
        }
        Some(Err(reason)) => {
            ui.colored_label(BAD, reason);
        }
        None => {}
    }
}
