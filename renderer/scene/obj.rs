//! Wavefront OBJ through `tobj`.

use std::collections::HashMap;
use std::fmt::Write;
use std::path::PathBuf;

use glam::{DVec3, Vec2, Vec3};

use super::error::{SceneError, io_reason};
use super::obj_check::{Outline, check, logical_lines};
use super::value::Node;
use super::{MaterialId, Mesh, MeshId, Scene, mend, mtl, polygon, texture};

/// A file that is in the scene already.
pub(super) struct Loaded {
    file: PathBuf,
    material: Option<MaterialId>,
    meshes: Vec<(MeshId, MaterialId)>,
}

/// The meshes of the file that `node` names, each with its material: one mesh where `material` is given, else one for
/// each material of its MTL files.
pub(super) fn read(
    node: &Node,
    material: Option<MaterialId>,
    loaded: &mut Vec<Loaded>,
    scene: &mut Scene,
) -> Result<Vec<(MeshId, MaterialId)>, SceneError> {
    let file = texture::referred(node)?;
    if let Some(known) = loaded.iter().find(|known| known.file == file && known.material == material) {
        return Ok(known.meshes.clone());
    }
    let refuse = |problem| texture::refuse(node, file.clone(), problem);
    let bytes = std::fs::read(&file).map_err(|error| refuse(format!("cannot be read: {}", io_reason(&error))))?;
    let text = String::from_utf8_lossy(&bytes);
    let lines = logical_lines(&text);
    let outline = check(&file, &lines)?;
    if outline.faces == 0 {
        return Err(refuse("holds no face; allowed: at least one triangle".to_owned()));
    }
    let libraries = match material {
        Some(_) => Vec::new(),
        None => outline.materials(&file, node)?,
    };
    let models = run_tobj(&normalised(&lines, &outline, material.is_none()), &libraries)
        .map_err(|error| refuse(format!("tobj cannot read: {error}")))?;

    let mut meshes = Vec::new();
    for (index, part) in group(models) {
        let name = match index {
            Some(index) => format!("{}:{}", file.display(), libraries[index].material.name),
            None => file.display().to_string(),
        };
        let material = match (material, index) {
            (Some(material), _) => material,
            (None, Some(index)) => mtl::add(&libraries[index], &name, scene)?,
            (None, None) => return Err(refuse("has faces without a material".to_owned())),
        };
        let mesh = assemble(&name, &part, &outline, &mut scene.warnings);
        if !mesh.triangles.is_empty() {
            scene.meshes.push(mesh);
            meshes.push((scene.meshes.len() - 1, material));
        }
    }
    if meshes.is_empty() {
        return Err(refuse("holds degenerate triangles only; allowed: at least one with an area".to_owned()));
    }
    loaded.push(Loaded { file, material, meshes: meshes.clone() });
    Ok(meshes)
}

/// The checked lines with what `tobj` needs only: one group, and no attribute that some faces lack, since it would make
/// one up for them.
fn normalised(lines: &[(u32, String)], outline: &Outline, with_materials: bool) -> String {
    let mut text = String::new();
    if with_materials {
        text.push_str("mtllib all\n");
    }
    for (_, line) in lines {
        let mut words = line.split_whitespace();
        match words.next() {
            // Colours or weights after the position are not wanted.
            Some(keyword @ ("v" | "vn")) if keyword == "v" || outline.has_normals() => {
                let numbers: Vec<&str> = words.take(3).collect();
                let _ = writeln!(text, "{keyword} {}", numbers.join(" "));
            }
            Some("vt") if outline.has_uvs() => {
                let [u, v] = [words.next().unwrap_or("0"), words.next().unwrap_or("0")];
                let _ = writeln!(text, "vt {u} {v}");
            }
            Some("f") => {
                text.push('f');
                for corner in words {
                    let mut fields = corner.split('/').map(str::to_owned);
                    let mut field = |wanted: bool| fields.next().filter(|_| wanted).unwrap_or_default();
                    let [v, vt, vn] = [field(true), field(outline.has_uvs()), field(outline.has_normals())];
                    let _ = write!(text, " {v}/{vt}/{vn}");
                }
                text.push('\n');
            }
            Some("usemtl") if with_materials => {
                let _ = writeln!(text, "{line}");
            }
            _ => {}
        }
    }
    text
}

fn run_tobj(text: &str, entries: &[mtl::Entry]) -> Result<Vec<tobj::Mesh>, tobj::LoadError> {
    let options = tobj::LoadOptions { ignore_points: true, ignore_lines: true, ..Default::default() };
    let (models, _) = tobj::load_obj_buf(&mut text.as_bytes(), &options, |_| {
        let materials: Vec<tobj::Material> = entries.iter().map(|entry| entry.material.clone()).collect();
        let places = materials.iter().enumerate().map(|(place, material)| (material.name.clone(), place)).collect();
        Ok((materials, places))
    })?;
    Ok(models.into_iter().map(|model| model.mesh).collect())
}

/// Parts of equal material side by side, in the order of their first face.
fn group(meshes: Vec<tobj::Mesh>) -> Vec<(Option<usize>, Vec<tobj::Mesh>)> {
    let mut groups: Vec<(Option<usize>, Vec<tobj::Mesh>)> = Vec::new();
    for mesh in meshes.into_iter().filter(|mesh| !mesh.indices.is_empty()) {
        match groups.iter_mut().find(|(material, _)| *material == mesh.material_id) {
            Some((_, parts)) => parts.push(mesh),
            None => groups.push((mesh.material_id, vec![mesh])),
        }
    }
    groups
}

/// One mesh of parts whose positions, normals and texture coordinates have indices of their own.
fn assemble(name: &str, parts: &[tobj::Mesh], outline: &Outline, warnings: &mut Vec<String>) -> Mesh {
    let mut mesh = Mesh { name: name.to_owned(), ..Mesh::default() };
    // The position each vertex came from: faces that share it are smooth across their edge.
    let mut smoothing = Vec::new();
    let mut first_position = 0;
    for part in parts {
        let mut known = HashMap::new();
        let corners: Vec<u32> = (0..part.indices.len())
            .map(|corner| {
                let indices = |of: &[u32]| of.get(corner).copied().unwrap_or(0) as usize;
                let [v, vt, vn] =
                    [indices(&part.indices), indices(&part.texcoord_indices), indices(&part.normal_indices)];
                *known.entry([v, vt, vn]).or_insert_with(|| {
                    mesh.positions.push(Vec3::from_array(take(&part.positions, v)));
                    mesh.uvs.push(Vec2::from_array(take(&part.texcoords, vt)));
                    mesh.normals.push(Vec3::from_array(take(&part.normals, vn)).normalize_or_zero());
                    smoothing.push((first_position + v) as u32);
                    mesh.positions.len() as u32 - 1
                })
            })
            .collect();
        first_position += part.positions.len() / 3;

        let mut start = 0;
        for arity in arities(part) {
            let face = &corners[start..(start + arity).min(corners.len())];
            let points: Vec<DVec3> = face.iter().map(|&vertex| mesh.positions[vertex as usize].as_dvec3()).collect();
            mesh.triangles.extend(polygon::triangulate(&points).iter().map(|triangle| triangle.map(|k| face[k])));
            start += arity;
        }
    }
    mend_all(&mut mesh, &smoothing, outline, warnings);
    mesh
}

/// Corners of each face; `tobj` gives none where all are triangles.
fn arities(part: &tobj::Mesh) -> Vec<usize> {
    if part.face_arities.is_empty() {
        return vec![3; part.indices.len() / 3];
    }
    part.face_arities.iter().map(|&arity| arity as usize).collect()
}

/// N numbers from place `index` of a flat list, zeros past its end.
fn take<const N: usize>(flat: &[f32], index: usize) -> [f32; N] {
    let start = index * N;
    flat.get(start..start + N).and_then(|numbers| numbers.try_into().ok()).unwrap_or([0.0; N])
}

fn mend_all(mesh: &mut Mesh, smoothing: &[u32], outline: &Outline, warnings: &mut Vec<String>) {
    let dropped = mend::drop_degenerate(mesh);
    if dropped > 0 {
        warnings.push(mend::dropped_warning(&mesh.name, dropped));
    }
    let name = &mesh.name;
    if !outline.has_normals() && outline.with_normal > 0 {
        let (some, all) = (outline.with_normal, outline.faces);
        warnings.push(format!("{name}: computed all normals, as only {some} of {all} faces have them"));
    }
    if !outline.has_uvs() && outline.with_uv > 0 {
        let (some, all) = (outline.with_uv, outline.faces);
        warnings.push(format!("{name}: dropped texture coordinates, as only {some} of {all} faces have them"));
    }
    let computed = mend::smooth_normals(&mesh.positions, &mesh.triangles, smoothing);
    let mut zeros = 0;
    for (normal, computed) in mesh.normals.iter_mut().zip(computed) {
        if *normal == Vec3::ZERO {
            *normal = computed;
            zeros += 1;
        }
    }
    if outline.has_normals() && zeros > 0 {
        warnings.push(format!("{}: computed {zeros} normals that had length 0", mesh.name));
    }
    let turned = mend::turn_normals(mesh);
    if turned > 0 {
        warnings.push(format!("{}: turned {turned} normals to the front of their faces", mesh.name));
    }
}
