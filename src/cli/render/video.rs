//! Videos: ffmpeg, which the user has or not, encodes the pictures that have been written.

use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::thread;

use super::Failure;
use crate::io::display::Display;
use crate::io::{make_atomic, picture};

const PROGRAM: &str = "ffmpeg";
/// Kinds of file, each with what ffmpeg is told of it.
const KINDS: [(&str, &[&str]); 3] = [
    ("mp4", &["-c:v", "libx264", "-crf", "14", "-movflags", "+faststart", "-f", "mp4"]),
    ("mov", &["-c:v", "libx264", "-crf", "14", "-f", "mov"]),
    ("webm", &["-c:v", "libvpx-vp9", "-crf", "20", "-b:v", "0", "-f", "webm"]),
];
/// What players expect: even sides, colours at half the resolution, and told which they are.
const COLOURS: [&str; 10] = [
    "-vf",
    "pad=ceil(iw/2)*2:ceil(ih/2)*2,scale=out_color_matrix=bt709",
    "-pix_fmt",
    "yuv420p",
    "-color_primaries",
    "bt709",
    "-color_trc",
    "iec61966-2-1",
    "-colorspace",
    "bt709",
];

/// A video of pictures.
pub(super) struct Video {
    path: PathBuf,
    arguments: &'static [&'static str],
    size: [u32; 2],
    fps: f64,
}

impl Video {
    /// The one at `path`, if its name ends as one. An error if there is no ffmpeg: before anything is rendered.
    pub(super) fn new(path: &Path, size: [u32; 2], fps: f64) -> Result<Option<Video>, Failure> {
        let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
        let Some((_, arguments)) = KINDS.iter().find(|(name, _)| *name == extension) else { return Ok(None) };
        let started = Command::new(PROGRAM).arg("-version").stdin(Stdio::null()).output();
        match started {
            Ok(output) if output.status.success() => Ok(Some(Video { path: path.into(), arguments, size, fps })),
            started => {
                let why = started.map_or_else(|error| error.to_string(), |output| output.status.to_string());
                let what =
                    format!("--animation {}: {PROGRAM} makes videos, and cannot be started here", path.display());
                Err(Failure::usage(format!(
                    "{what}: {why}; expected it to be installed, or a name that ends in .gif or .apng"
                )))
            }
        }
    }

    /// Encodes pictures for a display, one at a time; what is transparent is black.
    pub(super) fn write(&self, pictures: impl Iterator<Item = PathBuf>, display: &Display) -> Result<(), Failure> {
        let mut unreadable = None;
        let made = make_atomic(&self.path, |part| {
            let [width, height] = self.size;
            let mut command = Command::new(PROGRAM);
            command.args(["-v", "error", "-y", "-f", "rawvideo", "-pix_fmt", "rgb24"]);
            command.args(["-s", &format!("{width}x{height}"), "-r", &self.fps.to_string(), "-i", "-"]);
            command.args(COLOURS).args(self.arguments).arg(part);
            let mut child = command.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::piped()).spawn()?;
            let (input, errors) = (child.stdin.take(), child.stderr.take());
            // It says why it ends, and waits if nobody listens.
            let said = thread::spawn(move || {
                let mut text = String::new();
                errors.map(|mut errors| errors.read_to_string(&mut text)).transpose().map(|_| text)
            });
            let fed = input.map_or(Ok(()), |mut input| {
                for path in pictures {
                    match picture::read_sized(&path, self.size) {
                        Ok(picture) => input.write_all(&over_black(&picture.pixels, display))?,
                        Err(error) => {
                            unreadable = Some(error);
                            break;
                        }
                    }
                }
                io::Result::Ok(())
            });
            let status = child.wait()?;
            let said = said.join().map_or(Ok(String::new()), |said| said).unwrap_or_default();
            match said.lines().last() {
                _ if unreadable.is_some() => Err(io::Error::other("a picture cannot be read")),
                Some(last) if !status.success() => Err(io::Error::other(format!("{PROGRAM}: {last}"))),
                None if !status.success() => Err(io::Error::other(format!("{PROGRAM}: {status}"))),
                _ => fed,
            }
        });
        match unreadable {
            Some(error) => Err(error.into()),
            None => Ok(made?),
        }
    }
}

/// Bytes of red, green and blue of linear premultiplied pixels.
fn over_black(pixels: &[[f32; 4]], display: &Display) -> Vec<u8> {
    let opaque: Vec<[f32; 4]> = pixels.iter().map(|[r, g, b, _]| [*r, *g, *b, 1.0]).collect();
    display.codes(&opaque).into_iter().flat_map(|[r, g, b, _]| [r, g, b]).collect()
}
