//! `[[object]]`: shapes made, files loaded, each placed in the world.

use std::ops::Range;

use glam::{Affine3A, BVec3, DVec2, DVec3, Vec3};

use super::animation::{Keys, Water, WaterMotion};
use super::error::SceneError;
use super::file::{find_name, read_name};
use super::height_field::{Bump, HeightField, Relief, Wave};
use super::keyed::{self, KEYED};
use super::obj::{self, Loaded};
use super::shapes::{Face, cuboid, cylinder, plane, sphere};
use super::value::{ANGLE, COORDINATE, LENGTH, Node, Table};
use super::{Bounds, Instance, MaterialId, Mesh, MeshId, Placement, Scene, mend, motion, texture, transform};

/// Quads along one side of a sheet: 2048 squared makes 8 million triangles, 0.24 GB on the host.
const MOST_QUADS: u32 = 2048;
/// Points are placed within this many metres of the origin, where f32 still resolves 6 cm.
const FARTHEST: f32 = 1e6;

const COMMON: &[&str] = &["name", "shape", "material", "transform"];

const NO_PLACE: &str = "a placement with all points within 1e6 of the origin";

#[derive(Clone, Copy)]
enum Shape {
    Obj,
    Plane,
    Box,
    Sphere,
    Cylinder,
    HeightField,
}

const SHAPES: [(&str, Shape); 6] = [
    ("obj", Shape::Obj),
    ("plane", Shape::Plane),
    ("box", Shape::Box),
    ("sphere", Shape::Sphere),
    ("cylinder", Shape::Cylinder),
    ("heightfield", Shape::HeightField),
];

impl Shape {
    fn keys(self) -> &'static [&'static str] {
        match self {
            Shape::Obj => &["file"],
            Shape::Plane => &["centre", "size", "subdivisions"],
            Shape::Box => &["centre", "size", "faces", "inward"],
            Shape::Sphere => &["centre", "radius", "segments"],
            Shape::Cylinder => &["centre", "radius", "height", "segments", "subdivisions"],
            Shape::HeightField => &["x", "z", "base", "quads", "waves", "bumps", "image", "motion"],
        }
    }

    fn title(self) -> &'static str {
        match self {
            Shape::Obj => "an obj [[object]]",
            Shape::Plane => "a plane [[object]]",
            Shape::Box => "a box [[object]]",
            Shape::Sphere => "a sphere [[object]]",
            Shape::Cylinder => "a cylinder [[object]]",
            Shape::HeightField => "a heightfield [[object]]",
        }
    }
}

/// Reads all objects into the scene; an OBJ file used twice is one mesh.
pub(super) fn read_all(nodes: &[Node], scene: &mut Scene) -> Result<(), SceneError> {
    let mut files = Vec::new();
    let mut names: Vec<String> = Vec::new();
    for node in nodes {
        let shape = node
            .any_table("[[object]]")?
            .need("shape", "\"obj\", \"plane\", \"box\", \"sphere\", \"cylinder\", \"heightfield\"")?
            .choice(&SHAPES)?;
        let table = node.table(shape.title(), &[COMMON, KEYED, shape.keys()].concat())?;
        let name = read_name(&table, "object", names.iter().map(String::as_str))?;
        let own = table.or("transform", Placement::IDENTITY, |node| transform::read(&node))?;
        let first = scene.instances.len();
        read(&table, shape, &name, own.transform(), &mut files, scene)?;
        let keys = read_keys(&table, &own, first..scene.instances.len(), scene)?;
        scene.animation.objects.extend(keys);
        names.push(name);
    }
    Ok(())
}

/// The keys of the object that made the instances `of`; `own` is its own placement.
fn read_keys(
    table: &Table,
    own: &Placement,
    of: Range<usize>,
    scene: &Scene,
) -> Result<Option<Keys<Placement>>, SceneError> {
    let meshes = || scene.instances[of.clone()].iter().map(|instance| &scene.meshes[instance.mesh]);
    let boxes: Vec<[Vec3; 8]> = meshes().map(corners).collect();
    let waves: Vec<[Vec3; 8]> =
        scene.instances[of.clone()].iter().filter_map(|i| waves_corners(scene, i.mesh)).collect();
    keyed::read(table, of.clone(), "a key of an [[object]]", transform::KEYS, |node, key| {
        let placement = transform::read_pose(key, own)?;
        let transform = placement.transform();
        // A mesh may have millions of points, and an object many keys.
        let near =
            |(mesh, corners): (&Mesh, &[Vec3; 8])| are_near(corners, transform) || are_near(&mesh.positions, transform);
        let waves_near = waves.iter().all(|corners| are_near(corners, transform));
        if waves_near && meshes().zip(&boxes).all(near) { Ok(placement) } else { Err(node.refuse(NO_PLACE)) }
    })
}

fn read(
    table: &Table,
    shape: Shape,
    name: &str,
    placement: Affine3A,
    files: &mut Vec<Loaded>,
    scene: &mut Scene,
) -> Result<(), SceneError> {
    let materials = scene.materials.iter().map(|material| material.name.as_str());
    let material = match table.get("material") {
        Some(node) => Some(find_name(&node, "material", materials)?),
        None => None,
    };

    if let Shape::Obj = shape {
        let file = table.need("file", "the name of an OBJ file")?;
        for (mesh, material) in obj::read(&file, material, files, scene)? {
            place(table, scene, name, mesh, material, placement)?;
        }
        return Ok(());
    }
    let Some(material) = material else {
        table.need("material", "the name of a material")?;
        return Ok(());
    };
    let field = match shape {
        Shape::HeightField => Some(read_height_field(table)?),
        _ => None,
    };
    let mut mesh = match shape {
        Shape::Plane => read_plane(table, name)?,
        Shape::Box => read_box(table, name)?,
        Shape::Sphere => read_sphere(table, name)?,
        Shape::Cylinder => read_cylinder(table, name)?,
        Shape::HeightField | Shape::Obj => field.as_ref().map(|field| field.mesh(name)).unwrap_or_default(),
    };
    let dropped = mend::drop_degenerate(&mut mesh);
    if dropped > 0 {
        scene.warnings.push(mend::dropped_warning(&format!("object \"{name}\""), dropped));
    }
    if mesh.triangles.is_empty() {
        return Err(table.need("shape", "")?.refuse("a size at which f32 coordinates tell its vertices apart"));
    }
    scene.meshes.push(mesh);
    if let (Some(field), Some(node)) = (field, table.get("motion")) {
        let motion = motion::read(&node, &field, scene.animation.fps)?;
        scene.animation.waters.push(Water { mesh: scene.meshes.len() - 1, field, motion });
    }
    place(table, scene, name, scene.meshes.len() - 1, material, placement)
}

fn place(
    table: &Table,
    scene: &mut Scene,
    name: &str,
    mesh: MeshId,
    material: MaterialId,
    transform: Affine3A,
) -> Result<(), SceneError> {
    let waves_near = waves_corners(scene, mesh).is_none_or(|corners| are_near(&corners, transform));
    if !waves_near || !are_near(&scene.meshes[mesh].positions, transform) {
        let node = table.get("transform").map_or_else(|| table.need("name", ""), Ok)?;
        return Err(node.refuse(NO_PLACE));
    }
    scene.instances.push(Instance { name: name.to_owned(), mesh, material, transform });
    Ok(())
}

/// Whether all points, once placed, are near enough to the origin.
fn are_near(points: &[Vec3], transform: Affine3A) -> bool {
    points.iter().all(|&point| transform.transform_point3(point).abs().max_element() <= FARTHEST)
}

/// Of the box that holds the mesh.
fn corners(mesh: &Mesh) -> [Vec3; 8] {
    let mut bounds = Bounds::EMPTY;
    mesh.positions.iter().for_each(|&point| bounds.include(point));
    corners_of(&bounds)
}

/// Of a box that holds a mesh of travelling waves at every time.
fn waves_corners(scene: &Scene, mesh: MeshId) -> Option<[Vec3; 8]> {
    let water = scene.animation.waters.iter().find(|water| water.mesh == mesh)?;
    let WaterMotion::Waves { .. } = water.motion else { return None };
    let HeightField { x, z, base, .. } = &water.field;
    let most = water.field.most_above_base();
    let mut bounds = Bounds::EMPTY;
    for k in 0..2 {
        bounds.include(DVec3::new(x[k], [base - most, base + most][k], z[k]).as_vec3());
    }
    Some(corners_of(&bounds))
}

fn corners_of(bounds: &Bounds) -> [Vec3; 8] {
    std::array::from_fn(|k| Vec3::select(BVec3::new(k & 1 > 0, k & 2 > 0, k & 4 > 0), bounds.max, bounds.min))
}

fn centre(table: &Table) -> Result<DVec3, SceneError> {
    table.or("centre", DVec3::ZERO, |node| node.vec3(COORDINATE))
}

fn segments(table: &Table, default: u32) -> Result<u32, SceneError> {
    table.or("segments", default, |node| node.whole(3, 2 * MOST_QUADS))
}

fn read_plane(table: &Table, name: &str) -> Result<Mesh, SceneError> {
    let size = table.need("size", "a list of two numbers")?.vec2(LENGTH)?;
    let subdivisions = table.or("subdivisions", [1, 1], |node| node.whole_pair(1, MOST_QUADS))?;
    Ok(plane(name, centre(table)?, size, subdivisions))
}

fn read_box(table: &Table, name: &str) -> Result<Mesh, SceneError> {
    let size = table.need("size", "a number, or a list of three")?.triple(LENGTH)?;
    let inward = table.or("inward", false, |node| node.flag())?;
    let faces = table.or("faces", Face::ALL.map(|(_, face)| face).to_vec(), |node| read_faces(&node))?;
    Ok(cuboid(name, centre(table)?, size, &faces, inward))
}

fn read_faces(node: &Node) -> Result<Vec<Face>, SceneError> {
    let words = "one to six different faces out of \"-x\", \"+x\", \"-y\", \"+y\", \"-z\", \"+z\"";
    let mut faces = Vec::new();
    for item in node.list(words)? {
        let face = item.choice(&Face::ALL)?;
        if faces.contains(&face) {
            return Err(node.refuse(words));
        }
        faces.push(face);
    }
    if faces.is_empty() { Err(node.refuse(words)) } else { Ok(faces) }
}

fn read_sphere(table: &Table, name: &str) -> Result<Mesh, SceneError> {
    let radius = table.need("radius", "a number of metres")?.number(LENGTH)?;
    Ok(sphere(name, centre(table)?, radius, segments(table, 128)?))
}

fn read_cylinder(table: &Table, name: &str) -> Result<Mesh, SceneError> {
    let radius = table.need("radius", "a number of metres")?.number(LENGTH)?;
    let height = table.need("height", "a number of metres")?.number(LENGTH)?;
    let subdivisions = table.or("subdivisions", 1, |node| node.whole(1, MOST_QUADS))?;
    Ok(cylinder(name, centre(table)?, radius, height, segments(table, 256)?, subdivisions))
}

fn read_height_field(table: &Table) -> Result<HeightField, SceneError> {
    Ok(HeightField {
        x: read_side(table, "x")?,
        z: read_side(table, "z")?,
        quads: table.or("quads", [256, 256], |node| node.whole_pair(1, MOST_QUADS))?,
        base: table.or("base", 0.0, |node| node.number(COORDINATE))?,
        waves: read_each(table, "waves", read_wave)?,
        bumps: read_each(table, "bumps", |node| read_bump(&node.table("a bump", BUMP_KEYS)?))?,
        relief: table.get("image").map(|node| read_relief(&node)).transpose()?,
    })
}

fn read_side(table: &Table, key: &str) -> Result<[f64; 2], SceneError> {
    let node = table.need(key, "a list of two numbers, first and last")?;
    let DVec2 { x: first, y: last } = node.vec2(COORDINATE)?;
    if last - first < 1e-6 {
        return Err(node.refuse("a first number at least 1e-6 below the last"));
    }
    Ok([first, last])
}

/// The tables of the list `key`, none where there is no such key.
pub(super) fn read_each<T>(
    table: &Table,
    key: &str,
    read: fn(&Node) -> Result<T, SceneError>,
) -> Result<Vec<T>, SceneError> {
    table.get(key).map_or(Ok(Vec::new()), |node| node.list("tables")?.iter().map(read).collect())
}

fn read_wave(node: &Node) -> Result<Wave, SceneError> {
    let table = node.table("a wave", &["wavelength", "amplitude", "direction", "phase"])?;
    Ok(Wave {
        wavelength: table.need("wavelength", "a number of metres")?.number(LENGTH)?,
        amplitude: table.need("amplitude", "a number of metres")?.number(COORDINATE)?,
        direction: table.or("direction", 0.0, |node| node.number(ANGLE))?,
        phase: table.or("phase", 0.0, |node| node.number(ANGLE))?,
    })
}

pub(super) const BUMP_KEYS: &[&str] = &["centre", "height", "radius"];

pub(super) fn read_bump(table: &Table) -> Result<Bump, SceneError> {
    Ok(Bump {
        centre: table.need("centre", "a list of two numbers, x and z")?.vec2(COORDINATE)?,
        height: table.need("height", "a number of metres")?.number(COORDINATE)?,
        radius: table.need("radius", "a number of metres")?.number(LENGTH)?,
    })
}

fn read_relief(node: &Node) -> Result<Relief, SceneError> {
    let table = node.table("`image`", &["file", "height"])?;
    let file = table.need("file", "the name of a PNG or JPEG file")?;
    let height = table.need("height", "a number of metres")?.number(COORDINATE)?;
    let (columns, rows, values) = texture::read_grey(&file)?;
    if columns < 2 || rows < 2 {
        let problem = format!("is {columns} x {rows} pixels; allowed: at least 2 x 2");
        return Err(texture::refuse(&file, texture::referred(&file)?, problem));
    }
    Ok(Relief { columns, rows, values, height })
}
