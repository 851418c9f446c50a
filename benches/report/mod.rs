//! What every benchmark writes beside its table: JSON with the commit; devices and drivers are in the results.

use std::error::Error;
use std::path::Path;

/// Writes `target/bench/<name>.json`.
pub fn write(name: &str, results: serde_json::Value) -> Result<(), Box<dyn Error>> {
    let report = serde_json::json!({
        "commit": commit(),
        "results": results,
    });
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("target/bench");
    std::fs::create_dir_all(&folder)?;
    let temporary = folder.join(format!("{name}.json.tmp"));
    std::fs::write(&temporary, serde_json::to_string_pretty(&report)?)?;
    std::fs::rename(temporary, folder.join(format!("{name}.json")))?;
    Ok(())
}

/// The checkout's commit; empty outside of one.
fn commit() -> String {
    let git = std::process::Command::new("git").args(["rev-parse", "HEAD"]).output();
    git.map(|o| String::from_utf8_lossy(&o.stdout).trim().to_string()).unwrap_or_default()
}
