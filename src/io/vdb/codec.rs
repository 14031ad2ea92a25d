//! How values are packed: as they are, by ZIP, or by Blosc with LZ4; as half floats; without those of inactive voxels.

use std::borrow::Cow;
use std::io::Read;

use flate2::read::ZlibDecoder;

use super::bytes::Bytes;
use super::{Element, Scalar};
use crate::io::ReadError;

/// Flags of a grid's compression.
const ZIP: u32 = 1;
const ACTIVE_MASK: u32 = 2;
const BLOSC: u32 = 4;

/// First version in which nodes say which of their inactive values they leave out.
pub(super) const NODE_MASKS: u32 = 222;

/// Blosc's header, and its flags.
const BLOSC_HEADER: usize = 16;
const SHUFFLED: u8 = 1;
const COPIED: u8 = 2;
const BIT_SHUFFLED: u8 = 4;
const NOT_SPLIT: u8 = 16;
const LZ4: u8 = 1;
/// A block is split into a stream for each byte of a value, where these are no more, and have as many bytes.
const MOST_SPLITS: usize = 16;
const LEAST_STREAM: usize = 128;

/// How a grid's values are packed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Packing {
    pub(super) version: u32,
    pub(super) compression: u32,
    pub(super) element: Element,
    /// Its values are stored as half floats.
    pub(super) is_half: bool,
}

/// A node's bits, one for each of its values.
#[derive(Clone, Copy, Debug)]
pub(super) struct Mask<'f>(pub(super) &'f [u8]);

impl Mask<'_> {
    pub(super) fn is_on(self, index: usize) -> bool {
        self.0[index / 8] & 1 << (index % 8) != 0
    }

    pub(super) fn count(self) -> usize {
        self.0.iter().map(|byte| byte.count_ones() as usize).sum()
    }

    /// Those that are on, ascending.
    pub(super) fn on(self) -> impl Iterator<Item = usize> {
        (0..8 * self.0.len()).filter(move |index| self.is_on(*index))
    }
}

/// A value of up to three components.
pub(super) type Value = [f32; 3];

impl Packing {
    /// One value, at full precision.
    pub(super) fn value(&self, bytes: &mut Bytes, what: &str) -> Result<Value, ReadError> {
        let taken = bytes.take(self.element.bytes(), what)?;
        let mut value = [0.0; 3];
        self.element.scalar.unpack(taken, &mut value[..self.element.components]);
        Ok(value)
    }

    /// All `count` values of a node into `values`, each with as many components as it has. `active`: which are active.
    pub(super) fn values(
        &self,
        bytes: &mut Bytes,
        active: Mask,
        count: usize,
        background: Value,
        values: &mut Vec<f32>,
    ) -> Result<(), ReadError> {
        const WHAT: &str = "a node's values";
        let has_masks = self.version >= NODE_MASKS;
        let kind: u8 = if has_masks { bytes.value(WHAT)? } else { 6 };
        if kind > 6 {
            return Err(bytes.fault(format!("a node's values are stored in way {kind}"), "0 to 6"));
        }
        // Inactive values: all are of the one, or a mask tells the two apart.
        let mut inactive = [if kind == 0 { background } else { background.map(|c| -c) }, background];
        if matches!(kind, 2 | 4 | 5) {
            inactive[0] = self.value(bytes, WHAT)?;
        }
        if kind == 5 {
            inactive[1] = self.value(bytes, WHAT)?;
        }
        let chosen = if matches!(kind, 3..=5) { Some(Mask(bytes.take(count / 8, WHAT)?)) } else { None };
        let is_sparse = has_masks && self.compression & ACTIVE_MASK != 0 && kind != 6;
        let stored = if is_sparse { active.count() } else { count };
        let scalar = if self.is_half && self.element.scalar.is_real() { Scalar::Half } else { self.element.scalar };
        let components = self.element.components;
        let size = scalar.bytes() * components;
        // Of halves nothing is written where there are none.
        let packed = match stored {
            0 if scalar == Scalar::Half => Cow::Borrowed(&[][..]),
            _ => self.unpacked(bytes, stored * size)?,
        };
        values.clear();
        values.resize(count * components, 0.0);
        if stored == count {
            scalar.unpack(&packed, values);
            return Ok(());
        }
        let mut from = packed.chunks_exact(size);
        for (index, to) in values.chunks_exact_mut(components).enumerate() {
            match if active.is_on(index) { from.next() } else { None } {
                Some(value) => scalar.unpack(value, to),
                None => {
                    let which = usize::from(chosen.is_some_and(|mask| mask.is_on(index)));
                    to.copy_from_slice(&inactive[which][..components]);
                }
            }
        }
        Ok(())
    }

    /// `size` bytes, unpacked.
    fn unpacked<'f>(&self, bytes: &mut Bytes<'f>, size: usize) -> Result<Cow<'f, [u8]>, ReadError> {
        const WHAT: &str = "values";
        if self.compression & (ZIP | BLOSC) == 0 {
            return Ok(Cow::Borrowed(bytes.take(size, WHAT)?));
        }
        let length: i64 = bytes.value(WHAT)?;
        let is_plain = length <= 0;
        let count = usize::try_from(length.unsigned_abs()).unwrap_or(usize::MAX);
        let begin = *bytes;
        if is_plain && count != size {
            return Err(begin.fault(format!("{count} bytes of values are stored"), size.to_string()));
        }
        let packed = bytes.take(count, WHAT)?;
        if is_plain {
            return Ok(Cow::Borrowed(packed));
        }
        let unpacked = if self.compression & BLOSC != 0 { blosc(packed, size) } else { zip(packed, size) };
        unpacked.map(Cow::Owned).map_err(|why| begin.fault(why, format!("{size} bytes, packed into {count}")))
    }
}

fn zip(packed: &[u8], size: usize) -> Result<Vec<u8>, String> {
    let mut unpacked = Vec::with_capacity(size);
    // One more, to see whether there is more.
    let read = ZlibDecoder::new(packed).take(size as u64 + 1).read_to_end(&mut unpacked);
    match read {
        Ok(count) if count == size => Ok(unpacked),
        Ok(count) => Err(format!("ZIP unpacks to {} bytes", if count > size { "more" } else { "fewer" })),
        Err(error) => Err(format!("ZIP: {error}")),
    }
}

/// A chunk of Blosc 1: a header, where each block begins, and blocks of streams, each of which has its length before it.
fn blosc(packed: &[u8], size: usize) -> Result<Vec<u8>, String> {
    let word = |at: usize| -> Result<usize, String> {
        let bytes = packed.get(at..at + 4).ok_or("Blosc: a length is cut off")?;
        Ok(u32::from_le_bytes(bytes.try_into().unwrap_or_default()) as usize)
    };
    let Some(&[_, _, flags, type_size, ..]) = packed.get(..BLOSC_HEADER) else {
        return Err("Blosc: its header is cut off".to_owned());
    };
    let (unpacked_size, block_size, packed_size) = (word(4)?, word(8)?, word(12)?);
    if unpacked_size != size || packed_size != packed.len() {
        return Err(format!("Blosc: its header says {unpacked_size} bytes, packed into {packed_size}"));
    }
    if flags & COPIED != 0 {
        let values = packed.get(BLOSC_HEADER..BLOSC_HEADER + size).ok_or("Blosc: its bytes are cut off")?;
        return Ok(values.to_vec());
    }
    if flags >> 5 != LZ4 {
        let names = ["BloscLZ", "LZ4", "Snappy", "Zlib", "Zstandard"];
        let name = names.get(usize::from(flags >> 5)).unwrap_or(&"something unknown");
        return Err(format!("Blosc: packed by {name}, not LZ4"));
    }
    if flags & BIT_SHUFFLED != 0 || block_size == 0 || type_size == 0 {
        return Err("Blosc: bits are shuffled, or a size is 0".to_owned());
    }
    let type_size = usize::from(type_size);
    let mut unpacked = vec![0; size];
    let mut shuffled = vec![0; block_size.min(size)];
    for (number, block) in unpacked.chunks_mut(block_size).enumerate() {
        let is_whole = block.len() == block_size;
        let splits = flags & NOT_SPLIT == 0 && type_size <= MOST_SPLITS && block_size / type_size >= LEAST_STREAM;
        let streams = if splits && is_whole { type_size } else { 1 };
        let shuffled = &mut shuffled[..block.len()];
        let mut at = word(BLOSC_HEADER + 4 * number)?;
        let length = block.len() / streams;
        for stream in shuffled.chunks_mut(length.max(1)).take(streams) {
            let count = word(at)?;
            let from = at.checked_add(4).and_then(|begin| packed.get(begin..begin.checked_add(count)?));
            let from = from.ok_or("Blosc: a stream is cut off")?;
            at += 4 + count;
            if count == stream.len() {
                stream.copy_from_slice(from);
                continue;
            }
            match lz4_flex::block::decompress_into(from, stream) {
                Ok(found) if found == stream.len() => {}
                Ok(found) => return Err(format!("LZ4 unpacks to {found} of {} bytes", stream.len())),
                Err(error) => return Err(format!("LZ4: {error}")),
            }
        }
        if flags & SHUFFLED != 0 && type_size > 1 {
            unshuffle(shuffled, block, type_size);
        } else {
            block.copy_from_slice(shuffled);
        }
    }
    Ok(unpacked)
}

/// All first bytes of values, then all second ones and so on; what fills no value stands behind them as it is.
fn unshuffle(from: &[u8], to: &mut [u8], type_size: usize) {
    let count = from.len() / type_size;
    for (index, value) in to.chunks_exact_mut(type_size).enumerate() {
        for (byte, to) in value.iter_mut().enumerate() {
            *to = from[byte * count + index];
        }
    }
    let whole = count * type_size;
    to[whole..].copy_from_slice(&from[whole..]);
}
