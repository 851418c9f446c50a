//! `nephroid volume`: files that pictures are made from, and what is refused.

use std::fs;

use crate::program::Folder;

#[test]
fn a_picture_is_the_same_from_a_file() {
    let folder = Folder::new();
    let out = folder.run("volume scene.toml -o pond.volumes --set eikonal.resolution=24").stdout;
    assert!(out.contains("Volume  lamp: 24 x "), "{out}");
    assert!(out.contains("Wrote   "), "{out}");
    let render = "render scene.toml --technique eikonal --camera under --samples 1 --quiet";
    folder.run(&format!("{render} --set eikonal.resolution=24 -o solved.png"));
    folder.run(&format!("{render} --set eikonal.read=pond.volumes -o read.png"));
    let pixels = |name: &str| image::open(folder.at(name)).unwrap().into_rgb8().into_raw();
    assert_eq!(pixels("solved.png"), pixels("read.png"));
    assert!(pixels("read.png").iter().any(|&value| value > 20), "there is light");
    assert_eq!(folder.run("volume scene.toml -o pond.volumes --set eikonal.resolution=16 --quiet").stdout, "");
}

#[test]
fn what_is_wrong_is_said() {
    let folder = Folder::new();
    let said = |arguments: &str| folder.refused(folder.command(arguments.split_whitespace()), 1);
    let render = "render scene.toml -o kept.exr --technique eikonal --set eikonal.read=";
    assert!(said(&format!("{render}gone.volumes")).starts_with("nephroid: gone.volumes: cannot be read: "));
    assert!(
        said(&format!("{render}scene.toml")).starts_with("nephroid: scene.toml: is not a file of volumes: "),
        "a scene is none"
    );
    assert_eq!(
        said("volume scene.toml -o scene.toml"),
        "nephroid: scene.toml: the scene and --output name the same file; each needs its own\n"
    );
    assert_eq!(
        said("volume scene.toml -o kept.exr --set eikonal.resolution=7"),
        "nephroid: eikonal.resolution is \"7\"; allowed is an integer from 8 to 1024\n"
    );
    let text = fs::read_to_string(folder.at("scene.toml")).unwrap().replace("back = \"water\"", "back = \"air\"");
    fs::write(
        folder.at("dry.toml"),
        text.replace("kind = \"dielectric\"", "kind = \"mirror\"").replace("back = \"air\"", ""),
    )
    .unwrap();
    assert_eq!(
        said("volume dry.toml -o kept.exr"),
        "nephroid: dry.toml: no light shines through a refracting surface on anything, so there is no volume to write\n"
    );
}
