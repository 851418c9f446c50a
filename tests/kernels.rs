//! What can be said of the kernels without a device: their structs are laid out as the host's, and they keep to the
//! portable core.

use std::collections::BTreeSet;

use nephroid::gpu::{Parts, constants, reflect};
use nephroid::layouts::layouts;
use nephroid_kernels::KERNELS;

/// What every Vulkan 1.2 device offers.
const PUSH_CONSTANTS: u32 = 128;
const SETS: u32 = 4;
const WORKGROUP_INVOCATIONS: u32 = 128;
/// SwiftShader, the smallest device that is tested on, offers 30; phones often 24.
const STORAGE_BUFFERS: usize = 24;

#[test]
fn structs_are_laid_out_as_on_the_host() {
    let layouts = layouts();
    for layout in &layouts {
        let same = layouts.iter().filter(|other| other.name == layout.name).count();
        assert_eq!(same, 1, "structs named {}", layout.name);
    }
    let mut seen = BTreeSet::new();
    for kernel in KERNELS {
        let interface = reflect(&kernel.words()).unwrap();
        for found in interface.structs {
            let Some(layout) = layouts.iter().find(|l| l.name == found.name) else {
                assert!(
                    found.stride.is_none(),
                    "{}: the array of {} is in a buffer, and no struct of that name is on the host",
                    kernel.name,
                    found.name
                );
                continue;
            };
            seen.insert(layout.name);
            let expected: Vec<_> = layout.fields.iter().map(|f| (f.name.to_string(), f.offset, f.size)).collect();
            assert_eq!(found.fields, expected, "{} in {} {}", layout.name, kernel.name, kernel.variant);
            if let Some(stride) = found.stride {
                assert_eq!(stride, layout.size, "stride of {} in {}", layout.name, kernel.name);
            }
        }
    }
    let unused: Vec<_> = layouts.iter().map(|l| l.name).filter(|name| !seen.contains(name)).collect();
    assert!(unused.is_empty(), "no kernel reads {unused:?}");
}

#[test]
fn constants_are_the_parts_of_a_scene() {
    let mut seen = BTreeSet::new();
    for kernel in KERNELS {
        for (id, name) in constants(&kernel.words()) {
            let part = Parts::NAMES.get(id as usize).copied();
            assert_eq!(part, Some(name.as_str()), "constant {id} of {} {}", kernel.name, kernel.variant);
            seen.insert(id);
        }
    }
    assert_eq!(seen.len(), Parts::NAMES.len(), "kernels ask for {seen:?}");
}

#[test]
fn kernels_keep_to_the_portable_core() {
    for kernel in KERNELS {
        let name = format!("{} {} {}", kernel.name, kernel.stage, kernel.variant);
        let words = kernel.words();
        let interface = reflect(&words).unwrap();
        assert!(interface.push_constants <= PUSH_CONSTANTS, "{name}: {} bytes pushed", interface.push_constants);
        assert!(interface.slots.iter().all(|s| s.set < SETS), "{name}: {:?}", interface.slots);
        assert!(interface.slots.len() <= STORAGE_BUFFERS, "{name}: {} bindings", interface.slots.len());
        assert!(interface.workgroup.iter().product::<u32>() <= WORKGROUP_INVOCATIONS, "{name}");
        let version = words[1] >> 8;
        assert!(version <= 0x0105, "{name}: SPIR-V version {version:#x}");
        let allowed: &[u32] = match (kernel.stage, kernel.variant) {
            // Only where the device has geometry shaders.
            ("geom", _) => &[SHADER, GEOMETRY],
            // What conformance asks about, and only where the device has it; the basic operations every one has.
            _ if kernel.name == "conformance/float_atomics" => &[SHADER, FLOAT_ATOMIC_ADD],
            _ if kernel.name == "conformance/subgroups" => &[SHADER, SUBGROUPS],
            (_, "ray_query") => &[SHADER, RAY_QUERY],
            _ => &[SHADER],
        };
        let capabilities = interface.capabilities;
        assert!(capabilities.iter().all(|c| allowed.contains(c)), "{name}: capabilities {capabilities:?}");
        // Geometry has Shader in it.
        let shader = capabilities.iter().any(|c| [SHADER, GEOMETRY].contains(c));
        assert!(shader, "{name}: capabilities {capabilities:?}");
    }
}

const SHADER: u32 = 1;
const GEOMETRY: u32 = 2;
const RAY_QUERY: u32 = 4472;
const SUBGROUPS: u32 = 61;
const FLOAT_ATOMIC_ADD: u32 = 6033;
