//! File names with a frame number: `out/%04d.png`, `out/smoke.####.exr`.

use std::path::{Path, PathBuf};

/// A path with at most one place for the frame number: a run of `#` (as many digits, zero-padded), `%0Nd` (N digits,
/// zero-padded) or `%d` (no padding). Longer numbers take the digits that they need.
///
/// The place is looked for in the file name, and in the folders only if the file name has none, so that a folder
/// `c#` does no harm.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pattern {
    before: PathBuf,
    field: Option<Field>,
}

#[derive(Clone, Debug, PartialEq, Eq)]
struct Field {
    before: String,
    digits: usize,
    after: String,
}

/// A file name pattern that cannot serve (exit code 2).
#[derive(Debug, thiserror::Error, PartialEq, Eq)]
#[error("{}: {why}", path.display())]
pub struct PatternError {
    /// The pattern as it was given.
    pub path: PathBuf,
    /// What is wrong and what is allowed.
    pub why: String,
}

/// Most digits that a pattern may ask for: file names end at 255 bytes.
const MAX_DIGITS: usize = 64;

impl Pattern {
    /// Takes a path apart. A path without a frame number is a pattern too: of a single file.
    /// An error if the file name has two places for the number, or one of more than 64 digits.
    pub fn parse(path: impl AsRef<Path>) -> Result<Pattern, PatternError> {
        let path = path.as_ref();
        let error = |why: String| PatternError { path: path.into(), why };
        let whole = path.to_str().unwrap_or_default();
        let name_start = whole.rfind(std::path::is_separator).map_or(0, |at| at + 1);
        let in_name = fields(whole, name_start, whole.len());
        let found = if in_name.is_empty() { fields(whole, 0, name_start) } else { in_name };
        let (start, end, digits) = match found[..] {
            [] => return Ok(Pattern { before: path.into(), field: None }),
            [one] => one,
            [first, second, ..] => {
                return Err(error(format!(
                    "two places for the frame number, `{}` and `{}`; one is allowed",
                    &whole[first.0..first.1],
                    &whole[second.0..second.1]
                )));
            }
        };
        if digits > MAX_DIGITS {
            return Err(error(format!("a frame number of {digits} digits; at most {MAX_DIGITS} are allowed")));
        }
        let field = Field { before: whole[..start].into(), digits, after: whole[end..].into() };
        Ok(Pattern { before: PathBuf::new(), field: Some(field) })
    }

    /// Whether the path has a place for the frame number.
    pub fn has_number(&self) -> bool {
        self.field.is_some()
    }

    /// The path of one frame.
    pub fn path(&self, frame: u32) -> PathBuf {
        match &self.field {
            Some(Field { before, digits, after }) => {
                self.before.join(format!("{before}{frame:0width$}{after}", width = *digits))
            }
            None => self.before.clone(),
        }
    }

    /// The same pattern, if relative, below `folder`. A `#` in `folder` is no frame number.
    pub fn below(self, folder: &Path) -> Pattern {
        Pattern { before: folder.join(self.before), field: self.field }
    }

    /// Refuses a pattern without a frame number for more than one frame: each would overwrite the one before.
    pub fn check_frames(&self, first: u32, last: u32) -> Result<(), PatternError> {
        if self.has_number() || first == last {
            return Ok(());
        }
        let why = format!(
            "frames {first} to {last} need a place for the frame number in the file name: `####`, `%04d` or `%d`, \
             as in out/%04d.png"
        );
        Err(PatternError { path: self.before.clone(), why })
    }
}

/// Every place for a number in `text[from..to]`: start, end, digits.
fn fields(text: &str, from: usize, to: usize) -> Vec<(usize, usize, usize)> {
    let bytes = text.as_bytes();
    let mut found = Vec::new();
    let mut at = from;
    while at < to {
        let rest = &bytes[at..to];
        let hashes = rest.iter().take_while(|&&b| b == b'#').count();
        let (length, digits) = if hashes > 0 { (hashes, hashes) } else { percent(rest).unwrap_or((0, 0)) };
        if length > 0 {
            found.push((at, at + length, digits));
        }
        at += length.max(1);
    }
    found
}

/// `%d` or `%0Nd` at the start of `bytes`: length, digits. Anything else after `%` is an ordinary part of the name.
fn percent(bytes: &[u8]) -> Option<(usize, usize)> {
    let rest = bytes.strip_prefix(b"%")?;
    if rest.first() == Some(&b'd') {
        return Some((2, 1));
    }
    let rest = rest.strip_prefix(b"0")?;
    let count = rest.iter().take_while(|b| b.is_ascii_digit()).count();
    if count == 0 || rest.get(count) != Some(&b'd') {
        return None;
    }
    // A number too long to hold is certainly more than the digits allowed, which parse() says.
    let digits = std::str::from_utf8(&rest[..count]).ok()?.parse().unwrap_or(usize::MAX);
    Some((count + 3, digits))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn path(pattern: &str, frame: u32) -> String {
        Pattern::parse(pattern).unwrap().path(frame).to_str().unwrap().into()
    }

    #[test]
    fn numbers_are_put_in() {
        assert_eq!(path("out/%04d.png", 7), "out/0007.png");
        assert_eq!(path("out/%d.png", 7), "out/7.png");
        assert_eq!(path("out/%02d.png", 12345), "out/12345.png");
        assert_eq!(path("out/a.####.exr", 42), "out/a.0042.exr");
        assert_eq!(path("#.exr", 42), "42.exr");
        assert_eq!(path("%04d.png", u32::MAX), "4294967295.png");
        assert_eq!(path("sim.##/smoke.npz", 3), "sim.03/smoke.npz");
        assert_eq!(path("c#/%04d.png", 3), "c#/0003.png");
        assert_eq!(path("/tmp/####", 3), "/tmp/0003");
    }

    #[test]
    fn other_percent_signs_are_ordinary() {
        for name in ["100%.png", "%s.png", "%4d.png", "%0d.png", "%04", "%", "a%%b", "größe%.png"] {
            let pattern = Pattern::parse(name).unwrap();
            assert!(!pattern.has_number(), "{name}");
            assert_eq!(pattern.path(5), Path::new(name));
        }
        assert_eq!(path("100%_%03d.png", 5), "100%_005.png");
        assert_eq!(path("größe_##ü.png", 5), "größe_05ü.png");
    }

    #[test]
    fn several_frames_need_a_number() {
        let single = Pattern::parse("out/frame.png").unwrap();
        assert_eq!(single.check_frames(5, 5), Ok(()));
        let error = single.check_frames(1, 48).unwrap_err().to_string();
        assert!(error.contains("out/frame.png") && error.contains("%04d") && error.contains("1 to 48"), "{error}");
        assert_eq!(Pattern::parse("out/####.png").unwrap().check_frames(1, 48), Ok(()));
    }

    #[test]
    fn ambiguous_and_absurd_patterns_are_refused() {
        let error = Pattern::parse("a##_%04d.png").unwrap_err().to_string();
        assert!(error.contains("`##` and `%04d`"), "{error}");
        assert!(Pattern::parse("%0999d.png").is_err());
        assert!(Pattern::parse(format!("%0{}d.png", "9".repeat(40))).is_err());
        assert!(Pattern::parse("").is_ok_and(|p| !p.has_number()));
    }

    #[test]
    fn folders_of_relative_patterns() {
        let pattern = Pattern::parse("v/####.npz").unwrap();
        assert_eq!(pattern.clone().below(Path::new("/shots/c#")).path(1), Path::new("/shots/c#/v/0001.npz"));
        assert_eq!(Pattern::parse("/x/#.npz").unwrap().below(Path::new("/shots")).path(1), Path::new("/x/1.npz"));
        assert_eq!(Pattern::parse("one.npz").unwrap().below(Path::new("/s")).path(1), Path::new("/s/one.npz"));
    }
}
