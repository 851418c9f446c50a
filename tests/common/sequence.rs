//! Frames of a sequence against frames alone.

use nephroid::render::{Picture, RenderSettings, Renderer};
use nephroid::scene::Scene;

use super::measure::watts;
use super::{Request, assert_valid, layer};

/// The caustic light and the picture, to the last bit.
pub fn bits(picture: &Picture) -> Vec<u32> {
    let layers = ["caustic", "caustic_volume", "final"].into_iter().filter(|name| picture.image.layer(name).is_some());
    layers.flat_map(|name| layer(&picture.image, name)).flatten().map(f32::to_bits).collect()
}

/// Asks that frame 5 of `scene` is the same after frames 0 and 1, rendered once more, and alone, and so is `landed` of its
/// ledger. Returns frame 0 and frame 5.
pub fn frame_alone(request: &Request, scene: fn() -> Scene, settings: &RenderSettings) -> [Picture; 2] {
    let picture = |renderer: &mut Renderer| {
        for _ in 0..renderer.samples() {
            renderer.sample().unwrap();
        }
        renderer.finish().unwrap()
    };
    let mut row = request.renderer(scene(), settings);
    let first = picture(&mut row);
    for frame in [1, 5] {
        row.go_to(frame).unwrap();
    }
    let in_row = picture(&mut row);
    row.restart().unwrap();
    let again = picture(&mut row);
    assert_valid(row.device());
    let alone = picture(&mut request.renderer(scene(), &RenderSettings { frame: 5, ..settings.clone() }));
    assert!(bits(&in_row) == bits(&alone), "the frame knows of those before it");
    assert!(bits(&again) == bits(&alone), "the frame once more is another");
    let ledgers = [&in_row, &again, &alone].map(|picture| watts(picture, "landed"));
    assert!(ledgers.iter().all(|watts| *watts == ledgers[0]), "{ledgers:?} W landed");
    [first, alone]
}
