//! Compiles every kernel, in parallel, and only what changed: results are kept under the hash of their source.

use std::collections::hash_map::DefaultHasher;
use std::fmt::Write as _;
use std::hash::{Hash, Hasher};
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use nephroid_kernel_compiler::{self as compiler, Job};

fn main() {
    let root = PathBuf::from(std::env::var("CARGO_MANIFEST_DIR").unwrap_or_default());
    let out = PathBuf::from(std::env::var("OUT_DIR").unwrap_or_default());
    for folder in
        ["build.rs", "shared", "trace", "animate", "frame", "taa", "light", "technique", "selftest", "conformance"]
    {
        println!("cargo::rerun-if-changed={}", root.join(folder).display());
    }
    if let Err(message) = build(&root, &out) {
        for line in message.lines() {
            println!("cargo::error={line}");
        }
        std::process::exit(1);
    }
}

fn build(root: &Path, out: &Path) -> Result<(), String> {
    let jobs = compiler::jobs(root)?;
    let files: Vec<PathBuf> = jobs.iter().map(|job| out.join(format!("{:016x}.spv", hash(&job.source)))).collect();
    compile_missing(&jobs, &files)?;
    let table = table(&jobs, &files);
    std::fs::write(out.join("table.rs"), table).map_err(|e| format!("{}: {e}", out.display()))
}

fn hash(source: &str) -> u64 {
    let mut hasher = DefaultHasher::new();
    source.hash(&mut hasher);
    hasher.finish()
}

fn compile_missing(jobs: &[Job], files: &[PathBuf]) -> Result<(), String> {
    let next = AtomicUsize::new(0);
    let errors = Mutex::new(Vec::new());
    let threads = std::thread::available_parallelism().map_or(1, |n| n.get());
    std::thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                while let Some(index) = Some(next.fetch_add(1, Ordering::Relaxed)).filter(|&i| i < jobs.len()) {
                    if let Err(message) = compile_to(&jobs[index], &files[index])
                        && let Ok(mut errors) = errors.lock()
                    {
                        errors.push(message);
                    }
                }
            });
        }
    });
    let mut errors = errors.into_inner().unwrap_or_default();
    errors.sort();
    errors.dedup();
    if errors.is_empty() { Ok(()) } else { Err(errors.join("\n")) }
}

fn compile_to(job: &Job, file: &Path) -> Result<(), String> {
    if file.is_file() {
        return Ok(());
    }
    let bytes: Vec<u8> = compiler::compile(job)?.iter().flat_map(|word| word.to_le_bytes()).collect();
    // Renamed into place, so that a build that is killed leaves no half module behind.
    let temporary = file.with_extension(format!("{}.{}.tmp", job.name.replace('/', "-"), job.variant));
    std::fs::write(&temporary, bytes)
        .and_then(|()| std::fs::rename(&temporary, file))
        .map_err(|e| format!("{}: {e}", file.display()))
}

fn table(jobs: &[Job], files: &[PathBuf]) -> String {
    let mut text = String::from("pub static KERNELS: &[KernelSource] = &[\n");
    for (job, file) in jobs.iter().zip(files) {
        let _ = writeln!(
            text,
            "    KernelSource {{ name: {:?}, stage: {:?}, variant: {:?}, spirv: include_bytes!({:?}) }},",
            job.name,
            job.stage,
            job.variant,
            file.display().to_string()
        );
    }
    text.push_str("];\n");
    text
}
