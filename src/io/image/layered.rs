//! One EXR of many channels: what a compositor opens without a question.

use std::path::Path;

use exr::meta::attribute::Chromaticities;
use exr::meta::header::ImageAttributes;
use exr::prelude::{
    AnyChannel, AnyChannels, AttributeValue, Compression, Encoding, FlatSamples, IntegerBounds, Layer, LayerAttributes,
    Text, Vec2, WritableImage, f16,
};
use glam::{DMat4, DVec3};

use super::{NOTE, check_size, failed, write_encoded};
use crate::io::WriteError;
use crate::view::{Camera, View};

/// The largest number that a half float holds.
const LARGEST: f32 = 65_504.0;

/// A channel of a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// As in the file: `layer.R`.
    pub name: String,
    /// One a pixel, rows from the top.
    pub values: Vec<f32>,
    /// Whether half floats hold it: colours, of which those beyond the largest half float are that. Otherwise values pass
    /// unchanged.
    pub is_half: bool,
}

/// How the file is packed, by OpenEXR's names. All keep every bit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum Packing {
    /// Not at all.
    None,
    /// Runs of equal bytes.
    Rle,
    /// Deflate, a row at a time.
    Zips,
    /// Deflate, 16 rows at a time.
    #[default]
    Zip,
    /// Wavelets: smaller for grain.
    Piz,
}

/// What the file says of the picture beside its pixels.
#[derive(Clone, Debug)]
pub struct Header<'a> {
    /// The frame's number.
    pub frame: u32,
    /// Frames in a second.
    pub fps: f64,
    /// What it is seen through.
    pub camera: Camera,
    /// How it is packed.
    pub packing: Packing,
    /// What it was made from; none: not said.
    pub note: Option<&'a str>,
    /// More texts, by their names.
    pub texts: Vec<(String, String)>,
}

/// Writes a file of one part: channels by their names. Its header has the primaries of sRGB, the
/// frame's number (`celfx/frame`) and rate, and the matrices of its view as row vectors are multiplied by them. Atomic.
pub fn write_exr_layered(
    path: &Path,
    size: [u32; 2],
    channels: Vec<Channel>,
    header: &Header,
) -> Result<(), WriteError> {
    write_encoded(path, |buffer| {
        check_size(size, channels.iter().map(|channel| channel.values.len()).min().unwrap_or(0))?;
        let channels = AnyChannels::sort(channels.into_iter().map(samples).collect());
        let compression = match header.packing {
            Packing::None => Compression::Uncompressed,
            Packing::Rle => Compression::RLE,
            Packing::Zips => Compression::ZIP1,
            Packing::Zip => Compression::ZIP16,
            Packing::Piz => Compression::PIZ,
        };
        let encoding = Encoding { compression, ..Encoding::SMALL_LOSSLESS };
        let (view, pixels) = (header.camera.view(size), (size[0] as usize, size[1] as usize));
        let layer = Layer::new(pixels, of_layer(header, &view), encoding, channels);
        let attributes = of_image(header, IntegerBounds::from_dimensions(pixels));
        exr::prelude::Image::empty(attributes).with_layer(layer).write().to_buffered(buffer).map_err(failed)
    })
}

fn samples(Channel { name, values, is_half }: Channel) -> AnyChannel<FlatSamples> {
    let half = |value: &f32| f16::from_f32(value.clamp(-LARGEST, LARGEST));
    let samples = match is_half {
        true => FlatSamples::F16(values.iter().map(half).collect()),
        false => FlatSamples::F32(values),
    };
    AnyChannel::new(Text::from(&name[..]), samples)
}

fn of_image(header: &Header, window: IntegerBounds) -> ImageAttributes {
    // Of sRGB and Rec. 709, with D65.
    let [red, green, blue, white] =
        [(0.64, 0.33), (0.30, 0.60), (0.15, 0.06), (0.3127, 0.3290)].map(|(x, y)| Vec2(x, y));
    ImageAttributes {
        pixel_aspect: header.camera.pixel_aspect as f32,
        chromaticities: Some(Chromaticities { red, green, blue, white }),
        ..ImageAttributes::new(window)
    }
}

fn of_layer(header: &Header, View { world_to_view, view_to_clip, .. }: &View) -> LayerAttributes {
    let text = |text: &str| AttributeValue::Text(Text::from(text));
    let frame = (Text::from("celfx/frame"), AttributeValue::I32(header.frame as i32));
    let note = header.note.map(|note| (Text::from(NOTE), text(note)));
    let texts = header.texts.iter().map(|(name, value)| (Text::from(&name[..]), text(value)));
    // The columns of matrices that columns are multiplied by are rows of those for rows.
    let rows = |matrix: DMat4| matrix.to_cols_array().map(|x| x as f32);
    LayerAttributes {
        frames_per_second: Some(rational(header.fps)),
        world_to_camera: Some(rows(*world_to_view)),
        // There y is up.
        world_to_normalized_device: Some(rows(
            DMat4::from_scale(DVec3::new(1.0, -1.0, 1.0)) * *view_to_clip * *world_to_view,
        )),
        software_name: Some(Text::from(concat!("celfx ", env!("CARGO_PKG_VERSION")))),
        other: [frame].into_iter().chain(note).chain(texts).collect(),
        ..LayerAttributes::default()
    }
}

/// A rate as a fraction: NTSC's are so many thousand by 1001, however they are rounded.
fn rational(fps: f64) -> (i32, u32) {
    let whole = fps.round();
    let number = |x: f64| x.round().min(f64::from(i32::MAX)) as i32;
    match () {
        () if (fps - whole).abs() < 1e-9 => (number(whole), 1),
        () if whole >= 1.0 && (fps - whole * 1000.0 / 1001.0).abs() < 2e-3 => (number(1000.0 * whole), 1001),
        () => (number(1000.0 * fps), 1000),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::image::{exr_note, read_exr};
    use crate::io::tests::Folder;

    #[test]
    fn channels_come_back_as_halves_and_floats() {
        let folder = Folder::new();
        let path = folder.0.join("a.exr");
        let channel =
            |name: &str, values: [f32; 2], is_half| Channel { name: name.to_owned(), values: values.into(), is_half };
        let channels = vec![channel("R", [1e6, 0.1], true), channel("smoke_id.Y", [0.1, f32::INFINITY], false)];
        let camera = Camera { pixel_aspect: 2.0, ..Camera::default() };
        let texts = vec![("cryptomatte/0000000/name".to_owned(), "CryptoObject".to_owned())];
        let half = f16::from_f32(0.1).to_f32();
        let expected = [("R", vec![LARGEST, half]), ("smoke_id.Y", vec![0.1, f32::INFINITY])];
        let expected = expected.map(|(name, values)| (name.to_owned(), values));
        for packing in [Packing::None, Packing::Rle, Packing::Zips, Packing::Piz, Packing::Zip] {
            let (note, texts) = (Some("origin 1"), texts.clone());
            let header = Header { frame: 7, fps: 24.0, camera, packing, note, texts };
            write_exr_layered(&path, [2, 1], channels.clone(), &header).expect("written");
            assert_eq!(read_exr(&path).expect("readable").channels, expected, "{packing:?}");
        }
        assert_eq!(exr_note(&path).as_deref(), Some("origin 1"));
        let metadata = exr::meta::MetaData::read_from_file(&path, false).expect("a header");
        let [header] = &metadata.headers[..] else { panic!("one part") };
        let own = &header.own_attributes;
        assert_eq!(own.frames_per_second, Some((24, 1)));
        assert_eq!(own.other.get(&Text::from("celfx/frame")), Some(&AttributeValue::I32(7)));
        assert_eq!(header.shared_attributes.pixel_aspect, 2.0);
        // What is seen at the middle of the right edge, by a row on the left of the matrix.
        let matrix = own.world_to_normalized_device.expect("a matrix");
        let half = camera.half_extent([2, 1]);
        let row = [half.x as f32 * 4.0, 1.0 + half.y as f32 * 2.0, 0.0, 1.0];
        let seen = |column: usize| (0..4).map(|i| row[i] * matrix[4 * i + column]).sum::<f32>();
        assert!((seen(0) / seen(3) - 1.0).abs() < 1e-6 && (seen(1) / seen(3) - 0.5).abs() < 1e-6);
    }

    #[test]
    fn rates_are_fractions() {
        let of = [24.0, 24_000.0 / 1001.0, 29.97, 12.5, 0.001].map(rational);
        assert_eq!(of, [(24, 1), (24_000, 1001), (30_000, 1001), (12_500, 1000), (1, 1000)]);
    }
}
