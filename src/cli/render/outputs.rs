//! Where each frame's files go.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

use super::Failure;
use super::layers::LayerName;
use crate::io::WriteError;
use crate::io::array::{is_whole_npy, write_npy};
use crate::io::image::{read_exr_sized, write_exr};
use crate::io::pattern::Pattern;
use crate::io::picture::{self, Format};

/// A layer: what a pass wrote.
pub(super) struct Layer {
    /// `effect.layer`, as in the file name.
    pub(super) name: &'static str,
    pub(super) data: LayerData,
}

/// What a layer holds.
pub(super) enum LayerData {
    /// One value per pixel: channel `Y`.
    Value(Vec<f32>),
    /// Channels `R G B`.
    Rgb(Vec<[f32; 3]>),
    /// Channels `R G B A`.
    Colour(Vec<[f32; 4]>),
    /// An array of this shape, the last axis running fastest.
    Array { shape: Vec<u64>, values: Vec<f32> },
}

impl LayerData {
    /// Rows of so many columns.
    pub(super) fn table(columns: u64, values: Vec<f32>) -> LayerData {
        LayerData::Array { shape: vec![values.len() as u64 / columns.max(1), columns], values }
    }
}

/// A frame that is done on the device.
pub(super) struct Frame {
    /// The shot's number of it.
    pub(super) number: u32,
    /// Linear, premultiplied.
    pub(super) pixels: Vec<[f32; 4]>,
    /// Empty if no layers are written.
    pub(super) layers: Vec<Layer>,
}

/// The files of a frame.
pub(super) struct Outputs {
    picture: Pattern,
    format: Format,
    layers: Option<PathBuf>,
    size: [u32; 2],
}

impl Outputs {
    /// Takes the pattern apart; `[first, last]` are the frames that are rendered.
    pub(super) fn new(
        pattern: &Path,
        layers: Option<&Path>,
        size: [u32; 2],
        [first, last]: [u32; 2],
    ) -> Result<Outputs, Failure> {
        let picture = Pattern::parse(pattern)?;
        let Some(format) = Format::of(&picture.path(first)) else {
            let pattern = pattern.display();
            return Err(Failure::usage(format!("-o {pattern}: the name must end in .png or .exr, as in out/####.png")));
        };
        picture.check_frames(first, last)?;
        Ok(Outputs { picture, format, layers: layers.map(Path::to_owned), size })
    }

    /// Whether layers are written.
    pub(super) fn has_layers(&self) -> bool {
        self.layers.is_some()
    }

    /// The frame's picture.
    pub(super) fn picture(&self, frame: u32) -> PathBuf {
        self.picture.path(frame)
    }

    fn layer(&self, folder: &Path, name: &str, is_array: bool, frame: u32) -> PathBuf {
        let extension = if is_array { "npy" } else { "exr" };
        folder.join(format!("{name}.{frame:04}.{extension}"))
    }

    /// All files of a frame; `layers` as for [`Outputs::finished`].
    pub(super) fn files<'a>(&'a self, frame: u32, layers: &'a [LayerName]) -> impl Iterator<Item = PathBuf> + 'a {
        let files = self.layers.iter().flat_map(move |folder| {
            layers.iter().map(move |(name, is_array)| self.layer(folder, name, *is_array, frame))
        });
        files.chain([self.picture(frame)])
    }

    /// Makes the folders and tries to write in them, so that a long rendering does not fail at its first frame.
    pub(super) fn probe(&self, frame: u32, others: &[&Path]) -> Result<(), Failure> {
        probe(&self.picture(frame))?;
        if let Some(folder) = &self.layers {
            probe(&self.layer(folder, "layer", false, frame))?;
        }
        others.iter().try_for_each(|path| probe(path))
    }

    /// Writes a frame: the layers first, so that a frame with a picture is complete.
    pub(super) fn write(&self, frame: &Frame) -> Result<(), Failure> {
        if let Some(folder) = &self.layers {
            for Layer { name, data } in &frame.layers {
                let path = self.layer(folder, name, matches!(data, LayerData::Array { .. }), frame.number);
                match data {
                    LayerData::Value(values) => write_exr(&path, self.size, values)?,
                    LayerData::Rgb(pixels) => write_exr(&path, self.size, pixels)?,
                    LayerData::Colour(pixels) => write_exr(&path, self.size, pixels)?,
                    LayerData::Array { shape, values } => write_npy(&path, shape, values)?,
                }
            }
        }
        Ok(picture::write(&self.picture(frame.number), self.format, self.size, &frame.pixels)?)
    }

    /// The pixels of a frame all of whose files are there and whole; `layers` names those that an effect writes, and
    /// whether each is an array.
    pub(super) fn finished(&self, frame: u32, layers: &[LayerName]) -> Option<Vec<[f32; 4]>> {
        if let Some(folder) = &self.layers {
            let whole = |(name, is_array): &LayerName| {
                let path = self.layer(folder, name, *is_array, frame);
                match is_array {
                    true => is_whole_npy(&path),
                    false => read_exr_sized(&path, self.size).is_ok(),
                }
            };
            if !layers.iter().all(whole) {
                return None;
            }
        }
        let path = self.picture(frame);
        if self.format == Format::Png && !fs::read(&path).ok()?.ends_with(&PNG_END) {
            return None;
        }
        picture::read_sized(&path, self.size).ok().map(|picture| picture.pixels)
    }
}

/// The chunk that ends a PNG file. Decoders do without, but then the file is not the one that was written.
const PNG_END: [u8; 12] = *b"\0\0\0\0IEND\xae\x42\x60\x82";

/// Whether `path` could be written: its folder is made, and a file beside it is written and removed.
fn probe(path: &Path) -> Result<(), Failure> {
    let error = |source: io::Error| WriteError { path: path.to_owned(), source };
    if fs::metadata(path).is_ok_and(|m| !m.is_file()) {
        let source = io::Error::new(io::ErrorKind::AlreadyExists, "there is something of that name that is not a file");
        return Err(error(source).into());
    }
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    fs::create_dir_all(folder).map_err(error)?;
    let trial = folder.join(format!(".celfx.{}.part", std::process::id()));
    let written = File::create_new(&trial).map(drop);
    // The first error is the one to report.
    let removed = fs::remove_file(&trial);
    Ok(written.and(removed).map_err(error)?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::tests::Folder;

    fn frame(number: u32) -> Frame {
        let layers = vec![
            Layer { name: "smoke.depth", data: LayerData::Value(vec![1.0, f32::INFINITY]) },
            Layer { name: "smoke", data: LayerData::Colour(vec![[0.0; 4]; 2]) },
            Layer { name: "smoke.spheres", data: LayerData::table(5, vec![0.5; 10]) },
            Layer { name: "flame.mean", data: LayerData::Rgb(vec![[0.25; 3]; 2]) },
            Layer { name: "flame.mask", data: LayerData::Array { shape: vec![2, 3, 3], values: vec![0.5; 18] } },
        ];
        Frame { number, pixels: vec![[0.0, 0.0, 0.0, 1.0]; 2], layers }
    }

    const LAYERS: [LayerName; 5] = [
        ("smoke.depth", false),
        ("smoke", false),
        ("smoke.spheres", true),
        ("flame.mean", false),
        ("flame.mask", true),
    ];

    #[test]
    fn a_frame_is_finished_once_every_file_of_it_is_whole() {
        let folder = Folder::new();
        let layers = folder.0.join("layers");
        let outputs = Outputs::new(&folder.0.join("####.png"), Some(&layers), [2, 1], [1, 9]).expect("a pattern");
        assert!(outputs.finished(7, &LAYERS).is_none());
        outputs.write(&frame(7)).expect("written");
        assert_eq!(outputs.finished(7, &LAYERS), Some(frame(7).pixels));
        let files = [
            "layers/smoke.depth.0007.exr",
            "layers/smoke.0007.exr",
            "layers/smoke.spheres.0007.npy",
            "layers/flame.mean.0007.exr",
            "layers/flame.mask.0007.npy",
            "0007.png",
        ];
        for file in files {
            let path = folder.0.join(file);
            let whole = fs::read(&path).expect(file);
            fs::write(&path, &whole[..whole.len() - 1]).expect(file);
            assert!(outputs.finished(7, &LAYERS).is_none(), "{file} is cut");
            fs::remove_file(&path).expect(file);
            assert!(outputs.finished(7, &LAYERS).is_none(), "{file} is missing");
            fs::write(&path, whole).expect(file);
            assert!(outputs.finished(7, &LAYERS).is_some(), "{file} is back");
        }
    }

    #[test]
    fn a_probe_leaves_nothing_and_finds_what_cannot_be_written() {
        let folder = Folder::new();
        fs::write(folder.0.join("file"), b"").expect("temporary folder");
        let outputs = |pattern: &str| Outputs::new(&folder.0.join(pattern), None, [2, 1], [1, 9]).expect("a pattern");
        outputs("out/####.png").probe(1, &[]).expect("writable");
        assert_eq!(fs::read_dir(folder.0.join("out")).expect("made").count(), 0);
        let below_a_file = outputs("file/####.png").probe(1, &[]).expect_err("not a folder");
        assert!(below_a_file.code == Failure::OUTPUT && below_a_file.message.contains("0001.png"));
        let profile = folder.0.join("out");
        assert_eq!(outputs("out/####.png").probe(1, &[&profile]).expect_err("a folder").code, Failure::OUTPUT);
    }

    #[test]
    fn patterns_that_cannot_serve_are_refused() {
        for pattern in ["out/####.jpg", "out/####", "out.png", "##-##.png"] {
            let failure = Outputs::new(Path::new(pattern), None, [2, 1], [1, 9]).err().expect(pattern);
            assert!(failure.code == Failure::USAGE && failure.message.contains(pattern), "{}", failure.message);
        }
        assert!(Outputs::new(Path::new("one.png"), None, [2, 1], [4, 4]).is_ok(), "one frame needs no number");
    }
}
