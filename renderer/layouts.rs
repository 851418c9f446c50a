//! Every struct that host and kernels share, for the test that compares them with the SPIR-V.

use crate::gpu::{GpuStruct, Layout};
use crate::{adaptive, animate, conformance, display, film, frame, gpu_scene, light_view, taa, technique, trace, view};

/// All of them.
pub fn layouts() -> Vec<Layout> {
    let mut all = vec![
        gpu_scene::Vertex::LAYOUT,
        gpu_scene::records::Instance::LAYOUT,
        gpu_scene::records::Material::LAYOUT,
        gpu_scene::records::Medium::LAYOUT,
        gpu_scene::records::DensityGrid::LAYOUT,
        gpu_scene::records::Light::LAYOUT,
        gpu_scene::records::Texture::LAYOUT,
        view::View::LAYOUT,
        adaptive::RoundSample::LAYOUT,
        adaptive::PixelPlan::LAYOUT,
        adaptive::RoundPush::LAYOUT,
        display::DisplayPush::LAYOUT,
        film::FrameCounters::LAYOUT,
        frame::VisiblePoint::LAYOUT,
        frame::VisibleShade::LAYOUT,
        frame::ViewSegment::LAYOUT,
        frame::Sample::LAYOUT,
        frame::DrawPush::LAYOUT,
        technique::emission::EmissionCell::LAYOUT,
    ];
    all.extend(light_view::LAYOUTS);
    all.extend(animate::layouts());
    all.extend(technique::reference::LAYOUTS);
    all.extend(technique::mnee::layouts());
    all.extend(technique::beams::layouts());
    all.extend(technique::eikonal::device::LAYOUTS);
    all.extend(technique::eikonal::wave::device::LAYOUTS);
    all.extend(technique::photons::LAYOUTS);
    all.extend(taa::LAYOUTS);
    all.extend(trace::LAYOUTS);
    all.extend(conformance::LAYOUTS);
    all
}
