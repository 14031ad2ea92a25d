//! NumPy arrays: reading them from `.npz` archives, writing `.npy` files.

mod header;

use std::fs::File;
use std::io::{self, BufReader, Read};
use std::path::{Path, PathBuf};

use exr::prelude::f16;
use npyz::WriterBuilder;
use npyz::npz::NpzArchive;

use super::{ReadError, WriteError, write_atomic};

/// Header text longer than this is refused; that of a plain array has about 100 bytes.
const MAX_HEADER: usize = 1 << 16;

/// What an array consists of.
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

/// What the header of an array says.
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
    zip: NpzArchive<BufReader<File>>,
}

impl Archive {
    /// Opens the file and reads the list of its arrays.
    pub fn open(path: &Path) -> Result<Archive, ReadError> {
        let whole = "a whole .npz file as numpy.savez writes it";
        let file = File::open(path).map_err(|error| ReadError::file(path, error, "a file that can be read"))?;
        let zip = NpzArchive::new(BufReader::new(file)).map_err(|error| {
            ReadError::file(path, format!("no zip archive, or one that is cut short ({error})"), whole)
        })?;
        Ok(Archive { path: path.into(), zip })
    }

    /// Names of the arrays, sorted.
    pub fn names(&self) -> Vec<String> {
        let mut names: Vec<String> = self.zip.array_names().map(String::from).collect();
        names.sort();
        names
    }

    /// Header of the array `name`; `None` if there is no such array.
    pub fn header(&mut self, name: &str) -> Result<Option<Header>, ReadError> {
        if !self.zip.array_names().any(|n| n == name) {
            return Ok(None);
        }
        let fault = Fault { path: &self.path, name };
        let file = npyz::npz::file_name_from_array_name(name);
        let mut entry = self.zip.zip_archive().by_name(&file).map_err(|e| fault.error(e, "a readable zip entry"))?;
        read_header(&mut entry, &fault).map(|(header, _)| Some(header))
    }

    /// Reads the array `name`, of at most `limit` elements; `None` if there is no such array.
    pub fn read<T: Number>(&mut self, name: &str, limit: u64) -> Result<Option<Array<T>>, ReadError> {
        if !self.zip.array_names().any(|n| n == name) {
            return Ok(None);
        }
        let fault = Fault { path: &self.path, name };
        let file = npyz::npz::file_name_from_array_name(name);
        let mut entry = self.zip.zip_archive().by_name(&file).map_err(|e| fault.error(e, "a readable zip entry"))?;
        let (header, header_bytes) = read_header(&mut entry, &fault)?;
        let count = header.shape.iter().try_fold(1u64, |n, &axis| n.checked_mul(axis)).filter(|&n| n <= limit);
        let Some(count) = count else {
            return Err(
                fault.error(format!("shape {:?} is too large", header.shape), format!("{limit} values at most"))
            );
        };
        // No overflow: count <= limit, which is far below 2^60.
        let expected = count.saturating_mul(header.element.bytes() as u64);
        let present = entry.size().saturating_sub(header_bytes);
        if present != expected {
            let why = format!("{present} bytes of data for shape {:?}", header.shape);
            return Err(fault.error(why, format!("{expected} bytes")));
        }
        let values = read_values(&mut entry, &header, count, &fault)?;
        Ok(Some(in_c_order(Array { shape: header.shape, values }, header.fortran_order)))
    }

    /// The shape of the array `name`, which must be of floats; `None` if there is no such array.
    pub(super) fn float_shape(&mut self, name: &str) -> Result<Option<Vec<u64>>, ReadError> {
        match self.header(name)? {
            Some(header) if !header.element.is_float() => {
                Err(self.fault(name, "elements are integers", "f16, f32 or f64"))
            }
            header => Ok(header.map(|header| header.shape)),
        }
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

/// Reads `count` elements in the order of the file, to the end of the entry so that its checksum is looked at.
fn read_values<T: Number>(
    input: &mut impl Read,
    header: &Header,
    count: u64,
    fault: &Fault,
) -> Result<Vec<T>, ReadError> {
    let size = header.element.bytes();
    let total = count * size as u64;
    let mut buffer = vec![0; 1 << 16];
    let mut values: Vec<T> = Vec::new();
    let mut done = 0;
    loop {
        let wanted = (total - done).min(buffer.len() as u64) as usize;
        // One byte more than is wanted at the end: it must not be there, and the checksum is verified on the way.
        let chunk = &mut buffer[..wanted.max(1)];
        let got = read_full(input, chunk).map_err(|e| fault.at_byte(done, e, format!("{total} bytes of data")))?;
        if got != wanted {
            let why = if got < wanted { "the data end here" } else { "the data go on" };
            return Err(fault.at_byte(done + got as u64, why, format!("{total} bytes of data")));
        }
        if wanted == 0 {
            return Ok(values);
        }
        let chunk = &chunk[..wanted];
        values.try_reserve(chunk.len() / size).map_err(|e| fault.error(e, "an array that fits into memory"))?;
        match (header.element, header.little_endian) {
            // The usual case without the generic decoder, which is several times slower.
            (Element::F32, true) => values.extend(
                chunk.chunks_exact(4).map(|b| T::from_f64(f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]])))),
            ),
            (element, little) => {
                values.extend(chunk.chunks_exact(size).map(|bytes| T::from_f64(element.decode(bytes, little))))
            }
        }
        done += wanted as u64;
    }
}

/// Reorders an array whose first axis runs fastest.
fn in_c_order<T: Number>(array: Array<T>, fortran_order: bool) -> Array<T> {
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

/// Refuses a shape that does not hold `count` values.
pub(super) fn check_count(shape: &[u64], count: usize) -> io::Result<()> {
    if shape.iter().try_fold(1u64, |n, &axis| n.checked_mul(axis)) == Some(count as u64) {
        return Ok(());
    }
    Err(io::Error::new(io::ErrorKind::InvalidInput, format!("{count} values do not fill shape {shape:?}")))
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::io::tests::Folder;
    use npyz::npz::NpzWriter;
    use std::fs;
    use std::io::Write;

    /// The bytes of a `.npy` file.
    pub(crate) fn npy(descr: &str, fortran: bool, shape: &str, data: &[u8]) -> Vec<u8> {
        let fortran = if fortran { "True" } else { "False" };
        with_header(&format!("{{'descr': {descr}, 'fortran_order': {fortran}, 'shape': {shape}, }}\n"), data)
    }

    fn with_header(text: &str, data: &[u8]) -> Vec<u8> {
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend((text.len() as u16).to_le_bytes());
        bytes.extend(text.as_bytes());
        bytes.extend(data);
        bytes
    }

    /// Writes an `.npz` of such arrays.
    pub(crate) fn write_archive(path: &Path, arrays: &[(&str, Vec<u8>)]) {
        let mut npz = NpzWriter::new(File::create(path).unwrap());
        for (name, bytes) in arrays {
            npz.zip_writer().start_file(format!("{name}.npy"), Default::default()).unwrap();
            npz.zip_writer().write_all(bytes).unwrap();
        }
        npz.zip_writer().finish().unwrap();
    }

    fn read_one(bytes: Vec<u8>) -> Result<Array<f64>, ReadError> {
        let folder = Folder::new();
        let path = folder.0.join("one.npz");
        write_archive(&path, &[("a", bytes)]);
        Archive::open(&path)?.read("a", 1 << 20).map(Option::unwrap)
    }

    #[test]
    fn every_number_type_in_both_byte_orders() {
        let values = [1.5f64, -2.0, 0.25, 65504.0];
        let check = |descr: &str, bytes: Vec<u8>, expected: &[f64]| {
            let array = read_one(npy(descr, false, "(4,)", &bytes)).unwrap();
            assert_eq!((array.values.as_slice(), &array.shape[..]), (expected, &[4][..]), "{descr}");
        };
        check("'<f8'", values.iter().flat_map(|v| v.to_le_bytes()).collect(), &values);
        check("'>f8'", values.iter().flat_map(|v| v.to_be_bytes()).collect(), &values);
        check("'<f4'", values.iter().flat_map(|v| (*v as f32).to_le_bytes()).collect(), &values);
        check("'>f4'", values.iter().flat_map(|v| (*v as f32).to_be_bytes()).collect(), &values);
        check("'<f2'", values.iter().flat_map(|v| f16::from_f64(*v).to_le_bytes()).collect(), &values);
        check("'>f2'", values.iter().flat_map(|v| f16::from_f64(*v).to_be_bytes()).collect(), &values);
        let whole = [1i16, -2, 300, -32768];
        check("'<i2'", whole.iter().flat_map(|v| v.to_le_bytes()).collect(), &[1.0, -2.0, 300.0, -32768.0]);
        check("'>i2'", whole.iter().flat_map(|v| v.to_be_bytes()).collect(), &[1.0, -2.0, 300.0, -32768.0]);
        check("'|i1'", vec![255, 1, 128, 0], &[-1.0, 1.0, -128.0, 0.0]);
        check("\"|u1\"", vec![255, 1, 128, 0], &[255.0, 1.0, 128.0, 0.0]);
        let longest = [u64::MAX, 0, 1, 7].iter().flat_map(|v| v.to_le_bytes()).collect();
        check("'<u8'", longest, &[u64::MAX as f64, 0.0, 1.0, 7.0]);
    }

    #[test]
    fn shapes_and_headers_as_numpy_writes_them() {
        let data: Vec<u8> = (0..24u8).collect();
        let c = read_one(npy("'|u1'", false, "(2, 3, 4)", &data)).unwrap();
        assert_eq!(c.values, (0..24).map(f64::from).collect::<Vec<_>>());
        let fortran = read_one(npy("'|u1'", true, "(2, 3, 4)", &data)).unwrap();
        let at = |i: usize, j: usize, k: usize| fortran.values[(i * 3 + j) * 4 + k];
        assert_eq!([at(0, 0, 0), at(1, 0, 0), at(0, 1, 0), at(0, 0, 1), at(1, 2, 3)], [0.0, 1.0, 2.0, 6.0, 23.0]);
        assert_eq!(read_one(npy("'|u1'", true, "()", &[9])).unwrap().values, [9.0]);
        assert_eq!(read_one(npy("'|u1'", true, "(24L,)", &data)).unwrap().shape, [24]);
        assert_eq!(read_one(npy("'<f4'", false, "(0, 5)", &[])).unwrap().shape, [0, 5]);
        let compact = with_header("{\"shape\":(2,),\"fortran_order\":False,\"descr\":\"|u1\"}", &[1, 2]);
        assert_eq!(read_one(compact).unwrap().values, [1.0, 2.0]);
        let mut version_2 = b"\x93NUMPY\x02\x00".to_vec();
        let text = b"{'descr': '|u1', 'fortran_order': False, 'shape': (1,), }";
        version_2.extend((text.len() as u32).to_le_bytes());
        version_2.extend(text);
        version_2.push(5);
        assert_eq!(read_one(version_2).unwrap().values, [5.0]);
    }

    #[test]
    fn faulty_arrays_are_named() {
        let says = |bytes: Vec<u8>, words: &[&str]| {
            let error = read_one(bytes).unwrap_err().to_string();
            assert!(words.iter().all(|w| error.contains(w)) && error.contains("one.npz: array `a`"), "{error}");
        };
        says(npy("'<f4'", false, "(4,)", &[0; 15]), &["15 bytes", "[4]", "expected 16 bytes"]);
        says(npy("'<f4'", false, "(4,)", &[0; 17]), &["17 bytes", "expected 16 bytes"]);
        says(npy("'<f4'", false, "(99999, 99999)", &[0; 16]), &["too large"]);
        says(npy("'<f4'", false, "(4294967296, 4294967296, 0)", &[0; 16]), &["too large"]);
        says(npy("'<f4'", false, "(99999999999999999999999,)", &[0; 16]), &["shape"]);
        says(npy("'<f4'", false, "(-4,)", &[0; 16]), &["shape"]);
        says(npy("'|O'", false, "(4,)", &[0; 16]), &["`|O`", "f16, f32 or f64"]);
        says(npy("'<c8'", false, "(2,)", &[0; 16]), &["`<c8`"]);
        says(npy("'<f16'", false, "(1,)", &[0; 16]), &["`<f16`"]);
        says(npy("[('x', '<f4')]", false, "(4,)", &[0; 16]), &["several fields", "f16, f32 or f64"]);
        says(npy("'ä'", false, "(4,)", &[0; 16]), &["`ä`"]);
        says(with_header("{'descr': '<f4'}", &[]), &["lacks"]);
        says(with_header("[[[[[[[[[[", &[]), &["no dictionary"]);
        says(with_header("{'descr': '<f4' 'shape': (1,)}", &[]), &["comma"]);
        says(with_header("{'other': 3}", &[]), &["unknown key"]);
        says(b"\x93NUMPY\x01\x00\xff\xff{'descr'".to_vec(), &["byte 0", "ends within the header"]);
        says(b"\x93NUMPY\x02\x00\xff\xff\xff\xff{".to_vec(), &["header of 4294967295 bytes"]);
        says(b"\x93NUMPY\x09\x00\xff\xff".to_vec(), &["known version"]);
        says(b"no".to_vec(), &["byte 0"]);
        says(vec![], &["byte 0"]);
    }

    #[test]
    fn no_damage_to_an_archive_panics() {
        let folder = Folder::new();
        let path = folder.0.join("damaged.npz");
        write_archive(
            &path,
            &[("a", npy("'<f4'", true, "(2, 2)", &[1; 16])), ("b", npy("'<i8'", false, "()", &[2; 8]))],
        );
        let whole = fs::read(&path).unwrap();
        let read = |bytes: &[u8]| {
            fs::write(&path, bytes).unwrap();
            let mut archive = Archive::open(&path)?;
            for name in archive.names() {
                archive.header(&name)?;
                archive.read::<f32>(&name, 1 << 20)?;
            }
            Ok::<(), ReadError>(())
        };
        read(&whole).unwrap();
        for cut in 0..whole.len() {
            assert!(read(&whole[..cut]).is_err(), "cut at {cut}");
        }
        // The packed data of the first array follow a local header of 30 bytes and the name: the checksum tells.
        for at in 35..75 {
            let mut damaged = whole.clone();
            damaged[at] ^= 0x10;
            assert!(read(&damaged).is_err(), "byte {at}");
        }
        for at in 0..whole.len() {
            for value in [0, 0xff, whole[at] ^ 0x10] {
                let mut damaged = whole.clone();
                damaged[at] = value;
                // Not every byte of an archive matters (dates, for one); what counts is that it returns.
                let _ = read(&damaged);
            }
        }
    }

    #[test]
    fn npy_files_hold_what_was_written() {
        let folder = Folder::new();
        let path = folder.0.join("deep/a.npy");
        let values = [1.0f32, f32::NEG_INFINITY, 1e-45, -0.0, 3.5, 7.25];
        write_npy(&path, &[2, 3], &values).unwrap();
        let bytes = fs::read(&path).unwrap();
        let (header, start) = read_header(&mut &bytes[..], &Fault { path: &path, name: "" }).unwrap();
        assert_eq!((header.element, &header.shape[..], header.fortran_order), (Element::F32, &[2, 3][..], false));
        let stored: Vec<u32> =
            bytes[start as usize..].chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();
        assert_eq!(stored, values.map(f32::to_bits));
        // NumPy maps files whose data begin at a multiple of 64.
        assert_eq!(start % 16, 0);
        write_npy(&path, &[0, 5], &[]).unwrap();
        write_npy(&path, &[], &[1.0]).unwrap();
        let error = write_npy(&path, &[4, 2], &values).unwrap_err().to_string();
        assert!(error.contains("a.npy") && error.contains("6 values") && error.contains("[4, 2]"), "{error}");
        assert_eq!(fs::read_dir(path.parent().unwrap()).unwrap().count(), 1);
    }
}
