//! File names with a frame number: `out/%04d.png`, `out/smoke.####.exr`.

use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};

/// The highest frame number of a shot.
pub const LAST_FRAME: u32 = 999_999;

/// A path with at most one place for the frame number: a run of `#` (as many digits, zero-padded), `%0Nd` (N digits,
/// zero-padded) or `%d` (no padding). Longer numbers take the digits that they need.
///
/// The place is looked for in the file name, and in the folders only if the file name has none, so that a folder
/// `c#` does no harm. What is around it may be any bytes that a path may have.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pattern {
    before: PathBuf,
    field: Option<Field>,
}

#[derive(Clone, Debug, PartialEq, Eq)]
struct Field {
    before: OsString,
    digits: usize,
    after: OsString,
}

/// A file name pattern that cannot serve (exit code 2).
#[derive(Debug, thiserror::Error, PartialEq, Eq)]
#[error("{}: {why}", path.display())]
pub struct PatternError {
    /// The pattern as it was given.
    pub path: PathBuf,
    /// The fault, and what is allowed.
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
        let whole = path.as_os_str().as_encoded_bytes();
        let name_start = last_separator(whole).map_or(0, |at| at + 1);
        let in_name = fields(whole, name_start, whole.len());
        let found = if in_name.is_empty() { fields(whole, 0, name_start) } else { in_name };
        let (start, end, digits) = match found[..] {
            [] => return Ok(Pattern::single(path)),
            [one] => one,
            [first, second, ..] => {
                return Err(error(format!(
                    "two places for the frame number, `{}` and `{}`; one is allowed",
                    part(whole, first.0, first.1).display(),
                    part(whole, second.0, second.1).display()
                )));
            }
        };
        if digits > MAX_DIGITS {
            return Err(error(format!("a frame number of {digits} digits; at most {MAX_DIGITS} are allowed")));
        }
        let [before, after] = [part(whole, 0, start), part(whole, end, whole.len())].map(OsStr::to_owned);
        Ok(Pattern { before: PathBuf::new(), field: Some(Field { before, digits, after }) })
    }

    /// A single file, whatever is in its name.
    pub fn single(path: impl Into<PathBuf>) -> Pattern {
        Pattern { before: path.into(), field: None }
    }

    /// Whether the path has a place for the frame number.
    pub fn has_number(&self) -> bool {
        self.field.is_some()
    }

    /// The path of one frame.
    pub fn path(&self, frame: u32) -> PathBuf {
        match &self.field {
            Some(Field { before, digits, after }) => {
                let mut name = before.clone();
                name.push(format!("{frame:0width$}", width = *digits));
                name.push(after);
                self.before.join(name)
            }
            None => self.before.clone(),
        }
    }

    /// The same pattern, if relative, below `folder`. A `#` in `folder` is no frame number.
    pub fn below(self, folder: &Path) -> Pattern {
        Pattern { before: folder.join(self.before), field: self.field }
    }

    /// The same pattern with what `resolve` makes of the folder that holds its files; of the folder that holds those of
    /// the frames where the number is in a folder's name.
    pub fn with_folder(&self, resolve: impl FnOnce(&Path) -> PathBuf) -> Pattern {
        let whole = match &self.field {
            Some(field) => self.before.join(&field.before).into_os_string(),
            None => self.before.clone().into_os_string(),
        };
        let bytes = whole.as_encoded_bytes();
        let start = last_separator(bytes).map_or(0, |at| at + 1);
        let (folder, rest) = (resolve(Path::new(part(bytes, 0, start))), part(bytes, start, bytes.len()));
        match &self.field {
            Some(field) => Pattern { before: folder, field: Some(Field { before: rest.to_owned(), ..field.clone() }) },
            None => Pattern::single(folder.join(rest)),
        }
    }

    /// A path that both name, for a frame of each from 0 to [`LAST_FRAME`]; none if there is no such path. Nothing is
    /// looked up: links and `..` make other paths.
    pub fn common(&self, other: &Pattern) -> Option<PathBuf> {
        let widths = self.widths().flat_map(|mine| other.widths().map(move |theirs| [mine, theirs]));
        widths.map(|[mine, theirs]| meet(&self.places(mine), &other.places(theirs))).find_map(|path| path)
    }

    /// How many digits numbers have.
    fn widths(&self) -> impl Iterator<Item = usize> + use<> {
        let least = self.field.as_ref().map_or(0, |field| field.digits);
        let most = if self.field.is_some() { least.max(LAST_DIGITS) } else { 0 };
        least..=most
    }

    /// The bytes of paths whose number has so many digits.
    fn places(&self, width: usize) -> Vec<Place> {
        let bytes = |text: &OsStr| text.as_encoded_bytes().iter().map(|byte| Place::Byte(*byte)).collect::<Vec<_>>();
        let Some(Field { before, digits, after }) = &self.field else { return bytes(self.before.as_os_str()) };
        let mut places = bytes(self.before.join(before).as_os_str());
        places.extend((LAST_DIGITS..width).map(|_| Place::Byte(b'0')));
        // A number that is longer than its place does not begin with 0.
        places
            .extend((0..width.min(LAST_DIGITS)).map(|at| Place::Digit { least: u8::from(at == 0 && width > *digits) }));
        places.extend(bytes(after));
        places
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

/// Digits of [`LAST_FRAME`].
const LAST_DIGITS: usize = LAST_FRAME.ilog10() as usize + 1;

/// A byte of a path.
#[derive(Clone, Copy)]
enum Place {
    Byte(u8),
    /// Any digit from `least` on.
    Digit {
        least: u8,
    },
}

/// A path that fits both.
fn meet(mine: &[Place], theirs: &[Place]) -> Option<PathBuf> {
    if mine.len() != theirs.len() {
        return None;
    }
    let byte = |places: (&Place, &Place)| match places {
        (Place::Byte(a), Place::Byte(b)) => (a == b).then_some(*a),
        (Place::Byte(byte), Place::Digit { least }) | (Place::Digit { least }, Place::Byte(byte)) => {
            (b'0' + least..=b'9').contains(byte).then_some(*byte)
        }
        (Place::Digit { least: a }, Place::Digit { least: b }) => Some(b'0' + a.max(b)),
    };
    let bytes: Vec<u8> = mine.iter().zip(theirs).map(byte).collect::<Option<_>>()?;
    Some(PathBuf::from(part(&bytes, 0, bytes.len())))
}

fn last_separator(bytes: &[u8]) -> Option<usize> {
    bytes.iter().rposition(|&byte| byte.is_ascii() && std::path::is_separator(char::from(byte)))
}

/// `bytes[from..to]` of a path. It is cut beside ASCII characters, or bytes in it are other ASCII characters.
fn part(bytes: &[u8], from: usize, to: usize) -> &OsStr {
    // SAFETY: the bytes are a path's encoded ones, which may be cut beside any ASCII character.
    unsafe { OsStr::from_encoded_bytes_unchecked(&bytes[from..to]) }
}

/// Every place for a number in `bytes[from..to]`: start, end, digits.
fn fields(bytes: &[u8], from: usize, to: usize) -> Vec<(usize, usize, usize)> {
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

    #[cfg(unix)]
    #[test]
    fn bytes_around_the_number_may_be_anything() {
        use std::os::unix::ffi::OsStrExt;
        let path = |bytes: &'static [u8]| Path::new(OsStr::from_bytes(bytes));
        for (pattern, expected) in [
            (&b"out\xff/####.png"[..], &b"out\xff/0007.png"[..]),
            (b"\xff%03d\xfe.png", b"\xff007\xfe.png"),
            (b"\xfe##/a\xff.png", b"\xfe07/a\xff.png"),
        ] {
            let pattern = Pattern::parse(path(pattern)).unwrap();
            assert!(pattern.has_number() && pattern.check_frames(1, 2).is_ok());
            assert_eq!(pattern.path(7), path(expected));
        }
        assert!(Pattern::parse(path(b"\xff##_%04d.png")).is_err());
    }

    #[test]
    fn patterns_with_a_path_in_common_are_found() {
        let common = |a: &str, b: &str| {
            let [a, b] = [a, b].map(|pattern| Pattern::parse(pattern).unwrap());
            assert_eq!(a.common(&b), b.common(&a));
            a.common(&b)
        };
        for (a, b, path) in [
            ("im/####.png", "im/%04d.png", "im/0000.png"),
            // Of other widths: where numbers are longer than both.
            ("####.png", "%02d.png", "1000.png"),
            ("%d.png", "######.png", "100000.png"),
            ("####.png", "0042.png", "0042.png"),
            ("##.png", "123.png", "123.png"),
            ("1##.png", "####.png", "1100.png"),
            ("f.##.exr", "f.1#.exr", "f.10.exr"),
            ("%010d.png", "%012d.png", ""),
            ("%07d.png", "0%06d.png", "0000000.png"),
            ("s.##/a.png", "s.05/a.png", "s.05/a.png"),
            ("one.png", "one.png", "one.png"),
        ] {
            assert_eq!(common(a, b), (!path.is_empty()).then(|| path.into()), "{a} {b}");
        }
        for (a, b) in [
            ("####.png", "042.png"),
            ("#.png", "01.png"),
            ("##.png", "1000000.png"),
            ("a.####.png", "b.####.png"),
            ("a/####.png", "b/####.png"),
            ("####.png", "####.exr"),
            ("####.png", "00x1.png"),
            ("####.png", "smoke.####.png"),
            ("one.png", "two.png"),
        ] {
            assert_eq!(common(a, b), None, "{a} {b}");
        }
        let a_file_named_so = Pattern::single("##.png");
        assert_eq!(a_file_named_so.common(&Pattern::parse("##.png").unwrap()), None);
    }

    #[test]
    fn the_folder_of_a_pattern_is_replaced() {
        let moved = |pattern: &str| {
            let pattern = Pattern::parse(pattern).unwrap();
            pattern.with_folder(|folder| Path::new("/new").join(folder)).path(7)
        };
        assert_eq!(moved("a/b.####.png"), Path::new("/new/a/b.0007.png"));
        assert_eq!(moved("####.png"), Path::new("/new/0007.png"));
        assert_eq!(moved("s.##/b.png"), Path::new("/new/s.07/b.png"));
        assert_eq!(moved("a/b.png"), Path::new("/new/a/b.png"));
        let below = Pattern::parse("####.png").unwrap().below(Path::new("c#"));
        assert_eq!(below.with_folder(Path::to_owned).path(7), Path::new("c#/0007.png"));
    }

    #[test]
    fn folders_of_relative_patterns() {
        let pattern = Pattern::parse("v/####.npz").unwrap();
        assert_eq!(pattern.clone().below(Path::new("/shots/c#")).path(1), Path::new("/shots/c#/v/0001.npz"));
        assert_eq!(Pattern::parse("/x/#.npz").unwrap().below(Path::new("/shots")).path(1), Path::new("/x/1.npz"));
        assert_eq!(Pattern::parse("one.npz").unwrap().below(Path::new("/s")).path(1), Path::new("/s/one.npz"));
    }
}
