//! Hot reload: kernels whose GLSL changes get new pipelines while the program runs, and keep the old where the new
//! does not compile or does not fit the host.
//!
//! What a kernel is bound to is fixed when it is made, from the table that was built in. A changed module may leave
//! out part of that interface and may add nothing to it.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};
use std::time::SystemTime;

use nephroid_kernel_compiler::{self as compiler, Job};

use super::pipeline::module_words;
use super::reflect::{Interface, reflect};
use super::{Device, GpuError};

/// One module of the kernel table.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct ModuleName {
    name: String,
    stage: &'static str,
    variant: String,
}

impl ModuleName {
    pub(crate) fn new(name: &str, stage: &'static str, variant: &str) -> Self {
        ModuleName { name: name.to_string(), stage, variant: variant.to_string() }
    }

    fn is_made_by(&self, job: &Job) -> bool {
        job.name == self.name && job.stage == self.stage && job.variant == self.variant
    }
}

/// What holds a pipeline that can be replaced.
pub(crate) trait Reloadable {
    /// What the pipeline is made of.
    fn modules(&self) -> &[ModuleName];

    /// Makes a pipeline of these modules, in the order of [`modules`](Self::modules), and uses it from now on.
    fn reload(&self, device: &Device, modules: &[Vec<u32>]) -> Result<(), GpuError>;
}

type Live = dyn Reloadable + Send + Sync;

/// The kernels of a device, and the modules that replaced the table's.
#[derive(Default)]
pub(crate) struct LiveKernels(Mutex<Registry>);

#[derive(Default)]
struct Registry {
    kernels: Vec<Weak<Live>>,
    replaced: BTreeMap<ModuleName, Vec<u32>>,
}

impl LiveKernels {
    fn lock(&self) -> MutexGuard<'_, Registry> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn all(&self) -> Vec<Arc<Live>> {
        self.lock().kernels.iter().filter_map(Weak::upgrade).collect()
    }

    /// The module's words that new kernels are made of.
    fn words(&self, module: &ModuleName) -> Result<Vec<u32>, GpuError> {
        match self.lock().replaced.get(module) {
            Some(words) => Ok(words.clone()),
            None => module_words(&module.name, module.stage, &module.variant),
        }
    }
}

/// Makes a new kernel known to the device's watch, and gives it what its modules have been replaced by.
pub(crate) fn register(device: &Device, kernel: Arc<Live>) -> Result<(), GpuError> {
    {
        let mut registry = device.kernels.lock();
        registry.kernels.retain(|kernel| kernel.strong_count() > 0);
        registry.kernels.push(Arc::downgrade(&kernel));
        if !kernel.modules().iter().any(|module| registry.replaced.contains_key(module)) {
            return Ok(());
        }
    }
    let words = kernel.modules().iter().map(|module| device.kernels.words(module)).collect::<Result<Vec<_>, _>>()?;
    kernel.reload(device, &words)
}

/// Why a folder cannot be watched.
#[derive(Debug, thiserror::Error)]
#[error("the kernels cannot be watched: {} is not a folder with kernel sources", folder.display())]
pub struct WatchError {
    pub folder: PathBuf,
}

/// What became of a change. It is displayed as a line or more for the user.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ReloadReport {
    /// The kernel runs what its source says now.
    Reloaded { kernel: String },
    /// The kernels run what they ran before. The reason is a sentence, or the compiler's lines `file:line: what`.
    Kept { kernels: Vec<String>, reason: String },
    /// The folder cannot be read as a whole; nothing has changed.
    Unreadable { reason: String },
}

impl fmt::Display for ReloadReport {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            ReloadReport::Reloaded { kernel } => write!(f, "{kernel} is reloaded"),
            ReloadReport::Kept { kernels, reason } => {
                write!(f, "{reason}\n{}: the last good pipeline stays in use", kernels.join(", "))
            }
            ReloadReport::Unreadable { reason } => write!(f, "{reason}\nall kernels stay as they are"),
        }
    }
}

/// Watches a folder of kernel sources for all kernels of a device, those made later included.
///
/// A [`poll`](Self::poll) between submissions is safe at any time. It looks at the files' times and lengths only, until
/// one has changed.
pub struct KernelWatch {
    device: Device,
    folder: PathBuf,
    stamps: BTreeMap<PathBuf, (SystemTime, u64)>,
    jobs: Vec<Job>,
    tried: BTreeMap<ModuleName, Tried>,
}

/// A module's source and what it compiled to.
struct Tried {
    source: String,
    words: Result<Vec<u32>, String>,
}

impl KernelWatch {
    /// Watches `folder`, for instance [`nephroid_kernels::source_folder`]. The first poll also finds what has
    /// been changed since the program was built.
    pub fn new(device: &Device, folder: &Path) -> Result<Self, WatchError> {
        if stamps(folder).is_empty() {
            return Err(WatchError { folder: folder.to_owned() });
        }
        Ok(KernelWatch {
            device: device.clone(),
            folder: folder.to_owned(),
            stamps: BTreeMap::new(),
            jobs: Vec::new(),
            tried: BTreeMap::new(),
        })
    }

    /// Compiles what has changed since the last poll and is in use, and replaces the pipelines made of it.
    pub fn poll(&mut self) -> Vec<ReloadReport> {
        let stamps = stamps(&self.folder);
        if stamps != self.stamps {
            self.stamps = stamps;
            match compiler::jobs(&self.folder) {
                Ok(jobs) => self.jobs = jobs,
                Err(reason) => return vec![ReloadReport::Unreadable { reason }],
            }
        }
        let kernels = self.device.kernels.all();
        let changed = self.compile(&kernels);
        // A picture in several bands has several raster pipelines of one name.
        let mut groups: BTreeMap<&[ModuleName], Vec<&Live>> = BTreeMap::new();
        for kernel in &kernels {
            if kernel.modules().iter().any(|module| changed.contains(module)) {
                groups.entry(kernel.modules()).or_default().push(kernel.as_ref());
            }
        }
        reports(groups.iter().map(|(modules, kernels)| (label(modules), self.reload(modules, kernels))))
    }

    /// Compiles the kernels' modules that are not what was tried last, and returns their names.
    fn compile(&mut self, kernels: &[Arc<Live>]) -> BTreeSet<ModuleName> {
        let mut changed = BTreeSet::new();
        for module in kernels.iter().flat_map(|kernel| kernel.modules()) {
            let job = self.jobs.iter().find(|job| module.is_made_by(job));
            let source = job.map_or("", |job| &job.source);
            if self.tried.get(module).is_some_and(|tried| tried.source == source) {
                continue;
            }
            let words = job.map_or_else(
                || Err(format!("{} has no {} source in {}", module.name, module.stage, self.folder.display())),
                |job| compiler::compile(job).and_then(|words| fitting(module, words)),
            );
            self.tried.insert(module.clone(), Tried { source: source.to_string(), words });
            changed.insert(module.clone());
        }
        changed
    }

    /// Replaces the pipelines of `kernels`, which are all made of `modules`, by what was compiled last. The result is
    /// whether there was something to replace.
    fn reload(&self, modules: &[ModuleName], kernels: &[&Live]) -> Result<bool, String> {
        let live = &self.device.kernels;
        let in_use = modules.iter().map(|module| live.words(module)).collect::<Result<Vec<_>, _>>();
        let compiled = modules.iter().filter_map(|module| self.tried.get(module)).map(|tried| tried.words.clone());
        let compiled = compiled.collect::<Result<Vec<_>, _>>()?;
        if in_use.is_ok_and(|words| words == compiled) {
            return Ok(false);
        }
        for kernel in kernels {
            kernel.reload(&self.device, &compiled).map_err(|error| error.to_string())?;
        }
        live.lock().replaced.extend(modules.iter().cloned().zip(compiled));
        Ok(true)
    }
}

/// `frame/walk`, or `frame/walk (cwbvh)` where it traces.
fn label(modules: &[ModuleName]) -> String {
    match modules {
        [ModuleName { name, variant, .. }, ..] if !variant.is_empty() => format!("{name} ({variant})"),
        [ModuleName { name, .. }, ..] => name.clone(),
        [] => String::new(),
    }
}

/// One report a kernel that was reloaded, and one a reason for which kernels were not: an include has many users.
fn reports(outcomes: impl Iterator<Item = (String, Result<bool, String>)>) -> Vec<ReloadReport> {
    let mut reports = Vec::new();
    let mut kept: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for (kernel, outcome) in outcomes {
        match outcome {
            Ok(true) => reports.push(ReloadReport::Reloaded { kernel }),
            Ok(false) => {}
            Err(reason) => kept.entry(reason).or_default().push(kernel),
        }
    }
    reports.extend(kept.into_iter().map(|(reason, kernels)| ReloadReport::Kept { kernels, reason }));
    reports
}

/// The words, where their interface is a part of that of the module in the table.
fn fitting(module: &ModuleName, words: Vec<u32>) -> Result<Vec<u32>, String> {
    let host = module_words(&module.name, module.stage, &module.variant).map_err(|error| error.to_string())?;
    match misfit(&reflect(&host)?, &reflect(&words)?) {
        None => Ok(words),
        Some(what) => Err(format!("{} ({}) does not fit the program: {what}", module.name, module.stage)),
    }
}

fn misfit(host: &Interface, found: &Interface) -> Option<String> {
    if found.workgroup != host.workgroup {
        return Some(format!("its workgroup is {:?}; allowed is {:?}", found.workgroup, host.workgroup));
    }
    if found.push_constants != 0 && found.push_constants != host.push_constants {
        let (bytes, allowed) = (found.push_constants, host.push_constants);
        return Some(format!("it takes {bytes} bytes of push constants; the program pushes {allowed}"));
    }
    if let Some(slot) = found.slots.iter().find(|slot| !host.slots.contains(slot)) {
        let (set, binding) = (slot.set, slot.binding);
        let allowed: Vec<_> = host.slots.iter().map(|s| format!("{} at {}.{}", s.name, s.set, s.binding)).collect();
        let allowed = allowed.join(", ");
        return Some(format!("it binds {} at set {set}, binding {binding}; allowed are: {allowed}", slot.name));
    }
    if let Some(layout) = found.structs.iter().find(|layout| !host.structs.contains(layout)) {
        return Some(format!("the program has no struct {} of that layout", layout.name));
    }
    let capability = found.capabilities.iter().find(|capability| !host.capabilities.contains(capability))?;
    Some(format!("it wants the SPIR-V capability {capability}, which it was not built with"))
}

/// Time and length of every GLSL file below the folder; a file that cannot be read counts as missing.
fn stamps(folder: &Path) -> BTreeMap<PathBuf, (SystemTime, u64)> {
    let mut found = BTreeMap::new();
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    for entry in entries {
        let path = entry.path();
        if path.is_dir() {
            found.append(&mut stamps(&path));
        } else if path.extension().is_some_and(|ending| ending == "glsl")
            && let Ok(data) = path.metadata()
            && let Ok(changed) = data.modified()
        {
            found.insert(path, (changed, data.len()));
        }
    }
    found
}
