//! OBJ and MTL files: what is mended, what is mapped, and the sentence for each thing that is refused.

use std::path::PathBuf;

use glam::Vec3;
use nephroid::scene::adjacency::Adjacency;
use nephroid::scene::{Scene, SceneError, Surface, load};
use tempfile::TempDir;

const REST: &str = r#"
[[camera]]
name = "eye"
position = [0, 1, 4]
target = [0, 0, 0]
[[material]]
name = "sand"
kind = "diffuse"
albedo = 0.5
[[light]]
name = "sun"
kind = "directional"
direction = [0, -1, 0]
irradiance = 1
"#;

/// Line 1 of the scene is the object's header, line 4 its file.
const WITH_MATERIAL: &str =
    "[[object]]\nname = \"thing\"\nshape = \"obj\"\nfile = \"thing.obj\"\nmaterial = \"sand\"\n";
const WITHOUT_MATERIAL: &str = "[[object]]\nname = \"thing\"\nshape = \"obj\"\nfile = \"thing.obj\"\n";

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

struct Folder(TempDir);

impl Folder {
    fn with(files: &[(&str, &str)]) -> Self {
        let folder = Folder(tempfile::tempdir().unwrap());
        for (name, text) in files {
            std::fs::write(folder.path(name), text).unwrap();
        }
        folder
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn load(&self, objects: &str) -> Result<Scene, SceneError> {
        std::fs::write(self.path("scene.toml"), format!("{objects}{REST}")).unwrap();
        load(&self.path("scene.toml"))
    }

    /// The sentence, with this folder's name cut out.
    fn sentence(&self, objects: &str) -> String {
        let sentence = self.load(objects).expect_err(objects).to_string();
        sentence.replace(&format!("{}/", self.0.path().display()), "")
    }
}

fn scene_of(obj: &str) -> Scene {
    Folder::with(&[("thing.obj", obj)]).load(WITH_MATERIAL).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn each_broken_obj_has_its_sentence() {
    let cases = [
        (
            "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n",
            "thing.obj:4: `f` has the corner \"4\"; allowed: a `v` index from 1 to 3 or from -3 to -1, as 3 precede it",
        ),
        (
            "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 0 1 2\n",
            "thing.obj:4: `f` has the corner \"0\"; allowed: a `v` index from 1 to 3 or from -3 to -1, as 3 precede it",
        ),
        (
            "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -4 1 2\n",
            "thing.obj:4: `f` has the corner \"-4\"; allowed: a `v` index from 1 to 3 or from -3 to -1, as 3 precede it",
        ),
        (
            "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 -9223372036854775808\n",
            "thing.obj:4: `f` has the corner \"-9223372036854775808\"; allowed: a `v` index from 1 to 3 or from -3 to -1, as 3 precede it",
        ),
        (
            "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1/1 2/1 3/1\n",
            "thing.obj:4: `f` has the corner \"1/1\"; allowed: no `vt` index, as no `vt` precedes it",
        ),
        (
            "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2//2 3//1\n",
            "thing.obj:5: `f` has the corner \"2//2\"; allowed: a `vn` index of 1 or -1, as one precedes it",
        ),
        (
            "v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n",
            "thing.obj:2: `v` is \"nan 0 0\"; allowed: 3 numbers from -1e9 to 1e9",
        ),
        ("v 0 0 0\nv 1 0\nv 0 1 0\nf 1 2 3\n", "thing.obj:2: `v` is \"1 0\"; allowed: 3 numbers from -1e9 to 1e9"),
        (
            "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 inf 0\nf 1 2 3\n",
            "thing.obj:4: `vn` is \"0 inf 0\"; allowed: 3 numbers from -1e9 to 1e9",
        ),
        ("v 0 0 0\nv 1 0 0\nf 1 2\n", "thing.obj:3: `f` has 2 corners; allowed: 3 to 1024"),
        (
            "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1/2/3/4 2 3\n",
            "thing.obj:4: `f` has the corner \"1/2/3/4\"; allowed: v, v/vt, v//vn or v/vt/vn",
        ),
        (
            "v 0 0 0\n",
            "scene.toml:4: `object.file` refers to thing.obj, which holds no face; allowed: at least one triangle",
        ),
        ("", "scene.toml:4: `object.file` refers to thing.obj, which holds no face; allowed: at least one triangle"),
        (
            "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n",
            "scene.toml:4: `object.file` refers to thing.obj, which holds degenerate triangles only; allowed: at least one with an area",
        ),
    ];
    for (obj, expected) in cases {
        assert_eq!(Folder::with(&[("thing.obj", obj)]).sentence(WITH_MATERIAL), expected, "{obj}");
    }
    let expected = "scene.toml:4: `object.file` refers to thing.obj, which cannot be read: there is no such file";
    assert_eq!(Folder::with(&[]).sentence(WITH_MATERIAL), expected);
}

#[test]
fn each_broken_mtl_has_its_sentence() {
    let obj = format!("mtllib thing.mtl\nusemtl paint\n{TRIANGLE}");
    let cases = [
        ("newmtl paint\nKd 0.5\n", "thing.mtl:2: `Kd` is \"0.5\"; allowed: three numbers from 0 to 1"),
        ("newmtl paint\nKd 0.5 nan 0\n", "thing.mtl:2: `Kd` is \"0.5 nan 0\"; allowed: three numbers from 0 to 1"),
        ("newmtl paint\nNi\n", "thing.mtl:2: `Ni` is \"\"; allowed: a number from 0.001 to 10"),
        ("newmtl\n", "thing.mtl:1: `newmtl` is \"\"; allowed: the name of a material"),
        ("newmtl rust\n", "thing.obj:2: `usemtl` names \"paint\", which no `mtllib` holds; known: rust"),
        ("newmtl paint\nillum 7\n", "thing.mtl:1: the glass \"paint\" lacks `Ni`; allowed: a number from 1 to 10"),
        (
            "newmtl paint\nmap_Kd no.png\n",
            "thing.mtl:1: `map_Kd` refers to no.png, which cannot be read: there is no such file",
        ),
        (
            "newmtl paint\nmap_Kd folder\\no.png\n",
            "thing.mtl:1: `map_Kd` refers to folder/no.png, which cannot be read: there is no such file",
        ),
    ];
    for (mtl, expected) in cases {
        let folder = Folder::with(&[("thing.obj", &obj), ("thing.mtl", mtl)]);
        assert_eq!(folder.sentence(WITHOUT_MATERIAL), expected, "{mtl}");
    }
    let expected = "thing.obj:1: `mtllib` thing.mtl cannot be read: there is no such file";
    assert_eq!(Folder::with(&[("thing.obj", &obj)]).sentence(WITHOUT_MATERIAL), expected);
    let expected = "thing.obj:4: `f` has no material; allowed: faces after a `usemtl`, or a `material` for the object at scene.toml:4";
    assert_eq!(Folder::with(&[("thing.obj", TRIANGLE)]).sentence(WITHOUT_MATERIAL), expected);
}

#[test]
fn mtl_materials_become_surfaces_and_split_the_mesh() {
    let mtl = "newmtl paint\nKd 0.1 0.2 0.3\nnewmtl silver\nillum 3\nKs 0.9 0.8 0.7\nnewmtl glass\nd 0.1\nNi 1.5\nillum 2\n\
               newmtl water\nillum 7\nNi 1.33\nnewmtl veil\nd 0.5\n";
    let mut obj = "mtllib thing.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\n".to_owned();
    for name in ["paint", "silver", "glass", "water", "veil", "paint"] {
        obj.push_str(&format!("usemtl {name}\nf 1 2 3\nf 2 4 3\n"));
    }
    let folder = Folder::with(&[("thing.obj", &obj), ("thing.mtl", mtl)]);
    let scene = folder.load(WITHOUT_MATERIAL).unwrap();
    let surfaces: Vec<&Surface> =
        scene.instances.iter().map(|instance| &scene.materials[instance.material].surface).collect();
    assert_eq!(
        surfaces,
        [
            &Surface::Diffuse { albedo: Vec3::new(0.1, 0.2, 0.3), texture: None },
            &Surface::Mirror { reflectance: Vec3::new(0.9, 0.8, 0.7) },
            &Surface::Dielectric { front: 0, back: 1 },
            &Surface::Dielectric { front: 0, back: 2 },
            &Surface::Diffuse { albedo: Vec3::splat(0.8), texture: None },
        ]
    );
    assert_eq!(scene.media.iter().map(|medium| medium.index).collect::<Vec<_>>(), [1.0, 1.5, 1.33]);
    let sizes: Vec<usize> = scene.meshes.iter().map(|mesh| mesh.triangles.len()).collect();
    assert_eq!(sizes, [4, 2, 2, 2, 2]);
    let mtl = folder.path("thing.mtl");
    assert_eq!(scene.warnings, [format!("{}:13: drawn opaque, as it has `d` and no `Ni`", mtl.display())]);

    let scene = folder.load(WITH_MATERIAL).unwrap();
    assert_eq!((scene.meshes.len(), scene.instances.len(), scene.meshes[0].triangles.len()), (1, 1, 12));
    assert_eq!(scene.materials[scene.instances[0].material].name, "sand");
}

#[test]
fn polygons_are_cut_and_groups_joined() {
    // A house: five corners, the wall to its right a quad of another group, indices from the end.
    let scene = scene_of(
        "o house\nv 0 0 0 1 0 0\nv 1 0 0\nv 1 1 0\nv 0.5 1.5 0\nv 0 1 0\nf 1 2 \\\n 3 4 5 # front\ng side\nv 1 0 -2\nv 1 1 -2\n\
         f 2 -2 -1 3\ns off\nl 1 2\n",
    );
    let mesh = &scene.meshes[0];
    assert_eq!((scene.meshes.len(), mesh.triangles.len()), (1, 5));
    let adjacency = Adjacency::of(mesh);
    assert_eq!((adjacency.boundary_edges, adjacency.inner_edges, adjacency.flipped_edges), (7, 4, 0));
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
}

#[test]
fn missing_normals_are_smooth_where_faces_share_a_position_index_only() {
    // Two triangles at right angles; each corner of the shared edge sees one 45 degree angle of either.
    let shared = scene_of("v 0 0 0\nv 0 0 1\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 4 2\n");
    let expected = Vec3::new(1.0, 1.0, 0.0).normalize();
    for vertex in [1, 2].map(|place| shared.meshes[0].triangles[1][if place == 1 { 0 } else { 2 }] as usize) {
        assert!((shared.meshes[0].normals[vertex] - expected).length() < 1e-6, "{}", shared.meshes[0].normals[vertex]);
    }
    let split = scene_of("v 0 0 0\nv 0 0 1\nv 1 0 0\nv 0 1 0\nv 0 0 0\nv 0 0 1\nf 1 2 3\nf 5 4 6\n");
    let normals = &split.meshes[0].normals;
    assert!(normals[..3].iter().all(|n| *n == Vec3::Y) && normals[3..].iter().all(|n| *n == Vec3::X), "{normals:?}");
    assert!(split.warnings.is_empty());
}

#[test]
fn what_is_mended_is_told() {
    let cases = [
        (
            "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 2 0 0\nf 1 2 3\nf 1 2 4\nf 1 1 3\n",
            "dropped 2 degenerate triangles, which have no area",
        ),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 -1\nf 1//1 2//1 3//1\n", "turned 3 normals to the front of their faces"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 0\nf 1//1 2//1 3//1\n", "computed 3 normals that had length 0"),
        (
            "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvn 1 0 1\nf 1//1 2//1 3//1\nf 2 4 3\n",
            "computed all normals, as only 1 of 2 faces have them",
        ),
        (
            "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvt 0.5 0.5\nf 1/1 2/1 3/1\nf 2 4 3\n",
            "dropped texture coordinates, as only 1 of 2 faces have them",
        ),
    ];
    for (obj, told) in cases {
        let folder = Folder::with(&[("thing.obj", obj)]);
        let scene = folder.load(WITH_MATERIAL).unwrap();
        assert_eq!(scene.warnings, [format!("{}: {told}", folder.path("thing.obj").display())]);
        let mesh = &scene.meshes[0];
        for vertex in mesh.triangles.iter().flatten() {
            assert!((mesh.normals[*vertex as usize] - Vec3::Z).length() < 1e-6, "{told}");
        }
        assert!(mesh.uvs.iter().all(|uv| *uv == glam::Vec2::ZERO), "{told}");
    }
}

#[test]
fn a_file_used_twice_is_one_mesh() {
    let second = "[[object]]\nname = \"other\"\nshape = \"obj\"\nfile = \"thing.obj\"\nmaterial = \"sand\"\n\
                  transform = { translate = [0, 2, 0], rotate = { axis = [0, 0, 1], angle = 90 }, scale = 2 }\n";
    let folder = Folder::with(&[("thing.obj", TRIANGLE)]);
    let scene = folder.load(&format!("{WITH_MATERIAL}{second}")).unwrap();
    assert_eq!((scene.meshes.len(), scene.instances.len()), (1, 2));
    let placed = scene.instances[1].transform.transform_point3(Vec3::X);
    assert!((placed - Vec3::new(0.0, 4.0, 0.0)).length() < 1e-6, "{placed}");
}

#[test]
fn no_damage_of_an_obj_or_mtl_makes_the_reader_panic() {
    let obj =
        "mtllib thing.mtl\nusemtl a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\nf 1/1/1 2/1/1 3/1/1\nf -1 -2 -3\n";
    let mtl = "newmtl a\nKd 1 0 0\nNi 1.5\nd 0.5\nillum 7\nmap_Kd a.png\n";
    let folder = Folder::with(&[("thing.obj", obj), ("thing.mtl", mtl)]);
    for (name, sound) in [("thing.obj", obj), ("thing.mtl", mtl)] {
        for start in 0..sound.len() {
            for with in ["", "-", "/", "9e99", "18446744073709551615", "\\", "\n"] {
                let mut damaged = sound.to_owned();
                damaged.replace_range(start..start + 1, with);
                std::fs::write(folder.path(name), damaged).unwrap();
                let _ = folder.load(WITHOUT_MATERIAL);
                let _ = folder.load(WITH_MATERIAL);
            }
        }
        std::fs::write(folder.path(name), sound).unwrap();
    }
}
