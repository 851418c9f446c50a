//! What a frame writes: sums over samples on the device, layers of an image on the host.

use crate::gpu::{Bindings, Buffer, Device, GpuError, Recorder};
use crate::image::{Channel, FINAL_LAYER, Layer, LayeredImage, RgbImage};
use crate::view::{Band, SEGMENTS};

/// Layers of visible points a pixel: direct or refracted, and reflected.
pub const VISIBLE_LAYERS: u64 = 2;

/// Bytes of the largest buffer that a pixel has a share of: both layers of one 32-byte record, or of one a stretch where
/// media scatter.
pub fn largest_bytes_per_pixel(scatters: bool) -> u64 {
    VISIBLE_LAYERS * 32 * if scatters { u64::from(SEGMENTS) } else { 1 }
}

crate::gpu_struct! {
    /// What the frame's kernels left out, and why; see `kernels/shared/film.glsl`.
    #[derive(Default)]
    pub struct FrameCounters {
        pub non_finite: u32,
        pub too_long: u32,
        pub wrong_side: u32,
        pub stretches: u32,
    }
}

/// The film of one band.
pub struct Film {
    pub bindings: Bindings,
    width: u32,
    rows: u32,
    direct: Buffer,
    albedo: Buffer,
    normal: Buffer,
    caustic: Buffer,
    irradiance: Buffer,
    sample_irradiance: Buffer,
    /// Light that media scatter: straight from lights, caustic, and caustic of one sample; of no use where none does.
    volume: Buffer,
    caustic_volume: Buffer,
    sample_volume: Buffer,
    has_volume: bool,
    counters: Buffer,
}

impl Film {
    /// An empty film of `width` pixels by the band's rows, with layers for light that media scatter where any does.
    pub fn new(device: &Device, width: u32, band: Band, has_volume: bool) -> Result<Self, GpuError> {
        let pixels = u64::from(width) * u64::from(band.count);
        let buffer = |name, layers: u64| Buffer::new(device, name, pixels * layers * 16);
        let direct = buffer("film direct", VISIBLE_LAYERS)?;
        let albedo = buffer("film albedo", 1)?;
        let normal = buffer("film normal", 1)?;
        let caustic = buffer("film caustic", VISIBLE_LAYERS)?;
        let irradiance = buffer("film irradiance", 1)?;
        let sample_irradiance = buffer("sample irradiance", VISIBLE_LAYERS)?;
        let volume_layers = if has_volume { VISIBLE_LAYERS } else { 0 };
        let volume = buffer("film volume", volume_layers)?;
        let caustic_volume = buffer("film caustic volume", volume_layers)?;
        let sample_volume = buffer("sample volume", volume_layers)?;
        let counters = Buffer::new(device, "film counters", 16)?;
        let bindings = Bindings::new()
            .buffer("FilmDirect", &direct)
            .buffer("FilmAlbedo", &albedo)
            .buffer("FilmNormal", &normal)
            .buffer("FilmCaustic", &caustic)
            .buffer("FilmIrradiance", &irradiance)
            .buffer("SampleIrradiance", &sample_irradiance)
            .buffer("FilmVolume", &volume)
            .buffer("FilmCausticVolume", &caustic_volume)
            .buffer("SampleVolume", &sample_volume)
            .buffer("Counters", &counters);
        let film = Film {
            bindings,
            width,
            rows: band.count,
            direct,
            albedo,
            normal,
            caustic,
            irradiance,
            sample_irradiance,
            volume,
            caustic_volume,
            sample_volume,
            has_volume,
            counters,
        };
        film.clear(device)?;
        Ok(film)
    }

    /// Forgets all samples.
    pub fn clear(&self, device: &Device) -> Result<(), GpuError> {
        let mut recorder = Recorder::new(device)?;
        let mut pass = recorder.pass("film/clear")?;
        let Film { direct, albedo, normal, caustic, irradiance, sample_irradiance, counters, .. } = self;
        for buffer in [direct, albedo, normal, caustic, irradiance, sample_irradiance, counters] {
            pass.fill(buffer, 0);
        }
        for buffer in [&self.volume, &self.caustic_volume, &self.sample_volume] {
            pass.fill(buffer, 0);
        }
        drop(pass);
        recorder.submit()?;
        Ok(())
    }

    /// Pixels across and rows of the band.
    pub fn size(&self) -> (u32, u32) {
        (self.width, self.rows)
    }

    /// Pixels of the band.
    pub fn pixels(&self) -> u32 {
        self.width * self.rows
    }

    /// Where a per-sample technique leaves the caustic irradiance at this sample's visible points: a vec4 a slot, rgb in
    /// W/m2; the block `SampleIrradiance`. Slots without a point are not read.
    pub fn sample_irradiance(&self) -> &Buffer {
        &self.sample_irradiance
    }

    /// Whether there are layers for light that media scatter.
    pub fn has_volume(&self) -> bool {
        self.has_volume
    }

    /// The band's layers: means over each pixel's samples.
    pub fn read(&self, samples: &SampleCounts) -> Result<FilmRows, GpuError> {
        let pixels = self.pixels() as usize;
        let points = pixels * VISIBLE_LAYERS as usize;
        let mean = |values: Vec<[f32; 4]>| -> Vec<[f32; 4]> {
            let scale = |index: usize| 1.0 / samples.of(index % pixels).max(1) as f32;
            values.into_iter().enumerate().map(|(index, v)| v.map(|x| x * scale(index))).collect()
        };
        Ok(FilmRows {
            direct: mean(self.direct.read(points)?),
            caustic: self.caustic.read(points)?,
            irradiance: self.irradiance.read(pixels)?,
            albedo: mean(self.albedo.read(pixels)?),
            normal: mean(self.normal.read(pixels)?),
            volume: if self.has_volume { mean(self.volume.read(points)?) } else { Vec::new() },
            caustic_volume: if self.has_volume { self.caustic_volume.read(points)? } else { Vec::new() },
        })
    }

    pub fn counters(&self) -> Result<FrameCounters, GpuError> {
        Ok(self.counters.read(1)?.first().copied().unwrap_or_default())
    }

    /// Relative noise of the caustic irradiance, estimated from two halves of each pixel's samples: RMS difference of the
    /// halves' pictures over twice the mean. `second` tells how many of a pixel's samples are in the second half. `None`
    /// before both halves of every pixel have samples.
    pub fn noise(&self, samples: &SampleCounts, second: impl Fn(u32) -> Option<u32>) -> Result<Option<f32>, GpuError> {
        let part = |count: u32| {
            let second = second(count).filter(|&second| second > 0 && second < count)?;
            Some(f64::from(second) / f64::from(count))
        };
        let parts: Option<Vec<f64>> = match samples {
            SampleCounts::Same(count) => part(*count).map(|part| vec![part]),
            SampleCounts::Each(counts) => counts.iter().map(|&count| part(count)).collect(),
        };
        let Some(parts) = parts.filter(|parts| !parts.is_empty()) else { return Ok(None) };
        let values: Vec<[f32; 4]> = self.irradiance.read(self.pixels() as usize)?;
        Ok(relative_noise(&values, &parts))
    }
}

/// How many samples pixels have.
#[derive(Debug, Clone, PartialEq)]
pub enum SampleCounts {
    /// All the same number.
    Same(u32),
    /// Each its own, row by row.
    Each(Vec<u32>),
}

impl SampleCounts {
    /// Samples of the pixel with that index in the band.
    pub fn of(&self, pixel: usize) -> u32 {
        match self {
            SampleCounts::Same(count) => *count,
            SampleCounts::Each(counts) => counts.get(pixel).copied().unwrap_or_default(),
        }
    }
}

/// Irradiance in rgb; in w what the second half contributes to its mean over the channels. `parts`: of the samples, which
/// part is in the second half; one for all pixels or one each.
fn relative_noise(values: &[[f32; 4]], parts: &[f64]) -> Option<f32> {
    let (mut sum, mut squares) = (0.0f64, 0.0f64);
    for (&[r, g, b, second], part) in values.iter().zip(parts.iter().cycle()) {
        let mean = f64::from(r + g + b) / 3.0;
        let difference = f64::from(second) / part - (mean - f64::from(second)) / (1.0 - part);
        sum += mean;
        squares += difference * difference;
    }
    let mean = sum / values.len() as f64;
    (mean > 0.0).then(|| ((squares / values.len() as f64).sqrt() / (2.0 * mean)) as f32)
}

/// One band's layers on the host.
pub struct FilmRows {
    direct: Vec<[f32; 4]>,
    caustic: Vec<[f32; 4]>,
    irradiance: Vec<[f32; 4]>,
    albedo: Vec<[f32; 4]>,
    normal: Vec<[f32; 4]>,
    /// Empty where no medium scatters.
    volume: Vec<[f32; 4]>,
    caustic_volume: Vec<[f32; 4]>,
}

/// The picture's layers from its bands, top to bottom.
///
/// `final` = `refracted` + `reflected`, each all radiance seen through that layer; `direct` holds both layers' direct
/// radiance, `caustic` the irradiance at the first layer's points. `volume` and `caustic_volume`, both layers' radiance
/// that media scatter towards the camera, are there only where a medium scatters.
pub fn assemble(width: usize, height: usize, bands: &[FilmRows]) -> LayeredImage {
    let join = |pick: &dyn Fn(&FilmRows) -> Vec<[f32; 3]>| -> Vec<[f32; 3]> { bands.iter().flat_map(pick).collect() };
    let layer = |band: &FilmRows, index: usize| -> Vec<[f32; 3]> {
        let pixels = band.albedo.len();
        let range = index * pixels..(index + 1) * pixels;
        let mut sum: Vec<[f32; 3]> = band.direct[range.clone()]
            .iter()
            .zip(&band.caustic[range.clone()])
            .map(|(d, c)| add(rgb(d), rgb(c)))
            .collect();
        for part in [&band.volume, &band.caustic_volume] {
            let scattered = part.get(range.clone()).unwrap_or_default();
            sum.iter_mut().zip(scattered).for_each(|(sum, v)| *sum = add(*sum, rgb(v)));
        }
        sum
    };
    let refracted = join(&|band| layer(band, 0));
    let reflected = join(&|band| layer(band, 1));
    let total = refracted.iter().zip(&reflected).map(|(a, b)| add(*a, *b)).collect::<Vec<_>>();
    let both = |values: &[[f32; 4]]| -> Vec<[f32; 3]> {
        let (first, second) = values.split_at(values.len() / VISIBLE_LAYERS as usize);
        first.iter().zip(second).map(|(a, b)| add(rgb(a), rgb(b))).collect()
    };
    let mut rgb_layers = vec![
        (FINAL_LAYER, total),
        ("caustic", join(&|band| band.irradiance.iter().map(rgb).collect())),
        ("direct", join(&|band| both(&band.direct))),
        ("refracted", refracted),
        ("reflected", reflected),
        ("albedo", join(&|band| band.albedo.iter().map(rgb).collect())),
    ];
    if bands.iter().any(|band| !band.volume.is_empty()) {
        rgb_layers.push(("volume", join(&|band| both(&band.volume))));
        rgb_layers.push(("caustic_volume", join(&|band| both(&band.caustic_volume))));
    }
    let mut layers: Vec<Layer> = rgb_layers
        .into_iter()
        .map(|(name, pixels)| Layer::from_rgb(name, &RgbImage { width, height, pixels }))
        .collect();
    let all =
        |index: usize| -> Vec<f32> { bands.iter().flat_map(|b| b.normal.iter().map(move |n| n[index])).collect() };
    let channel = |name: &str, samples| Channel { name: name.to_string(), samples };
    layers.push(Layer {
        name: "normal".to_string(),
        width,
        height,
        channels: vec![channel("X", all(0)), channel("Y", all(1)), channel("Z", all(2))],
    });
    layers.push(Layer { name: "depth".to_string(), width, height, channels: vec![channel("Z", all(3))] });
    LayeredImage { layers, attributes: Default::default() }
}

fn rgb(value: &[f32; 4]) -> [f32; 3] {
    [value[0], value[1], value[2]]
}

fn add(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_is_the_error_of_the_mean_of_two_halves() {
        // Halves 1 + e and 1 - e: the mean is 1 and off by e as far as the halves can tell.
        let e = 0.1f32;
        let pixels: Vec<[f32; 4]> = (0..100)
            .map(|i| {
                let odd = if i % 2 == 0 { 1.0 + e } else { 1.0 - e };
                [1.0, 1.0, 1.0, odd / 2.0]
            })
            .collect();
        let noise = relative_noise(&pixels, &[0.5]).unwrap();
        assert!((noise - e).abs() < 1e-6, "{noise}");
    }
}
