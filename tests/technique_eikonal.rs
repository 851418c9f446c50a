//! The technique `eikonal`: waves in a grid on devices, against fast marching and closed forms in f64.

#[path = "technique_eikonal/closed.rs"]
mod closed;
mod common;
#[path = "technique_eikonal/light.rs"]
mod light;
#[path = "technique_eikonal/picture.rs"]
mod picture;
#[path = "technique_eikonal/solver.rs"]
mod solver;
#[path = "technique_eikonal/wave.rs"]
mod wave;

use std::path::Path;
use std::process::ExitCode;

use common::{Case, Request, assert_valid};
use glam::{DVec2, DVec3};
use nephroid::gpu::{Device, Recorder};
use nephroid::gpu_scene::GpuScene;
use nephroid::scene::shapes::{self, Vertex};
use nephroid::scene::{self, Emitter, Scene};
use nephroid::technique::eikonal::marching::Order;
use nephroid::technique::eikonal::{Grid, Kernels, Scheme, SolverOptions, Volume, VolumeOptions};

const WATER: f64 = 1.33;

fn main() -> ExitCode {
    let case = |name, run| Case { name, needs: &[], disable: "", run };
    let cases = vec![
        case("the_first_order_is_fast_marching", solver::first as fn(&Request)),
        case("the_second_order_is_fast_marching", solver::second),
        case("planes_are_near_fast_marching", solver::planes),
        case("marching_on_the_host_is_fast_marching", solver::on_the_host),
        case("equal_scenes_give_equal_waves", solver::equal_bits),
        case("what_is_given_is_the_closed_form", closed::given),
        case("planes_are_exact_to_the_edges", closed::planes),
        case("light_of_a_lamp_converges", closed::lamp),
        case("a_cap_focuses_where_it_should", closed::focus),
        case("flat_water_is_lit_evenly", light::flat),
        case("a_lamp_lights_flat_water", light::lamp),
        case("a_cap_gathers_light", light::cap),
        case("light_in_a_plane_is_what_came_in", light::conserved),
        case("waves_in_planes_keep_all_light", light::spread),
        case("the_laplacian_is_that_of_a_cap", light::laplacian),
        case("flat_water_shows_the_closed_form", picture::flat_water),
        case("the_printed_start_lights_flat_water", picture::printed_start),
        case("shadows_and_absorption_are_those_of_mnee", picture::shadows),
        case("the_pool_is_the_truth", picture::pool),
        case("tracing_tiers_agree", picture::tiers),
        case("a_file_gives_the_same_picture", picture::stored),
        case("a_file_of_another_scene_is_refused", picture::refused),
        case("a_wave_under_flat_water_is_even", wave::flat),
        case("a_wave_goes_a_cell_in_a_step", wave::speed),
        case("a_wave_through_a_cap_has_its_most_near_the_focus", wave::focus),
        case("a_signed_sum_has_no_most_below_the_surface", wave::signed),
        case("equal_scenes_give_equal_sums", wave::equal_bits),
    ];
    common::run(cases.leak())
}

/// Quads along each side of water that is not flat.
const QUADS: u32 = 96;

/// The pool of `flat_water.toml` under that light, its water at `height` over x and z, without `size / 2` of the middle. Shading
/// normals are the faces'.
fn water(emitter: Emitter, size: f64, quads: u32, height: impl Fn(DVec2) -> f64) -> Scene {
    let mut scene = scene::load(Path::new("scenes/flat_water.toml")).unwrap();
    let mesh = scene.instances.iter().find(|i| i.name == "water").unwrap().mesh;
    scene.meshes[mesh] = shapes::grid("water", quads, quads, |column, row| {
        let at = size * (DVec2::new(f64::from(column), f64::from(row)) / f64::from(quads) - 0.5);
        Vertex { position: DVec3::new(at.x, height(at), at.y), normal: DVec3::Y, uv: DVec2::ZERO }
    });
    scene.lights[0].emitter = emitter;
    scene
}

/// A solver's options.
fn solver(scheme: Scheme) -> SolverOptions {
    SolverOptions { scheme, ..SolverOptions::default() }
}

/// All that there are on devices, without the host's.
const SCHEMES: [Scheme; 3] = [Scheme::Planes, Scheme::Sweeps(Order::First), Scheme::Sweeps(Order::Second)];

/// A cube of cells, 4 m wide, whose top is 0.5 m above the water.
fn cube(cells: u32) -> Grid {
    Grid { lower: DVec3::new(-2.0, -3.5, -2.0), cell: 4.0 / f64::from(cells), cells: [cells; 3] }
}

/// A volume on a device.
struct Rig {
    device: Device,
    scene: GpuScene,
    kernels: Kernels,
    volume: Volume,
}

impl Rig {
    fn new(request: &Request, scene: &Scene, options: &VolumeOptions) -> Rig {
        let device = request.open();
        let volume = Volume::new(&device, scene, 0, options).unwrap().unwrap();
        Rig { scene: GpuScene::new(&device, scene).unwrap(), kernels: Kernels::new(&device).unwrap(), device, volume }
    }

    fn run(&self, record: impl FnOnce(&mut Recorder)) {
        let mut recorder = Recorder::new(&self.device).unwrap();
        record(&mut recorder);
        recorder.submit().unwrap();
        assert_valid(&self.device);
    }

    /// What is given next to the surface, in order of cells; infinite elsewhere, NaN above.
    fn given(&self) -> Vec<f64> {
        self.run(|recorder| self.volume.record_given(recorder, &self.scene.bindings, &self.kernels).unwrap());
        let (values, given) = self.volume.read().unwrap();
        let start = |(value, given): (f64, bool)| if value.is_nan() || given { value } else { f64::INFINITY };
        values.into_iter().zip(given).map(start).collect()
    }

    /// The wave.
    fn wave(&self) -> Vec<f64> {
        self.run(|recorder| self.volume.record_given(recorder, &self.scene.bindings, &self.kernels).unwrap());
        self.run(|recorder| self.volume.record_wave(recorder, &self.kernels).unwrap());
        self.volume.read().unwrap().0
    }
}

/// Largest and mean difference where both have a value, in cells times index; panics where one has none.
fn difference(grid: &Grid, index: f64, found: &[f64], exact: impl Fn(usize) -> f64) -> (f64, f64) {
    let mut wrong = Vec::new();
    for (at, value) in found.iter().enumerate().filter(|(_, value)| !value.is_nan()) {
        let off = (value - exact(at)).abs() / grid.cell / index;
        assert!(off.is_finite(), "cell {:?}: {value} for {}", grid.place(at), exact(at));
        wrong.push(off);
    }
    assert!(!wrong.is_empty());
    (wrong.iter().copied().fold(0.0, f64::max), wrong.iter().sum::<f64>() / wrong.len() as f64)
}
