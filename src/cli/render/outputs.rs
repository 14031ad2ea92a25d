//! Where each frame's files go.

use std::path::{Path, PathBuf};
use std::{fmt, fs};

use xxhash_rust::xxh3::xxh3_128;

use super::turns::Claim;
use super::{Failure, layered};
use crate::io::array::write_npy;
use crate::io::display::Display;
use crate::io::file::digest;
use crate::io::image::{Header, Packing, write_exr, write_exr_channels, write_exr_layered};
use crate::io::overlap::Files;
use crate::io::pattern::Pattern;
use crate::io::picture::{self, Format};
use crate::io::{ReadError, WriteError, probe};
use crate::program::layers::{Layer, LayerData, LayerName, VECTORS, Wanted};
use crate::view::Camera;

/// A frame that is done on the device.
pub(super) struct Frame {
    /// The shot's number of it.
    pub(super) number: u32,
    /// A hash of what it was made from.
    pub(super) origin: u128,
    /// Linear, premultiplied.
    pub(super) pixels: Vec<[f32; 4]>,
    /// Empty if no layers are written.
    pub(super) layers: Vec<Layer>,
    /// What it is seen through.
    pub(super) camera: Camera,
    /// Keeps other processes from it until it is written.
    pub(super) claim: Option<Claim>,
}

#[cfg(test)]
impl Frame {
    /// Without pixels and layers.
    pub(super) fn of_nothing(number: u32) -> Frame {
        Frame { number, origin: 0, pixels: Vec::new(), layers: Vec::new(), camera: Camera::default(), claim: None }
    }
}

/// Files of layers.
enum LayerFiles {
    /// None are written.
    None,
    /// One of each layer.
    Each(Vec<(LayerName, Pattern)>),
    /// One of all that are images, with the picture; and whether there are motion vectors in it.
    One(Pattern, bool),
}

/// All files of a run.
pub(super) struct Outputs {
    /// The pattern as it was given.
    given: String,
    picture: Pattern,
    format: Format,
    layers: LayerFiles,
    /// Of the one file of layers.
    packing: Packing,
    /// Those of all frames together: the profile, the contact sheet, the animation.
    others: Vec<Files>,
    size: [u32; 2],
    fps: f64,
    /// What PNG files are coded for.
    display: Display,
}

/// The state of a frame on disk.
pub(super) enum Found {
    /// Nothing, or not all of it, or half a file.
    Nothing,
    /// A whole picture that was not made from what this run would make it from, or does not say from what.
    Other,
    /// All of it: the pixels.
    Finished(Vec<[f32; 4]>),
}

impl Outputs {
    /// Takes the pattern apart; `layers` are those that are written, and the folder or the EXR files for them. `[first, last]`
    /// are the frames that are rendered, of pictures of that size and so many a second; `others` the files of all of them
    /// together.
    pub(super) fn new(
        pattern: &Path,
        layers: Option<(&Path, &[LayerName])>,
        others: Vec<Files>,
        (size, fps): ([u32; 2], f64),
        [first, last]: [u32; 2],
    ) -> Result<Outputs, Failure> {
        let picture = Pattern::parse(pattern)?;
        let given = format!("-o {}", pattern.display());
        let Some(format) = Format::of(&picture.path(first)) else {
            return Err(Failure::usage(format!("{given}: the name must end in .png or .exr, as in out/####.png")));
        };
        picture.check_frames(first, last)?;
        let layers =
            layers.map_or(Ok(LayerFiles::None), |(path, names)| LayerFiles::new(path, names, [first, last]))?;
        Ok(Outputs {
            given,
            picture,
            format,
            layers,
            packing: Packing::default(),
            others,
            size,
            fps,
            display: Display::Srgb,
        })
    }

    /// With pictures coded for this display.
    pub(super) fn shown_on(self, display: Display) -> Outputs {
        Outputs { display, ..self }
    }

    /// What a frame is coded for where it is shown beside others: one that has just been made, and one that was read from its
    /// picture's file.
    pub(super) fn display(&self, is_read: bool) -> Display {
        if is_read && self.format == Format::Png { self.display.read_back() } else { self.display.clone() }
    }

    /// With the one file of layers packed so, if that is said: an error if there is none.
    pub(super) fn packed(self, packing: Option<Packing>) -> Result<Outputs, Failure> {
        let is_one = matches!(self.layers, LayerFiles::One(..));
        if packing.is_some() && !is_one {
            return Err(Failure::usage("--compression is of one file a frame: expected --layers FILE.####.exr"));
        }
        Ok(Outputs { packing: packing.unwrap_or_default(), ..self })
    }

    /// The layers that are written.
    pub(super) fn wanted(&self) -> Wanted {
        match self.layers {
            LayerFiles::None => Wanted::None,
            LayerFiles::One(..) => Wanted::Images,
            LayerFiles::Each(_) => Wanted::All,
        }
    }

    fn has_layers(&self) -> bool {
        self.wanted() != Wanted::None
    }

    /// The frame's picture.
    pub(super) fn picture(&self, frame: u32) -> PathBuf {
        self.picture.path(frame)
    }

    /// Every file that is written, of whatever frame.
    pub(super) fn all(&self) -> Vec<Files> {
        let layer = |((name, _), pattern): &(LayerName, Pattern)| {
            Files::new(format!("the layer {name} of --layers"), pattern.clone())
        };
        let mut all = vec![Files::new(&*self.given, self.picture.clone())];
        match &self.layers {
            LayerFiles::None => {}
            LayerFiles::Each(layers) => all.extend(layers.iter().map(layer)),
            LayerFiles::One(pattern, _) => all.push(Files::new("--layers", pattern.clone())),
        }
        all.extend(self.others.iter().cloned());
        all
    }

    /// All files of a frame.
    pub(super) fn files(&self, frame: u32) -> impl Iterator<Item = PathBuf> + '_ {
        self.layers.patterns().map(move |pattern| pattern.path(frame)).chain([self.picture(frame)])
    }

    /// The files of all frames together.
    pub(super) fn others(&self) -> impl Iterator<Item = PathBuf> + '_ {
        self.others.iter().map(|other| other.pattern.path(0))
    }

    /// Makes the folders and tries to write in them what has the longest names, so that a long rendering fails neither at
    /// its first frame nor at its last.
    pub(super) fn probe(&self, [first, last]: [u32; 2]) -> Result<(), Failure> {
        let frames = [Some(first), Some(last).filter(|last| *last != first)].into_iter().flatten();
        let mut files = frames.flat_map(|frame| self.files(frame)).chain(self.others());
        Ok(files.try_for_each(|path| probe(&path))?)
    }

    /// Writes a frame: the layers first, so that a frame with a picture is complete. The picture's file says what all of
    /// it was made from.
    pub(super) fn write(&self, frame: &Frame) -> Result<(), Failure> {
        match &self.layers {
            LayerFiles::None => {}
            LayerFiles::Each(layers) => {
                for ((name, _), pattern) in layers {
                    let Some(layer) = frame.layers.iter().find(|layer| layer.name == *name) else { continue };
                    self.write_layer(&pattern.path(frame.number), &layer.data)?;
                }
            }
            LayerFiles::One(pattern, _) => {
                let (channels, texts) = layered::channels(self.size[0] as usize, &frame.pixels, &frame.layers);
                let note = Note { origin: frame.origin, layers: None }.to_string();
                let Frame { number, camera, .. } = frame;
                let (fps, packing, note) = (self.fps, self.packing, Some(&note[..]));
                let header = Header { frame: *number, fps, camera: *camera, packing, note, texts };
                write_exr_layered(&pattern.path(*number), self.size, channels, &header)?;
            }
        }
        let path = self.picture(frame.number);
        let layers = match self.has_layers() {
            true => self.layer_digest(frame.number).ok(),
            false => None,
        };
        let note = Note { origin: frame.origin, layers }.to_string();
        Ok(picture::write(&path, self.format, self.size, &frame.pixels, &self.display, Some(&note))?)
    }

    fn write_layer(&self, path: &Path, data: &LayerData) -> Result<(), WriteError> {
        match data {
            LayerData::Value(values) => write_exr(path, self.size, values),
            LayerData::Rgb(pixels) => write_exr(path, self.size, pixels),
            LayerData::Colour(pixels) => write_exr(path, self.size, pixels),
            LayerData::Vector(pixels) => {
                let channel = |c: usize| pixels.iter().map(|vector| vector[c]).collect();
                write_exr_channels(path, self.size, &[("X".to_owned(), channel(0)), ("Y".to_owned(), channel(1))])
            }
            LayerData::Objects { samples, .. } => {
                let values: Vec<[f32; 4]> = samples.iter().map(|sample| sample.map(|number| number as f32)).collect();
                write_exr(path, self.size, &values)
            }
            LayerData::Array { shape, values } => write_npy(path, shape, values),
        }
    }

    /// A hash of all layers' files of a frame.
    fn layer_digest(&self, frame: u32) -> Result<u128, ReadError> {
        let digests = self.layers.patterns().map(|pattern| digest(&pattern.path(frame)));
        let digests = digests.collect::<Result<Vec<u128>, _>>()?;
        let mut bytes: Vec<u8> = digests.into_iter().flat_map(u128::to_le_bytes).collect();
        // A file without them is not one with them.
        bytes.extend(matches!(self.layers, LayerFiles::One(_, true)).then_some(1));
        Ok(xxh3_128(&bytes))
    }

    /// The state of a frame that would be made from `origin`.
    pub(super) fn find(&self, frame: u32, origin: u128) -> Found {
        let path = self.picture(frame);
        if self.format == Format::Png && !fs::read(&path).is_ok_and(|bytes| bytes.ends_with(&PNG_END)) {
            return Found::Nothing;
        }
        let Ok(picture) = picture::read(&path) else { return Found::Nothing };
        let note = picture::note(&path).and_then(|note| Note::parse(&note));
        let Some(note) = note.filter(|note| note.origin == origin && picture.size == self.size) else {
            return Found::Other;
        };
        // Layers of another run may lie there: of one that was not asked for them, or was ended between them and the picture.
        let is_whole = !self.has_layers()
            || note.layers.is_some_and(|layers| self.layer_digest(frame).is_ok_and(|found| found == layers));
        if is_whole { Found::Finished(picture.pixels) } else { Found::Nothing }
    }
}

impl LayerFiles {
    /// In a folder, one file each; or in EXR files, one a frame, if that is what the name says.
    fn new(path: &Path, names: &[LayerName], [first, last]: [u32; 2]) -> Result<LayerFiles, Failure> {
        if path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("exr")) {
            let pattern = Pattern::parse(path)?;
            pattern.check_frames(first, last)?;
            return Ok(LayerFiles::One(pattern, names.contains(&VECTORS)));
        }
        let each = names.iter().map(|(name, is_array)| {
            let extension = if *is_array { "npy" } else { "exr" };
            Ok(((*name, *is_array), Pattern::parse(format!("{name}.####.{extension}"))?.below(path)))
        });
        Ok(LayerFiles::Each(each.collect::<Result<_, Failure>>()?))
    }

    fn patterns(&self) -> impl Iterator<Item = &Pattern> {
        let (each, one) = match self {
            LayerFiles::None => (&[][..], None),
            LayerFiles::Each(layers) => (&layers[..], None),
            LayerFiles::One(pattern, _) => (&[][..], Some(pattern)),
        };
        each.iter().map(|(_, pattern)| pattern).chain(one)
    }
}

/// The metadata in a picture's file.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Note {
    /// A hash of what the frame was made from.
    origin: u128,
    /// A hash of the layers that were written with it, if there were any.
    layers: Option<u128>,
}

impl Note {
    fn parse(text: &str) -> Option<Note> {
        let hash = |text: &str| u128::from_str_radix(text, 16).ok();
        let text = text.strip_prefix("origin ")?;
        match text.split_once(" layers ") {
            Some((origin, layers)) => Some(Note { origin: hash(origin)?, layers: Some(hash(layers)?) }),
            None => Some(Note { origin: hash(text)?, layers: None }),
        }
    }
}

impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "origin {:032x}", self.origin)?;
        self.layers.map_or(Ok(()), |layers| write!(f, " layers {layers:032x}"))
    }
}

/// The chunk that ends a PNG file. Decoders do without, but then the file is not the one that was written.
const PNG_END: [u8; 12] = *b"\0\0\0\0IEND\xae\x42\x60\x82";

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
        Frame { origin: ORIGIN, pixels: vec![[0.0, 0.0, 0.0, 1.0]; 2], layers, ..Frame::of_nothing(number) }
    }

    const ORIGIN: u128 = 42;
    /// Size and rate.
    const SHOT: ([u32; 2], f64) = ([2, 1], 24.0);
    const LAYERS: [LayerName; 5] = [
        ("smoke.depth", false),
        ("smoke", false),
        ("smoke.spheres", true),
        ("flame.mean", false),
        ("flame.mask", true),
    ];

    fn outputs(folder: &Folder, pattern: &str, layers: Option<&Path>) -> Outputs {
        let layers = layers.map(|folder| (folder, &LAYERS[..]));
        Outputs::new(&folder.0.join(pattern), layers, Vec::new(), SHOT, [1, 9]).expect("a pattern")
    }

    fn is_finished(outputs: &Outputs) -> bool {
        matches!(outputs.find(7, ORIGIN), Found::Finished(pixels) if pixels == frame(7).pixels)
    }

    #[test]
    fn a_frame_is_finished_once_every_file_of_it_is_whole() {
        let folder = Folder::new();
        let layers = folder.0.join("layers");
        for picture in ["####.png", "####.exr"] {
            let outputs = outputs(&folder, picture, Some(&layers));
            assert!(matches!(outputs.find(7, ORIGIN), Found::Nothing));
            outputs.write(&frame(7)).expect("written");
            assert!(is_finished(&outputs));
            for file in [
                "layers/smoke.depth.0007.exr",
                "layers/smoke.0007.exr",
                "layers/smoke.spheres.0007.npy",
                "layers/flame.mean.0007.exr",
                "layers/flame.mask.0007.npy",
                &picture.replace("####", "0007"),
            ] {
                let path = folder.0.join(file);
                let whole = fs::read(&path).expect(file);
                fs::write(&path, &whole[..whole.len() - 1]).expect(file);
                assert!(matches!(outputs.find(7, ORIGIN), Found::Nothing), "{file} is cut");
                fs::remove_file(&path).expect(file);
                assert!(matches!(outputs.find(7, ORIGIN), Found::Nothing), "{file} is missing");
                fs::write(&path, whole).expect(file);
                assert!(is_finished(&outputs), "{file} is back");
            }
        }
    }

    #[test]
    fn layers_of_one_file_are_part_of_a_frame() {
        let folder = Folder::new();
        let one = folder.0.join("comp.####.exr");
        let outputs = outputs(&folder, "####.png", Some(&one));
        outputs.write(&frame(7)).expect("written");
        assert!(is_finished(&outputs));
        let path = folder.0.join("comp.0007.exr");
        let names: Vec<String> =
            crate::io::image::read_exr(&path).expect("readable").channels.into_iter().map(|(name, _)| name).collect();
        assert!(
            ["R", "A", "Z", "flame_mean.B", "smoke.R"].iter().all(|name| names.iter().any(|n| n == name)),
            "{names:?}"
        );
        fs::remove_file(&path).expect("removed");
        assert!(matches!(outputs.find(7, ORIGIN), Found::Nothing));
        let failure =
            Outputs::new(&folder.0.join("####.png"), Some((Path::new("one.exr"), &LAYERS)), Vec::new(), SHOT, [1, 9]);
        assert_eq!(failure.err().expect("one name for nine frames").code, Failure::USAGE);
    }

    #[test]
    fn frames_of_another_origin_are_told_apart() {
        let folder = Folder::new();
        let layers = folder.0.join("layers");
        for pattern in ["####.png", "####.exr"] {
            let (with, without) = (outputs(&folder, pattern, Some(&layers)), outputs(&folder, pattern, None));
            without.write(&frame(7)).expect("written");
            assert!(matches!(with.find(7, ORIGIN), Found::Nothing), "it has no layers");
            assert!(is_finished(&without) && matches!(without.find(7, ORIGIN + 1), Found::Other));
            with.write(&frame(7)).expect("written");
            assert!(is_finished(&with) && is_finished(&without));
            // A run with other settings was ended between its layers and its picture.
            write_exr(&layers.join("smoke.depth.0007.exr"), [2, 1], &[2.0f32, 3.0]).expect("written");
            assert!(matches!(with.find(7, ORIGIN), Found::Nothing) && is_finished(&without));
            // As older versions wrote it.
            let path = without.picture(7);
            picture::write(&path, without.format, [2, 1], &frame(7).pixels, &Display::Srgb, None).expect("written");
            assert!(matches!(without.find(7, ORIGIN), Found::Other));
        }
    }

    #[test]
    fn notes_come_back() {
        for note in [Note { origin: u128::MAX, layers: None }, Note { origin: 1, layers: Some(2) }] {
            assert_eq!(Note::parse(&note.to_string()), Some(note));
        }
        assert_eq!(["", "origin", "origin x", "origin 1 layers", "1"].map(Note::parse), [None; 5]);
    }

    #[test]
    fn a_probe_leaves_nothing_and_finds_what_cannot_be_written() {
        let folder = Folder::new();
        fs::write(folder.0.join("file"), b"").expect("temporary folder");
        let layers = folder.0.join("layers");
        outputs(&folder, "out/####.png", Some(&layers)).probe([1, 9]).expect("writable");
        assert_eq!(["out", "layers"].map(|name| fs::read_dir(folder.0.join(name)).expect("made").count()), [0; 2]);
        let below_a_file = outputs(&folder, "file/####.png", None).probe([1, 9]).expect_err("not a folder");
        assert!(below_a_file.code == Failure::OUTPUT && below_a_file.message.contains("0001.png"));
        let profile = Files::new("--profile out", Pattern::single(folder.0.join("out")));
        let taken = Outputs::new(&folder.0.join("####.png"), None, vec![profile], SHOT, [1, 9]).expect("a pattern");
        assert_eq!(taken.probe([1, 9]).expect_err("a folder").code, Failure::OUTPUT);
        // Room for one digit, and not for two; and a layer's own name counts.
        let long = format!("{}#.png", "n".repeat(250));
        assert!(outputs(&folder, &long, None).probe([1, 9]).is_ok());
        assert!(outputs(&folder, &long, None).probe([1, 10]).expect_err("too long").message.contains("10.png"));
        fs::create_dir_all(layers.join("smoke.spheres.0009.npy")).expect("temporary folder");
        let taken = outputs(&folder, "####.png", Some(&layers)).probe([1, 9]).expect_err("a folder");
        assert!(taken.message.contains("smoke.spheres.0009.npy"), "{}", taken.message);
    }

    #[test]
    fn patterns_that_cannot_serve_are_refused() {
        let new = |pattern: &str, frames| Outputs::new(Path::new(pattern), None, Vec::new(), SHOT, frames);
        for pattern in ["out/####.jpg", "out/####", "out.png", "##-##.png"] {
            let failure = new(pattern, [1, 9]).err().expect(pattern);
            assert!(failure.code == Failure::USAGE && failure.message.contains(pattern), "{}", failure.message);
        }
        assert!(new("one.png", [4, 4]).is_ok(), "one frame needs no number");
    }
}
