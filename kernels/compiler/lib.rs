//! GLSL to SPIR-V: finds the entry points, resolves includes, compiles. Shared by the build script and hot reload.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use glslang::{
    Compiler, CompilerOptions, ShaderInput, ShaderSource, ShaderStage, SourceLanguage, SpirvVersion, Target,
    VulkanVersion,
};

/// The include that makes a kernel exist once per tracing back-end.
const TRACE_INTERFACE: &str = "trace/interface.glsl";

/// The tracing back-ends as (variant, macro that `trace/interface.glsl` looks at).
const TRACE_VARIANTS: [(&str, &str); 3] =
    [("ray_query", "TRACE_RAY_QUERY"), ("cwbvh", "TRACE_CWBVH"), ("bvh2", "TRACE_BVH2")];

/// One SPIR-V module to be made.
#[derive(Debug, Clone)]
pub struct Job {
    /// `reference/emit` for `technique/reference/emit.comp.glsl`.
    pub name: String,
    /// `comp`, `vert`, `geom` or `frag`.
    pub stage: String,
    /// A tracing back-end, or empty for a kernel that does not trace.
    pub variant: &'static str,
    /// Source with includes resolved; it is all that decides the result.
    pub source: String,
}

/// All modules below `root`, in the order of their names. Errors are sentences with file and line.
pub fn jobs(root: &Path) -> Result<Vec<Job>, String> {
    let mut entry_points = Vec::new();
    for folder in ["trace", "animate", "frame", "taa", "light", "technique", "selftest", "conformance"] {
        collect_entry_points(&root.join(folder), &mut entry_points)?;
    }
    entry_points.sort();
    let mut jobs = Vec::new();
    for path in entry_points {
        jobs.extend(jobs_of(root, &path)?);
    }
    Ok(jobs)
}

fn collect_entry_points(folder: &Path, found: &mut Vec<PathBuf>) -> Result<(), String> {
    let Ok(entries) = std::fs::read_dir(folder) else { return Ok(()) };
    for entry in entries {
        let path = entry.map_err(|e| format!("{}: {e}", folder.display()))?.path();
        if path.is_dir() {
            collect_entry_points(&path, found)?;
        } else if stage_of(&path).is_some() {
            found.push(path);
        }
    }
    Ok(())
}

/// `walk.comp.glsl` is an entry point of stage `comp`, `walk.glsl` an include.
fn stage_of(path: &Path) -> Option<&'static str> {
    let file = path.file_name()?.to_str()?;
    ["comp", "vert", "geom", "frag"].into_iter().find(|stage| file.ends_with(&format!(".{stage}.glsl")))
}

fn jobs_of(root: &Path, path: &Path) -> Result<Vec<Job>, String> {
    let stage = stage_of(path).unwrap_or_default();
    let relative = relative_name(root, path);
    let name = relative
        .strip_prefix("technique/")
        .unwrap_or(&relative)
        .trim_end_matches(&format!(".{stage}.glsl"))
        .to_string();
    let mut seen = BTreeSet::new();
    let body = flatten(root, &relative, &mut seen)?;
    let job = |variant, defines: &str| Job {
        name: name.clone(),
        stage: stage.to_string(),
        variant,
        source: format!("#version 460\n#extension GL_GOOGLE_cpp_style_line_directive : enable\n{defines}{body}"),
    };
    if seen.contains(TRACE_INTERFACE) {
        Ok(TRACE_VARIANTS.iter().map(|(variant, define)| job(variant, &format!("#define {define}\n"))).collect())
    } else {
        Ok(vec![job("", "")])
    }
}

fn relative_name(root: &Path, path: &Path) -> String {
    path.strip_prefix(root).unwrap_or(path).to_string_lossy().replace('\\', "/")
}

/// Replaces `#include "file"` (relative to `root`) by the file, once each, with `#line` so that messages name it.
fn flatten(root: &Path, relative: &str, seen: &mut BTreeSet<String>) -> Result<String, String> {
    if !seen.insert(relative.to_string()) {
        return Ok(String::new());
    }
    let text = std::fs::read_to_string(root.join(relative)).map_err(|e| format!("{relative}: {e}"))?;
    let mut out = format!("#line 1 \"{relative}\"\n");
    for (index, line) in text.lines().enumerate() {
        let Some(rest) = line.trim_start().strip_prefix("#include") else {
            out.push_str(line);
            out.push('\n');
            continue;
        };
        let file = rest.trim().trim_matches('"');
        if !root.join(file).is_file() {
            return Err(format!("{relative}:{}: no include file \"{file}\"", index + 1));
        }
        out.push_str(&flatten(root, file, seen)?);
        out.push_str(&format!("#line {} \"{relative}\"\n", index + 2));
    }
    Ok(out)
}

/// Compiles one module for Vulkan 1.2 (SPIR-V 1.5). The error holds the compiler's lines as `file:line: what`.
pub fn compile(job: &Job) -> Result<Vec<u32>, String> {
    let compiler = Compiler::acquire().ok_or("the GLSL compiler could not start")?;
    let stage = match job.stage.as_str() {
        "vert" => ShaderStage::Vertex,
        "geom" => ShaderStage::Geometry,
        "frag" => ShaderStage::Fragment,
        _ => ShaderStage::Compute,
    };
    let options = CompilerOptions {
        source_language: SourceLanguage::GLSL,
        target: Target::Vulkan { version: VulkanVersion::Vulkan1_2, spirv_version: SpirvVersion::SPIRV1_5 },
        ..CompilerOptions::default()
    };
    let source = ShaderSource::from(job.source.as_str());
    let input = ShaderInput::new(&source, stage, &options, None, None).map_err(|e| e.to_string())?;
    let shader = compiler.create_shader(input).map_err(|e| messages(&e.to_string()))?;
    shader.compile().map_err(|e| messages(&e.to_string()))
}

/// `ERROR: trace/bvh.glsl:12: 'x' : undeclared` becomes `trace/bvh.glsl:12: 'x' : undeclared`.
fn messages(log: &str) -> String {
    let lines: Vec<&str> = log.lines().filter_map(|l| Some(l.split_once("ERROR: ")?.1.trim())).collect();
    if lines.is_empty() { log.trim().to_string() } else { lines.join("\n") }
}
