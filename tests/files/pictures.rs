//! Pictures that are damaged, that lie about their size, that are turned, or that hold what cannot be rendered.

use std::io::Cursor;
use std::path::Path;

use celfx::io::image::write_exr;
use celfx::io::picture::{read, read_frame, read_row, read_sized};
use exr::image::Blocks;
use exr::prelude::{Compression, Encoding, Vec2};
use image::metadata::Orientation;
use image::{DynamicImage, ImageEncoder, RgbImage};

use crate::windows::{Part, exr, value};
use crate::{Temporary, peak};

/// Most bytes that reading a picture of 8 x 6 pixels takes: tables of decoders, most of them those of PIZ.
const MOST: isize = 16 << 20;

const COMPRESSIONS: [Compression; 10] = [
    Compression::Uncompressed,
    Compression::RLE,
    Compression::ZIP1,
    Compression::ZIP16,
    Compression::PIZ,
    Compression::PXR24,
    Compression::B44,
    Compression::B44A,
    Compression::DWAA(None),
    Compression::DWAB(None),
];

/// EXR files of 8 x 6 pixels in every compression, in lines and in tiles.
fn exrs() -> Vec<Vec<u8>> {
    let encoded = |compression, blocks| {
        let encoding = Encoding { compression, blocks, ..Encoding::SMALL_LOSSLESS };
        exr(&[Part { encoding, ..Part::default() }], [0; 2], [8, 6])
    };
    let tiles = Blocks::Tiles(Vec2(5, 4));
    COMPRESSIONS.iter().flat_map(|c| [encoded(*c, Blocks::ScanLines), encoded(*c, tiles)]).collect()
}

/// A picture of 8 x 6 pixels.
fn picture() -> RgbImage {
    RgbImage::from_fn(8, 6, |x, y| image::Rgb([30 * x as u8, 40 * y as u8, 10 * (x + y) as u8]))
}

fn encoded(format: image::ImageFormat) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    DynamicImage::from(picture()).write_to(&mut bytes, format).expect("encoded");
    bytes.into_inner()
}

/// Reads every damaged version of a file, one way or the other; whatever comes of it, it comes, and in little memory.
fn damage(extension: &str, whole: &[u8]) {
    let file = Temporary::new(extension);
    let readers: [&dyn Fn(&Path) -> bool; 3] = [
        &|path| read(path).is_ok(),
        &|path| read_sized(path, [8, 6]).is_ok_and(|picture| picture.pixels.len() == 48),
        &|path| read_row(path).is_ok(),
    ];
    let check = |bytes: &[u8], reader: usize, what: &str| {
        let path = file.with(bytes);
        let (peak, is_read) = peak::of(|| readers[reader % 3](path));
        assert!(peak < MOST, "{extension}, {what}: {peak} bytes");
        is_read
    };
    assert!((0..3).all(|reader| check(whole, reader, "whole")), "{extension}");
    for at in 0..whole.len() {
        for (i, byte) in [0xff, whole[at] ^ 0x10].into_iter().enumerate() {
            let mut damaged = whole.to_vec();
            damaged[at] = byte;
            check(&damaged, at + i, &format!("byte {at} is {byte}"));
        }
        if at % 16 == 0 {
            check(&whole[..at], at, &format!("cut at {at}"));
        }
    }
}

#[test]
fn no_damage_to_an_exr_panics_or_takes_much_memory() {
    exrs().iter().for_each(|file| damage("exr", file));
}

#[test]
fn no_damage_to_a_png_or_jpeg_panics_or_takes_much_memory() {
    damage("png", &encoded(image::ImageFormat::Png));
    damage("jpg", &encoded(image::ImageFormat::Jpeg));
}

#[test]
fn every_compression_is_read() {
    for (i, file) in exrs().iter().enumerate() {
        let picture = read(Temporary::new("exr").with(file)).expect("a picture");
        for (at, pixel) in picture.pixels.iter().enumerate() {
            let expected = [0, 1, 2].map(|c| value(c, at as i32 % 8, at as i32 / 8));
            // B44 keeps 6 bits of the differences within 4 x 4 pixels, DWA what is visible.
            let tolerance = if i < 12 { 0.0 } else { 0.02 };
            let is_near = pixel.iter().zip(expected).all(|(a, b)| (a - b).abs() <= tolerance);
            assert!(is_near, "file {i}, pixel {at}: {pixel:?}, {expected:?}");
        }
    }
}

/// The check sum of a PNG chunk.
fn crc(bytes: &[u8]) -> u32 {
    let step = |crc: u32, _| if crc & 1 == 1 { (crc >> 1) ^ 0xedb8_8320 } else { crc >> 1 };
    !bytes.iter().fold(u32::MAX, |crc, byte| (0..8).fold(crc ^ u32::from(*byte), step))
}

#[test]
fn a_size_that_lies_is_refused_before_anything_is_decoded() {
    let find = |bytes: &[u8], what: &[u8]| bytes.windows(what.len()).position(|w| w == what).expect("a place");
    let mut files = Vec::new();
    for mut file in exrs() {
        for window in ["displayWindow\0box2i\0", "dataWindow\0box2i\0"] {
            let at = find(&file, window.as_bytes()) + window.len() + 4;
            file[at + 8..at + 12].copy_from_slice(&59_999i32.to_le_bytes());
            file[at + 12..at + 16].copy_from_slice(&59_999i32.to_le_bytes());
        }
        files.push(("exr", file));
    }
    let mut png = encoded(image::ImageFormat::Png);
    png[16..20].copy_from_slice(&32_768u32.to_be_bytes());
    png[20..24].copy_from_slice(&32_768u32.to_be_bytes());
    let sum = crc(&png[12..29]).to_be_bytes();
    png[29..33].copy_from_slice(&sum);
    files.push(("png", png));
    let mut jpeg = encoded(image::ImageFormat::Jpeg);
    let at = find(&jpeg, b"\xff\xc0") + 5;
    jpeg[at..at + 4].copy_from_slice(&[0xff, 0, 0xff, 0]);
    files.push(("jpg", jpeg));
    for (extension, file) in files {
        let temporary = Temporary::new(extension);
        let path = temporary.with(&file);
        let (peak, errors) = peak::of(|| [read_sized(path, [8, 6]).err(), read(path).err()].map(|e| e.expect("a lie")));
        assert!(peak < 1 << 20, "{extension}: {peak} bytes");
        for error in errors.map(|error| error.to_string()) {
            assert!(error.starts_with(&path.display().to_string()), "{error}");
        }
    }
    // One that is what it says, but not the shot's.
    let temporary = Temporary::new("png");
    let error = read_sized(temporary.with(&encoded(image::ImageFormat::Png)), [8, 7]).expect_err("another size");
    assert!(error.to_string().ends_with("the picture has 8 x 6 pixels; expected 8 x 7, as the shot's size"), "{error}");
}

#[test]
fn a_window_of_data_may_be_large_but_not_its_blocks() {
    let mut file = exr(&[Part::default()], [0; 2], [8, 6]);
    let at = file.windows(11).position(|w| w == b"dataWindow\0").expect("a window") + 21;
    file[at + 8..at + 12].copy_from_slice(&1_000_000_000i32.to_le_bytes());
    let temporary = Temporary::new("exr");
    let (peak, error) = peak::of(|| read_sized(temporary.with(&file), [8, 6]).expect_err("a lie").to_string());
    assert!(peak < 1 << 20 && error.contains("a block of 1000000001 x 6 pixels"), "{peak}: {error}");
}

/// The orientation `number` as EXIF says it.
fn exif(number: u8) -> Vec<u8> {
    let mut bytes = b"II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0".to_vec();
    bytes.extend([number, 0, 0, 0, 0, 0, 0, 0]);
    bytes
}

#[test]
fn pictures_are_turned_upright_as_they_say() {
    for number in 1..=8 {
        let orientation = Orientation::from_exif(number).expect("one of eight");
        let mut expected = DynamicImage::from(picture());
        expected.apply_orientation(orientation);
        let mut png = Vec::new();
        let mut encoder = image::codecs::png::PngEncoder::new(&mut png);
        encoder.set_exif_metadata(exif(number)).expect("it can be said");
        encoder.write_image(&picture(), 8, 6, image::ExtendedColorType::Rgb8).expect("encoded");
        let size = [expected.width(), expected.height()];
        let turned = read_sized(Temporary::new("png").with(&png), size).expect("upright");
        let upright = Temporary::new("png");
        expected.save(upright.path()).expect("encoded");
        assert_eq!(turned, read_sized(upright.path(), size).expect("upright"), "orientation {number}");

        let whole = encoded(image::ImageFormat::Jpeg);
        let segment = [b"Exif\0\0".to_vec(), exif(number)].concat();
        let length = (segment.len() as u16 + 2).to_be_bytes();
        let jpeg = [&whole[..2], b"\xff\xe1", &length, &segment, &whole[2..]].concat();
        let mut expected = image::load_from_memory(&whole).expect("decoded");
        expected.apply_orientation(orientation);
        let turned = read_sized(Temporary::new("jpg").with(&jpeg), size).expect("upright");
        let first =
            expected.to_rgb8().get_pixel(0, 0).0.map(|c| celfx::io::image::linear_from_srgb(f64::from(c) / 255.0));
        assert_eq!(turned.pixels[0][..3], first.map(|c| c as f32), "orientation {number}");
    }
}

#[test]
fn what_cannot_be_rendered_is_refused_by_its_pixel() {
    let file = Temporary::new("exr");
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e38, 1.1e6, -1.1e6] {
        let mut pixels = [[0.0, -0.5, 1e6, 1.0]; 6];
        let path = file.path();
        write_exr(path, [3, 2], &pixels).expect("written");
        assert!(read_frame(path, [3, 2]).is_ok());
        pixels[5][1] = bad;
        write_exr(path, [3, 2], &pixels).expect("written");
        let error = read_frame(path, [3, 2]).expect_err("not to be rendered").to_string();
        assert!(error.contains("pixel (2, 1): is [0.0, ") && error.contains("finite numbers, none beyond"), "{error}");
        pixels.swap(0, 5);
        write_exr(path, [3, 2], &pixels).expect("written");
        assert!(read_row(path).expect_err("not to be rendered").to_string().contains("pixel (0, 0)"));
        assert!(read_sized(path, [3, 2]).is_ok(), "whoever does not render it may have it");
    }
}
