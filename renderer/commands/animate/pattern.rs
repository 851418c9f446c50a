//! File names with a place for the frame's number, as printf writes it.

use std::path::PathBuf;
use std::str::FromStr;

/// Digits that a number is filled up to, at most.
const MOST_DIGITS: usize = 20;

/// A path with exactly one `%d` or `%0Nd` in its file name; `%%` is a plain `%`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Pattern {
    before: String,
    digits: usize,
    after: String,
}

impl Pattern {
    /// The file of that frame.
    pub fn path(&self, frame: u32) -> PathBuf {
        let Pattern { before, digits, after } = self;
        PathBuf::from(format!("{before}{frame:0digits$}{after}"))
    }

    /// As it would be written on the command line, made absolute.
    pub fn absolute(&self) -> String {
        let place = if self.digits == 0 { "%d".to_owned() } else { format!("%0{}d", self.digits) };
        let path = PathBuf::from(format!("{}{place}{}", self.before, self.after));
        std::path::absolute(&path).unwrap_or(path).display().to_string()
    }
}

impl FromStr for Pattern {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        const WANTED: &str = "wanted is one %d, or %04d and the like, in the file's name";
        let mut parts = vec![String::new()];
        let mut widths = Vec::new();
        let mut rest = text;
        while let Some((plain, place)) = rest.split_once('%') {
            parts.last_mut().into_iter().for_each(|part| part.push_str(plain));
            if let Some(after) = place.strip_prefix('%') {
                parts.last_mut().into_iter().for_each(|part| part.push('%'));
                rest = after;
                continue;
            }
            let (width, after) = place.split_once('d').ok_or("a % is neither %d, %04d nor %%")?;
            widths.push(digits(width).ok_or_else(|| {
                format!("%{width}d is not known here; {WANTED}, filled with zeros to 1 to {MOST_DIGITS} digits")
            })?);
            parts.push(String::new());
            rest = after;
        }
        parts.last_mut().into_iter().for_each(|part| part.push_str(rest));
        match (parts.as_slice(), widths.as_slice()) {
            ([before, after], [digits]) if !after.contains(std::path::is_separator) => {
                Ok(Pattern { before: before.clone(), digits: *digits, after: after.clone() })
            }
            ([_, _], _) => Err(format!("the frame's number is in a folder's name; {WANTED}")),
            ([_], _) => Err(format!("all frames would go to one file; {WANTED}")),
            _ => Err(format!("it has {} places for the frame's number; {WANTED}", widths.len())),
        }
    }
}

/// Of what stands between % and d: nothing, or 0 and a width.
fn digits(width: &str) -> Option<usize> {
    if width.is_empty() {
        return Some(0);
    }
    let width = width.strip_prefix('0')?;
    let plain = width.bytes().all(|c| c.is_ascii_digit());
    width.parse().ok().filter(|digits| plain && (1..=MOST_DIGITS).contains(digits))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_written_as_printf_does() {
        for (pattern, frame, path) in [
            ("a/b_%04d.exr", 7, "a/b_0007.exr"),
            ("%02d.png", 1234, "1234.png"),
            ("%d", 0, "0"),
            ("50%%_%03d_100%%.png", 2, "50%_002_100%.png"),
            ("10%%/%d.png", 2, "10%/2.png"),
        ] {
            assert_eq!(pattern.parse::<Pattern>().unwrap().path(frame), PathBuf::from(path), "{pattern}");
        }
    }

    #[test]
    fn whatever_else_is_refused() {
        for pattern in
            ["a.png", "%d_%d.png", "%04d/a.png", "%4d.png", "%x.png", "%-4d.png", "%0+4d.png", "%00d.png", "50%.png"]
        {
            assert!(pattern.parse::<Pattern>().is_err(), "{pattern}");
        }
    }
}
