//! Pictures by the technique against the closed form, `mnee` and the truth of the pool.

use std::path::Path;

use nephroid::render::RenderError;
use nephroid::scene::{self, Scene};
use nephroid::technique::eikonal::{self, file};
use nephroid::technique::{Settings, TechniqueKind};

use super::Request;
use super::common::measure::difference;
use super::common::pool::{flat_water_irradiance, floor_point};
use super::common::truth::Truth;
use super::common::{assert_valid, layer};
use nephroid::gpu_scene::GpuScene;

const SIZE: (u32, u32) = (24, 18);

/// Of flat water's light, the energy and the relative RMSE.
const FLAT: (f64, f64) = (0.002, 0.005);

fn flat() -> Scene {
    scene::load(Path::new("scenes/flat_water.toml")).unwrap()
}

fn caustic(request: &Request, scene: Scene, technique: TechniqueKind, set: &[&str]) -> Vec<[f32; 3]> {
    sampled(request, scene, technique, set, 1)
}

fn sampled(request: &Request, scene: Scene, technique: TechniqueKind, set: &[&str], samples: u32) -> Vec<[f32; 3]> {
    let picture = request.render(scene, |settings| {
        settings.technique = technique;
        settings.size = Some(SIZE);
        settings.samples = Some(samples);
        settings.set = set.iter().map(|item| item.to_string()).collect();
    });
    layer(&picture.image, "caustic")
}

pub fn flat_water(request: &Request) {
    // One sample lies elsewhere in its pixel, a per cent of the light away.
    let found = sampled(request, flat(), TechniqueKind::Eikonal, &["eikonal.resolution=48"], 16);
    let (mut sum, mut expected_sum, mut squares, mut count) = (0.0, 0.0, 0.0, 0.0);
    for (index, pixel) in (0u32..).zip(&found) {
        let (column, row) = (f64::from(index % SIZE.0), f64::from(index / SIZE.0));
        let Some((x, z)) = floor_point(column, row, SIZE.0.into(), SIZE.1.into()) else { continue };
        let expected = flat_water_irradiance(x, z);
        sum += f64::from(pixel[1]);
        expected_sum += expected;
        squares += (f64::from(pixel[1]) / expected - 1.0).powi(2);
        count += 1.0;
    }
    let (energy, rms) = (sum / expected_sum, f64::sqrt(squares / count));
    println!("energy {energy:.5}, off by {rms:.5}");
    assert!((energy - 1.0).abs() < FLAT.0 && rms < FLAT.1, "{energy} and {rms}");
}

/// Of the light, what the noise of snapped points may take or add, in the mean: a cell's value is off by up to half a cell.
const SNAPPED: f64 = 0.1;

/// Two triangles, far larger than cells, and surface cells whose middles may be in the air.
pub fn printed_start(request: &Request) {
    for cells in [47, 48] {
        let light = |start: &str| {
            let set = [format!("eikonal.resolution={cells}"), format!("eikonal.start={start}")];
            let set = [set[0].as_str(), &set[1], "eikonal.solver=marching"];
            caustic(request, flat(), TechniqueKind::Eikonal, &set).iter().map(|p| f64::from(p[1])).sum::<f64>()
        };
        let ratio = light("printed") / light("light");
        println!("{cells} cells: {ratio:.4} of the light");
        assert!((ratio - 1.0).abs() < SNAPPED, "{cells} cells: {ratio}");
    }
}

/// Boards in the water and above it, in water that takes light.
const BOARDS: &str = r#"
[[object]]
name = "board in the water"
shape = "plane"
centre = [0.5, -1, 0.3]
size = [1.5, 1.5]
material = "floor"
[[object]]
name = "board above"
shape = "plane"
centre = [-0.5, 1, -0.6]
size = [1, 1]
material = "floor"
"#;

/// Of the light in a picture, what may be off: pixels at the shadows' edges that fall to either side.
const SHADOWS: f64 = 0.02;

pub fn shadows(request: &Request) {
    let path = Path::new("scenes/flat_water.toml");
    let text = std::fs::read_to_string(path).unwrap() + BOARDS;
    let mut scene = scene::parse(&text, path).unwrap();
    scene.media.iter_mut().find(|m| m.name == "water").unwrap().absorption = glam::Vec3::new(0.4, 0.1, 0.05);
    let exact = caustic(request, scene.clone(), TechniqueKind::Mnee, &[]);
    let found = caustic(request, scene.clone(), TechniqueKind::Eikonal, &["eikonal.resolution=48"]);
    let off = difference(&found, &exact);
    println!("{off:.4}");
    assert!(off < SHADOWS, "{off}");
    // And there are some.
    let without = caustic(request, scene, TechniqueKind::Eikonal, &["eikonal.resolution=48", "eikonal.shadows=off"]);
    let lost = difference(&without, &exact);
    assert!(lost > 5.0 * SHADOWS, "{lost}");
}

/// Of the pool's light on its floor: energy, and relative RMSE in a volume whose cells are as wide as caustics' lines; 0.117 on
/// llvmpipe.
const POOL: (f64, f64) = (0.01, 0.15);

pub fn pool(request: &Request) {
    let truth = Truth::of_pool("under", 3);
    let picture = request.render(scene::load(Path::new("scenes/pool.toml")).unwrap(), |settings| {
        settings.technique = TechniqueKind::Eikonal;
        settings.size = Some(truth.size);
        settings.samples = Some(4);
    });
    let (energy, rms) = truth.against(&layer(&picture.image, "refracted"));
    println!("energy {energy:.4}, relative RMSE {rms:.3}");
    assert!((energy - 1.0).abs() < POOL.0 && rms < POOL.1, "{energy} and {rms}");
}

/// Of the light, what rays of another tracer may change at edges.
const TIERS: f64 = 1e-3;

pub fn tiers(request: &Request) {
    let set = ["eikonal.resolution=32"];
    let tree = caustic(request, flat(), TechniqueKind::Eikonal, &set);
    for disable in ["ray-query", "ray-query,graphics"] {
        let picture = request.render(flat(), |settings| {
            settings.device = request.without(disable);
            settings.trace = "auto".parse().unwrap();
            settings.technique = TechniqueKind::Eikonal;
            settings.size = Some(SIZE);
            settings.samples = Some(1);
            settings.set = set.iter().map(|item| item.to_string()).collect();
        });
        let off = difference(&layer(&picture.image, "caustic"), &tree);
        assert!(off < TIERS, "{disable}: {off}");
    }
}

/// Volumes of `scene` in a file, under a folder that goes with what is returned.
fn file_of(request: &Request, scene: &Scene, set: &[&str]) -> (tempfile::TempDir, String) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.volumes");
    let device = request.open();
    let items: Vec<String> = set.iter().map(|item| item.to_string()).collect();
    let settings = Settings::of(TechniqueKind::Eikonal, scene, &items).unwrap();
    let gpu_scene = GpuScene::new(&device, scene).unwrap();
    file::write(&path, &eikonal::precompute(&device, scene, &gpu_scene, &settings).unwrap()).unwrap();
    assert_valid(&device);
    let item = format!("eikonal.read={}", path.display());
    (folder, item)
}

pub fn stored(request: &Request) {
    for set in [&["eikonal.resolution=32"][..], &["eikonal.resolution=32", "eikonal.intensity=laplacian"]] {
        let (_folder, read) = file_of(request, &flat(), set);
        let solved = caustic(request, flat(), TechniqueKind::Eikonal, set);
        let looked_up = caustic(request, flat(), TechniqueKind::Eikonal, &[&read]);
        assert_eq!(solved, looked_up, "{set:?}");
    }
}

pub fn refused(request: &Request) {
    let (_folder, read) = file_of(request, &flat(), &["eikonal.resolution=16"]);
    let mut dry = flat();
    dry.instances.retain(|instance| instance.name != "water");
    let settings = nephroid::render::RenderSettings {
        device: request.device.clone(),
        technique: TechniqueKind::Eikonal,
        set: vec![read],
        ..Default::default()
    };
    match nephroid::render::Renderer::new(dry, &settings) {
        Err(error @ RenderError::Volumes(_)) => {
            let said = error.to_string();
            assert!(
                said.ends_with("light 0 comes through no surface here; the file was made of another scene"),
                "{said}"
            );
        }
        other => panic!("{:?}", other.err()),
    }
}
