//! OBJ text checked line by line, since `tobj` trusts its input: what it would choke on is refused, with the line.

use std::path::Path;

use super::error::{SceneError, in_file};
use super::mtl;
use super::value::Node;

/// OBJ units; their squares stay inside the range of f32.
const LARGEST_COORDINATE: f32 = 1e9;
/// Corners of one face; cutting up the worst of faces takes their cube in time.
const MOST_CORNERS: usize = 1024;

/// Numbered lines without comments, a trailing backslash joining two.
pub(super) fn logical_lines(text: &str) -> Vec<(u32, String)> {
    let mut lines: Vec<(u32, String)> = Vec::new();
    let mut joining = false;
    for (index, line) in text.lines().enumerate() {
        let line = line.split('#').next().unwrap_or("").trim();
        let (line, goes_on) = line.strip_suffix('\\').map_or((line, false), |line| (line, true));
        match lines.last_mut() {
            Some((_, start)) if joining => {
                start.push(' ');
                start.push_str(line);
            }
            _ => lines.push((index as u32 + 1, line.to_owned())),
        }
        joining = goes_on;
    }
    lines
}

/// What a checked OBJ holds.
#[derive(Default)]
pub(super) struct Outline {
    /// Of `v`, `vt` and `vn`.
    counts: [usize; 3],
    pub faces: usize,
    /// Faces whose corners all have a texture coordinate, and a normal.
    pub with_uv: usize,
    pub with_normal: usize,
    libraries: Vec<(u32, String)>,
    uses: Vec<(u32, String)>,
    /// Line of the first face that no `usemtl` precedes.
    bare_face: Option<u32>,
}

/// Refuses what `tobj` would choke on or mend by guessing: numbers that are none, indices out of range.
pub(super) fn check(file: &Path, lines: &[(u32, String)]) -> Result<Outline, SceneError> {
    let mut outline = Outline::default();
    for (line, text) in lines {
        let mut words = text.split_whitespace();
        let keyword = words.next().unwrap_or("");
        let rest = text.get(keyword.len()..).unwrap_or("").trim();
        let checked = match keyword {
            "v" => count_vertex(&mut outline.counts[0], "v", words, 3),
            "vt" => count_vertex(&mut outline.counts[1], "vt", words, 2),
            "vn" => count_vertex(&mut outline.counts[2], "vn", words, 3),
            "f" => outline.add_face(*line, words),
            "mtllib" => {
                outline.libraries.push((*line, rest.to_owned()));
                Ok(())
            }
            "usemtl" if rest.is_empty() => Err("`usemtl` is empty; allowed: the name of a material".to_owned()),
            "usemtl" => {
                outline.uses.push((*line, rest.to_owned()));
                Ok(())
            }
            _ => Ok(()),
        };
        checked.map_err(|problem| in_file(file, *line, problem))?;
    }
    Ok(outline)
}

fn count_vertex<'a>(
    count: &mut usize,
    keyword: &str,
    words: impl Iterator<Item = &'a str>,
    components: usize,
) -> Result<(), String> {
    let words: Vec<&str> = words.take(components).collect();
    // One component is enough for a texture coordinate, v being 0 then.
    let wanted = if keyword == "vt" { 1 } else { components };
    let sound = |word: &&str| word.parse().is_ok_and(|x: f32| x.abs() <= LARGEST_COORDINATE);
    if words.len() < wanted || !words.iter().all(sound) {
        let (found, most) = (words.join(" "), LARGEST_COORDINATE);
        return Err(format!("`{keyword}` is \"{found}\"; allowed: {wanted} numbers from -{most:e} to {most:e}"));
    }
    *count += 1;
    Ok(())
}

impl Outline {
    fn add_face<'a>(&mut self, line: u32, corners: impl Iterator<Item = &'a str>) -> Result<(), String> {
        let corners: Vec<&str> = corners.collect();
        if !(3..=MOST_CORNERS).contains(&corners.len()) {
            return Err(format!("`f` has {} corners; allowed: 3 to {MOST_CORNERS}", corners.len()));
        }
        let mut complete = [true; 3];
        for corner in corners {
            let fields: Vec<&str> = corner.split('/').collect();
            if fields.len() > 3 {
                return Err(format!("`f` has the corner \"{corner}\"; allowed: v, v/vt, v//vn or v/vt/vn"));
            }
            for (kind, keyword) in ["v", "vt", "vn"].into_iter().enumerate() {
                let field = fields.get(kind).copied().unwrap_or("");
                if field.is_empty() && kind > 0 {
                    complete[kind] = false;
                } else {
                    check_index(corner, field, keyword, self.counts[kind])?;
                }
            }
        }
        self.faces += 1;
        self.with_uv += usize::from(complete[1]);
        self.with_normal += usize::from(complete[2]);
        if self.uses.is_empty() {
            self.bare_face.get_or_insert(line);
        }
        Ok(())
    }

    /// All materials of the MTL files, every one that is used being among them.
    pub fn materials(&self, file: &Path, node: &Node) -> Result<Vec<mtl::Entry>, SceneError> {
        if let Some(line) = self.bare_face {
            let object = node.at();
            let problem = format!(
                "`f` has no material; allowed: faces after a `usemtl`, or a `material` for the object at {object}"
            );
            return Err(in_file(file, line, problem));
        }
        let mut entries = Vec::new();
        for (line, name) in &self.libraries {
            entries.extend(mtl::read(file, *line, name)?);
        }
        for (line, name) in &self.uses {
            if !entries.iter().any(|entry| entry.material.name == *name) {
                let known: Vec<&str> = entries.iter().map(|entry| entry.material.name.as_str()).collect();
                let known = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
                let problem = format!("`usemtl` names \"{name}\", which no `mtllib` holds; known: {known}");
                return Err(in_file(file, *line, problem));
            }
        }
        Ok(entries)
    }

    pub fn has_normals(&self) -> bool {
        self.with_normal == self.faces
    }

    pub fn has_uvs(&self) -> bool {
        self.with_uv == self.faces
    }
}

/// Indices count from 1, or back from the latest as -1.
fn check_index(corner: &str, field: &str, keyword: &str, count: usize) -> Result<(), String> {
    let sound = field
        .parse()
        .is_ok_and(|index: i64| index != 0 && usize::try_from(index.unsigned_abs()).is_ok_and(|index| index <= count));
    if sound {
        return Ok(());
    }
    let allowed = match count {
        0 => format!("no `{keyword}` index, as no `{keyword}` precedes it"),
        1 => format!("a `{keyword}` index of 1 or -1, as one precedes it"),
        _ => format!("a `{keyword}` index from 1 to {count} or from -{count} to -1, as {count} precede it"),
    };
    Err(format!("`f` has the corner \"{corner}\"; allowed: {allowed}"))
}
