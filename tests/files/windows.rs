//! EXR files of several windows, parts and layers.

use std::io::Cursor;

use celfx::io::image::Picture;
use celfx::io::picture;
use exr::prelude::{
    AnyChannel, AnyChannels, Compression, Encoding, FlatSamples, Image, ImageAttributes, IntegerBounds, Layer,
    LayerAttributes, SmallVec, Text, Vec2, WritableImage, f16,
};

use crate::Temporary;

/// A part of a file: its name, channels, and where its data are.
pub struct Part<'a> {
    pub name: Option<&'a str>,
    /// Each has the values of [`value`] for its place in this list.
    pub channels: &'a [&'a str],
    pub position: [i32; 2],
    pub size: [usize; 2],
    pub encoding: Encoding,
}

impl Default for Part<'_> {
    fn default() -> Self {
        let encoding = Encoding { compression: Compression::ZIP16, ..Encoding::SMALL_LOSSLESS };
        Part { name: None, channels: &["R", "G", "B"], position: [0; 2], size: [8, 6], encoding }
    }
}

/// What a channel has at a pixel of the plane, exact in half floats.
pub fn value(channel: usize, x: i32, y: i32) -> f32 {
    (channel as i32 * 256 + 16 * (y + 8) + x + 8) as f32 / 1024.0
}

/// A file with that display window.
pub fn exr(parts: &[Part], origin: [i32; 2], size: [usize; 2]) -> Vec<u8> {
    let layers: SmallVec<[Layer<AnyChannels<FlatSamples>>; 2]> = parts.iter().map(layer).collect();
    let display = IntegerBounds { position: Vec2(origin[0], origin[1]), size: Vec2(size[0], size[1]) };
    let mut bytes = Cursor::new(Vec::new());
    let attributes = ImageAttributes::new(display);
    match layers.len() {
        1 => {
            let image = Image::new(attributes, layers.into_iter().next().expect("one"));
            image.write().to_buffered(&mut bytes).expect("a picture");
        }
        _ => Image::new(attributes, layers).write().to_buffered(&mut bytes).expect("a picture"),
    }
    bytes.into_inner()
}

fn layer(part: &Part) -> Layer<AnyChannels<FlatSamples>> {
    let [width, height] = part.size;
    let samples = |channel: usize| {
        let at = |i: usize| [part.position[0] + (i % width) as i32, part.position[1] + (i / width) as i32];
        let samples = (0..width * height).map(at).map(|[x, y]| f16::from_f32(value(channel, x, y)));
        FlatSamples::F16(samples.collect())
    };
    let channels = part.channels.iter().enumerate().map(|(i, name)| AnyChannel::new(*name, samples(i))).collect();
    let attributes = LayerAttributes {
        layer_name: part.name.map(Text::from),
        layer_position: Vec2(part.position[0], part.position[1]),
        ..LayerAttributes::default()
    };
    Layer::new((width, height), attributes, part.encoding, AnyChannels::sort(channels))
}

fn read(bytes: &[u8]) -> Picture<[f32; 4]> {
    picture::read(Temporary::new("exr").with(bytes)).expect("a picture")
}

/// What is seen in a display window of data at `position` of `size`: 0 outside of the data.
fn seen([left, top]: [i32; 2], [width, height]: [usize; 2], position: [i32; 2], size: [usize; 2]) -> Vec<[f32; 4]> {
    let pixel = |i: usize| {
        let [x, y] = [left + (i % width) as i32, top + (i / width) as i32];
        let has = |axis: usize, at: i32| (position[axis]..position[axis] + size[axis] as i32).contains(&at);
        let colour = [0, 1, 2].map(|c| if has(0, x) && has(1, y) { value(c, x, y) } else { 0.0 });
        [colour[0], colour[1], colour[2], 1.0]
    };
    (0..width * height).map(pixel).collect()
}

#[test]
fn data_are_placed_in_the_display_window() {
    let tiles = Encoding { blocks: exr::image::Blocks::Tiles(Vec2(5, 4)), ..Part::default().encoding };
    // Within, over each edge, all around, beside.
    let places: [([i32; 2], [usize; 2]); 6] = [
        ([1, 2], [3, 2]),
        ([-3, -4], [8, 6]),
        ([3, 3], [8, 20]),
        ([-4, -3], [20, 40]),
        ([8, 0], [4, 4]),
        ([0, -8], [8, 8]),
    ];
    for (position, size) in places {
        for (encoding, origin) in [(Part::default().encoding, [0, 0]), (tiles, [0, 0]), (tiles, [-2, 1])] {
            let file = exr(&[Part { position, size, encoding, ..Part::default() }], origin, [8, 6]);
            let picture = read(&file);
            assert_eq!(picture.size, [8, 6]);
            assert_eq!(picture.pixels, seen(origin, [8, 6], position, size), "{position:?} {size:?} {origin:?}");
        }
    }
}

#[test]
fn the_part_and_the_layer_that_have_colour_are_taken() {
    let colours = |channels: &[&str], first: usize| {
        let pixels = read(&exr(&[Part { channels, ..Part::default() }], [0; 2], [8, 6])).pixels;
        assert_eq!(pixels[9][..3], [0, 1, 2].map(|c| value(first + c, 1, 1)), "{channels:?}");
    };
    colours(&["Z", "R", "G", "B"], 1);
    colours(&["beauty.R", "beauty.G", "beauty.B", "depth.Z"], 0);
    colours(&["albedo.R", "albedo.G", "albedo.B", "View.Combined.R", "View.Combined.G", "View.Combined.B"], 3);
    colours(&["albedo.R", "albedo.G", "albedo.B", "R", "G", "B"], 3);
    let part = |name, channels| Part { name: Some(name), channels, ..Part::default() };
    let depth = || part("depth", &["Z"]);
    let of_parts = |parts: &[Part]| read(&exr(parts, [0; 2], [8, 6])).pixels[9];
    let plain = [0, 1, 2].map(|c| value(c, 1, 1));
    assert_eq!(of_parts(&[depth(), part("left", &["R", "G", "B"])])[..3], plain);
    let alpha = part("rgba", &["A", "R", "G", "B"]);
    let named = of_parts(&[part("albedo", &["R", "G", "B"]), alpha]);
    assert_eq!(named, [1, 2, 3, 0].map(|c| value(c, 1, 1)));
    let refused = |parts: &[Part], words: &[&str]| {
        let file = Temporary::new("exr");
        let error = picture::read(file.with(&exr(parts, [0; 2], [8, 6]))).expect_err("no colours").to_string();
        assert!(words.iter().all(|word| error.contains(word)), "{error}");
    };
    refused(&[depth(), part("normal", &["X", "Y"])], &["has channels Z, X, Y", "channels R, G, B"]);
    let two = ["a.R", "a.G", "a.B", "b.R", "b.G", "b.B"];
    refused(&[Part { channels: &two, ..Part::default() }], &["colours in several layers: a, b", "beauty"]);
}
