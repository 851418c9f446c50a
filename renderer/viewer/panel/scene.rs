//! Camera, lights and water.

use egui::{ComboBox, DragValue, Ui};
use glam::Vec3;

use super::{form, row, slider};
use crate::scene::{Emitter, Light};
use crate::viewer::camera::Control;
use crate::viewer::medium;
use crate::viewer::session::Session;
use crate::viewer::state::Eye;

pub fn camera(ui: &mut Ui, session: &mut Session) {
    form(ui, "camera", |ui| {
        row(ui, "camera", "Those of the scene; dragging on the picture leaves them", |ui| {
            let shown = match &session.wish.eye {
                Eye::Scene(name) => name.clone(),
                Eye::Own(_) => "moved by hand".to_string(),
            };
            let names: Vec<String> = session.scene.cameras.iter().map(|camera| camera.name.clone()).collect();
            ComboBox::from_id_salt("camera").selected_text(shown).show_ui(ui, |ui| {
                for name in names {
                    let selected = session.wish.eye == Eye::Scene(name.clone());
                    if ui.selectable_label(selected, &name).clicked() {
                        session.wish.eye = Eye::Scene(name);
                    }
                }
            });
        });
        row(ui, "view", "Vertical field of view", |ui| {
            let mut fov = session.camera().fov_y;
            if ui.add(slider(&mut fov, 5.0..=150.0).suffix("°").fixed_decimals(0)).changed() {
                session.move_camera(|camera| camera.fov_y = fov);
            }
        });
        row(ui, "dragging", "What dragging on the picture does (C)", |ui| {
            ui.selectable_value(&mut session.control, Control::Orbit, "orbit");
            ui.selectable_value(&mut session.control, Control::Fly, "fly");
            let speed = session.speed;
            ui.add(
                DragValue::new(&mut session.speed).range(1e-3..=1e4).speed(speed * 0.01).max_decimals(2).suffix(" m/s"),
            )
            .on_hover_text("How fast W, A, S and D fly");
        });
        let camera = session.camera();
        let medium = session.scene.media.get(camera.medium).map_or("", |medium| medium.name.as_str());
        row(ui, "in", "The medium that the camera is in; it follows from where it is", |ui| {
            let Vec3 { x, y, z } = camera.position;
            ui.label(format!("{medium}, at {x:.2}, {y:.2}, {z:.2}"));
        });
    });
}

pub fn lights(ui: &mut Ui, session: &mut Session) {
    let shown = session.wish.lights.as_ref().unwrap_or(&session.left.seen().scene().lights);
    let mut lights = shown.clone();
    for (index, (light, own)) in lights.iter_mut().zip(&session.scene.lights).enumerate() {
        ui.label(&light.name);
        form(ui, &format!("light {index}"), |ui| one_light(ui, light, own));
    }
    if lights != *shown {
        for (light, before) in lights.iter_mut().zip(shown) {
            if let Some(now) = position(&light.emitter).filter(|now| position(&before.emitter) != Some(*now)) {
                light.medium = medium::at(session.left.seen().scene(), now).unwrap_or(light.medium);
            }
        }
        session.wish.lights = Some(lights);
        session.moves();
    }
    if session.wish.lights.is_some() && ui.button("as in the scene").clicked() {
        session.wish.lights = None;
        session.moves();
    }
}

/// `own`: the light as the scene has it.
fn one_light(ui: &mut Ui, light: &mut Light, own: &Light) {
    let start = strength(&own.emitter).max_element();
    row(ui, "strength", "Times the scene's", |ui| {
        let now = strength(&light.emitter).max_element();
        let mut times = if start > 0.0 { now / start } else { 1.0 };
        let times_of = slider(&mut times, 0.01..=100.0).logarithmic(true).suffix(" x").max_decimals(2);
        if ui.add(times_of).changed() && start > 0.0 {
            *strength_of(&mut light.emitter) = strength(&own.emitter) * times;
        }
    });
    match &mut light.emitter {
        Emitter::Point { position, .. } => place(ui, position),
        Emitter::Spot { position, direction, .. } => {
            place(ui, position);
            aim(ui, direction);
        }
        Emitter::Directional { direction, .. } => aim(ui, direction),
    }
}

fn strength(emitter: &Emitter) -> Vec3 {
    match emitter {
        Emitter::Point { intensity, .. } | Emitter::Spot { intensity, .. } => *intensity,
        Emitter::Directional { irradiance, .. } => *irradiance,
    }
}

/// `None` where it is at no place.
fn position(emitter: &Emitter) -> Option<Vec3> {
    match emitter {
        Emitter::Point { position, .. } | Emitter::Spot { position, .. } => Some(*position),
        Emitter::Directional { .. } => None,
    }
}

fn strength_of(emitter: &mut Emitter) -> &mut Vec3 {
    match emitter {
        Emitter::Point { intensity, .. } | Emitter::Spot { intensity, .. } => intensity,
        Emitter::Directional { irradiance, .. } => irradiance,
    }
}

fn place(ui: &mut Ui, position: &mut Vec3) {
    row(ui, "position", "Metres: x, y up, z", |ui| {
        for component in position.as_mut() {
            ui.add(
                DragValue::new(component).speed(0.02).range(-1e5..=1e5).clamp_existing_to_range(false).max_decimals(2),
            );
        }
    });
}

/// A direction of travel by two angles.
fn aim(ui: &mut Ui, direction: &mut Vec3) {
    let mut fall = (-direction.y).clamp(-1.0, 1.0).acos().to_degrees();
    let mut turn = direction.x.atan2(direction.z).to_degrees();
    let before = (fall, turn);
    row(ui, "off vertical", "Between the light's direction and straight down", |ui| {
        ui.add(slider(&mut fall, 0.0..=180.0).suffix("°").fixed_decimals(1));
    });
    row(ui, "towards", "Round the vertical, from the z axis to the x axis", |ui| {
        ui.add(slider(&mut turn, -180.0..=180.0).suffix("°").fixed_decimals(1));
    });
    if (fall, turn) != before {
        // At the pole the turn would be lost.
        let (sin, cos) = fall.clamp(0.05, 179.95).to_radians().sin_cos();
        let (x, z) = turn.to_radians().sin_cos();
        *direction = Vec3::new(sin * x, -cos, sin * z).normalize();
    }
}

pub fn water(ui: &mut Ui, session: &mut Session) {
    if !session.scene.animation.moves() {
        ui.weak("Nothing moves in this scene.");
        return;
    }
    let time = session.scene.animation.time(session.wish.frame);
    ui.horizontal(|ui| {
        if ui.button(if session.play.playing { "pause" } else { "play" }).on_hover_text("Space").clicked() {
            session.play.playing = !session.play.playing;
        }
        if ui.button("<").on_hover_text("One frame back (,)").clicked() {
            session.wish.frame = session.wish.frame.saturating_sub(1);
        }
        if ui.button(">").on_hover_text("One frame on (.)").clicked() {
            session.wish.frame = session.wish.frame.saturating_add(1);
        }
        ui.label(format!("{time:.2} s"));
    });
    form(ui, "water", |ui| {
        row(ui, "frame", "Each is what 'nephroid render --frame' shows", |ui| {
            let last = session.play.end.saturating_sub(1).max(session.wish.frame);
            if ui.add(slider(&mut session.wish.frame, 0..=last)).changed() {
                session.moves();
            }
        });
        row(ui, "loop", "Frames after which playing starts again", |ui| {
            ui.add(DragValue::new(&mut session.play.end).range(1..=1_000_000).suffix(" frames"));
        });
        let own = session.scene.animation.fps;
        row(ui, "speed", "Frames shown in a second, as far as rendering keeps up", |ui| {
            let rate = DragValue::new(&mut session.play.rate).range(0.1..=240.0).clamp_existing_to_range(false);
            ui.add(rate.speed(0.1).max_decimals(1).suffix(" fps"));
            ui.weak(format!("the scene's: {own}"));
        });
    });
}
