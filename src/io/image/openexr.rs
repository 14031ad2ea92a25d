//! Reading EXR files: channels of one part, placed in the display window.
//!
//! What a header says is held against the file's length and what is wanted before anything is allocated, and blocks are
//! decoded one at a time, only those that reach into the picture. So memory is a few times the picture's at most.

mod named;

use std::collections::HashSet;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use exr::block::UncompressedBlock;
use exr::block::chunk::{Chunk, CompressedBlock};
use exr::block::reader::Reader;
use exr::meta::BlockDescription;
use exr::meta::header::Header;
use exr::prelude::{Compression, SampleType, f16};

use super::contained::contained;
use super::{Fault, Fit, Picture};
use crate::io::{ReadError, file};

pub use named::{Wanted, read_named};

/// Bytes that a block may unpack to besides four times those of the picture: 256 rows of many channels.
const MAX_BLOCK: u64 = 1 << 27;
/// Most values of all channels of a picture that has less than four of them a pixel.
const MAX_VALUES: u64 = 1 << 26;

/// Names by which a layer or a part is the colours of a picture, among others that have R, G and B.
const COLOURS: [&str; 6] = ["rgba", "rgb", "beauty", "combined", "colour", "color"];

/// The channels of an EXR file's first part, as f32.
#[derive(Clone, Debug, PartialEq)]
pub struct Channels {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Names and values, sorted by name; rows from the top.
    pub channels: Vec<(String, Vec<f32>)>,
}

/// Reads all channels of the first part of an EXR file, of any size.
pub fn read_exr(path: &Path) -> Result<Channels, ReadError> {
    read(path, Fit::ANY, |headers| Ok(Pick::all(headers)))
}

/// Reads colours: of the layer and part that has them (see [`Pick::colours`]), opaque where it has no alpha.
pub(in crate::io) fn read_colours(path: &Path, fit: Fit) -> Result<Picture<[f32; 4]>, ReadError> {
    let Channels { size, channels } = read(path, fit, Pick::colours)?;
    let values = |at: usize| channels.get(at).map(|(_, values)| &values[..]);
    let (Some(r), Some(g), Some(b)) = (values(0), values(1), values(2)) else {
        return Err(ReadError::file(path, "has no colours", "channels R, G, B and maybe A"));
    };
    let colours = r.iter().zip(g).zip(b);
    let pixels = match values(3) {
        Some(a) => colours.zip(a).map(|(((r, g), b), a)| [*r, *g, *b, *a]).collect(),
        None => colours.map(|((r, g), b)| [*r, *g, *b, 1.0]).collect(),
    };
    Ok(Picture { size, pixels })
}

/// The channels of a file that are read: those of one part, by number.
struct Pick {
    part: usize,
    channels: Vec<usize>,
}

impl Pick {
    fn all(headers: &[Header]) -> Pick {
        Pick { part: 0, channels: (0..headers.first().map_or(0, |header| header.channels.list.len())).collect() }
    }

    /// R, G, B and maybe A: those without a layer's name if a part has them, else those of the only layer that has them
    /// (`beauty.R`). Among several parts or layers it is the one that is called so ([`COLOURS`]); of parts else the first.
    fn colours(headers: &[Header]) -> Result<Pick, Fault> {
        let mut layers: Vec<(usize, String)> = Vec::new();
        for (part, header) in headers.iter().enumerate() {
            let reds = header.channels.list.iter().filter_map(|channel| {
                let name = channel.name.to_string();
                name.strip_suffix('R').filter(|layer| layer.is_empty() || layer.ends_with('.')).map(str::to_owned)
            });
            layers.extend(reds.map(|layer| (part, layer)).filter(|(_, layer)| is_whole(header, layer)));
        }
        let is_plain = |(_, layer): &&(usize, String)| layer.is_empty();
        let name_of = |(part, layer): &(usize, String)| match layer.strip_suffix('.') {
            Some(layer) => layer.rsplit('.').next().unwrap_or(layer).to_owned(),
            None => headers[*part].own_attributes.layer_name.as_ref().map(|n| n.to_string()).unwrap_or_default(),
        };
        let is_named = |layer: &&(usize, String)| COLOURS.contains(&name_of(layer).to_ascii_lowercase().as_str());
        let plain = || layers.iter().filter(is_plain);
        let chosen = plain().find(is_named).or_else(|| plain().next()).or(match &layers[..] {
            [one] => Some(one),
            several => several.iter().find(is_named),
        });
        match chosen {
            Some((part, layer)) => Ok(Pick { part: *part, channels: numbers(&headers[*part], layer) }),
            None => Err(no_colours(headers, &layers)),
        }
    }
}

/// Numbers of a layer's channels R, G, B and A, as far as there are such.
fn numbers(header: &Header, layer: &str) -> Vec<usize> {
    let channels = &header.channels.list;
    let number = |name: &str| channels.iter().position(|channel| channel.name.to_string() == format!("{layer}{name}"));
    ["R", "G", "B", "A"].into_iter().filter_map(number).collect()
}

fn is_whole(header: &Header, layer: &str) -> bool {
    let names = ["R", "G", "B"].map(|name| format!("{layer}{name}"));
    names.iter().all(|name| header.channels.list.iter().any(|channel| channel.name.to_string() == *name))
}

fn no_colours(headers: &[Header], layers: &[(usize, String)]) -> Fault {
    const SHOWN: usize = 32;
    let channels = headers.iter().flat_map(|header| header.channels.list.iter());
    let names: Vec<String> = channels.map(|channel| channel.name.to_string()).take(SHOWN).collect();
    match layers.is_empty() {
        true => (format!("has channels {}", names.join(", ")), "channels R, G, B and maybe A".to_owned()),
        false => {
            let layers: Vec<&str> = layers.iter().map(|(_, layer)| layer.trim_end_matches('.')).take(SHOWN).collect();
            let expected = format!("channels R, G, B and maybe A, or one layer of them called {}", COLOURS.join(", "));
            (format!("has colours in several layers: {}", layers.join(", ")), expected)
        }
    }
}

fn read(path: &Path, fit: Fit, pick: impl FnOnce(&[Header]) -> Result<Pick, Fault>) -> Result<Channels, ReadError> {
    let unreadable = |error| ReadError::file(path, error, "a file that can be read");
    let file = file::open(path).map_err(unreadable)?;
    let length = file.metadata().map_err(unreadable)?.len();
    let decoded = contained(|| {
        let reader = exr::block::read(BufReader::new(file), false).map_err(damaged)?;
        check_tables(reader.headers(), length)?;
        let pick = pick(reader.headers())?;
        decode(reader, &pick, fit)
    });
    decoded.map_err(damaged).and_then(|result| result).map_err(|(why, expected)| ReadError::file(path, why, expected))
}

fn damaged(why: impl ToString) -> Fault {
    (why.to_string(), "a whole EXR picture without deep data".to_owned())
}

/// Refuses more blocks than a file of so many bytes has room for: each has 8 bytes in a table and at least 8 of its own.
fn check_tables(headers: &[Header], length: u64) -> Result<(), Fault> {
    let blocks = headers.iter().fold(0u64, |sum, header| sum.saturating_add(header.chunk_count as u64));
    match blocks.saturating_mul(16) <= length {
        true => Ok(()),
        false => Err(damaged(format!("the header says {blocks} blocks, which a file of {length} bytes does not hold"))),
    }
}

fn decode(reader: Reader<BufReader<File>>, pick: &Pick, fit: Fit) -> Result<Channels, Fault> {
    let header = reader.headers()[pick.part].clone();
    let window = Window::new(&header, fit)?;
    let values = window.pixels().saturating_mul(pick.channels.len() as u64);
    if values > MAX_VALUES.max(4 * window.pixels()) {
        return Err(damaged(format!("{} channels of {} pixels", pick.channels.len(), window.pixels())));
    }
    check_block(&header, window.pixels())?;
    let mut canvas = vec![vec![0.0; window.pixels() as usize]; pick.channels.len()];
    let is_wanted = |layer: usize, level: exr::math::Vec2<usize>| layer == pick.part && (level.0, level.1) == (0, 0);
    let mut chunks = reader
        .filter_chunks(false, |_, _, block| {
            is_wanted(block.layer, block.level) && window.sees(block.pixel_position, block.pixel_size)
        })
        .map_err(damaged)?;
    let mut placed = HashSet::new();
    while let Some(chunk) = chunks.next() {
        let chunk = chunk.map_err(damaged)?;
        let meta = exr::block::reader::ChunksReader::meta_data(&chunks);
        check_chunk(&chunk, &header, pick.part)?;
        let block = UncompressedBlock::decompress_chunk(chunk, meta, false).map_err(damaged)?;
        let index = block.index;
        // As many as are wanted, each of them wanted and none twice: all of the picture is there.
        let is_new = placed.insert((index.pixel_position.0, index.pixel_position.1));
        if !(is_new && is_wanted(index.layer, index.level) && window.sees(index.pixel_position, index.pixel_size)) {
            return Err(damaged("its table of blocks is damaged"));
        }
        for line in block.lines(&header.channels) {
            let at = line.location;
            let wanted = pick.channels.iter().zip(&mut canvas).filter(|(channel, _)| **channel == at.channel);
            let kind = header.channels.list[at.channel].sample_type;
            wanted.for_each(|(_, values)| window.place([at.position.0, at.position.1], kind, line.value, values));
        }
    }
    let name = |channel: &usize| header.channels.list[*channel].name.to_string();
    Ok(Channels { size: window.size, channels: pick.channels.iter().map(name).zip(canvas).collect() })
}

/// Refuses blocks that unpack to far more than the picture.
fn check_block(header: &Header, pixels: u64) -> Result<(), Fault> {
    let [width, height] = [header.layer_size.0 as u64, header.layer_size.1 as u64];
    let [columns, rows] = match header.blocks {
        BlockDescription::ScanLines => [width, height.min(header.compression.scan_lines_per_block() as u64)],
        BlockDescription::Tiles(tiles) => [width.min(tiles.tile_size.0 as u64), height.min(tiles.tile_size.1 as u64)],
    };
    let bytes = columns.saturating_mul(rows).saturating_mul(header.channels.bytes_per_pixel as u64);
    let most = MAX_BLOCK + 64 * pixels;
    match bytes <= most {
        true => Ok(()),
        false => {
            let why = format!("a block of {columns} x {rows} pixels has {bytes} bytes");
            Err((why, format!("blocks of at most {most} bytes for a picture of {pixels} pixels")))
        }
    }
}

/// Refuses a block of another part, and one with fewer bytes than its compression can make of its pixels.
fn check_chunk(chunk: &Chunk, header: &Header, part: usize) -> Result<(), Fault> {
    let packed = match &chunk.compressed_block {
        CompressedBlock::ScanLine(block) => block.compressed_pixels_le.len(),
        CompressedBlock::Tile(block) => block.compressed_pixels_le.len(),
        _ => return Err(damaged("has deep data")),
    };
    if chunk.layer_index != part {
        return Err(damaged("its table of blocks is damaged"));
    }
    let tile = header.get_block_data_indices(&chunk.compressed_block).map_err(damaged)?;
    let place = header.get_absolute_block_pixel_coordinates(tile).map_err(damaged)?;
    let whole = place.size.area().saturating_mul(header.channels.bytes_per_pixel);
    match whole <= packed.saturating_mul(most_expansion(header.compression)) {
        true => Ok(()),
        false => Err(damaged(format!("a block of {packed} bytes cannot be {whole} bytes of {}", header.compression))),
    }
}

/// How many bytes one of a block can be at most.
fn most_expansion(compression: Compression) -> usize {
    match compression {
        Compression::Uncompressed => 1,
        // Two bytes are a run of 128.
        Compression::RLE => 64,
        // Three bytes are 16 halfs.
        Compression::B44 | Compression::B44A => 11,
        // Deflate makes at most 1032 of one; PXR24 leaves out every fourth byte before. Runs of PIZ are shorter.
        Compression::ZIP1 | Compression::ZIP16 | Compression::PIZ | Compression::PXR24 => 1376,
        // Two deflated halfs are 64 pixels.
        _ => 1 << 16,
    }
}

/// The display window, and where the data are in it.
struct Window {
    size: [u32; 2],
    /// Of the data's first pixel in the display window.
    offset: [i64; 2],
}

impl Window {
    fn new(header: &Header, fit: Fit) -> Result<Window, Fault> {
        let display = header.shared_attributes.display_window;
        // A window that is wider than this is wider than any picture, too.
        let side = |side: usize| u32::try_from(side).unwrap_or(u32::MAX);
        let size = fit.checked([side(display.size.0), side(display.size.1)])?;
        let data = header.own_attributes.layer_position;
        let offset = [data.0, data.1].map(i64::from);
        let origin = [display.position.0, display.position.1].map(i64::from);
        Ok(Window { size, offset: [offset[0] - origin[0], offset[1] - origin[1]] })
    }

    fn pixels(&self) -> u64 {
        u64::from(self.size[0]) * u64::from(self.size[1])
    }

    /// Whether data of that size at that place, counted from the data's first pixel, reach into the display window.
    fn sees(&self, position: exr::math::Vec2<usize>, size: exr::math::Vec2<usize>) -> bool {
        let reaches = |axis: usize, position: usize, size: usize| {
            let start = position as i64 + self.offset[axis];
            start < i64::from(self.size[axis]) && start + size as i64 > 0
        };
        reaches(0, position.0, size.0) && reaches(1, position.1, size.1)
    }

    /// Puts a row of samples where it belongs; what is outside is left out.
    fn place(&self, [x, y]: [usize; 2], kind: SampleType, samples: &[u8], values: &mut [f32]) {
        let [width, height] = self.size.map(i64::from);
        let (left, row) = (x as i64 + self.offset[0], y as i64 + self.offset[1]);
        if !(0..height).contains(&row) {
            return;
        }
        let skipped = (-left).max(0);
        let start = row * width + left + skipped;
        let end = (row + 1) * width;
        // Both are within the picture.
        let row = values.get_mut(start.clamp(0, end) as usize..end as usize).unwrap_or_default();
        let bytes = kind.bytes_per_sample();
        let samples = samples.chunks_exact(bytes).skip(skipped as usize);
        row.iter_mut().zip(samples).for_each(|(value, sample)| *value = number(kind, sample));
    }
}

/// A sample in the byte order of this machine.
fn number(kind: SampleType, bytes: &[u8]) -> f32 {
    match (kind, bytes) {
        (SampleType::F16, &[a, b]) => f16::from_ne_bytes([a, b]).to_f32(),
        (SampleType::F32, &[a, b, c, d]) => f32::from_ne_bytes([a, b, c, d]),
        (SampleType::U32, &[a, b, c, d]) => u32::from_ne_bytes([a, b, c, d]) as f32,
        _ => 0.0,
    }
}
