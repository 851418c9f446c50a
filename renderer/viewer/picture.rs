//! The picture in the middle of the window: one pane, two with a divider, or a heat map.

use egui::{Color32, ColorImage, CursorIcon, Pos2, Rect, Response, Sense, TextureHandle, TextureOptions, Ui, Vec2};
use glam::Vec3;

use super::camera::{self, Control};
use super::pane::Pane;
use super::session::Session;

/// Half the width of what can be grabbed of the divider, in points.
const GRAB: f32 = 6.0;
/// Points of scrolling in a notch of the wheel.
const NOTCH: f32 = 50.0;

/// The textures of what is shown.
#[derive(Default)]
pub struct Pictures {
    left: Slot,
    right: Slot,
    heat: Slot,
}

/// A texture and which version of a picture it holds.
#[derive(Default)]
struct Slot {
    texture: Option<TextureHandle>,
    held: Option<((u32, u32), u64)>,
}

impl Slot {
    fn take(
        &mut self,
        ui: &Ui,
        name: &str,
        size: (u32, u32),
        version: u64,
        image: impl FnOnce([usize; 2]) -> ColorImage,
    ) {
        if self.held == Some((size, version)) {
            return;
        }
        let image = image([size.0 as usize, size.1 as usize]);
        let options = TextureOptions::LINEAR;
        match (&mut self.texture, self.held) {
            // In place: a texture of another size is a new one.
            (Some(texture), Some((before, _))) if before == size => texture.set_partial([0, 0], image, options),
            _ => self.texture = Some(ui.ctx().load_texture(name, image, options)),
        }
        self.held = Some((size, version));
    }

    fn take_pane(&mut self, ui: &Ui, name: &str, pane: Option<&Pane>) {
        match pane.and_then(|pane| pane.shown.as_ref().map(|shown| (shown, &pane.pixels))) {
            Some((shown, pixels)) => {
                let rgba = |size| ColorImage::from_rgba_premultiplied(size, pixels.as_flattened());
                self.take(ui, name, shown.size, shown.version, rgba);
            }
            None => *self = Slot::default(),
        }
    }

    /// Draws the part of the picture in `area` that is right of `from` and left of `to`, both 0 to 1.
    fn draw(&self, ui: &Ui, area: Rect, from: f32, to: f32) {
        let Some(texture) = &self.texture else { return };
        let at = |x: f32, y: f32| Pos2::new(area.left() + x * area.width(), area.top() + y * area.height());
        let uv = Rect::from_min_max(Pos2::new(from, 0.0), Pos2::new(to, 1.0));
        ui.painter().image(texture.id(), Rect::from_min_max(at(from, 0.0), at(to, 1.0)), uv, Color32::WHITE);
    }
}

impl Pictures {
    /// Shows the picture in all that is left of the window, and lets the camera be moved on it.
    pub fn show(&mut self, ui: &mut Ui, session: &mut Session) {
        let free = ui.available_rect_before_wrap();
        let area = fitted(free, session.wish.size, ui.ctx().pixels_per_point());
        let response = ui.allocate_rect(free, Sense::click_and_drag());
        self.left.take_pane(ui, "picture", Some(&session.left));
        self.right.take_pane(ui, "second picture", session.right.as_ref());
        // A panel that fills the window leaves nothing.
        if !area.is_positive() {
            return;
        }
        self.left.draw(ui, area, 0.0, 1.0);
        self.right.draw(ui, area, session.divider, 1.0);
        if let Some(heat) = session.heat.as_ref().filter(|heat| heat.shown)
            && let Some(map) = &heat.map
        {
            let rgb = |size| ColorImage::from_rgb(size, map.pixels.as_flattened());
            self.heat.take(ui, "heat map", map.size, map.version, rgb);
            self.heat.draw(ui, area, 0.0, if session.right.is_some() { session.divider } else { 1.0 });
        }
        if session.left.shown.is_none() {
            ui.put(area, egui::Label::new("Rendering the first sample ..."));
        }
        let grabbed = session.right.is_some() && divide(ui, area, session);
        if !grabbed {
            drag(ui, &response, area, session);
        }
        fly(ui, session);
    }
}

/// The largest rectangle of the picture's shape; where the picture fits, its pixels are the screen's.
fn fitted(free: Rect, (width, height): (u32, u32), pixels_per_point: f32) -> Rect {
    let size = Vec2::new(width as f32, height as f32) / pixels_per_point;
    let room = (free.width() / size.x).min(free.height() / size.y);
    // Just a little larger or smaller would blur the picture for nothing.
    let scale = if (0.999..1.25).contains(&room) { 1.0 } else { room };
    let corner = (free.center() - size * scale * 0.5) * pixels_per_point;
    Rect::from_min_size(Pos2::new(corner.x.round(), corner.y.round()) / pixels_per_point, size * scale)
}

/// The divider; `true` while it is held.
fn divide(ui: &mut Ui, area: Rect, session: &mut Session) -> bool {
    let x = area.left() + session.divider * area.width();
    let grip = Rect::from_x_y_ranges(x - GRAB..=x + GRAB, area.y_range());
    let response =
        ui.interact(grip, ui.id().with("divider"), Sense::drag()).on_hover_cursor(CursorIcon::ResizeHorizontal);
    if let Some(pointer) = response.interact_pointer_pos() {
        session.divider = ((pointer.x - area.left()) / area.width()).clamp(0.02, 0.98);
    }
    let painter = ui.painter();
    painter.vline(x, area.y_range(), (1.5, Color32::WHITE));
    painter.circle(Pos2::new(x, area.center().y), 5.0, Color32::WHITE, (1.0, Color32::DARK_GRAY));
    let label = |left: bool, text: &str| {
        let (at, align) = match left {
            true => (Pos2::new(x - 10.0, area.top() + 8.0), egui::Align2::RIGHT_TOP),
            false => (Pos2::new(x + 10.0, area.top() + 8.0), egui::Align2::LEFT_TOP),
        };
        let galley = painter.layout_no_wrap(text.to_string(), egui::FontId::proportional(13.0), Color32::WHITE);
        let rect = align.anchor_size(at, galley.size());
        painter.rect_filled(rect.expand(3.0), 3.0, Color32::from_black_alpha(170));
        painter.galley(rect.min, galley, Color32::WHITE);
    };
    let text = |pane: &Pane| format!("{}, {} samples", pane.method.kind.name(), pane.done());
    label(true, &text(&session.left));
    if let Some(right) = &session.right {
        label(false, &text(right));
    }
    response.dragged()
}

/// Drags and the wheel move the camera.
fn drag(ui: &Ui, response: &Response, area: Rect, session: &mut Session) {
    let delta = response.drag_delta() / area.height();
    let delta = glam::Vec2::new(delta.x, delta.y);
    let control = session.control;
    if delta != glam::Vec2::ZERO {
        if response.dragged_by(egui::PointerButton::Primary) {
            session.move_camera(|camera| camera::turn(camera, control, delta));
        } else {
            session.move_camera(|camera| camera::pan(camera, delta));
        }
    }
    let notches = if response.hovered() { ui.input(|input| input.smooth_scroll_delta.y) / NOTCH } else { 0.0 };
    if notches != 0.0 {
        let speed = session.speed;
        session.move_camera(|camera| camera::zoom(camera, control, notches, speed));
    }
}

/// W, A, S, D, Q and E move the camera while they are held.
fn fly(ui: &Ui, session: &mut Session) {
    if ui.ctx().wants_keyboard_input() {
        return;
    }
    let (way, time, fast) = ui.input(|input| {
        use egui::Key;
        let axis = |more, less| f32::from(u8::from(input.key_down(more))) - f32::from(u8::from(input.key_down(less)));
        let way = Vec3::new(axis(Key::D, Key::A), axis(Key::E, Key::Q), axis(Key::W, Key::S));
        (if input.modifiers.command { Vec3::ZERO } else { way }, input.stable_dt.min(0.1), input.modifiers.shift)
    });
    if way != Vec3::ZERO {
        session.control = Control::Fly;
        let step = way * session.speed * time * if fast { 4.0 } else { 1.0 };
        session.move_camera(|camera| camera::walk(camera, step));
        ui.ctx().request_repaint();
    }
}
