//! What a scene file may hold, and the sentence for each thing it may not.

mod scene_text;

use std::path::Path;

use glam::Vec3;
use nephroid::scene::{Emitter, SceneError, Surface, ToneCurve, load, parse};
use nephroid::technique::{Settings, TechniqueKind};
use scene_text::{check_sentence, read};

/// Line numbers in the sentences below count from the first line here.
const SOUND: &str = r#"[film]
width = 64
height = 48
samples = 4
[[camera]]
name = "eye"
position = [0, 1, 4]
target = [0, 0, 0]
[[medium]]
name = "water"
index = 1.33
[[material]]
name = "sand"
kind = "diffuse"
albedo = 0.5
[[material]]
name = "surface"
kind = "dielectric"
back = "water"
[[object]]
name = "ground"
shape = "plane"
size = [4, 4]
material = "sand"
[[light]]
name = "lamp"
kind = "point"
position = [0, 3, 0]
intensity = 10
"#;

/// The sentence for the sound scene with `from` replaced.
fn sentence(from: &str, to: &str) -> String {
    scene_text::sentence(SOUND, from, to)
}

#[test]
fn the_sound_scene_is_read() {
    let scene = read(SOUND).unwrap();
    assert_eq!((scene.film.width, scene.film.height, scene.film.samples), (64, 48, 4));
    assert_eq!((scene.film.exposure, scene.film.tone_curve), (0.0, ToneCurve::Linear));
    assert_eq!((scene.cameras[0].up, scene.cameras[0].fov_y, scene.cameras[0].medium), (Vec3::Y, 45.0, 0));
    assert_eq!(scene.media.iter().map(|medium| medium.name.as_str()).collect::<Vec<_>>(), ["air", "water"]);
    assert_eq!(scene.materials[0].surface, Surface::Diffuse { albedo: Vec3::splat(0.5), texture: None });
    assert_eq!(scene.materials[1].surface, Surface::Dielectric { front: 0, back: 1 });
    assert_eq!(
        scene.lights[0].emitter,
        Emitter::Point { position: Vec3::new(0.0, 3.0, 0.0), intensity: Vec3::splat(10.0) }
    );
    assert!(scene.warnings.is_empty());
}

#[test]
fn a_missing_scene_is_named() {
    let error = load(Path::new("no/such/scene.toml")).unwrap_err();
    assert_eq!(error.to_string(), "the scene file no/such/scene.toml cannot be read: there is no such file");
}

#[test]
fn a_scene_that_is_not_text_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.toml");
    std::fs::write(&path, [0xff, 0xfe, 0x00]).unwrap();
    let expected = format!("the scene file {} cannot be read: it is not UTF-8 text", path.display());
    assert_eq!(load(&path).unwrap_err().to_string(), expected);
}

#[test]
fn each_wrong_value_has_its_sentence() {
    let cases = [
        (
            "width = 64",
            "width = ",
            "bad.toml:2:9: not valid TOML: string values must be quoted, expected literal string",
        ),
        (
            "width = 64",
            "widht = 64",
            "bad.toml:2: unknown key `widht` in [film]; allowed: width, height, samples, exposure, tone_curve, background, \
             volume_samples",
        ),
        (
            "[film]",
            "[flim]",
            "bad.toml:1: unknown key `flim` in the scene file; allowed: film, animation, camera, medium, material, object, light, technique",
        ),
        (
            "size = [4, 4]",
            "radius = 4",
            "bad.toml:23: unknown key `radius` in a plane [[object]]; allowed: name, shape, material, transform, keys, interpolation, repeat, centre, size, subdivisions",
        ),
        (
            "width = 64",
            "width = \"big\"",
            "bad.toml:2: `film.width` is the text \"big\"; allowed: a whole number from 1 to 16384",
        ),
        ("width = 64", "width = 0", "bad.toml:2: `film.width` is 0; allowed: a whole number from 1 to 16384"),
        (
            "height = 48",
            "height = 1_000_000",
            "bad.toml:3: `film.height` is 1000000; allowed: a whole number from 1 to 16384",
        ),
        ("width = 64", "width = 64.5", "bad.toml:2: `film.width` is 64.5; allowed: a whole number from 1 to 16384"),
        (
            "width = 64",
            "width = 0x0",
            "bad.toml:2: `film.width` is 0 in base 16; allowed: a whole number from 1 to 16384",
        ),
        ("samples = 4", "exposure = nan", "bad.toml:4: `film.exposure` is nan; allowed: a number from -32 to 32"),
        (
            "samples = 4",
            "tone_curve = \"aces\"",
            "bad.toml:4: `film.tone_curve` is the text \"aces\"; allowed: \"linear\", \"reinhard\"",
        ),
        (
            "samples = 4",
            "background = [1, 2]",
            "bad.toml:4: `film.background` is the list [1, 2]; allowed: a number from 0 to 1e9, or a list of three",
        ),
        (
            "position = [0, 1, 4]",
            "position = [0, inf, 4]",
            "bad.toml:7: `camera.position` is the list [0, inf, 4]; allowed: a list of three numbers, each from -1e6 to 1e6",
        ),
        ("position = [0, 1, 4]\n", "", "bad.toml:5: [[camera]] lacks `position`; allowed: a list of three numbers"),
        (
            "target = [0, 0, 0]",
            "target = [0, 1, 4]",
            "bad.toml:8: `camera.target` is the list [0, 1, 4]; allowed: a point at least 1e-6 from the camera's position",
        ),
        (
            "target = [0, 0, 0]",
            "target = [0, -3, 4]",
            "bad.toml:8: `camera.target` is the list [0, -3, 4]; allowed: a camera whose `up` (0, 1, 0 if left out) is not along its view",
        ),
        (
            "target = [0, 0, 0]",
            "target = [0, 0, 0]\nmedium = \"oil\"",
            "bad.toml:9: `camera.medium` names the medium \"oil\", which is not in the scene; known: \"air\", \"water\"",
        ),
        (
            "target = [0, 0, 0]",
            "target = [0, 0, 0]\nfov_y = 180",
            "bad.toml:9: `camera.fov_y` is 180; allowed: a number from 0.1 to 179",
        ),
        (
            "name = \"water\"",
            "name = \"air\"",
            "bad.toml:10: the medium name \"air\" is taken; allowed: a name no other medium has",
        ),
        ("index = 1.33", "index = 0.9", "bad.toml:11: `medium.index` is 0.9; allowed: a number from 1 to 10"),
        (
            "index = 1.33",
            "index = 1.33\nasymmetry = 1",
            "bad.toml:12: `medium.asymmetry` is 1; allowed: a number from -0.999 to 0.999",
        ),
        (
            "albedo = 0.5",
            "albedo = 1.5",
            "bad.toml:15: `material.albedo` is 1.5; allowed: a number from 0 to 1, or a list of three",
        ),
        (
            "kind = \"diffuse\"",
            "kind = \"velvet\"",
            "bad.toml:14: `material.kind` is the text \"velvet\"; allowed: \"diffuse\", \"dielectric\", \"mirror\", \"rough\"",
        ),
        (
            "back = \"water\"",
            "back = \"oil\"",
            "bad.toml:19: `material.back` names the medium \"oil\", which is not in the scene; known: \"air\", \"water\"",
        ),
        (
            "back = \"water\"",
            "back = \"air\"",
            "bad.toml:19: `material.back` is the text \"air\"; allowed: a medium other than the one in `front` (air if left out)",
        ),
        (
            "material = \"sand\"",
            "material = \"snad\"",
            "bad.toml:24: `object.material` names the material \"snad\", which is not in the scene; known: \"sand\", \"surface\"",
        ),
        (
            "material = \"sand\"\n",
            "",
            "bad.toml:20: a plane [[object]] lacks `material`; allowed: the name of a material",
        ),
        (
            "size = [4, 4]",
            "size = [4, 4]\ntransform = { scale = 0 }",
            "bad.toml:24: `object.transform.scale` is 0; allowed: a number from 1e-6 to 1e6, or a list of three",
        ),
        (
            "size = [4, 4]",
            "size = [4, 4]\ntransform = { rotate = 90 }",
            "bad.toml:24: `object.transform.rotate` is 90; allowed: three angles in degrees, each from -1e4 to 1e4, or { axis, angle }",
        ),
        (
            "size = [4, 4]",
            "size = [4, 4]\ntransform = { translate = [1e6, 0, 0] }",
            "bad.toml:24: `object.transform` is a table; allowed: a placement with all points within 1e6 of the origin",
        ),
        (
            "intensity = 10",
            "intensity = -10",
            "bad.toml:29: `light.intensity` is -10; allowed: a number from 0 to 1e9, or a list of three",
        ),
        (
            "intensity = 10",
            "intensity = [1, 1, nan]",
            "bad.toml:29: `light.intensity` is the list [1, 1, nan]; allowed: a number from 0 to 1e9, or a list of three",
        ),
        ("[[light]]", "[light]", "bad.toml:25: `light` is a table; allowed: a list of tables, each written [[light]]"),
        (
            "albedo = 0.5",
            "texture = \"no.png\"",
            "bad.toml:15: `material.texture` refers to no.png, which cannot be read: there is no such file",
        ),
        (
            "shape = \"plane\"\nsize = [4, 4]",
            "shape = \"obj\"\nfile = \"no.obj\"",
            "bad.toml:23: `object.file` refers to no.obj, which cannot be read: there is no such file",
        ),
    ];
    for (from, to, expected) in cases {
        assert_eq!(sentence(from, to), expected, "{to}");
    }
}

#[test]
fn settings_of_techniques_are_read_and_refused_by_their_tables() {
    let levels = TechniqueKind::Beams.settings().iter().find(|setting| setting.key == "levels").unwrap();
    let keys = TechniqueKind::Beams.settings().iter().map(|setting| setting.key).collect::<Vec<_>>().join(", ");
    let names = TechniqueKind::ALL.iter().map(|kind| kind.name()).collect::<Vec<_>>().join(", ");
    let cases = [
        ("levels = 99", format!("`technique.beams.levels` is 99; allowed: {}", levels.kind.allowed())),
        ("levels = 2.5", format!("`technique.beams.levels` is 2.5; allowed: {}", levels.kind.allowed())),
        ("levels = [1, 2]", format!("`technique.beams.levels` is the list [1, 2]; allowed: {}", levels.kind.allowed())),
        ("convergence = nan", "`technique.beams.convergence` is nan; allowed: a number from -10 to 1".to_string()),
        ("jitter = true", "`technique.beams.jitter` is true; allowed: one of on, off".to_string()),
        ("jitter = \"maybe\"", "`technique.beams.jitter` is the text \"maybe\"; allowed: one of on, off".to_string()),
        ("level = 4", format!("unknown key `level` in [technique.beams]; allowed: {keys}")),
    ];
    let line = 1 + SOUND.lines().count() + 1;
    for (text, expected) in cases {
        let error = read(&format!("{SOUND}[technique.beams]\n{text}\n")).unwrap_err();
        assert_eq!(error.to_string(), format!("bad.toml:{line}: {expected}"));
    }
    let error = read(&format!("{SOUND}[technique.beam]\nlevels = 4\n")).unwrap_err().to_string();
    assert_eq!(error, format!("bad.toml:{}: unknown key `beam` in [technique]; allowed: {names}", line - 1));
    assert!(read(&format!("{SOUND}[technique]\nbeams = 4\n")).unwrap_err().to_string().contains("allowed: a table"));
}

#[test]
fn a_scenes_settings_are_defaults_that_the_command_line_wins_over() {
    let text = format!(
        "{SOUND}[technique.reference]\nalpha = 0.5\n[technique.beams]\nlevels = 3\nconvergence = 1e-3\njitter = \"off\"\n"
    );
    let scene = read(&text).unwrap();
    let settings = Settings::of(TechniqueKind::Beams, &scene, &["beams.levels=4".to_string()]).unwrap();
    assert_eq!((settings.integer("levels"), settings.choice("jitter")), (4, "off"));
    assert_eq!(settings.number("convergence"), 1e-3);
    let of = |key| TechniqueKind::Beams.settings().iter().find(|setting| setting.key == key).unwrap().default;
    assert_eq!(settings.integer("grid").to_string(), of("grid"), "what neither says is the table's");
    assert_eq!(Settings::of(TechniqueKind::Reference, &scene, &[]).unwrap().number("alpha"), 0.5);
    assert_eq!(Settings::of(TechniqueKind::Beams, &read(SOUND).unwrap(), &[]).unwrap().choice("jitter"), of("jitter"));
}

#[test]
fn a_scene_without_camera_or_object_is_refused() {
    let (camera, rest) = SOUND.split_once("[[medium]]").unwrap();
    let (film, _) = camera.split_once("[[camera]]").unwrap();
    let text = format!("{film}[[medium]]{rest}");
    let expected = "bad.toml:1: the scene file lacks `camera`; allowed: at least one [[camera]]";
    assert_eq!(read(&text).unwrap_err().to_string(), expected);
    let expected = "bad.toml:1: the scene file lacks `camera`; allowed: at least one [[camera]]";
    assert_eq!(read("").unwrap_err().to_string(), expected);
    let (before, after) = SOUND.split_once("[[object]]").unwrap();
    let (_, light) = after.split_once("[[light]]").unwrap();
    let expected = "bad.toml:1: the scene file lacks `object`; allowed: at least one [[object]]";
    assert_eq!(read(&format!("{before}[[light]]{light}")).unwrap_err().to_string(), expected);
}

#[test]
fn no_prefix_or_damage_of_a_scene_makes_the_reader_panic() {
    let text = include_str!("../scenes/lagoon.toml");
    for end in (0..text.len()).step_by(7) {
        let _ = read(&text[..end]);
    }
    for (start, character) in SOUND.char_indices() {
        for with in ["", "-", "\"", "[", "=", "9e99", "nan", "{"] {
            let mut damaged = SOUND.to_owned();
            damaged.replace_range(start..start + character.len_utf8(), with);
            if let Err(error) = read(&damaged) {
                check_sentence(&error);
            }
        }
    }
}

/// A scene whose last table holds the key `unknown`, and the heading of `FORMAT.md` that lists that table's keys.
const TABLES: &[(&str, &str)] = &[
    ("[film]", "## `[film]`"),
    ("[technique]", "## `[technique]`"),
    ("[[camera]]", "## `[[camera]]`"),
    ("[[medium]]", "## `[[medium]]`"),
    ("[[medium]]\nname = \"m\"\nindex = 1\n[medium.density]\nfile = \"f\"", "### `density` of a `file`"),
    ("[[medium]]\nname = \"m\"\nindex = 1\n[medium.density]\nkind = \"noise\"", "### `density` by `noise`"),
    ("[[material]]\nkind = \"diffuse\"", "### `diffuse`"),
    ("[[material]]\nkind = \"dielectric\"", "### `dielectric`"),
    ("[[material]]\nkind = \"mirror\"", "### `mirror`"),
    ("[[material]]\nkind = \"rough\"", "### `rough`"),
    ("[[light]]\nkind = \"point\"", "### `point`"),
    ("[[light]]\nkind = \"spot\"", "### `spot`"),
    ("[[light]]\nkind = \"directional\"", "### `directional`"),
    ("[[object]]\nshape = \"obj\"", "### `obj`"),
    ("[[object]]\nshape = \"plane\"", "### `plane`"),
    ("[[object]]\nshape = \"box\"", "### `box`"),
    ("[[object]]\nshape = \"sphere\"", "### `sphere`"),
    ("[[object]]\nshape = \"cylinder\"", "### `cylinder`"),
    ("[[object]]\nshape = \"heightfield\"", "### `heightfield`"),
    ("[[object]]\nname = \"o\"\nshape = \"plane\"\n[object.transform]", "### `transform`"),
    ("[[object]]\nname = \"o\"\nshape = \"heightfield\"\nx = [0, 1]\nz = [0, 1]\n[[object.waves]]", "### `waves`"),
    ("[[object]]\nname = \"o\"\nshape = \"heightfield\"\nx = [0, 1]\nz = [0, 1]\n[[object.bumps]]", "### `bumps`"),
    (
        "[[object]]\nname = \"o\"\nshape = \"heightfield\"\nx = [0, 1]\nz = [0, 1]\n[object.motion]\nkind = \"waves\"",
        "### `motion` by `waves`",
    ),
    (
        "[[object]]\nname = \"o\"\nshape = \"heightfield\"\nx = [0, 1]\nz = [0, 1]\n[object.motion]\nkind = \"simulated\"",
        "### `simulated` `motion`",
    ),
    (
        "[[object]]\nname = \"o\"\nshape = \"heightfield\"\nx = [0, 1]\nz = [0, 1]\n[object.motion]\nkind = \"simulated\"\nspeed = 1\n[[object.motion.drops]]",
        "### `drops`",
    ),
    (
        "[[object]]\nname = \"o\"\nshape = \"heightfield\"\nx = [0, 1]\nz = [0, 1]\n[object.motion]\nkind = \"simulated\"\nspeed = 1\n[object.motion.rain]",
        "### `rain`",
    ),
];

/// The first column under a heading of `FORMAT.md`.
fn documented(heading: &str) -> Vec<&'static str> {
    let format = include_str!("../scenes/FORMAT.md");
    let (_, section) = format.split_once(&format!("\n{heading}\n")).expect(heading);
    let section = section.split("\n##").next().unwrap();
    section.lines().filter_map(|line| line.strip_prefix("| `")?.split('`').next()).collect()
}

#[test]
fn the_documentation_lists_the_keys_that_are_allowed_and_no_others() {
    for (table, heading) in TABLES {
        // Objects name a material before their own tables are read.
        let text = format!("{table}\nunknown = 1\n").replace("name = \"o\"", "name = \"o\"\nmaterial = \"m\"");
        let text = format!("{text}[[material]]\nname = \"m\"\nkind = \"mirror\"\n");
        let error = read(&text).unwrap_err();
        let SceneError::UnknownKey { key, allowed, .. } = &error else { panic!("{table}: {error}") };
        assert_eq!(key, "unknown");
        let mut allowed: Vec<&str> = allowed.split(", ").collect();
        let mut documented = documented(heading);
        if table.starts_with("[[object]]\nshape") {
            documented.extend(self::documented("## `[[object]]`"));
        }
        allowed.sort_unstable();
        documented.sort_unstable();
        assert_eq!(allowed, documented, "{heading}");
    }
}

#[test]
fn values_are_converted_to_the_scenes_units() {
    let text = SOUND.replace(
        "kind = \"point\"\nposition = [0, 3, 0]\nintensity = 10",
        "kind = \"spot\"\nposition = [0, 3, 0]\ntarget = [0, 1, 0]\nintensity = [1, 2, 3]\nouter = 60\ninner = 30\n\
         [[light]]\nname = \"sun\"\nkind = \"directional\"\ndirection = [0, -2, 0]\nirradiance = 4\nmedium = \"water\"",
    );
    let lights = read(&text).unwrap().lights;
    let Emitter::Spot { direction, intensity, inner, outer, .. } = lights[0].emitter else { panic!() };
    assert_eq!((direction, intensity), (Vec3::NEG_Y, Vec3::new(1.0, 2.0, 3.0)));
    assert_eq!((inner, outer), (30f32.to_radians(), 60f32.to_radians()));
    assert_eq!(lights[1].emitter, Emitter::Directional { direction: Vec3::NEG_Y, irradiance: Vec3::splat(4.0) });
    assert_eq!((lights[0].medium, lights[1].medium), (0, 1));
}

#[test]
fn an_object_is_scaled_then_turned_about_x_y_z_then_moved() {
    let transform = "size = [4, 4]\ntransform = { translate = [10, 0, 0], rotate = [90, 90, 0], scale = [1, 2, 3] }";
    let scene = read(&SOUND.replace("size = [4, 4]", transform)).unwrap();
    // (0, 1, 0) doubles, turns about x onto +z, about y onto +x, and moves.
    let placed = scene.instances[0].transform.transform_point3(Vec3::Y);
    assert!((placed - Vec3::new(12.0, 0.0, 0.0)).length() < 1e-5, "{placed}");
}

#[test]
fn images_become_textures_and_reliefs() {
    let folder = tempfile::tempdir().unwrap();
    let colours = image::RgbImage::from_fn(2, 1, |x, _| image::Rgb(if x == 0 { [255, 188, 0] } else { [0; 3] }));
    colours.save(folder.path().join("colours.png")).unwrap();
    let ramp = image::ImageBuffer::from_fn(3, 2, |x, _| image::Luma([x as u16 * 32_767]));
    ramp.save(folder.path().join("ramp.png")).unwrap();
    std::fs::write(folder.path().join("text.png"), "no image").unwrap();
    let textured = SOUND.replace("albedo = 0.5", "texture = \"colours.png\"");
    let ground =
        "shape = \"heightfield\"\nx = [0, 2]\nz = [0, 1]\nquads = [2, 1]\nimage = { file = \"ramp.png\", height = 5 }";
    let text = textured.replace("shape = \"plane\"\nsize = [4, 4]", ground);
    let path = folder.path().join("scene.toml");
    let scene = parse(&text, &path).unwrap();
    let texture = &scene.textures[0];
    assert_eq!((texture.width, texture.height, texture.texels.len()), (2, 1, 2));
    // sRGB 188 is linear 0.5029.
    assert!((Vec3::from_array(texture.texels[0]) - Vec3::new(1.0, 0.5029, 0.0)).length() < 1e-3);
    let heights: Vec<f32> = scene.meshes[0].positions.iter().map(|position| position.y).collect();
    for (height, expected) in heights.iter().zip([0.0, 2.5, 5.0, 0.0, 2.5, 5.0]) {
        // 65535 is odd: the middle of the ramp is half a grey level low.
        assert!((height - expected).abs() < 1e-4, "{heights:?}");
    }
    let error = parse(&text.replace("ramp.png", "text.png"), &path).unwrap_err().to_string();
    let expected = format!(
        "scene.toml:26: `object.image.file` refers to {}, which is not a sound image: Format error decoding Png: Invalid PNG signature",
        folder.path().join("text.png").display()
    );
    assert!(error.ends_with(&expected), "{error}");
}

/// A spot light that projects an image, in place of the lamp.
const PROJECTOR: &str = "kind = \"spot\"\nposition = [0, 3, 0]\ntarget = [0, 1, 0]\nintensity = 1\nouter = 60\n\
                         image = \"slide.png\"\nup = [0, 1, 1]";

#[test]
fn a_spot_light_projects_an_image() {
    let folder = tempfile::tempdir().unwrap();
    image::RgbImage::from_pixel(3, 2, image::Rgb([255, 0, 0])).save(folder.path().join("slide.png")).unwrap();
    let path = folder.path().join("bad.toml");
    let text = SOUND.replace("kind = \"point\"\nposition = [0, 3, 0]\nintensity = 10", PROJECTOR);
    let scene = parse(&text, &path).unwrap();
    let Emitter::Spot { image: Some(image), direction, .. } = scene.lights[0].emitter else { panic!() };
    assert_eq!((image.texture, scene.textures[0].width, scene.textures[0].texels[0]), (0, 3, [1.0, 0.0, 0.0]));
    // Down, its top turned to +z: +x is then on its left.
    let [right, up] = image.axes(direction.as_dvec3());
    assert!((right - glam::DVec3::NEG_X).length() < 1e-6 && (up - glam::DVec3::Z).length() < 1e-6, "{right} {up}");

    let up = "a light whose `up` (0, 1, 0 if left out) is not along its axis";
    let cases = [
        ("outer = 60", "outer = 90", "31: `light.outer` is 90; allowed: a number from 0.1 to 89 beside `image`".into()),
        ("outer = 60", "outer = 0", "31: `light.outer` is 0; allowed: a number from 0.1 to 89 beside `image`".into()),
        (
            "image = \"slide.png\"\n",
            "",
            "32: `light.up` is the list [0, 1, 1]; allowed: this key beside `image` only".into(),
        ),
        ("up = [0, 1, 1]", "up = [0, 2, 0]", format!("33: `light.up` is the list [0, 2, 0]; allowed: {up}")),
        ("\nup = [0, 1, 1]", "", format!("29: `light.target` is the list [0, 1, 0]; allowed: {up}")),
        (
            "up = [0, 1, 1]",
            "up = [0, 1, 1]\nkeys = [{ time = 0 }, { time = 1, target = [0, 4, 1] }]",
            format!("34: `light.keys.target` is the list [0, 4, 1]; allowed: {up}"),
        ),
        (
            "slide.png",
            "none.png",
            format!(
                "32: `light.image` refers to {}, which cannot be read: there is no such file",
                folder.path().join("none.png").display()
            ),
        ),
    ];
    for (from, to, expected) in cases {
        assert!(text.contains(from), "{from}");
        let error = parse(&text.replace(from, to), &path).expect_err(to).to_string();
        assert!(error.ends_with(&format!("bad.toml:{expected}")), "{to}: {error}");
    }
}
