//! Picture files: what is written is read back to the bit, foreign EXR files open, a failed write
//! leaves the folder as it was.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use exr::image::{AnyChannel, AnyChannels, Encoding, FlatSamples, Image};
use exr::meta::header::LayerAttributes;
use exr::prelude::{SmallVec, WritableImage, f16};
use nephroid::image::openexr::{self, SOFTWARE};
use nephroid::image::{
    Channel, FINAL_LAYER, Format, ImageError, Layer, LayeredImage, Mask, RenderInfo, RgbImage, atomic, png, read, tone,
};

const WIDTH: usize = 37;
const HEIGHT: usize = 19;

fn ramp(offset: f32) -> RgbImage {
    let pixels = (0..WIDTH * HEIGHT).map(|i| {
        let value = offset + i as f32 / 7.0;
        [value, -value * 1e-3, value * 1e9]
    });
    RgbImage { width: WIDTH, height: HEIGHT, pixels: pixels.collect() }
}

fn plane(name: &str, channels: &[&str]) -> Layer {
    let samples = |seed: usize| (0..WIDTH * HEIGHT).map(|i| (i * seed) as f32 / 3.0).collect();
    Layer {
        name: name.to_owned(),
        width: WIDTH,
        height: HEIGHT,
        channels: (channels.iter().enumerate())
            .map(|(i, name)| Channel { name: (*name).to_owned(), samples: samples(i + 1) })
            .collect(),
    }
}

fn render_info() -> RenderInfo {
    RenderInfo {
        scene: "scenes/pöol.toml".to_owned(),
        technique: "photons".to_owned(),
        camera: "under".to_owned(),
        samples: 64,
        seed: 7,
        frame: 3,
        device: "llvmpipe (LLVM 15, 256 bits)".to_owned(),
        tier: "cwbvh tracing, raster visibility".to_owned(),
    }
}

fn rendered() -> LayeredImage {
    LayeredImage {
        layers: vec![
            Layer::from_rgb(FINAL_LAYER, &ramp(0.1)),
            Layer::from_rgb("caustic", &ramp(2.0)),
            Layer::from_rgb("direct", &ramp(3.0)),
            Layer::from_rgb("albedo", &ramp(4.0)),
            plane("normal", &["X", "Y", "Z"]),
            plane("depth", &["Z"]),
        ],
        attributes: render_info().attributes(),
    }
}

fn entries(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

/// Writes parts as another program might: any sample type, any encoding.
fn write_foreign(path: &Path, parts: Vec<(&str, Vec<(&str, FlatSamples)>)>, encoding: Encoding) {
    let layers: SmallVec<[exr::image::Layer<_>; 2]> = parts
        .into_iter()
        .map(|(name, channels)| {
            let channels: SmallVec<[_; 4]> =
                channels.into_iter().map(|(name, data)| AnyChannel::new(name, data)).collect();
            let attributes = match name {
                "" => LayerAttributes::default(),
                name => LayerAttributes::named(name),
            };
            let channels = AnyChannels::sort(channels);
            exr::image::Layer::new((WIDTH, HEIGHT), attributes, encoding, channels)
        })
        .collect();
    let size = exr::meta::header::ImageAttributes::with_size((WIDTH, HEIGHT));
    Image::from_layers(size, layers).write().to_file(path).unwrap();
}

fn halves() -> Vec<f16> {
    (0..WIDTH * HEIGHT).map(|i| f16::from_f32(i as f32 / 16.0)).collect()
}

#[test]
fn exr_keeps_every_layer_to_the_bit() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("picture.exr");
    let mut written = rendered();
    // A NaN with a payload, an infinity, a denormal and a negative zero must survive too.
    let odd = [f32::from_bits(0x7fc0_1234), f32::INFINITY, f32::from_bits(1), -0.0];
    written.layers[0].channels[0].samples[..4].copy_from_slice(&odd);
    openexr::write(&path, &written).unwrap();

    let found = read(&path).unwrap();
    assert_eq!(found.layers.len(), written.layers.len());
    for layer in &written.layers {
        let twin = found.layer(&layer.name).unwrap();
        assert_eq!((twin.width, twin.height, twin.channels.len()), (WIDTH, HEIGHT, layer.channels.len()));
        for channel in &layer.channels {
            let bits = |samples: &[f32]| samples.iter().map(|s| s.to_bits()).collect::<Vec<_>>();
            assert_eq!(
                bits(twin.channel(&channel.name).unwrap()),
                bits(&channel.samples),
                "{}.{}",
                layer.name,
                channel.name
            );
        }
    }
    let mut attributes = written.attributes;
    attributes.insert("software".to_owned(), SOFTWARE.to_owned());
    assert_eq!(found.attributes, attributes);
    assert_eq!(attributes["nephroid.scene"], "scenes/pöol.toml");
    assert_eq!(entries(folder.path()), ["picture.exr"]);
}

#[test]
fn equal_pictures_are_equal_files() {
    let folder = tempfile::tempdir().unwrap();
    let written = |name: &str, attributes: &BTreeMap<String, String>| {
        let (exr, png) = (folder.path().join(format!("{name}.exr")), folder.path().join(format!("{name}.png")));
        openexr::write(&exr, &LayeredImage { attributes: attributes.clone(), ..rendered() }).unwrap();
        png::write_with(&png, 2, 1, &[[1, 2, 3], [4, 5, 6]], attributes).unwrap();
        (fs::read(exr).unwrap(), fs::read(png).unwrap())
    };
    // Ten attributes in an order left to chance agree once in millions of times.
    let mut attributes = render_info().attributes();
    attributes.insert("another".to_owned(), "one".to_owned());
    let first = written("first", &attributes);
    assert!(first == written("second", &attributes), "files differ");
    let exr = read(&folder.path().join("first.exr")).unwrap();
    assert_eq!(exr.attributes["another"], "one");
    let display = png::read_display(&folder.path().join("first.png")).unwrap();
    assert_eq!((display.width, display.height, &display.pixels[..]), (2, 1, &[[1, 2, 3], [4, 5, 6]][..]));
    attributes.insert("Software".to_owned(), SOFTWARE.to_owned());
    assert_eq!(display.attributes, attributes);
}

#[test]
fn files_cut_short_anywhere_are_noticed() {
    let folder = tempfile::tempdir().unwrap();
    let (exr, png) = (folder.path().join("a.exr"), folder.path().join("a.png"));
    openexr::write(&exr, &rendered()).unwrap();
    let pixels: Vec<[u8; 3]> = (0..WIDTH * HEIGHT).map(|i| [(i % 251) as u8, (i / 7) as u8, 9]).collect();
    png::write_with(&png, WIDTH, HEIGHT, &pixels, &render_info().attributes()).unwrap();
    for (path, whole) in [(&exr, fs::read(&exr).unwrap()), (&png, fs::read(&png).unwrap())] {
        let good = || match Format::of(path).unwrap() {
            Format::Exr => openexr::read(path).is_ok(),
            Format::Png => png::read_display(path).is_ok(),
        };
        assert!(good());
        for length in (0..whole.len()).step_by(997).chain([whole.len() - 1]) {
            fs::write(path, &whole[..length]).unwrap();
            assert!(!good(), "{} of {} bytes of {path:?} pass for a picture", length, whole.len());
        }
    }
}

#[test]
fn exr_is_one_part_with_plain_and_prefixed_float_channels() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("picture.exr");
    openexr::write(&path, &rendered()).unwrap();
    let meta = exr::meta::MetaData::read_from_file(&path, true).unwrap();
    assert_eq!(meta.headers.len(), 1);
    let header = &meta.headers[0];
    assert_eq!(header.compression, exr::prelude::Compression::ZIP16);
    let names: Vec<String> = header.channels.list.iter().map(|channel| channel.name.to_string()).collect();
    for name in ["R", "G", "B", "caustic.R", "direct.G", "albedo.B", "normal.X", "depth.Z"] {
        assert!(names.iter().any(|found| found == name), "{name} is not among {names:?}");
    }
    let float = exr::prelude::SampleType::F32;
    assert!(header.channels.list.iter().all(|channel| channel.sample_type == float));
}

#[test]
fn half_and_luminance_files_open() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("half.exr");
    let data = || FlatSamples::F16(halves());
    let alpha = FlatSamples::F16(vec![f16::ONE; WIDTH * HEIGHT]);
    write_foreign(&path, vec![("", vec![("Y", data()), ("A", alpha)])], Encoding::FAST_LOSSLESS);
    let grey = read(&path).unwrap().select(&path, None).unwrap();
    for (pixel, half) in grey.pixels.iter().zip(halves()) {
        assert_eq!(*pixel, [half.to_f32(); 3]);
    }

    let floats = FlatSamples::F32(vec![0.25; WIDTH * HEIGHT]);
    let whole = FlatSamples::U32(vec![3; WIDTH * HEIGHT]);
    let mixed = vec![("R", data()), ("G", floats), ("B", whole), ("A", data())];
    write_foreign(&path, vec![("beauty", mixed)], Encoding::SMALL_FAST_LOSSLESS);
    let colour = read(&path).unwrap().select(&path, Some(FINAL_LAYER)).unwrap();
    assert_eq!(colour.pixels[16], [1.0, 0.25, 3.0]);
}

#[test]
fn parts_become_layers() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("parts.exr");
    let data = || FlatSamples::F16(halves());
    let parts = vec![
        ("caustic", vec![("R", data()), ("G", data()), ("B", data())]),
        ("depth", vec![("depth.Z", data())]),
        ("left", vec![("volume.Y", data())]),
    ];
    write_foreign(&path, parts, Encoding::UNCOMPRESSED);
    let file = read(&path).unwrap();
    let names: Vec<&str> = file.layers.iter().map(|layer| layer.name.as_str()).collect();
    assert_eq!(names, ["caustic", "depth", "left.volume"]);
    assert_eq!(file.select(&path, Some("depth")).unwrap().pixels[32], [2.0; 3]);
}

#[test]
fn a_missing_layer_is_told_with_those_found() {
    let file = rendered();
    let path = Path::new("picture.exr");
    assert_eq!(
        file.select(path, Some("volume")).unwrap_err().to_string(),
        "picture.exr: has no layer 'volume'; its layers are: final, caustic, direct, albedo, \
         normal, depth"
    );
    let odd = LayeredImage { layers: vec![plane("flow", &["U", "V"])], ..Default::default() };
    assert_eq!(
        odd.select(path, None).unwrap_err().to_string(),
        "picture.exr: layer 'flow' has the channels U, V; a picture needs R, G, B, or X, Y, Z, or \
         a single channel"
    );
}

#[test]
fn damaged_files_are_errors_not_panics() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("picture.exr");
    openexr::write(&path, &rendered()).unwrap();
    let whole = fs::read(&path).unwrap();
    for length in [0, 3, 8, 60, 300, whole.len() / 2, whole.len() - 1] {
        fs::write(&path, &whole[..length]).unwrap();
        let error = read(&path).expect_err("a truncated file must not open");
        assert!(error.to_string().contains("picture.exr: cannot be read: "), "{error}");
    }
    // One byte in seven of the header flipped, one at a time: any answer but a panic is right.
    for position in (0..1200).step_by(7) {
        let mut broken = whole.clone();
        broken[position] ^= 0x55;
        fs::write(&path, &broken).unwrap();
        let _ = read(&path);
    }
    let path = folder.path().join("picture.png");
    fs::write(&path, b"not a picture").unwrap();
    assert!(matches!(read(&path), Err(ImageError::Read { .. })));
    let path = folder.path().join("absent.exr");
    assert!(matches!(read(&path), Err(ImageError::Read { .. })));
}

#[test]
fn png_is_srgb_outside_and_linear_inside() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("grey.PNG");
    let levels: Vec<[u8; 3]> = (0..=255).map(|level| [level, 255 - level, 128]).collect();
    png::write(&path, 16, 16, &levels).unwrap();
    let linear = png::read_linear(&path).unwrap();
    // Encoded 128 is 0.21586 linear: 21.6 % reflectance, the textbook mid level of sRGB.
    assert!((linear.pixels[0][2] - 0.215_86).abs() < 1e-5);
    assert_eq!(linear.pixels[255], [1.0, 0.0, linear.pixels[0][2]]);
    assert_eq!(tone::display(&linear.pixels, 0.0, |colour| colour), levels);

    let mask: Vec<[u8; 3]> = [0, 127, 128, 255].map(|level| [level; 3]).to_vec();
    png::write(&path, 2, 2, &mask).unwrap();
    let inside = vec![false, false, true, true];
    assert_eq!(png::read_mask(&path).unwrap(), Mask { width: 2, height: 2, inside });
}

#[test]
fn a_damaged_text_of_a_png_is_noticed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("picture.png");
    let attributes = BTreeMap::from([("nephroid.request".to_owned(), "0123456789".to_owned())]);
    png::write_with(&path, 2, 1, &[[0; 3]; 2], &attributes).unwrap();
    assert_eq!(png::read_display(&path).unwrap().attributes["nephroid.request"], "0123456789");
    let mut bytes = fs::read(&path).unwrap();
    let at = bytes.windows(10).position(|window| window == b"0123456789").unwrap();
    bytes[at] ^= 1;
    fs::write(&path, bytes).unwrap();
    png::read_display(&path).unwrap_err();
}

#[test]
fn long_names_that_begin_alike_are_told_apart() {
    let folder = tempfile::tempdir().unwrap();
    let names = ["1", "2"].map(|end| format!("{}{end}", "a".repeat(220)));
    let paths = names.map(|name| folder.path().join(name));
    // Written by another program that is killed meanwhile.
    let killed = atomic::write_by(&paths[0], |temporary| {
        fs::copy(temporary, folder.path().join("kept")).unwrap();
        Err::<(), _>(ImageError::Write { path: temporary.to_owned(), reason: "killed".to_owned() })
    });
    let ImageError::Write { path: temporary, .. } = killed.unwrap_err() else { panic!("another error") };
    fs::rename(folder.path().join("kept"), &temporary).unwrap();
    assert_eq!(atomic::remove_stale([paths[1].as_path()]).unwrap(), 0, "another file's was taken");
    assert_eq!(atomic::remove_stale([paths[0].as_path()]).unwrap(), 1);
}

#[test]
fn tone_curves_hit_their_fixed_points() {
    assert_eq!(tone::to_srgb8([-1.0, f32::NAN, f32::INFINITY]), [0, 0, 255]);
    let bytes = |value: f32, stops: f32| tone::display(&[[value; 3]], stops, |colour| colour);
    assert_eq!(bytes(0.125, 2.0), bytes(0.5, 0.0), "two stops are a factor of four");
    let white = tone::reinhard_extended([4.0; 3], 4.0);
    let one = tone::reinhard_extended([1.0; 3], 4.0);
    // L = white gives 1; L = 1 gives (1 + 1/16) / 2.
    for (found, expected) in white.into_iter().zip([1.0; 3]).chain(one.into_iter().zip([0.53125; 3])) {
        assert!((found - expected).abs() < 1e-6, "{found} is not {expected}");
    }
    assert_eq!(tone::reinhard_extended([0.0; 3], 4.0), [0.0; 3]);
}

#[test]
fn a_failed_write_changes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("picture.exr");
    fs::write(&path, "what stood here").unwrap();

    let torn = atomic::write(&path, |output| {
        output.write_all(b"half a pic").unwrap();
        Err("the disk is full".to_owned())
    });
    let sentence = format!("{}: cannot be written: the disk is full", path.display());
    assert_eq!(torn.unwrap_err().to_string(), sentence);

    let mut uneven = rendered();
    uneven.layers[1].channels[0].samples.pop();
    let error = openexr::write(&path, &uneven).unwrap_err().to_string();
    assert!(error.contains("channel 'R' of layer 'caustic' has 702 samples for 37x19"), "{error}");

    let refused = |layers| {
        let image = LayeredImage { layers, ..Default::default() };
        openexr::write(&path, &image).unwrap_err().to_string()
    };
    assert!(refused(vec![plane("flow", &["X", "X"])]).ends_with("layer 'flow' has two channels 'X'"));
    let narrow = Layer { width: 1, ..plane("flow", &["X"]) };
    assert!(
        refused(vec![plane("depth", &["Z"]), narrow]).contains("layer 'flow' is 1x19 pixels, where 'depth' is 37x19")
    );
    assert!(refused(vec![]).ends_with("the picture has no layers"));

    assert_eq!(entries(folder.path()), ["picture.exr"]);
    assert_eq!(fs::read_to_string(&path).unwrap(), "what stood here");
}

#[test]
fn paths_that_cannot_be_written_are_told_before_the_work() {
    let folder = tempfile::tempdir().unwrap();
    let told = |path: &Path| atomic::check(path).unwrap_err().to_string();
    assert!(told(&folder.path().join("picture.tga")).contains("neither .exr nor .png"));
    let taken = folder.path().join("taken.exr");
    fs::create_dir(&taken).unwrap();
    assert!(told(&taken).ends_with("taken.exr: cannot be written: it is a folder"));
    fs::write(folder.path().join("file"), "").unwrap();
    let within = told(&folder.path().join("file/picture.png"));
    assert!(within.ends_with("file is not a folder"), "{within}");
    fs::remove_file(folder.path().join("file")).unwrap();
    let nowhere = told(&folder.path().join("absent/picture.png"));
    assert!(nowhere.ends_with("absent does not exist"), "{nowhere}");
    assert_eq!(atomic::check(&folder.path().join("picture.EXR")).unwrap(), Format::Exr);
    assert_eq!(entries(folder.path()), ["taken.exr"]);
}

#[cfg(unix)]
#[test]
fn pictures_get_the_permissions_of_ordinary_files() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    let (ours, ordinary) = (folder.path().join("ours.png"), folder.path().join("ordinary"));
    png::write(&ours, 1, 1, &[[0; 3]]).unwrap();
    fs::write(&ordinary, "").unwrap();
    let mode = |path| fs::metadata(path).unwrap().permissions().mode();
    assert_eq!(mode(&ours), mode(&ordinary));
}
