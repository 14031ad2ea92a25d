//! OpenVDB files, versions 220 to 224: grids of numbers and vectors in trees of 5-4-3 levels.
//!
//! The format is that of the library's sources (`openvdb/io/Archive.cc`, `io/Compression.h`, `tree/*Node.h`). A grid's tree
//! comes first, without the values of voxels; these follow, leaf by leaf. So a grid is opened by reading its tree, which
//! says where there is something, and then its voxels go from the file to where they belong, and nowhere in between.

mod bytes;
mod codec;
mod map;
mod tree;

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use exr::prelude::f16;

use self::bytes::Bytes;
use self::codec::Packing;
pub use self::map::Map;
pub use self::tree::{Brick, Tree};
use super::{ReadError, file};

/// First and last version of the format that is read.
const VERSIONS: std::ops::RangeInclusive<u32> = 220..=224;
const MAGIC: i64 = 0x5644_4220;
/// First version in which grids, not files, say how they are packed.
const GRID_COMPRESSION: u32 = codec::NODE_MASKS;
/// What stands behind a grid's name if it is not the first of that name, before a number.
const SEPARATOR: char = '\u{1e}';
/// What a type ends in whose values are stored as half floats.
const HALF: &str = "_HalfFloat";
/// Bytes that a file's own metadata, and a descriptor, have room in.
const FIRST: u64 = 1 << 22;
const DESCRIPTOR: u64 = 1 << 14;
/// Most entries of metadata, and most grids: real files have a few dozen.
const MOST_ENTRIES: u32 = 65_536;

/// Numbers that voxels have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scalar {
    /// 16-bit float.
    Half,
    /// 32-bit float.
    Float,
    /// 64-bit float.
    Double,
    /// 32-bit integer.
    Int32,
    /// 64-bit integer.
    Int64,
}

impl Scalar {
    fn bytes(self) -> usize {
        match self {
            Scalar::Half => 2,
            Scalar::Float | Scalar::Int32 => 4,
            Scalar::Double | Scalar::Int64 => 8,
        }
    }

    fn is_real(self) -> bool {
        !matches!(self, Scalar::Int32 | Scalar::Int64)
    }

    /// Numbers as the nearest `f32`.
    fn unpack(self, from: &[u8], to: &mut [f32]) {
        fn each<const N: usize>(from: &[u8], to: &mut [f32], number: impl Fn([u8; N]) -> f32) {
            from.as_chunks().0.iter().zip(to).for_each(|(bytes, to)| *to = number(*bytes));
        }
        match self {
            Scalar::Half => each(from, to, |bytes| f16::from_le_bytes(bytes).to_f32()),
            Scalar::Float => each(from, to, f32::from_le_bytes),
            Scalar::Double => each(from, to, |bytes| f64::from_le_bytes(bytes) as f32),
            Scalar::Int32 => each(from, to, |bytes| i32::from_le_bytes(bytes) as f32),
            Scalar::Int64 => each(from, to, |bytes| i64::from_le_bytes(bytes) as f32),
        }
    }
}

/// What a voxel has: a number, or a vector of three.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Element {
    /// Its numbers.
    pub scalar: Scalar,
    /// How many: 1 or 3.
    pub components: usize,
}

impl Element {
    fn bytes(self) -> usize {
        self.scalar.bytes() * self.components
    }

    /// That of a type of grid, if it is one that is read.
    fn of(grid_type: &str) -> Option<Element> {
        let name = grid_type.strip_prefix("Tree_")?.strip_suffix("_5_4_3")?;
        let (scalar, components) = match name {
            "half" => (Scalar::Half, 1),
            "float" => (Scalar::Float, 1),
            "double" => (Scalar::Double, 1),
            "int32" => (Scalar::Int32, 1),
            "int64" => (Scalar::Int64, 1),
            "vec3h" => (Scalar::Half, 3),
            "vec3s" => (Scalar::Float, 3),
            "vec3d" => (Scalar::Double, 3),
            "vec3i" => (Scalar::Int32, 3),
            _ => return None,
        };
        Some(Element { scalar, components })
    }
}

/// A file, and what its grids are.
#[derive(Debug)]
pub struct Vdb<F = File> {
    path: PathBuf,
    file: F,
    version: u32,
    /// How all grids are packed, in versions before [`GRID_COMPRESSION`].
    compression: u32,
    grids: Vec<Entry>,
}

/// A grid of a file, as its descriptor has it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Entry {
    /// Its name.
    pub name: String,
    /// How many grids before it have the same.
    pub number: u32,
    /// Its type as the file names it: `Tree_float_5_4_3`.
    pub grid_type: String,
    /// Its values are stored as half floats.
    pub is_half: bool,
    /// What its voxels have; none: a type that is not read, such as points.
    pub element: Option<Element>,
    /// Its name as the file tells it from others, and that of the grid whose tree it has, if that is another's.
    unique: String,
    parent: String,
    /// Bytes at which its header and its voxels begin, and behind these.
    at: [u64; 3],
}

/// A grid in memory, as it is in the file.
#[derive(Debug)]
pub struct Block {
    path: PathBuf,
    entry: Entry,
    version: u32,
    compression: u32,
    bytes: Vec<u8>,
    /// Where it is, if it has another's tree.
    own: Option<Place>,
}

/// What a grid says of itself.
#[derive(Clone, Debug, PartialEq)]
pub struct Place {
    /// Where it is in the world.
    pub map: Map,
    /// What kind of thing it is: `fog volume`, `level set`, `staggered`; often empty.
    pub class: String,
}

/// A grid with its tree.
#[derive(Debug)]
pub struct Grid<'f> {
    /// What it says of itself.
    pub place: Place,
    /// Where it has values.
    pub tree: Tree<'f>,
}

impl Entry {
    /// Its name, with its number if it is not the first.
    pub fn title(&self) -> String {
        if self.number == 0 { self.name.clone() } else { format!("{}[{}]", self.name, self.number) }
    }

    /// Its type as people call it: `float`, `half`, `vec3f`.
    pub fn type_name(&self) -> String {
        let Some(Element { scalar, components }) = self.element else {
            return self.grid_type.strip_prefix("Tree_").unwrap_or(&self.grid_type).to_owned();
        };
        let scalar = if self.is_half && scalar.is_real() { Scalar::Half } else { scalar };
        let name = match (scalar, components) {
            (Scalar::Half, 1) => "half",
            (Scalar::Float, 1) => "float",
            (Scalar::Double, 1) => "double",
            (Scalar::Int32, 1) => "int32",
            (Scalar::Int64, 1) => "int64",
            (Scalar::Half, _) => "vec3h",
            (Scalar::Float, _) => "vec3f",
            (Scalar::Double, _) => "vec3d",
            (Scalar::Int32 | Scalar::Int64, _) => "vec3i",
        };
        name.to_owned()
    }
}

impl Vdb {
    /// Reads what a file's grids are, not yet their trees.
    ///
    /// # Errors
    /// What cannot be read, is no such file, of another version, or is damaged: with the byte.
    pub fn open(path: &Path) -> Result<Vdb, ReadError> {
        let file = file::open(path).map_err(|error| ReadError::file(path, error, "a file that can be read"))?;
        Vdb::of(path, file)
    }
}

impl<F: Read + Seek> Vdb<F> {
    /// [`Vdb::open`] of anything that has a file's bytes.
    pub fn of(path: &Path, mut file: F) -> Result<Vdb<F>, ReadError> {
        let begin = part(path, &mut file, [0, FIRST])?;
        let mut bytes = Bytes::new(path, &begin, 0);
        let (version, compression) = header(&mut bytes)?;
        metadata(&mut bytes)?;
        let count = entries(&mut bytes, "grids")?;
        let mut at = bytes.at();
        let mut grids: Vec<Entry> = Vec::new();
        for _ in 0..count {
            let part = part(path, &mut file, [at, at.saturating_add(DESCRIPTOR)])?;
            let entry = descriptor(&mut Bytes::new(path, &part, at), &grids)?;
            // The next descriptor stands behind this grid.
            at = entry.at[2];
            grids.push(entry);
        }
        Ok(Vdb { path: path.into(), file, version, compression, grids })
    }

    /// Its grids, in the order of the file.
    pub fn grids(&self) -> &[Entry] {
        &self.grids
    }

    /// The grid that `name` or `name[number]` means.
    pub fn find(&self, name: &str) -> Option<&Entry> {
        let exact = self.grids.iter().find(|grid| grid.number == 0 && grid.name == name);
        exact.or_else(|| self.grids.iter().find(|grid| grid.title() == name))
    }

    /// Reads a grid; without `voxels`, only where it has them.
    ///
    /// # Errors
    /// What cannot be read, or is damaged, with the byte; a tree that is another grid's, which is not there.
    pub fn load(&mut self, entry: &Entry, voxels: bool) -> Result<Block, ReadError> {
        if entry.parent.is_empty() {
            return self.block(entry, voxels, None);
        }
        let of = |grid: &&Entry| grid.unique == entry.parent && grid.parent.is_empty();
        let Some(parent) = self.grids.iter().find(of).cloned() else {
            let why = format!("grid `{}` has the tree of `{}`, which is not there", entry.title(), entry.parent);
            return Err(ReadError::at(&self.path, format!("byte {}", entry.at[0]), why, "a grid of the file"));
        };
        let own = self.block(entry, false, None)?;
        let (_, own) = own.header(&mut own.begin())?;
        self.block(&parent, voxels, Some(own))
    }

    fn block(&mut self, entry: &Entry, voxels: bool, own: Option<Place>) -> Result<Block, ReadError> {
        let [begin, between, end] = entry.at;
        let bytes = part(&self.path, &mut self.file, [begin, if voxels { end } else { between }])?;
        let Vdb { version, compression, .. } = *self;
        Ok(Block { path: self.path.clone(), entry: entry.clone(), version, compression, bytes, own })
    }
}

impl Block {
    /// The grid's place in the world, and its tree.
    ///
    /// # Errors
    /// What is damaged, with the byte; a type that is not read; a transform that is not affine.
    pub fn grid(&self) -> Result<Grid<'_>, ReadError> {
        let mut bytes = self.begin();
        let (compression, place) = self.header(&mut bytes)?;
        let Entry { is_half, element, at: [begin, between, _], .. } = self.entry;
        let Some(element) = element else {
            let why = format!("grid `{}` is of type {}", self.entry.title(), self.entry.grid_type);
            return Err(bytes.fault(why, "numbers or vectors in a tree of levels 5-4-3"));
        };
        let packing = Packing { version: self.version, compression, element, is_half };
        let voxels = self.bytes.get((between - begin) as usize..).unwrap_or_default();
        let tree = Tree::read(packing, &mut bytes, Bytes::new(&self.path, voxels, between))?;
        Ok(Grid { place: self.own.clone().unwrap_or(place), tree })
    }

    fn begin(&self) -> Bytes<'_> {
        Bytes::new(&self.path, &self.bytes, self.entry.at[0])
    }

    /// How the grid is packed, and what it says of itself; its tree comes next.
    fn header(&self, bytes: &mut Bytes) -> Result<(u32, Place), ReadError> {
        let compression = match self.version >= GRID_COMPRESSION {
            true => bytes.value("a grid's compression")?,
            false => self.compression,
        };
        let class = metadata(bytes)?;
        Ok((compression, Place { map: Map::read(bytes)?, class }))
    }
}

/// The bytes of a file from one to before another, or to its end.
fn part<F: Read + Seek>(path: &Path, file: &mut F, [from, to]: [u64; 2]) -> Result<Vec<u8>, ReadError> {
    let mut read = || {
        let size = file.seek(SeekFrom::End(0))?;
        file.seek(SeekFrom::Start(from))?;
        let count = to.min(size).saturating_sub(from);
        let mut bytes = Vec::new();
        bytes.try_reserve_exact(usize::try_from(count).map_err(io::Error::other)?)?;
        file.take(count).read_to_end(&mut bytes)?;
        io::Result::Ok(bytes)
    };
    read().map_err(|error| ReadError::file(path, error, "a file that can be read"))
}

/// The version, and how grids are packed in versions that say it here.
fn header(bytes: &mut Bytes) -> Result<(u32, u32), ReadError> {
    if bytes.value::<i64>("the beginning").ok() != Some(MAGIC) {
        return Err(ReadError::file(bytes.path, "is no OpenVDB file", "a file that begins as one"));
    }
    let version: u32 = bytes.value("the version")?;
    if !VERSIONS.contains(&version) {
        let expected = format!("{} to {}; vdb files of today are 224", VERSIONS.start(), VERSIONS.end());
        return Err(bytes.fault(format!("is of file version {version}"), expected));
    }
    bytes.take(8, "the library's version")?;
    if bytes.value::<u8>("whether there are offsets")? == 0 {
        return Err(bytes.fault("was written to a stream: nothing says where its grids are", "a file with offsets"));
    }
    let compression = match version < GRID_COMPRESSION {
        true => u32::from(bytes.value::<u8>("compression")?),
        false => 0,
    };
    bytes.take(36, "the file's id")?;
    Ok((version, compression))
}

fn entries(bytes: &mut Bytes, what: &str) -> Result<u32, ReadError> {
    let count: u32 = bytes.value(what)?;
    match count > MOST_ENTRIES {
        true => Err(bytes.fault(format!("{count} {what}"), format!("{MOST_ENTRIES} at most"))),
        false => Ok(count),
    }
}

/// Passes over metadata, but for the class.
fn metadata(bytes: &mut Bytes) -> Result<String, ReadError> {
    let mut class = String::new();
    for _ in 0..entries(bytes, "entries of metadata")? {
        let name = bytes.text("a name of metadata")?;
        bytes.text("a type of metadata")?;
        let length: u32 = bytes.value("the length of metadata")?;
        let value = bytes.take(length as usize, "metadata")?;
        if name == "class" {
            class = String::from_utf8_lossy(value).into_owned();
        }
    }
    Ok(class)
}

/// The next descriptor.
fn descriptor(bytes: &mut Bytes, before: &[Entry]) -> Result<Entry, ReadError> {
    let unique = bytes.text("a grid's name")?;
    let stored = bytes.text("a grid's type")?;
    let parent = bytes.text("the name of another grid")?;
    let begin = *bytes;
    let mut at: [u64; 3] = bytes.value("where a grid is")?;
    if !parent.is_empty() {
        // It has no voxels of its own.
        at[1] = at[2];
    }
    if !(begin.at() < at[0] && at.is_sorted()) {
        let expected = format!("ascending bytes beyond {}", begin.at());
        return Err(begin.fault(format!("a grid, its voxels and what follows are at bytes {at:?}"), expected));
    }
    let name = unique.split(SEPARATOR).next().unwrap_or_default().to_owned();
    let number = before.iter().filter(|grid| grid.name == name).count() as u32;
    let half = stored.strip_suffix(HALF);
    let grid_type = half.unwrap_or(&stored).to_owned();
    let (is_half, element) = (half.is_some(), Element::of(&grid_type));
    Ok(Entry { name, number, grid_type, is_half, element, unique, parent, at })
}

#[cfg(test)]
pub(super) mod tests;
