//! Volumes in files, for programs that look them up without solving anything: [`README`'s table](../../../../README.md) of
//! `eikonal.read`.
//!
//! A line of JSON, a line feed, then for each volume of the header 32-bit floats, little end first: `phi` of all cells, then
//! `light` of all cells. Cells count up along x first, then y, then z; cell (0, 0, 0) is the box's lower corner.

use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::image::{ImageError, atomic};

/// What the first line's `format` says.
const FORMAT: &str = "nephroid volumes 1";
/// Bytes of the longest header that is read.
const LONGEST_HEADER: u64 = 1 << 20;
/// Cells of the largest volume that is read.
const MOST_CELLS: u64 = 1 << 30;

/// One light's volume as it is kept.
#[derive(Debug, Clone, PartialEq)]
pub struct StoredVolume {
    pub header: VolumeHeader,
    /// Optical paths from the light less `offset`, metres times index; infinite where no wave comes, NaN outside of the medium.
    pub phi: Vec<f32>,
    /// See [`Volume::read_light`](super::Volume::read_light).
    pub light: Vec<f32>,
}

/// What a file says of a volume.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct VolumeHeader {
    /// The light's number in its scene.
    pub light: usize,
    /// World space, m: the box's lower corner, half a cell off the first cell's middle.
    pub lower: [f64; 3],
    /// Metres along a cell's side.
    pub cell: f64,
    /// Along x, y and z.
    pub cells: [u32; 3],
    /// Axes of the world, 0 to 2: two across the light's way, then the one along it.
    pub axes: [u32; 3],
    /// Whether light goes down the last of them.
    pub backward: bool,
    /// Metres times index that `phi` lacks.
    pub offset: f64,
    pub unit: LightUnit,
    /// Whether `light` is that of the quad from a cell to the next along both of the first axes, not of the cell.
    pub between: bool,
}

/// What `light` is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum LightUnit {
    /// Irradiance across the light's way over what the light sends, media taking nothing: over W/sr, in 1/m2, or for a
    /// directional light over W/m2.
    Irradiance,
    /// A factor of what flat water would let through.
    Factor,
}

#[derive(Serialize, Deserialize)]
struct Header {
    format: String,
    volumes: Vec<VolumeHeader>,
}

/// Why a file of volumes cannot be used.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum VolumeFileError {
    #[error("{path}: cannot be read: {reason}")]
    Read { path: PathBuf, reason: String },
    #[error("{path}: is not a file of volumes: {reason}")]
    Malformed { path: PathBuf, reason: String },
    #[error("{path}: {reason}; the file was made of another scene")]
    OtherScene { path: PathBuf, reason: String },
}

/// Writes a file, all of it or nothing.
pub fn write(path: &Path, volumes: &[StoredVolume]) -> Result<(), ImageError> {
    let header =
        Header { format: FORMAT.to_string(), volumes: volumes.iter().map(|volume| volume.header.clone()).collect() };
    atomic::write(path, |output| {
        serde_json::to_writer(&mut *output, &header).map_err(|error| error.to_string())?;
        output.write_all(b"\n").map_err(|error| error.to_string())?;
        for value in volumes.iter().flat_map(|volume| volume.phi.iter().chain(&volume.light)) {
            output.write_all(&value.to_le_bytes()).map_err(|error| error.to_string())?;
        }
        Ok(())
    })
}

/// Reads a file, whose numbers are checked to be as many as it says.
pub fn read(path: &Path) -> Result<Vec<StoredVolume>, VolumeFileError> {
    let failed = |error: std::io::Error| VolumeFileError::Read { path: path.to_owned(), reason: error.to_string() };
    let malformed = |reason: String| VolumeFileError::Malformed { path: path.to_owned(), reason };
    let mut input = BufReader::new(std::fs::File::open(path).map_err(failed)?);
    let mut line = Vec::new();
    input.by_ref().take(LONGEST_HEADER).read_until(b'\n', &mut line).map_err(failed)?;
    let header: Header = serde_json::from_slice(&line).map_err(|error| malformed(error.to_string()))?;
    if header.format != FORMAT {
        return Err(malformed(format!("its format is \"{}\"; known is \"{FORMAT}\"", header.format)));
    }
    let mut volumes = Vec::new();
    for header in header.volumes {
        let cells: u64 = header.cells.iter().try_fold(1u64, |all, &n| all.checked_mul(n.into())).unwrap_or(u64::MAX);
        let axes: u32 = header.axes.iter().filter(|&&axis| axis < 3).map(|axis| 1 << axis).sum();
        let sound = header.cell > 0.0 && header.cell.is_finite() && header.lower.iter().all(|x| x.is_finite());
        if !(1..=MOST_CELLS).contains(&cells) || axes != 7 || !sound || !header.offset.is_finite() {
            return Err(malformed("a volume's grid makes no sense".to_string()));
        }
        let mut floats = || -> Result<Vec<f32>, VolumeFileError> {
            let mut bytes = Vec::new();
            input.by_ref().take(4 * cells).read_to_end(&mut bytes).map_err(failed)?;
            if bytes.len() as u64 != 4 * cells {
                return Err(malformed("it ends before its last number".to_string()));
            }
            Ok(bytes.as_chunks().0.iter().map(|four| f32::from_le_bytes(*four)).collect())
        };
        volumes.push(StoredVolume { phi: floats()?, light: floats()?, header });
    }
    if input.read(&mut [0]).map_err(failed)? > 0 {
        return Err(malformed("it goes on after its last number".to_string()));
    }
    Ok(volumes)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn volume() -> StoredVolume {
        let header = VolumeHeader {
            light: 1,
            lower: [-1.0, 0.1, 1e-3],
            cell: 0.125,
            cells: [3, 1, 2],
            axes: [0, 2, 1],
            backward: true,
            offset: 4.75,
            unit: LightUnit::Irradiance,
            between: true,
        };
        let phi = vec![0.5, f32::INFINITY, 1.5, 2.5, -0.0, 1e-30];
        StoredVolume { header, phi, light: vec![-1e30, 0.0, 1.0, 2.0, 3.0, 4.0] }
    }

    #[test]
    fn a_file_gives_back_what_was_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("pool.volumes");
        write(&path, &[volume(), volume()]).unwrap();
        assert_eq!(read(&path).unwrap(), [volume(), volume()]);
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn what_is_wrong_with_a_file_is_said() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("pool.volumes");
        write(&path, &[volume()]).unwrap();
        let whole = std::fs::read(&path).unwrap();
        let message = |bytes: &[u8]| {
            std::fs::write(&path, bytes).unwrap();
            read(&path).unwrap_err().to_string()
        };
        assert!(message(&whole[..whole.len() - 1]).ends_with("it ends before its last number"));
        assert!(message(&[&whole[..], &[0]].concat()).ends_with("it goes on after its last number"));
        let text = String::from_utf8_lossy(&whole).replace("volumes 1", "volumes 2");
        assert!(message(text.as_bytes()).contains("its format is \"nephroid volumes 2\""));
        let text = String::from_utf8_lossy(&whole).replace("\"axes\":[0,2,1]", "\"axes\":[0,2,2]");
        assert!(message(text.as_bytes()).ends_with("a volume's grid makes no sense"));
        assert!(message(b"").contains("is not a file of volumes"));
        assert!(
            read(Path::new("nowhere.volumes")).unwrap_err().to_string().contains("nowhere.volumes: cannot be read")
        );
    }
}
