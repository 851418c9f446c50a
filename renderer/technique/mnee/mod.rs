//! Manifold next-event estimation along the coplanarity curve (Granizo-Hidalgo and Holzschuch 2024): every path from a
//! visible point through one refracting surface to a light, found by walking a curve on the surface.

mod counters;
mod footprints;
mod newton;
mod rest;
mod surface;

use super::{Context, CounterEntry, LedgerEntry, Setting, SettingKind, Settings, Technique};
use crate::frame::Frame;
use crate::gpu::{Bindings, Buffer, GpuError, GpuStruct, Kernel, Layout, Recorder};
use footprints::Footprints;
use newton::Newton;
use rest::Rest;
use surface::SpecularSurface;

pub const SETTINGS: &[Setting] = &[
    Setting {
        key: "solutions",
        kind: SettingKind::Choice(&["all", "one"]),
        default: "all",
        unit: "",
        help: "Every path from a point to a light; or the first along the walk, as the paper has it; for solver=walk",
    },
    Setting {
        key: "search",
        kind: SettingKind::Choice(&["footprints", "walk", "both"]),
        default: "footprints",
        unit: "",
        help: "Where all paths are looked for: on triangles whose light may land at the point, with a walk where that \
               finds nothing; along the curve from the start alone; or both everywhere; for solver=walk",
    },
    Setting {
        key: "solver",
        kind: SettingKind::Choice(&["walk", "newton", "sms-biased", "sms-unbiased"]),
        default: "walk",
        unit: "",
        help: "What finds paths: the walk; or, to compare it with, Newton's method from the walk's start, which finds one \
               path, from `trials` random starts, which misses some, or from one, weighted by how many more it takes to \
               find the path again, which is right on average",
    },
    Setting {
        key: "trials",
        kind: SettingKind::Integer { min: 0, max: 100_000 },
        default: "0",
        unit: "starts",
        help: "Random starts of solver=sms-biased a point and light; the most that solver=sms-unbiased tries to find a \
               path again, where a cap that is met darkens; 0 is 20 and 1000",
    },
    Setting {
        key: "smooth",
        kind: SettingKind::Number { min: 0.0, max: 100.0 },
        default: "1",
        unit: "pixels",
        help: "Where light folds, irradiance is infinite along a line: within this distance of it, over the root of the \
               number of samples so far, the mean is taken; 0 leaves rare samples that outshine the picture",
    },
    Setting {
        key: "rest",
        kind: SettingKind::Choice(&["off", "photons"]),
        default: "off",
        unit: "",
        help: "Light that is reflected, or refracted more than once: left out, or by photons as the reference has it; not \
               with --adaptive",
    },
    Setting {
        key: "rest_photons",
        kind: SettingKind::Integer { min: 1, max: 4_000_000 },
        default: "500000",
        unit: "photons",
        help: "Photons that leave the lights at once, for rest=photons",
    },
];

/// Which arcs the solver gets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Search {
    /// Those of triangles whose footprint holds the point, and of walks where these have no certain root.
    Footprints,
    /// Those of walks.
    Walk,
    /// All of them.
    Both,
}

/// Pixel layers that are worked on together: bounds the memory for walks and arcs.
const CHUNK: u32 = 1 << 16;
/// Walks a chunk has room for: two a start, and some points have several starts.
const WALK_CAPACITY: u32 = 3 * CHUNK;
/// Triangles that a walk may cross in each round. Few at first, since most walks are short; no walk goes beyond the sum.
const ROUND_STEPS: [u32; 9] = [12, 12, 24, 48, 96, 192, 384, 768, 1536];
/// Arcs a pixel layer keeps, as in `walks.glsl`.
const MAX_BRACKETS: u64 = 32;

/// What `start` finds: nothing; arcs that may do; arcs that walks are to add to.
const SEEDED_NOT: u32 = 0;
const SEEDED_ENOUGH: u32 = 1;
const SEEDED_MORE: u32 = 2;

crate::gpu_struct! {
    /// One direction of a walk; see `kernels/technique/mnee/walks.glsl`.
    pub struct Walk {
        pub at: [f32; 3],
        pub objective: f32,
        pub normal: [f32; 3],
        pub tilt: f32,
        pub place: f32,
        pub triangle: u32,
        pub item: u32,
        pub start: u32,
        pub steps: u32,
        pub padding0: u32,
        pub start_ends: [f32; 2],
    }
}

crate::gpu_struct! {
    /// A piece of the curve on which a path may be.
    pub struct Bracket {
        pub from: [f32; 2],
        pub to: [f32; 2],
        pub triangle: u32,
        pub steps: u32,
    }
}

crate::gpu_struct! {
    /// Arguments of an indirect dispatch over a round's walks.
    pub struct Round {
        pub groups_x: u32,
        pub groups_y: u32,
        pub groups_z: u32,
        pub walks: u32,
    }
}

crate::gpu_struct! {
    pub struct StartPush {
        pub first_slot: u32,
        pub items: u32,
        pub light: u32,
        pub capacity: u32,
        pub seeded: u32,
    }
}

crate::gpu_struct! {
    pub struct SeedPush {
        pub first_slot: u32,
        pub items: u32,
        pub light: u32,
    }
}

crate::gpu_struct! {
    pub struct WalkPush {
        pub first_slot: u32,
        pub light: u32,
        pub capacity: u32,
        pub round: u32,
        pub max_steps: u32,
        pub last: u32,
        pub one: u32,
    }
}

crate::gpu_struct! {
    pub struct SolvePush {
        pub first_slot: u32,
        pub items: u32,
        pub light: u32,
        pub one: u32,
        pub width: f32,
    }
}

const OWN_LAYOUTS: &[Layout] = &[
    Walk::LAYOUT,
    Bracket::LAYOUT,
    Round::LAYOUT,
    StartPush::LAYOUT,
    SeedPush::LAYOUT,
    WalkPush::LAYOUT,
    SolvePush::LAYOUT,
];

/// What the technique shares with its kernels.
pub fn layouts() -> impl Iterator<Item = Layout> {
    let parts = [OWN_LAYOUTS, surface::LAYOUTS, footprints::LAYOUTS, newton::LAYOUTS, rest::LAYOUTS];
    parts.into_iter().flatten().copied()
}

struct Kernels {
    seed: Kernel,
    start: Kernel,
    walk: Kernel,
    solve: Kernel,
}

/// The technique's state for one band.
pub struct Mnee {
    kernels: Kernels,
    surface: SpecularSurface,
    /// `None` where only walks are made.
    footprints: Option<Footprints>,
    search: Search,
    /// Takes the walk's place.
    newton: Option<Newton>,
    rest: Option<Rest>,
    /// Pixels.
    smooth: f32,
    /// What of the settings has no effect, in sentences.
    useless: Vec<String>,
    bindings: Bindings,
    rounds: Buffer,
    counters: Buffer,
    lights: u32,
    one: bool,
    chunk: u32,
    surface_is_current: bool,
}

impl Mnee {
    pub fn new(settings: &Settings, context: &Context<'_>) -> Result<Self, GpuError> {
        let device = context.device;
        let surface = SpecularSurface::new(device, context.scene)?;
        let one = settings.choice("solutions") == "one";
        let newton = Newton::new(settings, context)?;
        let search = match settings.choice("search") {
            _ if one || newton.is_some() => Search::Walk,
            "walk" => Search::Walk,
            "both" => Search::Both,
            _ => Search::Footprints,
        };
        let footprints = if search == Search::Walk { None } else { Some(Footprints::new(context, &surface)?) };
        let chunk = CHUNK.min(context.frame.slots());
        let buffer = |name: &str, items: u64, bytes: usize| Buffer::new(device, name, items * bytes as u64);
        let rounds = buffer("mnee rounds", ROUND_STEPS.len() as u64, size_of::<Round>())?;
        let counters = Buffer::zeroed(device, "mnee counters", 4 * counters::WORDS as u64)?;
        let walks = u64::from(WALK_CAPACITY);
        let bindings = Bindings::new()
            .and(&surface.bindings)
            .buffer("Walks", &buffer("mnee walks", walks, size_of::<Walk>())?)
            .buffer("Rounds", &rounds)
            .buffer("WalkLists", &buffer("mnee walk lists", 2 * walks, 4)?)
            .buffer("Brackets", &buffer("mnee arcs", u64::from(chunk) * MAX_BRACKETS, size_of::<Bracket>())?)
            .buffer("BracketCounts", &buffer("mnee arc counts", chunk.into(), 4)?)
            .buffer("MneeCounters", &counters);
        let variant = context.tracer.variant();
        Ok(Mnee {
            kernels: Kernels {
                seed: Kernel::new(device, "mnee/seed", context.tracer.plain())?,
                start: Kernel::new(device, "mnee/start", variant)?,
                walk: Kernel::new(device, "mnee/walk", context.tracer.plain())?,
                solve: Kernel::new(device, "mnee/solve", variant)?,
            },
            surface,
            footprints,
            search,
            newton,
            rest: Rest::new(settings, context)?,
            smooth: settings.number("smooth"),
            useless: useless(settings),
            bindings,
            rounds,
            counters,
            lights: context.scene.lights.len() as u32,
            one,
            chunk,
            surface_is_current: false,
        })
    }

    /// Whether there is anything that light could be refracted by.
    fn searches(&self) -> bool {
        self.surface.triangles > 0 && self.lights > 0
    }

    /// The caustic irradiance of sample `index` at all visible points.
    fn record_search(&mut self, frame: &Frame, recorder: &mut Recorder, index: u32) -> Result<(), GpuError> {
        if !self.surface_is_current {
            self.surface.record(recorder, &frame.bindings)?;
            if let Some(footprints) = &self.footprints {
                footprints.record(recorder, (&frame.bindings, &self.bindings), &self.surface)?;
            }
            self.surface_is_current = true;
        }
        let width = self.smooth / ((index + 1) as f32).sqrt();
        for first_slot in (0..frame.slots()).step_by(self.chunk as usize) {
            let items = self.chunk.min(frame.slots() - first_slot);
            for light in 0..self.lights {
                match &self.newton {
                    Some(newton) => {
                        let items = (first_slot, items);
                        newton.record(recorder, (frame, &self.bindings), items, light, (index, width))?;
                    }
                    None => self.record_chunk(frame, recorder, (first_slot, items), light, width)?,
                }
            }
        }
        Ok(())
    }

    /// All paths of `items` pixel layers from `first_slot` on to one light.
    fn record_chunk(
        &self,
        frame: &Frame,
        recorder: &mut Recorder,
        (first_slot, items): (u32, u32),
        light: u32,
        width: f32,
    ) -> Result<(), GpuError> {
        let bindings = [&frame.bindings, &self.bindings];
        let kernels = &self.kernels;
        let one = u32::from(self.one);
        recorder.pass("mnee/clear")?.fill(&self.rounds, 0);
        if let Some(footprints) = &self.footprints {
            let seed = SeedPush { first_slot, items, light };
            let bindings = [&frame.bindings, &self.bindings, footprints.bindings(light)];
            recorder.pass("mnee/seed")?.dispatch(&kernels.seed, &bindings, &seed, items)?;
        }
        let seeded = match self.search {
            Search::Walk => SEEDED_NOT,
            Search::Footprints => SEEDED_ENOUGH,
            Search::Both => SEEDED_MORE,
        };
        let start = StartPush { first_slot, items, light, capacity: WALK_CAPACITY, seeded };
        recorder.pass("mnee/start")?.dispatch(&kernels.start, &bindings, &start, items)?;
        for (round, max_steps) in (0u32..).zip(ROUND_STEPS) {
            let last = u32::from(round as usize + 1 == ROUND_STEPS.len());
            let walk = WalkPush { first_slot, light, capacity: WALK_CAPACITY, round, max_steps, last, one };
            let offset = u64::from(round) * size_of::<Round>() as u64;
            recorder.pass("mnee/walk")?.dispatch_indirect(&kernels.walk, &bindings, &walk, &self.rounds, offset)?;
        }
        let solve = SolvePush { first_slot, items, light, one, width };
        recorder.pass("mnee/solve")?.dispatch(&kernels.solve, &bindings, &solve, items)?;
        Ok(())
    }
}

/// What `settings` say that has no effect.
fn useless(settings: &Settings) -> Vec<String> {
    let solver = settings.choice("solver");
    let one = settings.choice("solutions") == "one";
    let search = settings.choice("search");
    let mut said = Vec::new();
    if one && solver != "walk" {
        said.push(format!("mnee.solutions=one is for mnee.solver=walk; {solver} has no use for it"));
    }
    if search != "footprints" && solver != "walk" {
        said.push(format!("mnee.search={search} is for mnee.solver=walk; {solver} has no use for it"));
    }
    if search == "both" && one {
        said.push(
            "mnee.search=both is for mnee.solutions=all; one path is looked for along the walk alone".to_string(),
        );
    }
    if settings.integer("trials") > 0 && !solver.starts_with("sms") {
        said.push(format!("mnee.trials is for the solvers sms-biased and sms-unbiased; {solver} has no use for it"));
    }
    said
}

/// Counters of what there was no room for.
const DROPPED: [&str; 3] = ["walks_dropped", "arcs_dropped", "roots_dropped"];

impl Technique for Mnee {
    fn restart(&mut self, context: &Context<'_>) -> Result<(), GpuError> {
        self.surface.update(context.scene)?;
        if let Some(footprints) = &mut self.footprints {
            footprints.update(context.scene, &self.surface)?;
        }
        if let Some(newton) = &mut self.newton {
            newton.restart(context)?;
        }
        if let Some(rest) = &mut self.rest {
            rest.restart(context)?;
        }
        self.surface_is_current = false;
        let mut recorder = Recorder::new(context.device)?;
        recorder.pass("mnee/clear")?.fill(&self.counters, 0);
        recorder.submit()?;
        Ok(())
    }

    fn record(&mut self, frame: &Frame, recorder: &mut Recorder, index: u32) -> Result<(), GpuError> {
        if let Some(rest) = &self.rest {
            rest.take_out(frame, recorder)?;
        }
        if self.searches() {
            self.record_search(frame, recorder, index)?;
        }
        frame.record_caustic(recorder, index)?;
        if let Some(rest) = &mut self.rest {
            rest.put_in(frame, recorder, index)?;
        }
        Ok(())
    }

    fn ledger(&self, _samples: u32) -> Result<Vec<LedgerEntry>, GpuError> {
        Ok(Vec::new())
    }

    fn counters(&self) -> Result<Vec<CounterEntry>, GpuError> {
        counters::read(&self.counters)
    }

    fn second_half(&self, samples: u32) -> Option<u32> {
        self.searches().then_some(samples / 2)
    }

    fn warnings(&self) -> Result<Vec<String>, GpuError> {
        if self.surface.triangles == 0 && self.rest.is_none() {
            return Ok(vec!["the scene has no refracting surface, so mnee finds no caustic light".to_string()]);
        }
        let mut warnings = self.useless.clone();
        for entry in self.counters()? {
            if entry.value > 0.0 && DROPPED.contains(&entry.name) {
                let what = entry.name.trim_end_matches("_dropped");
                warnings.push(format!("mnee had no room for {} {what}; some light may be missing", entry.value));
            }
        }
        Ok(warnings)
    }
}
