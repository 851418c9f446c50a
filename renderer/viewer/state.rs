//! What the picture is to show, as plain data that can be compared.

use crate::render::{RenderError, Renderer};
use crate::scene::{Camera, Light};
use crate::taa::{History, TaaSettings};
use crate::technique::{Setting, SettingKind, TechniqueKind};

/// Where the scene is looked at from.
#[derive(Debug, Clone, PartialEq)]
pub enum Eye {
    /// The scene's camera of that name, wherever it is at the frame.
    Scene(String),
    /// A camera that was moved by hand.
    Own(Camera),
}

/// What is to be seen. All pictures of the window show the same.
#[derive(Debug, Clone, PartialEq)]
pub struct Wish {
    pub eye: Eye,
    /// In place of the scene's.
    pub lights: Option<Vec<Light>>,
    /// Of the animation.
    pub frame: u32,
    /// Pixels.
    pub size: (u32, u32),
    /// Pictures that one is made of while things move, 1 for none but itself.
    pub taa: u32,
}

impl Wish {
    /// What the renderer is told of [`taa`](Self::taa).
    pub fn taa_settings(&self) -> Option<TaaSettings> {
        (self.taa > 1).then_some(TaaSettings { frames: self.taa, history: History::Shown })
    }
}

/// A technique and what the settings of all of them are; those of the others are remembered.
#[derive(Debug, Clone, PartialEq)]
pub struct Method {
    pub kind: TechniqueKind,
    values: Vec<(TechniqueKind, &'static str, String)>,
}

impl Method {
    /// `items` are `technique.key=value`; what does not parse is left out, since the renderer has refused it already.
    pub fn new(kind: TechniqueKind, items: &[String]) -> Self {
        let mut method = Method { kind, values: Vec::new() };
        for item in items {
            let _ = method.set_item(item);
        }
        method
    }

    /// The value in use.
    pub fn value<'a>(&'a self, setting: &'a Setting) -> &'a str {
        let of = |(kind, key, _): &&(TechniqueKind, &str, String)| *kind == self.kind && *key == setting.key;
        self.values.iter().find(of).map_or(setting.default, |(_, _, value)| value)
    }

    /// Takes another value for a setting of the technique in use.
    pub fn set(&mut self, setting: &Setting, value: String) {
        self.set_of(self.kind, setting.key, value);
    }

    fn set_of(&mut self, kind: TechniqueKind, key: &'static str, value: String) {
        self.values.retain(|(k, name, _)| (*k, *name) != (kind, key));
        self.values.push((kind, key, value));
    }

    /// Reads `technique.key=value`, for whichever technique.
    ///
    /// # Errors
    /// A sentence: what was found and what is allowed.
    pub fn set_item(&mut self, item: &str) -> Result<(), String> {
        let name = item.split('.').next().unwrap_or_default();
        let kind = TechniqueKind::parse(name.trim()).map_err(|error| error.to_string())?;
        let parsed = crate::technique::Settings::parse(kind, &[item.to_string()]).map_err(|error| error.to_string())?;
        let key = item.split(['.', '=']).nth(1).unwrap_or_default().trim();
        if let Some((key, value)) = parsed.iter().find(|(name, _)| *name == key) {
            self.set_of(kind, key, value.to_string());
        }
        Ok(())
    }

    /// What `--set` would say.
    pub fn items(&self) -> Vec<String> {
        let own = self.values.iter().filter(|(kind, ..)| *kind == self.kind);
        own.map(|(kind, key, value)| format!("{}.{key}={value}", kind.name())).collect()
    }

    /// Whether both come to the same picture.
    fn is_like(&self, other: &Method) -> bool {
        let same = |setting| self.value(setting) == other.value(setting);
        self.kind == other.kind && self.kind.settings().iter().all(same)
    }

    /// The same for a picture of a `scale`-th of the size each way. Photons are what the reference's sample costs, whatever
    /// the size.
    pub fn draft(&self, scale: u32) -> Self {
        let mut draft = self.clone();
        let photons = self.kind.settings().iter().find(|setting| setting.key == "photons");
        if let Some((setting, SettingKind::Integer { min, .. })) = photons.map(|setting| (setting, setting.kind))
            && let Ok(count) = self.value(setting).parse::<i64>()
        {
            draft.set(setting, (count / i64::from(scale * scale)).max(min).to_string());
        }
        draft
    }
}

/// What it took to follow a wish.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Followed {
    /// Nothing.
    Already,
    /// The samples are forgotten.
    Restarted,
    /// As well as the times of passes.
    Posed,
    /// As well as the passes themselves.
    Technique,
}

/// A renderer and what it shows.
pub struct Stage {
    pub renderer: Renderer,
    wish: Wish,
    method: Method,
    /// A change failed half-way: the next one starts from the technique.
    broken: bool,
}

impl Stage {
    /// `renderer` was made for this wish and method; lights and a camera of one's own are still to be followed.
    pub fn new(renderer: Renderer, wish: Wish, method: Method) -> Self {
        Stage { renderer, wish, method, broken: false }
    }

    /// Brings the renderer to what is wanted.
    pub fn follow(&mut self, wish: &Wish, method: &Method) -> Result<Followed, RenderError> {
        if self.is(wish, method) {
            return Ok(Followed::Already);
        }
        let was_broken = std::mem::replace(&mut self.broken, true);
        let followed = if was_broken || !self.method.is_like(method) {
            Followed::Technique
        } else if self.wish.taa != wish.taa
            || self.wish.frame != wish.frame
            || (self.wish.lights.is_some() && wish.lights.is_none())
        {
            Followed::Posed
        } else {
            Followed::Restarted
        };
        self.change(wish, method, was_broken)?;
        self.broken = false;
        Ok(followed)
    }

    /// Whether the renderer shows just this.
    pub fn is(&self, wish: &Wish, method: &Method) -> bool {
        !self.broken && self.wish == *wish && self.method.is_like(method)
    }

    fn change(&mut self, wish: &Wish, method: &Method, all: bool) -> Result<(), RenderError> {
        if all || self.wish.frame != wish.frame {
            self.renderer.go_to(wish.frame)?;
            self.wish.frame = wish.frame;
        }
        if self.wish.eye != wish.eye {
            match &wish.eye {
                Eye::Scene(name) => self.renderer.look_through(name)?,
                Eye::Own(camera) => self.renderer.set_camera(camera.clone())?,
            }
            self.wish.eye = wish.eye.clone();
        }
        if self.wish.lights != wish.lights {
            self.renderer.set_lights(wish.lights.clone())?;
            self.wish.lights = wish.lights.clone();
        }
        if all || self.wish.size != wish.size {
            self.renderer.set_size(wish.size)?;
            self.wish.size = wish.size;
        }
        if all || self.wish.taa != wish.taa {
            self.renderer.set_taa(wish.taa_settings())?;
            self.wish.taa = wish.taa;
        }
        if all || !self.method.is_like(method) {
            self.renderer.set_technique(method.kind, &method.items())?;
            self.method = method.clone();
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_of_other_techniques_are_remembered() {
        let mut method = Method::new(TechniqueKind::Reference, &["reference.photons=64000".to_string()]);
        method.set_item("mnee.rest=photons").unwrap();
        assert_eq!(method.items(), ["reference.photons=64000"]);
        assert_eq!(method.draft(4).items(), ["reference.photons=4000"]);
        method.kind = TechniqueKind::Mnee;
        assert_eq!(method.items(), ["mnee.rest=photons"]);
        // The order in which settings were set is nothing that a picture depends on, nor is a default that was set.
        let items = |a: &str, b: &str| Method::new(TechniqueKind::Reference, &[a.to_string(), b.to_string()]);
        let (photons, rest) = ("reference.photons=64000", "mnee.rest=photons");
        assert!(items(photons, rest).is_like(&items(rest, photons)));
        assert!(!items(photons, rest).is_like(&items(rest, rest)));
        assert!(method.set_item("mnee.rest=stars").unwrap_err().contains("allowed is one of"));
    }
}
