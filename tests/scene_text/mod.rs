//! Scenes given as text: read, damaged, and refused in one sentence.

use std::path::Path;

use nephroid::scene::{Scene, SceneError, parse};

pub fn read(text: &str) -> Result<Scene, SceneError> {
    parse(text, Path::new("bad.toml"))
}

/// The sentence for the scene `sound` with `from` replaced.
pub fn sentence(sound: &str, from: &str, to: &str) -> String {
    assert!(sound.contains(from), "{from}");
    read(&sound.replacen(from, to, 1)).expect_err(to).to_string()
}

/// Fails unless what is said is one line that names the file.
pub fn check_sentence(error: &SceneError) {
    let sentence = error.to_string();
    assert!(sentence.starts_with("bad.toml:") && !sentence.contains('\n'), "{sentence}");
}
