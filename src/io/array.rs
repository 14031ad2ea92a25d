//! NumPy arrays: reading them from `.npz` archives, writing `.npy` files.

mod header;

use std::collections::TryReserveError;
use std::fs::File;
use std::io::{self, BufReader, Read};
use std::path::{Path, PathBuf};

use exr::prelude::f16;
use npyz::npz::{array_name_from_file_name, file_name_from_array_name};
use npyz::{AutoSerialize, WriterBuilder};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipArchive, ZipWriter};

use super::{ReadError, WriteError, file, write_atomic};

/// Header text longer than this is refused; that of a plain array has about 100 bytes.
const MAX_HEADER: usize = 1 << 16;

/// Bytes that deflate makes of one at most.
const MAX_EXPANSION: u64 = 1032;

/// The element type of an array.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Element {
    /// 16-bit float.
    F16,
    /// 32-bit float.
    F32,
    /// 64-bit float.
    F64,
    /// Signed integer of 1, 2, 4 or 8 bytes.
    Int(usize),
    /// Unsigned integer of 1, 2, 4 or 8 bytes.
    Uint(usize),
}

impl Element {
    /// Bytes of one element.
    pub fn bytes(self) -> usize {
        match self {
            Element::F16 => 2,
            Element::F32 => 4,
            Element::F64 => 8,
            Element::Int(bytes) | Element::Uint(bytes) => bytes,
        }
    }

    /// Whether it is one of the floating-point types.
    pub fn is_float(self) -> bool {
        matches!(self, Element::F16 | Element::F32 | Element::F64)
    }

    fn decode(self, bytes: &[u8], little: bool) -> f64 {
        let mut wide = [0; 8];
        let count = bytes.len().min(8);
        wide[..count].copy_from_slice(&bytes[..count]);
        if !little {
            wide[..count].reverse();
        }
        let bits = u64::from_le_bytes(wide);
        let unused = 64 - 8 * count as u32;
        match self {
            Element::F16 => f16::from_bits(bits as u16).to_f64(),
            Element::F32 => f64::from(f32::from_bits(bits as u32)),
            Element::F64 => f64::from_bits(bits),
            Element::Int(_) => (((bits << unused) as i64) >> unused) as f64,
            Element::Uint(_) => bits as f64,
        }
    }
}

/// The header of an array.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Header {
    /// Type of the elements.
    pub element: Element,
    /// Length of each axis, as NumPy shows it.
    pub shape: Vec<u64>,
    /// Whether the bytes are little-endian.
    pub little_endian: bool,
    /// Whether the first axis runs fastest in the file.
    pub fortran_order: bool,
}

impl Header {
    /// How many elements there are; none where nothing could hold so many.
    pub fn count(&self) -> Option<u64> {
        self.shape.iter().try_fold(1u64, |n, &axis| n.checked_mul(axis))
    }

    /// How many bytes they take.
    fn data_bytes(&self) -> Option<u64> {
        self.count()?.checked_mul(self.element.bytes() as u64)
    }
}

/// Which elements an array may have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// Numbers.
    Any,
    /// No integers, because what they mean is not known.
    Float,
    /// Integers.
    Whole,
}

/// An array in memory, the last axis running fastest whatever the order in the file.
#[derive(Clone, Debug, PartialEq)]
pub struct Array<T> {
    /// Length of each axis, as NumPy shows it.
    pub shape: Vec<u64>,
    /// The elements, as many as the product of `shape`.
    pub values: Vec<T>,
}

/// The number types that arrays are read into.
pub trait Number: Copy + Default {
    /// The nearest value.
    fn from_f64(value: f64) -> Self;
}

impl Number for f32 {
    fn from_f64(value: f64) -> f32 {
        value as f32
    }
}

impl Number for f64 {
    fn from_f64(value: f64) -> f64 {
        value
    }
}

/// A `.npz` file, open for reading. Nothing in the file is trusted: memory grows with what is really there.
pub struct Archive {
    path: PathBuf,
    /// Bytes of the file.
    length: u64,
    zip: ZipArchive<BufReader<File>>,
}

impl Archive {
    /// Opens the file and reads the list of its arrays.
    pub fn open(path: &Path) -> Result<Archive, ReadError> {
        let whole = "a whole .npz file as numpy.savez writes it";
        let unreadable = |error| ReadError::file(path, error, "a file that can be read");
        let file = file::open(path).map_err(unreadable)?;
        let length = file.metadata().map_err(unreadable)?.len();
        let zip = ZipArchive::new(BufReader::new(file)).map_err(|error| {
            ReadError::file(path, format!("no zip archive, or one that is cut short ({error})"), whole)
        })?;
        Ok(Archive { path: path.into(), length, zip })
    }

    /// Names of the arrays, sorted.
    pub fn names(&self) -> Vec<String> {
        let mut names: Vec<String> =
            self.zip.file_names().filter_map(array_name_from_file_name).map(String::from).collect();
        names.sort();
        names
    }

    /// Header of the array `name`; `None` if there is no such array.
    pub fn header(&mut self, name: &str) -> Result<Option<Header>, ReadError> {
        Ok(self.entry(name)?.map(|entry| entry.header))
    }

    /// Reads the array `name`, of at most `limit` elements; `None` if there is no such array.
    pub fn read<T: Number>(&mut self, name: &str, limit: u64) -> Result<Option<Array<T>>, ReadError> {
        let Some(mut entry) = self.entry(name)? else { return Ok(None) };
        let mut values: Vec<T> = Vec::new();
        entry.each_chunk(limit, |header, chunk| {
            values.try_reserve(chunk.len() / header.element.bytes())?;
            each_number(header, chunk, |value| values.push(value));
            Ok(())
        })?;
        let Header { shape, fortran_order, .. } = entry.header;
        Ok(Some(in_c_order(Array { shape, values }, fortran_order)))
    }

    /// Hands over the elements of the array `name` in the order of the file, however many there are: none is kept. The
    /// array's header, or `None` if there is no such array.
    pub fn each<T: Number>(&mut self, name: &str, mut take: impl FnMut(T)) -> Result<Option<Header>, ReadError> {
        let Some(mut entry) = self.entry(name)? else { return Ok(None) };
        entry.each_chunk(u64::MAX, |header, chunk| {
            each_number(header, chunk, &mut take);
            Ok(())
        })?;
        Ok(Some(entry.header))
    }

    fn entry<'a>(&'a mut self, name: &'a str) -> Result<Option<Entry<'a>>, ReadError> {
        let Some(index) = self.zip.index_for_name(&file_name_from_array_name(name)) else { return Ok(None) };
        let fault = Fault { path: &self.path, name };
        let unreadable = |error| fault.error(error, "a readable zip entry");
        // Others, which NumPy does not write, make gigabytes of a few bytes.
        let packing = self.zip.by_index_raw(index).map_err(unreadable)?.compression();
        if ![CompressionMethod::Stored, CompressionMethod::Deflated].contains(&packing) {
            return Err(fault.error(format!("is packed as {packing}"), "a stored or deflated zip entry"));
        }
        let mut zipped = self.zip.by_index(index).map_err(unreadable)?;
        // What is allocated by a header's shape is so no more than what is there.
        let (size, packed) = (zipped.size(), zipped.compressed_size().min(self.length));
        if size > packed.saturating_mul(MAX_EXPANSION) {
            return Err(fault.error(format!("is {packed} bytes that claim to unpack to {size}"), "a whole zip entry"));
        }
        let (header, header_bytes) = read_header(&mut zipped, &fault)?;
        let present = zipped.size().saturating_sub(header_bytes);
        Ok(Some(Entry { fault, header, present, data: Box::new(zipped) }))
    }

    /// The shape of the array `name` of such elements, which is to have so many axes: more of them, of length 1 at the
    /// end, are passed over ([n, 1] is [n]). `None` if there is no such array.
    pub(super) fn shape(
        &mut self,
        name: &str,
        axes: usize,
        kind: Kind,
        expected: &str,
    ) -> Result<Option<Vec<u64>>, ReadError> {
        let Some(Header { element, mut shape, .. }) = self.header(name)? else { return Ok(None) };
        match (kind, element.is_float()) {
            (Kind::Float, false) => return Err(self.fault(name, "elements are integers", expected)),
            (Kind::Whole, true) => return Err(self.fault(name, "elements are floats", expected)),
            _ => {}
        }
        while shape.len() > axes && shape.last() == Some(&1) {
            shape.pop();
        }
        Ok(Some(shape))
    }

    /// The error of an array that must be there.
    pub(super) fn missing(&self, name: &str, expected: &str) -> ReadError {
        self.fault(name, format!("is missing; the file has {:?}", self.names()), expected)
    }

    /// The error of an array of another shape.
    pub(super) fn wrong_shape(&self, name: &str, shape: &[u64], expected: &str) -> ReadError {
        self.fault(name, format!("has shape {shape:?}"), expected)
    }

    /// A fault of the array `name`.
    pub(super) fn fault(&self, name: &str, why: impl ToString, expected: impl Into<String>) -> ReadError {
        Fault { path: &self.path, name }.error(why, expected)
    }
}

/// Names file and array in errors.
struct Fault<'a> {
    path: &'a Path,
    name: &'a str,
}

impl Fault<'_> {
    fn error(&self, why: impl ToString, expected: impl Into<String>) -> ReadError {
        ReadError::at(self.path, format!("array `{}`", self.name), why, expected)
    }

    fn at_byte(&self, byte: u64, why: impl ToString, expected: impl Into<String>) -> ReadError {
        ReadError::at(self.path, format!("array `{}`, byte {byte}", self.name), why, expected)
    }
}

/// Reads what `buffer` can hold, less only at the end of the input.
fn read_full(input: &mut impl Read, buffer: &mut [u8]) -> io::Result<usize> {
    let mut filled = 0;
    while filled < buffer.len() {
        match input.read(&mut buffer[filled..]) {
            Ok(0) => break,
            Ok(n) => filled += n,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
    Ok(filled)
}

/// The header and the number of bytes that it takes.
fn read_header(input: &mut impl Read, fault: &Fault) -> Result<(Header, u64), ReadError> {
    let npy = "an array as numpy.save writes it (format 1, 2 or 3)";
    let mut read = |buffer: &mut [u8]| match read_full(input, buffer) {
        Ok(n) if n == buffer.len() => Ok(()),
        Ok(_) => Err(fault.at_byte(0, "ends within the header", npy)),
        Err(error) => Err(fault.at_byte(0, error, npy)),
    };
    let mut start = [0; 8];
    read(&mut start)?;
    let length_bytes = match (&start[..6], start[6]) {
        (b"\x93NUMPY", 1) => 2,
        (b"\x93NUMPY", 2 | 3) => 4,
        _ => return Err(fault.at_byte(0, "is not a NumPy array of a known version", npy)),
    };
    let mut length = [0; 4];
    read(&mut length[..length_bytes])?;
    let length = u32::from_le_bytes(length) as usize;
    if length > MAX_HEADER {
        return Err(fault.at_byte(8, format!("a header of {length} bytes"), format!("{MAX_HEADER} bytes at most")));
    }
    let mut text = vec![0; length];
    read(&mut text)?;
    let bytes = 8 + length_bytes + length;
    let header = header::parse(&text).map_err(|(why, expected)| fault.error(why, expected))?;
    Ok((header, bytes as u64))
}

/// An array of an archive, whose header has been read.
struct Entry<'a> {
    fault: Fault<'a>,
    header: Header,
    /// Bytes of data, as the archive says.
    present: u64,
    data: Box<dyn Read + 'a>,
}

impl Entry<'_> {
    /// Hands over the data of at most `limit` elements, whole elements at a time, to the end of the entry so that its
    /// checksum is looked at.
    fn each_chunk(
        &mut self,
        limit: u64,
        mut take: impl FnMut(&Header, &[u8]) -> Result<(), TryReserveError>,
    ) -> Result<(), ReadError> {
        let Entry { fault, header, present, data } = self;
        let bytes = header.count().filter(|&count| count <= limit).and_then(|_| header.data_bytes());
        let Some(total) = bytes else {
            let why = format!("shape {:?} is too large", header.shape);
            return Err(fault.error(why, format!("{limit} values at most")));
        };
        if *present != total {
            let why = format!("{present} bytes of data for shape {:?}", header.shape);
            return Err(fault.error(why, format!("{total} bytes")));
        }
        let mut buffer = vec![0; 1 << 16];
        let mut done = 0;
        loop {
            let wanted = (total - done).min(buffer.len() as u64) as usize;
            // One byte more than is wanted at the end: it must not be there, and the checksum is verified on the way.
            let chunk = &mut buffer[..wanted.max(1)];
            let got = read_full(data, chunk).map_err(|e| fault.at_byte(done, e, format!("{total} bytes of data")))?;
            if got != wanted {
                let why = if got < wanted { "the data end here" } else { "the data go on" };
                return Err(fault.at_byte(done + got as u64, why, format!("{total} bytes of data")));
            }
            if wanted == 0 {
                return Ok(());
            }
            take(header, &chunk[..wanted]).map_err(|e| fault.error(e, "an array that fits into memory"))?;
            done += wanted as u64;
        }
    }
}

/// The elements that the bytes are.
fn each_number<T: Number>(header: &Header, bytes: &[u8], mut take: impl FnMut(T)) {
    match (header.element, header.little_endian) {
        // The usual case without the generic decoder, which is several times slower.
        (Element::F32, true) => {
            let (floats, _) = bytes.as_chunks();
            floats.iter().for_each(|b| take(T::from_f64(f64::from(f32::from_le_bytes(*b)))));
        }
        (element, little) => {
            bytes.chunks_exact(element.bytes()).for_each(|b| take(T::from_f64(element.decode(b, little))));
        }
    }
}

/// Reorders an array whose first axis runs fastest.
pub(super) fn in_c_order<T: Copy>(array: Array<T>, fortran_order: bool) -> Array<T> {
    if !fortran_order || array.shape.len() < 2 {
        return array;
    }
    let Array { shape, values } = array;
    let mut strides = vec![1usize; shape.len()];
    for axis in 1..shape.len() {
        strides[axis] = strides[axis - 1] * shape[axis - 1] as usize;
    }
    let mut index = vec![0u64; shape.len()];
    let mut source = 0usize;
    let mut ordered = Vec::with_capacity(values.len());
    for _ in 0..values.len() {
        ordered.push(values[source]);
        for axis in (0..shape.len()).rev() {
            index[axis] += 1;
            source += strides[axis];
            if index[axis] < shape[axis] {
                break;
            }
            source -= strides[axis] * shape[axis] as usize;
            index[axis] = 0;
        }
    }
    Array { shape, values: ordered }
}

/// Writes a `.npy` file of 32-bit floats, the last axis of `shape` running fastest. Atomic.
pub fn write_npy(path: &Path, shape: &[u64], values: &[f32]) -> Result<(), WriteError> {
    write_atomic(path, |file| {
        check_count(shape, values.len())?;
        let mut writer = npyz::WriteOptions::new().default_dtype().shape(shape).writer(file).begin_nd()?;
        writer.extend(values.iter().copied())?;
        writer.finish()
    })
}

/// A `.npz` file that is being written.
pub struct ArchiveWriter<W: io::Write + io::Seek>(ZipWriter<W>);

impl<W: io::Write + io::Seek> ArchiveWriter<W> {
    /// An archive without an array.
    pub fn new(file: W) -> ArchiveWriter<W> {
        ArchiveWriter(ZipWriter::new(file))
    }

    /// Adds an array, the last axis of `shape` running fastest.
    pub fn add<T: AutoSerialize>(
        &mut self,
        name: &str,
        shape: &[u64],
        values: impl IntoIterator<Item = T>,
    ) -> io::Result<()> {
        // Without a limit of 4 GiB.
        let options = SimpleFileOptions::DEFAULT.large_file(true).compression_method(CompressionMethod::Stored);
        self.0.start_file(file_name_from_array_name(name), options)?;
        let mut writer = npyz::WriteOptions::new().default_dtype().shape(shape).writer(&mut self.0).begin_nd()?;
        writer.extend(values)?;
        writer.finish()
    }

    /// Writes the list of arrays, which ends the file.
    pub fn finish(self) -> io::Result<W> {
        Ok(self.0.finish()?)
    }
}

/// Refuses a shape that does not hold `count` values.
pub(super) fn check_count(shape: &[u64], count: usize) -> io::Result<()> {
    if shape.iter().try_fold(1u64, |n, &axis| n.checked_mul(axis)) == Some(count as u64) {
        return Ok(());
    }
    Err(io::Error::new(io::ErrorKind::InvalidInput, format!("{count} values do not fill shape {shape:?}")))
}

#[cfg(test)]
pub(crate) mod tests;
