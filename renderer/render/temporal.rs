//! Frames before the one at hand: what anti-aliasing and motion vectors take from them.

use super::{History, RenderError, Renderer};
use crate::animate::Previous;
use crate::image::{FINAL_LAYER, Layer, LayeredImage, RgbImage};
use crate::random;
use crate::spans;
use crate::stats::{self, PassTotal, Stats};
use crate::taa::{Taa, TaaSettings};
use crate::view::{Band, View};

impl Renderer {
    fn history(&self) -> Option<History> {
        self.taa_settings.map(|taa| taa.history)
    }

    /// Frames that a picture is made of, 1 without anti-aliasing.
    pub fn taa_frames(&self) -> u32 {
        self.taa_settings.map_or(1, |taa| taa.frames)
    }

    /// Makes pictures of several frames from now on, or of one, and forgets all samples and the frames before.
    pub fn set_taa(&mut self, settings: Option<TaaSettings>) -> Result<(), RenderError> {
        self.passes.clear();
        let before = std::mem::replace(&mut self.taa_settings, settings);
        self.begin_row().and_then(|()| self.make_bands()).or_else(|error| {
            self.taa_settings = before;
            self.begin_row()?;
            self.make_bands()?;
            Err(error)
        })
    }

    /// Keeps the frame before, or no longer. The first of those that were shown is the one at hand.
    fn begin_row(&mut self) -> Result<(), RenderError> {
        self.shown_by = None;
        self.animator.drop_previous();
        if self.taa_settings.is_some() || self.motion.is_some() {
            self.animator.keep_previous(&self.gpu_scene)?;
        }
        match self.history() {
            Some(History::Shown) => Ok(self.animator.keep_now(&self.scene, &self.gpu_scene)?),
            _ => self.move_to(self.frame),
        }
    }

    /// Number of the picture in the row that anti-aliasing makes one of.
    fn place_in_row(&self) -> u32 {
        match self.history() {
            None => 0,
            Some(History::Numbered) => self.frame,
            Some(History::Shown) => self.shown,
        }
    }

    /// With anti-aliasing, frames have noise of their own: of equal noise, many are no better than one.
    pub(super) fn own_seed(&self) -> u32 {
        match self.taa_settings {
            None => self.seed,
            Some(_) => random::combine(self.seed, self.place_in_row()),
        }
    }

    /// Seed of the jitter, and the number of its first point: frames go on in one sequence, so that those of a window are
    /// spread over the pixel as the samples of one are.
    pub(super) fn jitter(&self) -> (u32, u32) {
        let step = if self.history() == Some(History::Shown) { 1 } else { self.samples };
        (self.seed, self.place_in_row().wrapping_mul(step))
    }

    /// No samples yet.
    pub(super) fn begin(&mut self) {
        self.done = 0;
        if let Some(taa) = &mut self.taa {
            taa.restart();
        }
    }

    /// Before anything of the picture changes: keeps it for anti-aliasing, or forgets what was kept. `next`: the frame
    /// that is gone to, where it is this that changes.
    pub(super) fn leave(&mut self, next: Option<u32>) -> Result<(), RenderError> {
        match self.history() {
            None => {}
            Some(History::Numbered) => match next {
                // A frame that was stopped is no frame of a window.
                Some(next) if next != self.frame && self.done == self.samples => self.keep()?,
                Some(_) => {}
                None => self.taa.iter_mut().for_each(Taa::forget),
            },
            Some(History::Shown) if self.done > 0 => {
                self.keep()?;
                self.animator.keep_now(&self.scene, &self.gpu_scene)?;
                self.shown_by = Some(self.camera.clone());
                self.shown = self.shown.wrapping_add(1);
            }
            Some(History::Shown) => {}
        }
        Ok(())
    }

    fn keep(&mut self) -> Result<(), RenderError> {
        self.take(&mut Vec::new())?;
        let number = self.place_in_row();
        if let Some(taa) = &mut self.taa {
            taa.keep(&self.device, number)?;
        }
        self.done = 0;
        Ok(())
    }

    /// Renders the frames that the picture is made of besides the one at hand, where they are not there.
    pub(super) fn render_frames_before(&mut self) -> Result<(), RenderError> {
        if self.history() != Some(History::Numbered) {
            return Ok(());
        }
        let Some(taa) = &mut self.taa else { return Ok(()) };
        let frame = self.frame;
        let first = taa.first_missing(frame);
        for before in first..frame {
            let _span = spans::span_of("frame before", || before.to_string());
            self.move_to(before)?;
            self.start_over()?;
            for _ in 0..self.samples {
                self.render_sample()?;
            }
            self.keep()?;
        }
        if first < frame {
            self.move_to(frame)?;
            self.start_over()?;
        }
        Ok(())
    }

    fn take(&self, passes: &mut Vec<PassTotal>) -> Result<(), RenderError> {
        if let (Some(taa), Some(previous)) = (&self.taa, self.animator.previous()) {
            let bands = self.bands.iter().map(|band| (&band.frame, self.previous_view(previous, band.rows)));
            stats::add_times(passes, &taa.take(&self.device, previous, self.done, bands)?);
        }
        Ok(())
    }

    /// Makes the picture of the samples so far and the frames before; `None` where there are none.
    pub(super) fn resolve(&self, passes: &mut Vec<PassTotal>) -> Result<Option<&Taa>, RenderError> {
        let Some(taa) = self.taa.as_ref().filter(|taa| taa.has_past() && self.done > 0) else { return Ok(None) };
        self.take(passes)?;
        // A frame of the past weighs as much as a whole one, or in a window as one sample: what stands still gets better.
        let whole = if self.history() == Some(History::Shown) { 1 } else { self.samples };
        stats::add_times(passes, &taa.resolve(&self.device, self.done as f32 / whole as f32)?);
        Ok(Some(taa))
    }

    /// Puts the picture made of several frames in the place of the frame's own, which is still the sum of `refracted` and
    /// `reflected`.
    pub(super) fn anti_alias(&self, image: &mut LayeredImage, stats: &mut Stats) -> Result<(), RenderError> {
        if self.history() != Some(History::Numbered) {
            return Ok(());
        }
        let Some(taa) = self.resolve(&mut stats.passes)? else { return Ok(()) };
        let (width, height) = (self.size.0 as usize, self.size.1 as usize);
        let picture = Layer::from_rgb(FINAL_LAYER, &RgbImage { width, height, pixels: taa.read()? });
        if let Some(layer) = image.layers.iter_mut().find(|layer| layer.name == FINAL_LAYER) {
            *layer = picture;
        }
        Ok(())
    }

    /// That of the frame before. A camera that is not the scene's own stands still, unless frames are those that were
    /// shown.
    pub(super) fn previous_view(&self, previous: &Previous, band: Band) -> View {
        let own = previous.cameras.iter().find(|camera| self.own_camera && camera.name == self.camera.name);
        let camera = self.shown_by.as_ref().or(own).unwrap_or(&self.camera);
        View::new(camera, &self.scene.film, self.size, band)
    }
}
