//! Which files a sequence writes, and whether it can.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use super::AnimateArgs;
use super::pattern::Pattern;
use super::sequence::Shard;
use crate::commands::PictureError;
use crate::commands::places::{self, PlaceError, folder_of};
use crate::image::{Format, ImageError, atomic};

/// Stands for a shard's number in the names of its reports.
const SHARD: &str = "{shard}";

/// All files of a sequence.
pub struct Files {
    /// Of the frames.
    pub pictures: Vec<(Pattern, Format)>,
    pub stats: Option<PathBuf>,
    pub trace_file: Option<PathBuf>,
    pub video: Option<PathBuf>,
}

impl Files {
    /// # Errors
    /// An unknown extension, reports of several shards under one name, or places where no file can be.
    pub fn new(args: &AnimateArgs, shard: Shard) -> Result<Self, PictureError> {
        let format = |pattern: &Pattern| Ok((pattern.clone(), Format::of(&pattern.path(0))?));
        let files = Files {
            pictures: args.output.iter().map(format).collect::<Result<_, ImageError>>()?,
            stats: report("--stats", args.picture.stats.as_deref(), shard)?,
            trace_file: report("--trace-file", args.picture.trace_file.as_deref(), shard)?,
            video: args.video.clone(),
        };
        [&files.stats, &files.trace_file].into_iter().flatten().try_for_each(|path| files.check_place(path))?;
        Ok(files)
    }

    /// Whether a file can be written at `path`, which may be in a folder that is made for pictures.
    ///
    /// # Errors
    /// [`ImageError::Write`].
    pub fn check_place(&self, path: &Path) -> Result<(), ImageError> {
        let full = |path: &Path| std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
        let folder = full(folder_of(path));
        let made = |(pattern, _): &(Pattern, Format)| full(folder_of(&pattern.path(0))).starts_with(&folder);
        if !folder.exists() && self.pictures.iter().any(made) { Ok(()) } else { atomic::check_place(path) }
    }

    /// Sees that none of them is another one or the scene. `frames`: of all shards.
    ///
    /// # Errors
    /// Two that are one file.
    pub fn check_distinct(&self, scene: &Path, frames: impl Iterator<Item = u32> + Clone) -> Result<(), PlaceError> {
        let named = [("--stats", &self.stats), ("--trace-file", &self.trace_file), ("--video", &self.video)];
        let named = named.into_iter().filter_map(|(option, path)| Some((option, path.clone()?)));
        let pictures = self.pictures.iter().flat_map(|(pattern, _)| frames.clone().map(|frame| pattern.path(frame)));
        let pictures = pictures.map(|path| ("--output", path));
        places::distinct([("the scene", scene.to_owned())].into_iter().chain(named).chain(pictures))
    }

    /// Sees that pictures can be written where their folder is there already.
    ///
    /// # Errors
    /// [`ImageError::Write`].
    pub fn check_pictures(&self, frames: &[u32]) -> Result<(), ImageError> {
        for (pattern, _) in &self.pictures {
            let mut paths = frames.iter().map(|&frame| pattern.path(frame));
            let taken = paths.clone().find(|path| path.is_dir());
            if let Some(path) = taken.or_else(|| paths.next())
                && folder_of(&path).exists()
            {
                atomic::check_place(&path)?;
            }
        }
        Ok(())
    }

    /// Makes the folders of pictures that are not there.
    ///
    /// # Errors
    /// [`PictureError::Folder`].
    pub fn make_folders(&self) -> Result<(), PictureError> {
        for (pattern, _) in &self.pictures {
            let path = pattern.path(0);
            let folder = folder_of(&path);
            let failed =
                |error: io::Error| PictureError::Folder { path: folder.to_owned(), reason: error.kind().to_string() };
            fs::create_dir_all(folder).map_err(failed)?;
        }
        Ok(())
    }

    /// Removes what killed runs left of a shard's files. The video of a shard may be another shard's work just now.
    ///
    /// # Errors
    /// As [`atomic::remove_stale`].
    pub fn remove_stale(&self, frames: &[u32], shard: Shard) -> Result<(), ImageError> {
        let pictures = self.pictures.iter().flat_map(|(pattern, _)| frames.iter().map(|&frame| pattern.path(frame)));
        let video = self.video.iter().filter(|_| shard == Shard::WHOLE);
        let others = self.stats.iter().chain(&self.trace_file).chain(video).cloned();
        let paths: Vec<PathBuf> = pictures.chain(others).collect();
        atomic::remove_stale(paths.iter().map(PathBuf::as_path))?;
        Ok(())
    }
}

/// A report's place, with the shard's number in it where that has a place.
fn report(option: &'static str, path: Option<&Path>, shard: Shard) -> Result<Option<PathBuf>, PictureError> {
    let Some(path) = path else { return Ok(None) };
    match path.to_str().filter(|text| text.contains(SHARD)) {
        Some(text) => Ok(Some(text.replace(SHARD, &shard.index.to_string()).into())),
        None if shard.count == 1 => Ok(Some(path.to_owned())),
        None => Err(PictureError::Shared { option, path: path.to_owned() }),
    }
}
