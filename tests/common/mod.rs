//! Tests on devices: every case runs on every device found, under validation, and its name carries the device.
//!
//! A case that a device cannot run is listed as ignored, with the reason in its name.
#![allow(dead_code, reason = "each test binary uses its part")]

pub mod measure;
pub mod pool;
pub mod sequence;
pub mod slide;
pub mod smoke;
pub mod text;
pub mod truth;

use std::process::{Command, ExitCode};
use std::sync::{Mutex, PoisonError};
use std::thread;

use libtest_mimic::{Arguments, Failed, Trial};
use nephroid::gpu::{Capabilities, Capability, Device, DeviceInfo, DeviceRequest};
use nephroid::image::LayeredImage;
use nephroid::render::{Picture, RenderSettings, Renderer};
use nephroid::scene::Scene;

/// A check that runs once a device.
pub struct Case {
    pub name: &'static str,
    /// Capabilities without which the check makes no sense.
    pub needs: &'static [Capability],
    /// Capabilities that the device is used without, as in `--disable`.
    pub disable: &'static str,
    pub run: fn(&Request),
}

/// Which device a case runs on.
pub struct Request {
    pub info: DeviceInfo,
    pub device: DeviceRequest,
}

/// The devices that cases have opened, for those that follow: SwiftShader takes seconds to make a technique's pipelines,
/// and makes them once a device.
static DEVICES: Mutex<Vec<(DeviceRequest, Device)>> = Mutex::new(Vec::new());

/// The device that `request` names, shared by all cases that ask for it alike. What the validation layers say of one case
/// fails those that are there at the time, too.
fn device(request: &DeviceRequest) -> Device {
    let mut devices = DEVICES.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some((_, device)) = devices.iter().find(|(known, _)| known == request) {
        return device.clone();
    }
    let device = Device::open(request).unwrap();
    devices.push((request.clone(), device.clone()));
    device
}

impl Request {
    /// The device under validation, as the case asked for it.
    pub fn open(&self) -> Device {
        device(&self.device)
    }

    /// A renderer on the device, or on another that `settings` name.
    pub fn renderer(&self, scene: Scene, settings: &RenderSettings) -> Renderer {
        Renderer::with_device(device(&settings.device), scene, settings).unwrap()
    }

    /// Renders every sample of `scene` on the device, by the BVH unless `change` says otherwise, and asks for silence of
    /// the validation layers.
    pub fn render(&self, scene: Scene, change: impl FnOnce(&mut RenderSettings)) -> Picture {
        let mut settings =
            RenderSettings { device: self.device.clone(), trace: "bvh".parse().unwrap(), ..Default::default() };
        change(&mut settings);
        let mut renderer = self.renderer(scene, &settings);
        for _ in 0..renderer.samples() {
            renderer.sample().unwrap();
        }
        let picture = renderer.finish().unwrap();
        assert_valid(renderer.device());
        picture
    }

    /// The same device with more disabled.
    pub fn without(&self, disable: &str) -> DeviceRequest {
        DeviceRequest { disable: Capabilities::parse(disable).unwrap(), ..self.device.clone() }
    }
}

/// Fails where the validation layers had anything to say; call it on every device a case opened.
pub fn assert_valid(device: &Device) {
    let messages = device.validation_messages();
    assert!(messages.is_empty(), "{} validation messages, first: {}", messages.len(), messages[0]);
}

/// The pixels of a layer that has three channels.
pub fn layer(image: &LayeredImage, name: &str) -> Vec<[f32; 3]> {
    image.layer(name).unwrap().to_rgb().unwrap().pixels
}

/// Says to a process of a test which device is its own, by index.
const OWN_DEVICE: &str = "NEPHROID_TEST_DEVICE";

/// Runs the cases on all devices: the `main` of a device test. Each device has a process of its own, beside each other,
/// and there one case at a time: with two threads on software drivers, or two of them in one process, about one run of all
/// tests in two died of a broken heap in a driver's thread.
pub fn run(cases: &'static [Case]) -> ExitCode {
    let mut arguments = Arguments::from_args();
    arguments.test_threads.get_or_insert(1);
    let devices = match Device::list() {
        Ok(devices) if !devices.is_empty() => devices,
        found => {
            // Passing without a device would be a silent skip of everything.
            let reason = format!("no Vulkan device to test on: {:?}", found.err().map(|e| e.to_string()));
            let failing = Trial::test("a device is there", || Err(Failed::from(reason)));
            return libtest_mimic::run(&arguments, vec![failing]).exit_code();
        }
    };
    let own = std::env::var(OWN_DEVICE).ok();
    if own.is_none() && devices.len() > 1 && !arguments.list {
        return run_each(&devices);
    }
    let is_own = |info: &&DeviceInfo| own.as_ref().is_none_or(|own| *own == info.index.to_string());
    let own_devices = devices.iter().filter(is_own);
    let mut trials: Vec<Trial> = own_devices.flat_map(|info| cases.iter().map(|case| trial(case, info))).collect();
    if devices.first().as_ref().is_some_and(is_own) {
        trials.extend(expected_drivers().into_iter().map(|(name, part)| {
            let found = devices.iter().any(|d| d.name.contains(part));
            Trial::test(format!("the driver {name} shows a device"), move || {
                if found { Ok(()) } else { Err(Failed::from(format!("no device's name contains \"{part}\""))) }
            })
        }));
    }
    libtest_mimic::run(&arguments, trials).exit_code()
}

/// This program again for each device, with the same arguments; what they say follows device by device.
fn run_each(devices: &[DeviceInfo]) -> ExitCode {
    let program = std::env::current_exe().unwrap();
    let start = |info: &DeviceInfo| {
        let mut command = Command::new(&program);
        command.args(std::env::args_os().skip(1)).env(OWN_DEVICE, info.index.to_string());
        thread::spawn(move || command.output().unwrap())
    };
    let running: Vec<_> = devices.iter().map(start).collect();
    let mut code = ExitCode::SUCCESS;
    for (process, info) in running.into_iter().zip(devices) {
        let output = process.join().unwrap();
        print!("{}", String::from_utf8_lossy(&output.stdout));
        eprint!("{}", String::from_utf8_lossy(&output.stderr));
        if !output.status.success() {
            println!("The tests on {} ended with {}.", info.name, output.status);
            code = ExitCode::FAILURE;
        }
    }
    code
}

/// The software drivers that `tools/test` says are installed, each with a part of its device's name: one that shows no
/// device would go untested unseen.
fn expected_drivers() -> Vec<(&'static str, &'static str)> {
    let installed = std::env::var("NEPHROID_TEST_DRIVERS").unwrap_or_default();
    let known = [("lavapipe", "llvmpipe"), ("swiftshader", "SwiftShader")];
    known.into_iter().filter(|(name, _)| installed.split(':').any(|d| d.starts_with(&format!("{name}=")))).collect()
}

/// Pictures that SwiftShader takes half a minute and more each for, and whose kernels other cases run on it: the whole run
/// has to end within minutes.
const TOO_SLOW_ON_SWIFTSHADER: &[&str] = &[
    "a_ball_of_glass_is_the_reference",
    "adaptive_samples_keep_the_light",
    "all_techniques_are_treated_alike",
    "beams_through_waves_are_the_truth",
    "discs_keep_to_their_surface",
    "each_rule_splits",
    "even_light_is_flat_at_every_tilt",
    "extreme_media_are_finite",
    "given_beams_in_extreme_media_are_finite",
    "frames_of_a_still_scene_converge",
    "path_classes_part_the_light_in_volumes",
    "photons_are_accounted_for",
    "photons_at_odd_settings_are_sound",
    "pictures_have_less_noise_and_the_same_light",
    "single_specular_light_is_the_reference",
    "slats_shine_evenly",
    "smoke_scatters_as_quadrature_says",
    "ways_to_see_agree",
];

fn trial(case: &'static Case, info: &DeviceInfo) -> Trial {
    let short = info.name.split(" (").next().unwrap_or(&info.name).to_string();
    let name = format!("{}::{short}", case.name);
    if let Some(reason) = &info.unsuitable {
        return Trial::test(format!("{name} (skipped: {reason})"), || Ok(())).with_ignored_flag(true);
    }
    if let Some(missing) = case.needs.iter().find(|c| !info.capabilities.has(**c)) {
        let name = format!("{name} (skipped: the driver lacks {})", missing.name());
        return Trial::test(name, || Ok(())).with_ignored_flag(true);
    }
    if info.name.contains("SwiftShader") && TOO_SLOW_ON_SWIFTSHADER.contains(&case.name) {
        return Trial::test(format!("{name} (skipped: too slow there)"), || Ok(())).with_ignored_flag(true);
    }
    let request = Request {
        info: info.clone(),
        device: DeviceRequest {
            device: Some(info.index.to_string()),
            disable: Capabilities::parse(case.disable).unwrap_or_default(),
            validation: true,
        },
    };
    Trial::test(name, move || {
        (case.run)(&request);
        Ok(())
    })
}
