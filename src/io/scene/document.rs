//! A glTF file taken apart: its JSON, its buffers, and the numbers of its accessors.
//!
//! Every index and every byte is checked here, for nothing in a file is trusted.

use std::borrow::Cow;
use std::cell::{OnceCell, RefCell};
use std::collections::HashSet;
use std::path::{Path, PathBuf};

use super::budget::Budget;
use super::data_uri;
use super::json::{Accessor, Buffer, BufferView, ComponentType, Compressed, Head, Index, Root, Type};
use super::reach::{REACH, beside};
use super::{Note, extensions, meshopt};
use crate::io::{ReadError, file};

/// Most memory of an object of the JSON, in bytes, but for what is longer in the file as well.
const OBJECT: u64 = 512;

/// A glTF file in memory.
pub(super) struct Document<'a> {
    pub(super) path: &'a Path,
    pub(super) root: Root,
    /// Wishes of the file that it cannot have.
    pub(super) notes: Vec<Note>,
    pub(super) budget: Budget<'a>,
    /// The binary chunk.
    binary: Option<&'a [u8]>,
    /// Those that have been read.
    buffers: Vec<OnceCell<Cow<'a, [u8]>>>,
    /// Contents of compressed buffer views, of those that have been read.
    unpacked: Vec<OnceCell<Vec<u8>>>,
    /// Files that it names and that have been read.
    files: RefCell<HashSet<PathBuf>>,
}

impl<'a> Document<'a> {
    /// Takes a `.glb` or `.gltf` file apart. The buffers that it names are read where something in them is.
    pub(super) fn new(path: &'a Path, file: &'a [u8]) -> Result<Document<'a>, ReadError> {
        let (json, binary) = match file.starts_with(b"glTF") {
            true => glb_chunks(path, file)?,
            false => (file, None),
        };
        let json = without_ends(json);
        let head: Head = serde_json::from_slice(json).map_err(|error| json_error(path, error))?;
        check_version(path, &head)?;
        extensions::check(path, &head)?;
        let budget = Budget::new(path, file.len());
        let objects = json.iter().filter(|&&byte| byte == b'{').count() as u64;
        budget.keep("its JSON", &format!("{objects} objects"), objects * OBJECT)?;
        let root: Root = serde_json::from_slice(json).map_err(|error| json_error(path, error))?;
        let buffers = root.buffers.iter().map(|_| OnceCell::new()).collect();
        let unpacked = root.buffer_views.iter().map(|_| OnceCell::new()).collect();
        let (notes, files) = (extensions::notes(&head), RefCell::default());
        Ok(Document { path, root, notes, budget, binary, buffers, unpacked, files })
    }

    /// The bytes of a buffer.
    fn buffer(&self, index: Index<Buffer>) -> Result<&[u8], ReadError> {
        let buffer = self.entry(&self.root.buffers, index, "buffer")?;
        let read = &self.buffers[index.value()];
        if let Some(bytes) = read.get() {
            return Ok(bytes);
        }
        let bytes = self.read_buffer(index.value(), buffer)?;
        Ok(read.get_or_init(|| bytes))
    }

    /// Reads a buffer: the binary chunk, a `data:` URI, or a file beside this one.
    fn read_buffer(&self, index: usize, buffer: &Buffer) -> Result<Cow<'a, [u8]>, ReadError> {
        let place = format!("buffer {index}");
        let is_fallback = buffer.extensions.is_fallback();
        let mut bytes = match (&buffer.uri, self.binary) {
            (Some(uri), _) => self.resource(&place, uri, buffer.byte_length.0)?,
            (None, Some(binary)) if index == 0 && !is_fallback => Cow::Borrowed(binary),
            _ => return Err(self.fault(place, "has neither a URI nor a binary chunk", "a .glb file, or a URI")),
        };
        if (bytes.len() as u64) < buffer.byte_length.0 {
            let expected = format!("{} bytes", buffer.byte_length.0);
            return Err(self.fault(place, format!("has {} bytes", bytes.len()), expected));
        }
        let length = buffer.byte_length.0 as usize;
        match &mut bytes {
            Cow::Borrowed(bytes) => *bytes = &bytes[..length],
            Cow::Owned(bytes) => bytes.truncate(length),
        }
        Ok(bytes)
    }

    /// The data of a URI: those in it, or the bytes of a file beside this one, of which at most `most` are read.
    pub(super) fn resource(&self, place: &str, uri: &str, most: u64) -> Result<Cow<'static, [u8]>, ReadError> {
        if uri.starts_with("data:") {
            return data_uri::decoded(uri).map(Cow::Owned).ok_or_else(|| {
                let expected = "`data:TYPE;base64,` and base64, or `data:TYPE,` and text";
                self.fault(place.to_owned(), "a data URI that cannot be decoded", expected)
            });
        }
        let path = beside(self.path, uri).map_err(|why| self.fault(place, why, REACH))?;
        let fault = |error| self.fault(place, format!("{}: {error}", path.display()), "a file that can be read");
        let size = file::open(&path).and_then(|file| file.metadata()).map_err(fault)?.len().min(most);
        if self.files.borrow_mut().insert(path.clone()) {
            self.budget.extend(size);
        }
        self.budget.keep(place, &format!("{size} bytes of {}", path.display()), size)?;
        file::read(&path, size).map(Cow::Owned).map_err(fault)
    }

    /// A fault at one place of the file.
    pub(super) fn fault(&self, place: impl Into<String>, why: impl ToString, expected: impl Into<String>) -> ReadError {
        ReadError::at(self.path, place, why, expected)
    }

    /// The entry of that number in one of the file's lists; `what` names the list.
    pub(super) fn entry<'s, T>(&'s self, list: &'s [T], index: Index<T>, what: &str) -> Result<&'s T, ReadError> {
        list.get(index.value()).ok_or_else(|| {
            let why = format!("there is no {what} {}", index.value());
            self.fault(String::new(), why, format!("a number below {}, how many there are", list.len()))
        })
    }

    /// The bytes of a buffer view and their stride, if it has one.
    pub(super) fn view(&self, index: Index<BufferView>) -> Result<(&[u8], Option<usize>), ReadError> {
        let view = self.entry(&self.root.buffer_views, index, "buffer view")?;
        let place = format!("buffer view {}", index.value());
        let range = (view.byte_offset.unwrap_or_default().0, view.byte_length.0);
        let bytes = match view.extensions.compressed() {
            Some(compressed) => {
                let unpacked = &self.unpacked[index.value()];
                if unpacked.get().is_none() {
                    // Nobody else fills it in between.
                    let _ = unpacked.set(self.unpacked(&place, compressed)?);
                }
                unpacked.get().map_or(&[][..], Vec::as_slice)
            }
            None => self.part(&place, view.buffer, range)?,
        };
        Ok((bytes, view.byte_stride.map(|stride| stride.0 as usize)))
    }

    /// The bytes of a compressed buffer view, `place`.
    fn unpacked(&self, place: &str, compressed: &Compressed) -> Result<Vec<u8>, ReadError> {
        let count = compressed.count.0;
        let bytes = self.part(place, compressed.buffer, (compressed.byte_offset.0, compressed.byte_length.0))?;
        let size = count.saturating_mul(compressed.byte_stride.0);
        self.budget.work(place, &format!("{count} compressed values"), size)?;
        self.budget.keep(place, &format!("{count} compressed values"), size)?;
        meshopt::unpack(bytes, compressed).map_err(|(why, expected)| self.fault(place, why, expected))
    }

    /// Bytes of a buffer: so many from an offset on.
    pub(super) fn part(
        &self,
        place: &str,
        buffer: Index<Buffer>,
        (offset, length): (u64, u64),
    ) -> Result<&[u8], ReadError> {
        let bytes = self.buffer(buffer)?;
        let range = offset.checked_add(length).filter(|&end| end <= bytes.len() as u64);
        let Some(end) = range else {
            let why = format!("{length} bytes from byte {offset}");
            return Err(self.fault(place, why, format!("a part of its buffer of {} bytes", bytes.len())));
        };
        Ok(&bytes[offset as usize..end as usize])
    }

    /// The values of an accessor of `N` components each, integers normalised where it says so. All are finite.
    pub(super) fn values<const N: usize>(&self, index: Index<Accessor>) -> Result<Vec<[f64; N]>, ReadError> {
        let accessor = self.entry(&self.root.accessors, index, "accessor")?;
        let place = format!("accessor {}", index.value());
        let wanted = match N {
            1 => Type::Scalar,
            2 => Type::Vec2,
            3 => Type::Vec3,
            4 => Type::Vec4,
            _ => Type::Mat4,
        };
        let (type_, component) = (accessor.type_, accessor.component_type);
        if type_ == Type::Other || component == ComponentType::Other {
            return Err(self.fault(place, "has an unknown type", format!("{wanted:?} of floats or integers")));
        }
        if type_ != wanted {
            return Err(self.fault(place, format!("is of {type_:?}"), format!("{wanted:?}")));
        }
        let count = accessor.count.0;
        let without = if accessor.buffer_view.is_none() { " without data" } else { "" };
        self.budget.work(&place, &format!("{count} values{without}"), bytes_of::<N>(count))?;
        let decode = |bytes: &[u8]| decoded(component, accessor.normalized, bytes);
        let offset = accessor.byte_offset.unwrap_or_default().0;
        let mut values = match accessor.buffer_view {
            Some(view) => self.elements::<N, _>(&place, view, offset, count, component, decode)?,
            // Within the budget, so within memory.
            None => vec![[0.0; N]; count as usize],
        };
        if accessor.sparse.is_some() {
            self.replace_sparse(&place, accessor, component, &mut values)?;
        }
        match values.iter().position(|value| !value.iter().all(|x| x.is_finite())) {
            Some(row) => Err(self.fault(format!("{place}, value {row}"), "is not finite", "finite numbers")),
            None => Ok(values),
        }
    }

    /// Puts the values of a sparse accessor that differ in their place.
    fn replace_sparse<const N: usize>(
        &self,
        place: &str,
        accessor: &Accessor,
        component: ComponentType,
        values: &mut [[f64; N]],
    ) -> Result<(), ReadError> {
        let Some(sparse) = &accessor.sparse else { return Ok(()) };
        let kind = sparse.indices.component_type;
        if !matches!(kind, ComponentType::U8 | ComponentType::U16 | ComponentType::U32) {
            return Err(self.fault(place, "has sparse indices of an unknown type", "unsigned integers"));
        }
        let (indices, new) = (&sparse.indices, &sparse.values);
        let whole = |bytes: &[u8]| decoded(kind, false, bytes);
        let number = |bytes: &[u8]| decoded(component, accessor.normalized, bytes);
        let count = sparse.count.0;
        self.budget.work(place, &format!("{count} sparse values"), bytes_of::<N>(count))?;
        let rows = self.elements::<1, _>(place, indices.buffer_view, indices.byte_offset.0, count, kind, whole)?;
        let new = self.elements::<N, _>(place, new.buffer_view, new.byte_offset.0, count, component, number)?;
        for ([row], value) in rows.into_iter().zip(new) {
            let Some(slot) = values.get_mut(row as usize) else {
                return Err(self.fault(place, format!("replaces value {row}"), format!("below {}", accessor.count.0)));
            };
            *slot = value;
        }
        Ok(())
    }

    /// `count` elements of `N` components in a buffer view.
    fn elements<const N: usize, D: Fn(&[u8]) -> f64>(
        &self,
        place: &str,
        view: Index<BufferView>,
        offset: u64,
        count: u64,
        component: ComponentType,
        decode: D,
    ) -> Result<Vec<[f64; N]>, ReadError> {
        if count == 0 {
            return Ok(Vec::new());
        }
        let number = view.value();
        let (bytes, stride) = self.view(view)?;
        let size = N * component.size();
        let stride = stride.unwrap_or(size);
        if stride < size {
            let why = format!("buffer view {number} has a stride of {stride} bytes");
            return Err(self.fault(place, why, format!("{size} at least")));
        }
        let end = (count - 1).checked_mul(stride as u64).and_then(|n| n.checked_add(offset)?.checked_add(size as u64));
        if end.is_none_or(|end| end > bytes.len() as u64) {
            let why = format!("{count} values of {size} bytes, {stride} bytes apart, from byte {offset}");
            return Err(self.fault(place, why, format!("values within buffer view {number} of {} bytes", bytes.len())));
        }
        // Within the view, so within memory: nothing is cut by the conversions.
        let rows = (0..count as usize).map(|row| &bytes[offset as usize + row * stride..][..size]);
        Ok(rows.map(|row| std::array::from_fn(|i| decode(&row[i * component.size()..][..component.size()]))).collect())
    }

    /// How many values an accessor has, if all of them are 0 because it has no data.
    pub(super) fn zeros(&self, index: Index<Accessor>) -> Result<Option<u64>, ReadError> {
        let accessor = self.entry(&self.root.accessors, index, "accessor")?;
        Ok((accessor.buffer_view.is_none() && accessor.sparse.is_none()).then_some(accessor.count.0))
    }

    /// The values of an accessor of whole numbers.
    pub(super) fn indices(&self, index: Index<Accessor>) -> Result<Vec<u32>, ReadError> {
        let accessor = self.entry(&self.root.accessors, index, "accessor")?;
        if accessor.component_type == ComponentType::F32 {
            return Err(self.fault(format!("accessor {}", index.value()), "is of floats", "unsigned integers"));
        }
        // What is negative becomes 0xFFFFFFFF and is refused where it is used.
        let whole = |[x]: [f64; 1]| if x < 0.0 { u32::MAX } else { x as u32 };
        Ok(self.values::<1>(index)?.into_iter().map(whole).collect())
    }
}

pub(super) fn json_error(path: &Path, error: serde_json::Error) -> ReadError {
    ReadError::at(path, "its JSON", error, "glTF 2.0")
}

/// Bytes of so many values of `N` numbers.
fn bytes_of<const N: usize>(count: u64) -> u64 {
    count.saturating_mul(8 * N as u64)
}

/// The JSON and the binary chunk of a `.glb` file.
fn glb_chunks<'f>(path: &Path, file: &'f [u8]) -> Result<(&'f [u8], Option<&'f [u8]>), ReadError> {
    let word = |at: usize| file.get(at..at + 4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    let fault = |at: usize, why: String| ReadError::at(path, format!("byte {at}"), why, "a whole .glb file, version 2");
    match word(4) {
        Some(2) => {}
        Some(version) => return Err(fault(4, format!("version {version}"))),
        None => return Err(fault(file.len(), "the file ends".to_owned())),
    }
    match word(8) {
        Some(length) if length as usize > file.len() => {
            return Err(fault(8, format!("a length of {length} bytes, of which {} are there", file.len())));
        }
        Some(_) => {}
        None => return Err(fault(file.len(), "the file ends".to_owned())),
    }
    let chunk = |at: usize| -> Result<Option<(u32, &'f [u8])>, ReadError> {
        let (Some(length), Some(kind)) = (word(at), word(at + 4)) else { return Ok(None) };
        let data = file[at + 8..].get(..length as usize);
        let data = data.ok_or_else(|| {
            fault(at, format!("a chunk of {length} bytes, of which {} are there", file.len() - at - 8))
        })?;
        Ok(Some((kind, data)))
    };
    let Some((JSON, json)) = chunk(12)? else { return Err(fault(12, "the first chunk is not JSON".to_owned())) };
    // Chunks of other kinds are for extensions, and come after the binary one.
    let binary = chunk((20 + json.len()).next_multiple_of(4))?;
    Ok((json, binary.filter(|(kind, _)| *kind == BINARY).map(|(_, data)| data)))
}

/// Kinds of chunks of a `.glb` file.
const JSON: u32 = u32::from_le_bytes(*b"JSON");
const BINARY: u32 = u32::from_le_bytes(*b"BIN\0");

/// The JSON without the byte order mark that some put before it and the zeros that some pad it with.
pub(super) fn without_ends(json: &[u8]) -> &[u8] {
    let json = json.strip_prefix(b"\xef\xbb\xbf").unwrap_or(json);
    let end = json.iter().rposition(|&byte| byte != 0).map_or(0, |last| last + 1);
    &json[..end]
}

/// Refuses a file of another version.
fn check_version(path: &Path, head: &Head) -> Result<(), ReadError> {
    if head.asset.version.split('.').next() != Some("2") {
        return Err(ReadError::at(path, "asset", format!("is glTF {}", head.asset.version), "glTF 2.0"));
    }
    match head.asset.min_version.as_deref().filter(|version| *version != "2.0") {
        Some(version) => Err(ReadError::at(path, "asset", format!("needs glTF {version}"), "glTF 2.0")),
        None => Ok(()),
    }
}

/// A component as a number; `bytes` are as many as it has.
fn decoded(component: ComponentType, normalized: bool, bytes: &[u8]) -> f64 {
    let mut wide = [0; 4];
    wide[..bytes.len()].copy_from_slice(bytes);
    let bits = u32::from_le_bytes(wide);
    let (value, most) = match component {
        ComponentType::I8 => (f64::from(bits as u8 as i8), f64::from(i8::MAX)),
        ComponentType::U8 => (f64::from(bits), f64::from(u8::MAX)),
        ComponentType::I16 => (f64::from(bits as u16 as i16), f64::from(i16::MAX)),
        ComponentType::U16 => (f64::from(bits), f64::from(u16::MAX)),
        // What is unknown is refused before.
        ComponentType::U32 | ComponentType::Other => (f64::from(bits), f64::from(u32::MAX)),
        ComponentType::F32 => return f64::from(f32::from_bits(bits)),
    };
    if normalized { (value / most).max(-1.0) } else { value }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integers_are_normalised() {
        assert_eq!(decoded(ComponentType::I8, true, &[0x80]), -1.0);
        assert_eq!(decoded(ComponentType::I8, true, &[0x81]), -1.0);
        assert_eq!(decoded(ComponentType::I8, false, &[0x80]), -128.0);
        assert_eq!(decoded(ComponentType::U8, true, &[255]), 1.0);
        assert_eq!(decoded(ComponentType::I16, true, &[0xff, 0x7f]), 1.0);
        assert_eq!(decoded(ComponentType::U16, true, &[0xff, 0x7f]), 32767.0 / 65535.0);
        assert_eq!(decoded(ComponentType::U32, false, &[0xff; 4]), 4294967295.0);
        assert_eq!(decoded(ComponentType::F32, true, &2.5f32.to_le_bytes()), 2.5);
    }
}
