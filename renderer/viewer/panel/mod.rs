//! Everything in the window that is not the picture.

mod figures;
mod image;
mod scene;
mod technique;

use egui::{
    Align, CentralPanel, Color32, Context, Frame, Key, KeyboardShortcut, Layout, Modifiers, RichText, Slider,
    SliderClamping, Ui,
};

use super::camera::Control;
use super::picture::Pictures;
use super::session::Session;
use super::state::Eye;
use crate::technique::TechniqueKind;

/// Points.
pub const PANEL_WIDTH: f32 = 340.0;
pub const STATUS_HEIGHT: f32 = 30.0;

/// Of news that are bad.
const BAD: Color32 = Color32::from_rgb(255, 130, 110);
const BACKDROP: Color32 = Color32::from_gray(18);
const PANEL: Color32 = Color32::from_gray(30);

/// Keys as the window lists them.
const KEYS: &[(&str, &str)] = &[
    ("drag", "turn the camera"),
    ("right drag", "move it sideways"),
    ("wheel", "nearer, farther"),
    ("W A S D", "fly; Q, E down and up, Shift faster"),
    ("C", "orbit or look around by dragging"),
    ("R", "back to the scene's camera"),
    ("T", "next technique"),
    ("X", "split view with the reference"),
    ("M", "error map (with --truth)"),
    ("Space", "play or pause the animation"),
    (", .", "one frame back or on"),
    ("- +", "darker, brighter"),
    ("P", "save the picture, PNG and EXR"),
    ("H", "hide or show the panel"),
    ("F1", "show or hide these keys"),
];

/// What the panel remembers.
#[derive(Default)]
pub struct Panel {
    hidden: bool,
    keys: bool,
}

/// Dark, and a little denser than egui's own: there is much to show.
pub fn style(context: &Context) {
    context.set_visuals(egui::Visuals::dark());
    context.all_styles_mut(|style| {
        style.spacing.item_spacing = egui::vec2(6.0, 5.0);
        style.spacing.slider_width = 110.0;
        style.spacing.combo_width = 110.0;
        style.visuals.panel_fill = PANEL;
        style.visuals.override_text_color = Some(Color32::from_gray(222));
        // Numbers and labels are not for selecting: the pointer would change over each.
        style.interaction.selectable_labels = false;
    });
}

impl Panel {
    pub fn show(&mut self, context: &Context, session: &mut Session, pictures: &mut Pictures) {
        self.keys(context, session);
        egui::TopBottomPanel::bottom("status").exact_height(STATUS_HEIGHT).show(context, |ui| {
            ui.with_layout(Layout::left_to_right(Align::Center), |ui| status(ui, session, &mut self.keys))
        });
        if !self.hidden {
            egui::SidePanel::right("panel")
                .exact_width(PANEL_WIDTH)
                .resizable(false)
                .show(context, |ui| sections(ui, session));
        }
        self.key_list(context);
        long_message(context, session);
        CentralPanel::default().frame(Frame::NONE.fill(BACKDROP)).show(context, |ui| pictures.show(ui, session));
    }

    fn key_list(&mut self, context: &Context) {
        egui::Window::new("Keys")
            .open(&mut self.keys)
            .anchor(egui::Align2::LEFT_TOP, [12.0, 12.0])
            .collapsible(false)
            .resizable(false)
            .show(context, |ui| {
                egui::Grid::new("keys").num_columns(2).spacing([16.0, 4.0]).show(ui, |ui| {
                    for (key, meaning) in KEYS {
                        ui.label(RichText::new(*key).monospace());
                        ui.label(*meaning);
                        ui.end_row();
                    }
                });
            });
    }

    fn keys(&mut self, context: &Context, session: &mut Session) {
        if context.wants_keyboard_input() {
            return;
        }
        let pressed = |key| context.input_mut(|i| i.consume_shortcut(&KeyboardShortcut::new(Modifiers::NONE, key)));
        if pressed(Key::C) {
            session.control = match session.control {
                Control::Orbit => Control::Fly,
                Control::Fly => Control::Orbit,
            };
        }
        if pressed(Key::R) {
            session.wish.eye = Eye::Scene(session.camera().name);
        }
        if pressed(Key::T) {
            session.left.method.kind = next(session.left.method.kind);
        }
        if pressed(Key::X) {
            let kind = session.right.is_none().then_some(TechniqueKind::Reference);
            session.split_or_tell(kind);
        }
        if pressed(Key::M) {
            match &mut session.heat {
                Some(heat) => heat.shown = !heat.shown,
                None => session.message = Some(("An error map needs a truth: --truth FILE".to_string(), true)),
            }
        }
        if pressed(Key::Space) && session.scene.animation.moves() {
            session.play.playing = !session.play.playing;
        }
        for (key, step) in [(Key::Comma, -1), (Key::Period, 1)] {
            if pressed(key) {
                session.wish.frame = session.wish.frame.saturating_add_signed(step);
            }
        }
        for (key, stops) in [(Key::Minus, -0.25), (Key::Plus, 0.25), (Key::Equals, 0.25)] {
            if pressed(key) {
                session.look.exposure = (session.look.exposure + stops).clamp(-image::STOPS, image::STOPS);
            }
        }
        if pressed(Key::P) {
            session.screenshot();
        }
        if pressed(Key::H) {
            self.hidden = !self.hidden;
        }
        if pressed(Key::F1) {
            self.keys = !self.keys;
        }
    }
}

fn next(kind: TechniqueKind) -> TechniqueKind {
    let all = TechniqueKind::ALL;
    let index = all.iter().position(|k| *k == kind).unwrap_or(0);
    all[(index + 1) % all.len()]
}

fn sections(ui: &mut Ui, session: &mut Session) {
    egui::ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        ui.add_space(4.0);
        section(ui, "Technique", true, |ui| technique::show(ui, session));
        section(ui, "Camera", true, |ui| scene::camera(ui, session));
        section(ui, "Light", false, |ui| scene::lights(ui, session));
        section(ui, "Water", session.scene.animation.moves(), |ui| scene::water(ui, session));
        section(ui, "Picture", true, |ui| image::show(ui, session));
        section(ui, "Times", true, |ui| figures::times(ui, &session.left.history));
        section(ui, "Figures", false, |ui| figures::figures(ui, session));
    });
}

fn section(ui: &mut Ui, name: &str, open: bool, show: impl FnOnce(&mut Ui)) {
    egui::CollapsingHeader::new(RichText::new(name).strong()).default_open(open).show(ui, show);
}

/// The line below the picture.
fn status(ui: &mut Ui, session: &mut Session, keys: &mut bool) {
    let failure = session.left.failure.as_ref().or(session.right.as_ref().and_then(|pane| pane.failure.as_ref()));
    ui.label(RichText::new(session.left.method.kind.name()).strong());
    ui.separator();
    ui.label(format!("{} samples", session.left.done()));
    if let Some(time) = session.left.sample_time {
        ui.separator();
        ui.label(format!("{} a sample", milliseconds(time.as_secs_f32() * 1e3)));
    }
    if let Some(noise) = session.left.noise {
        ui.separator();
        ui.label(format!("noise {:.2} %", 100.0 * noise)).on_hover_text(
            "Estimated relative error of the caustic light, from two halves of the samples; told at powers of two",
        );
    }
    if let Some(heat) = session.heat.as_ref().filter(|heat| heat.shown)
        && let Some(map) = &heat.map
        && let Ok((error, _)) = map.result
    {
        ui.separator();
        ui.label(format!("relRMSE of {} {:.2} %", map.layer, 100.0 * error));
    }
    if session.scene.animation.moves() {
        ui.separator();
        ui.label(format!("frame {}", session.wish.frame));
    }
    ui.separator();
    if let Some((reason, ..)) = failure {
        ui.add(egui::Label::new(RichText::new(reason).color(BAD)).truncate()).on_hover_text(reason);
    } else if let Some((text, bad)) = session.message.clone() {
        if ui.small_button("x").on_hover_text("Dismiss").clicked() {
            session.message = None;
        }
        let shown = RichText::new(text.lines().next().unwrap_or_default());
        let shown = if bad { shown.color(BAD) } else { shown };
        ui.add(egui::Label::new(shown).truncate()).on_hover_text(text);
    } else {
        ui.toggle_value(keys, "keys").on_hover_text("F1");
        let tier = format!("{}, {}", session.device.info.name, session.left.renderer().tier());
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            ui.add(egui::Label::new(RichText::new(&tier).weak()).truncate()).on_hover_text(&tier);
        });
    }
}

/// What does not fit the line: a compiler's messages, for instance.
fn long_message(context: &Context, session: &mut Session) {
    let Some((text, bad)) = session.message.clone().filter(|(text, _)| text.contains('\n')) else { return };
    let mut open = true;
    egui::Window::new(if bad { "Something is wrong" } else { "News" })
        .open(&mut open)
        .anchor(egui::Align2::LEFT_BOTTOM, [12.0, -STATUS_HEIGHT - 12.0])
        .collapsible(false)
        .resizable(false)
        .show(context, |ui| {
            let shown = RichText::new(text).monospace();
            ui.add(egui::Label::new(if bad { shown.color(BAD) } else { shown }).wrap());
        });
    if !open {
        session.message = None;
    }
}

fn milliseconds(milliseconds: f32) -> String {
    match milliseconds {
        m if m >= 1000.0 => format!("{:.2} s", m / 1000.0),
        m if m >= 10.0 => format!("{m:.0} ms"),
        m => format!("{m:.2} ms"),
    }
}

/// A slider that changes a value only where the user does: egui's own clamps and rounds whatever it shows.
fn slider<Num: egui::emath::Numeric>(value: &mut Num, range: std::ops::RangeInclusive<Num>) -> Slider<'_> {
    Slider::new(value, range).clamping(SliderClamping::Edits)
}

/// A row of a form: a name on the left, what it is about as its tooltip, and something to change on the right.
fn row(ui: &mut Ui, name: &str, help: &str, show: impl FnOnce(&mut Ui)) {
    let label = ui.label(name);
    if !help.is_empty() {
        label.on_hover_text(help);
    }
    ui.horizontal(show);
    ui.end_row();
}

fn form(ui: &mut Ui, name: &str, show: impl FnOnce(&mut Ui)) {
    egui::Grid::new(name).num_columns(2).min_col_width(86.0).spacing([8.0, 5.0]).show(ui, show);
}
