//! Water that moves: waves that travel, or a simulated surface with the drops that fall on it.

use glam::DVec2;

use crate::random::{combine, mix_bits};
use crate::scene::MeshId;
use crate::scene::height_field::{HeightField, Wave};

/// Standard gravity, m/s2.
pub const GRAVITY: f64 = 9.806_65;

/// A simulated wave crosses at most this part of a cell in a step. Leapfrog on square cells is stable up to 0.707.
pub const MOST_CELLS_PER_STEP: f64 = 0.5;

/// Damping times the length of a step, at most. From 2 on an increment would change its sign from step to step.
pub const MOST_DAMPING_PER_STEP: f64 = 0.5;

/// Steps of a simulation between two frames, at most.
pub const MOST_STEPS_PER_FRAME: u32 = 1000;

/// Vertices times steps and drops from time 0 to a frame, at most: some days without a GPU, at 31 ns each on llvmpipe.
const MOST_WORK: f64 = 1e13;

/// The last frame that simulated water can be taken to, however small it is.
const LAST_FRAME: u32 = 1_000_000;

/// A height field whose mesh moves.
#[derive(Debug, Clone, PartialEq)]
pub struct Water {
    pub mesh: MeshId,
    /// As it is at time 0; for simulated water, as it is let go at time 0.
    pub field: HeightField,
    pub motion: WaterMotion,
}

/// What moves a height field.
#[derive(Debug, Clone, PartialEq)]
pub enum WaterMotion {
    /// Each of the field's waves travels along its wave vector at the phase speed of gravity waves over `depth` metres of
    /// still water, deep water where `None`. Bumps and the relief stay.
    Waves { depth: Option<f64> },
    /// The damped wave equation on the field's vertices.
    Simulated(Simulation),
}

/// h_tt + `damping` h_t = `speed`^2 (h_xx + h_zz) for the height h above the field's `base`, at rest at time 0, with
/// walls that reflect (no slope across the rectangle's edges).
#[derive(Debug, Clone, PartialEq)]
pub struct Simulation {
    /// Of waves, m/s, positive.
    pub speed: f64,
    /// 1/s, not negative.
    pub damping: f64,
    /// In the order of their times.
    pub drops: Vec<Drop>,
    pub rain: Option<Rain>,
}

/// A Gaussian that is added to the surface at one time: `height` exp(-r^2 / (2 `radius`^2)).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drop {
    /// Seconds.
    pub time: f64,
    /// x and z, metres.
    pub centre: DVec2,
    /// Metres; negative for a hollow.
    pub height: f64,
    /// One standard deviation, metres, positive.
    pub radius: f64,
}

/// Drops without end: one at a random moment of each 1 / `rate` seconds from time 0 on, at a random place of the
/// rectangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rain {
    /// Drops a second over the whole rectangle, positive.
    pub rate: f64,
    /// Metres, as [`Drop::height`].
    pub height: f64,
    /// Metres, as [`Drop::radius`].
    pub radius: f64,
    pub seed: u32,
}

impl Simulation {
    /// What falls on `field` from time `from`, inclusive, to time `to`, exclusive, in the order of time; seconds. Intervals
    /// that join hold the same drops as their union, to the last bit.
    pub fn drops_between(&self, field: &HeightField, from: f64, to: f64) -> Vec<Drop> {
        let before = |time: f64| self.drops.partition_point(|drop| drop.time < time);
        let mut drops = self.drops[before(from)..before(to).max(before(from))].to_vec();
        if let Some(rain) = &self.rain {
            drops.extend(rain.between(field, from, to));
            drops.sort_by(|a, b| a.time.total_cmp(&b.time));
        }
        drops
    }

    /// The least number of equal steps between frames in which no wave crosses more than [`MOST_CELLS_PER_STEP`] of a cell
    /// of `field`, and damping is at most [`MOST_DAMPING_PER_STEP`]. A scene file's is at most [`MOST_STEPS_PER_FRAME`].
    pub fn steps_per_frame(&self, field: &HeightField, fps: f64) -> u32 {
        let cells_per_frame = self.speed / (fps * field.least_spacing());
        let damping_per_frame = self.damping / fps;
        let steps = (cells_per_frame / MOST_CELLS_PER_STEP).max(damping_per_frame / MOST_DAMPING_PER_STEP);
        steps.ceil().max(1.0) as u32
    }

    /// The last frame that may be gone to: all before it have to be simulated.
    pub fn last_frame(&self, field: &HeightField, fps: f64) -> u32 {
        let vertices = field.quads.map(|quads| f64::from(quads) + 1.0).iter().product::<f64>();
        let drops = self.rain.as_ref().map_or(0.0, |rain| rain.rate / fps);
        let work_per_frame = vertices * (f64::from(self.steps_per_frame(field, fps)) + drops);
        (MOST_WORK / work_per_frame).min(LAST_FRAME.into()) as u32
    }

    /// Metres per second, at which waves take [`MOST_STEPS_PER_FRAME`] between frames.
    pub fn fastest(field: &HeightField, fps: f64) -> f64 {
        f64::from(MOST_STEPS_PER_FRAME) * MOST_CELLS_PER_STEP * fps * field.least_spacing()
    }

    /// The damping, 1/s, that takes [`MOST_STEPS_PER_FRAME`] between frames.
    pub fn most_damping(fps: f64) -> f64 {
        f64::from(MOST_STEPS_PER_FRAME) * MOST_DAMPING_PER_STEP * fps
    }
}

impl Rain {
    fn between(&self, field: &HeightField, from: f64, to: f64) -> impl Iterator<Item = Drop> {
        // A drop more on either side: the products below are rounded.
        let first = (from * self.rate).floor() - 1.0;
        let last = (to * self.rate).ceil() + 1.0;
        (first.max(0.0) as u64..last.max(0.0) as u64)
            .map(|index| self.drop(field, index))
            .filter(move |drop| (from..to).contains(&drop.time))
    }

    fn drop(&self, field: &HeightField, index: u64) -> Drop {
        let seed = combine(combine(mix_bits(self.seed), index as u32), (index >> 32) as u32);
        let random = |which: u32| f64::from(combine(seed, which)) / 2f64.powi(32);
        let across = |[first, last]: [f64; 2], random: f64| first + (last - first) * random;
        Drop {
            time: (index as f64 + random(0)) / self.rate,
            centre: DVec2::new(across(field.x, random(1)), across(field.z, random(2))),
            height: self.height,
            radius: self.radius,
        }
    }
}

/// Angular frequency of a gravity wave over `depth` metres of water, rad/s: omega^2 = g k tanh(k depth).
pub fn angular_frequency(wave: &Wave, depth: Option<f64>) -> f64 {
    let k = wave.wave_vector().length();
    (GRAVITY * k * depth.map_or(1.0, |depth| (k * depth).tanh())).sqrt()
}

impl HeightField {
    /// What no height, at any time, differs from `base` by more than: all there is in one place, metres.
    pub fn most_above_base(&self) -> f64 {
        let waves: f64 = self.waves.iter().map(|wave| wave.amplitude.abs()).sum();
        let bumps: f64 = self.bumps.iter().map(|bump| bump.height.abs()).sum();
        // Splines between pixels overshoot by less than half of what they join.
        let relief = self.relief.as_ref().map_or(0.0, |relief| 1.5 * relief.height.abs());
        waves + bumps + relief
    }

    /// The field with its waves where they are at `time`, seconds: what the device's vertices are checked against.
    pub fn at(&self, depth: Option<f64>, time: f64) -> HeightField {
        let mut field = self.clone();
        for wave in &mut field.waves {
            wave.phase -= angular_frequency(wave, depth) * time;
        }
        field
    }

    /// The shorter side of a quad, metres.
    fn least_spacing(&self) -> f64 {
        self.spacing().min_element()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn field(quads: [u32; 2]) -> HeightField {
        HeightField {
            x: [-1.0, 3.0],
            z: [2.0, 4.0],
            quads,
            base: 0.0,
            waves: Vec::new(),
            bumps: Vec::new(),
            relief: None,
        }
    }

    fn rainy() -> Simulation {
        let drops = [0.7, 3.0].map(|time| Drop { time, centre: DVec2::ONE, height: 0.1, radius: 0.2 }).to_vec();
        let rain = Some(Rain { rate: 7.3, height: 0.01, radius: 0.05, seed: 5 });
        Simulation { speed: 1.5, damping: 0.2, drops, rain }
    }

    #[test]
    fn joined_intervals_hold_the_drops_of_their_union() {
        let (simulation, field) = (rainy(), field([8, 8]));
        let whole = simulation.drops_between(&field, 0.0, 10.0);
        for pieces in [3, 24, 240, 1001] {
            let edge = |k: u32| f64::from(k) * 10.0 / f64::from(pieces);
            let parts: Vec<Drop> =
                (0..pieces).flat_map(|k| simulation.drops_between(&field, edge(k), edge(k + 1))).collect();
            assert_eq!(parts, whole, "{pieces}");
        }
        assert!(whole.is_sorted_by(|a, b| a.time <= b.time));
        assert_eq!(whole.len(), 2 + 73);
    }

    #[test]
    fn an_interval_has_its_first_moment_and_not_its_last() {
        let simulation = Simulation { rain: None, ..rainy() };
        let times = |from, to| simulation.drops_between(&field([1, 1]), from, to).len();
        assert_eq!((times(0.7, 3.0), times(0.0, 0.7), times(3.0, 3.1)), (1, 0, 1));
    }

    #[test]
    fn rain_falls_all_over_the_rectangle_from_time_0_and_by_its_seed() {
        let field = field([8, 8]);
        let rain =
            |seed| Simulation { drops: Vec::new(), rain: Some(Rain { seed, ..rainy().rain.unwrap() }), ..rainy() };
        let drops = rain(5).drops_between(&field, -50.0, 100.0);
        assert_eq!(drops, rain(5).drops_between(&field, 0.0, 100.0));
        assert_ne!(drops, rain(6).drops_between(&field, 0.0, 100.0));
        // Of 730 drops in 16 cells, each has some 46 with a standard deviation of 6.5.
        let mut cells = [0; 16];
        for drop in &drops {
            let place = (drop.centre - DVec2::new(-1.0, 2.0)) / DVec2::new(4.0, 2.0) * 4.0;
            assert!(place.cmpge(DVec2::ZERO).all() && place.cmplt(DVec2::splat(4.0)).all(), "{}", drop.centre);
            cells[place.x as usize + 4 * place.y as usize] += 1;
        }
        assert!(cells.iter().all(|count| (20..72).contains(count)), "{cells:?}");
    }

    #[test]
    fn steps_are_the_fewest_that_keep_waves_within_half_a_cell() {
        for (quads, speed, fps) in
            [([40, 40], 1.5, 24.0), ([40, 7], 3.0, 30.0), ([1, 1], 0.01, 24.0), ([400, 400], 9.0, 1.0)]
        {
            let (field, simulation) = (field(quads), Simulation { speed, ..rainy() });
            let steps = simulation.steps_per_frame(&field, fps);
            let cell = (4.0 / f64::from(quads[0])).min(2.0 / f64::from(quads[1]));
            let crossed = |steps: u32| speed / (fps * f64::from(steps)) / cell;
            assert!(crossed(steps) <= 0.5, "{quads:?} {steps}");
            assert!(steps == 1 || crossed(steps - 1) > 0.5, "{quads:?} {steps}");
            let fastest = Simulation { speed: Simulation::fastest(&field, fps), ..rainy() };
            assert_eq!(fastest.steps_per_frame(&field, fps), MOST_STEPS_PER_FRAME);
        }
    }

    #[test]
    fn the_last_frame_goes_by_the_work_before_it() {
        let last = |quads, rain| Simulation { rain, ..rainy() }.last_frame(&field(quads), 1000.0);
        assert_eq!(last([8, 8], rainy().rain), LAST_FRAME);
        // 2049 x 2049 vertices, four steps, and a drop every two frames.
        let drops = Rain { rate: 500.0, ..rainy().rain.unwrap() };
        assert_eq!([last([2048, 2048], None), last([2048, 2048], Some(drops))], [595_464, 529_302]);
    }

    #[test]
    fn strong_damping_takes_more_steps() {
        let (field, fps) = (field([4, 2]), 24.0);
        let steps = |damping| Simulation { speed: 0.1, damping, ..rainy() }.steps_per_frame(&field, fps);
        assert_eq!([0.0, 12.0, 12.1, 1e3].map(steps), [1, 1, 2, 84]);
        assert_eq!(steps(Simulation::most_damping(fps)), MOST_STEPS_PER_FRAME);
    }

    #[test]
    fn a_metre_of_deep_water_has_a_period_of_0_8_seconds() {
        let wave = Wave { wavelength: 1.0, amplitude: 0.1, direction: 0.3, phase: 0.0 };
        let period = |depth| std::f64::consts::TAU / angular_frequency(&wave, depth);
        // sqrt(2 pi / g) = 0.80044 s.
        assert!((period(None) - 0.800_44).abs() < 1e-5, "{}", period(None));
        assert!((period(Some(5.0)) - period(None)).abs() < 1e-9);
    }

    #[test]
    fn waves_over_shallow_water_travel_at_the_root_of_g_times_depth() {
        // tanh(x) / x is 1 - x^2 / 3.
        const DEPTH: f64 = 0.01;
        for wavelength in [5.0, 50.0] {
            let wave = Wave { wavelength, amplitude: 0.1, direction: 2.0, phase: 0.0 };
            let speed = angular_frequency(&wave, Some(DEPTH)) / wave.wave_vector().length();
            let limit = (GRAVITY * DEPTH).sqrt();
            assert!((speed / limit - 1.0).abs() < 1e-4, "{speed} {limit}");
        }
    }

    #[test]
    fn a_wave_travels_along_its_wave_vector() {
        let wave = Wave { wavelength: 1.3, amplitude: 0.1, direction: 0.8, phase: 0.4 };
        let still = HeightField { waves: vec![wave], ..field([8, 8]) };
        let speed = angular_frequency(&wave, Some(0.5)) / wave.wave_vector().length();
        let moved = still.at(Some(0.5), 0.9);
        let way = 0.9 * speed * DVec2::from_angle(0.8);
        for (x, z) in [(0.0, 2.5), (1.1, 3.7)] {
            assert!((moved.height(x + way.x, z + way.y) - still.height(x, z)).abs() < 1e-12);
        }
        assert_eq!(still.at(Some(0.5), 0.0), still);
    }
}
