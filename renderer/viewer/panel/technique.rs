//! Choice of the techniques, and their settings from the table that `--set` has.

use egui::{ComboBox, DragValue, Ui};

use super::{form, row};
use crate::technique::{Setting, SettingKind, TechniqueKind};
use crate::viewer::session::Session;
use crate::viewer::state::Method;

pub fn show(ui: &mut Ui, session: &mut Session) {
    choice(ui, "left", &mut session.left.method);
    let mut split = session.right.is_some();
    if ui.checkbox(&mut split, "split view").on_hover_text("A second technique to the right of a line (X)").changed() {
        let kind = split.then_some(TechniqueKind::Reference);
        session.split_or_tell(kind);
    }
    if let Some(right) = &mut session.right {
        choice(ui, "right", &mut right.method);
    }
}

fn choice(ui: &mut Ui, id: &str, method: &mut Method) {
    ui.push_id(id, |ui| {
        ui.horizontal(|ui| {
            for kind in TechniqueKind::ALL {
                ui.selectable_value(&mut method.kind, *kind, kind.name());
            }
        });
        form(ui, "settings", |ui| {
            for setting in method.kind.settings() {
                let help = help(setting);
                row(ui, setting.key, &help, |ui| {
                    let mut value = method.value(setting).to_string();
                    if widget(ui, setting, &mut value) {
                        method.set(setting, value);
                    }
                    if method.value(setting) != setting.default
                        && ui.small_button("x").on_hover_text(format!("Back to {}", setting.default)).clicked()
                    {
                        method.set(setting, setting.default.to_string());
                    }
                });
            }
        });
    });
}

fn help(setting: &Setting) -> String {
    let unit = if setting.unit.is_empty() { String::new() } else { format!(", {}", setting.unit) };
    format!("{} ({}{unit}; {} by default)", setting.help, setting.kind.allowed(), setting.default)
}

/// Lets the value be changed; `true` once it was, and for a number not before it is let go.
fn widget(ui: &mut Ui, setting: &Setting, value: &mut String) -> bool {
    let suffix = match setting.unit {
        "" => String::new(),
        unit => format!(" {unit}"),
    };
    match setting.kind {
        SettingKind::Choice(values) => {
            let before = value.clone();
            ComboBox::from_id_salt(setting.key).selected_text(value.as_str()).show_ui(ui, |ui| {
                for choice in values {
                    ui.selectable_value(value, choice.to_string(), *choice);
                }
            });
            *value != before
        }
        SettingKind::File => ui.text_edit_singleline(value).lost_focus(),
        SettingKind::Integer { min, max } => {
            let parsed = value.parse().unwrap_or(min);
            let speed = (parsed as f64 * 0.01).max(0.1);
            number(ui, parsed as f64, DragWith { min: min as f64, max: max as f64, speed, decimals: 0, suffix }, value)
        }
        SettingKind::Number { min, max } => {
            let parsed: f64 = value.parse().unwrap_or(min);
            let speed = (parsed.abs() * 0.01).max((max - min) * 1e-4);
            number(ui, parsed, DragWith { min, max, speed, decimals: 3, suffix }, value)
        }
    }
}

struct DragWith {
    min: f64,
    max: f64,
    speed: f64,
    decimals: usize,
    suffix: String,
}

/// A number that is dragged keeps its new value beside the setting until it is let go: a technique made anew at every
/// step would stutter.
fn number(ui: &mut Ui, current: f64, with: DragWith, value: &mut String) -> bool {
    let id = ui.next_auto_id().with("held");
    let mut held = ui.data(|data| data.get_temp(id)).unwrap_or(current);
    let drag = DragValue::new(&mut held)
        .range(with.min..=with.max)
        .speed(with.speed)
        .max_decimals(with.decimals)
        .suffix(with.suffix)
        .update_while_editing(false);
    let response = ui.add(drag);
    if response.dragged() {
        ui.data_mut(|data| data.insert_temp(id, held));
        return false;
    }
    ui.data_mut(|data| data.remove::<f64>(id));
    if held == current {
        return false;
    }
    *value = format!("{}", (held * 1e6).round() / 1e6);
    true
}
