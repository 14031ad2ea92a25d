use std::io::{Cursor, Write};

use flate2::Compression;
use flate2::write::ZlibEncoder;

use super::tree::place_in_brick;
use super::*;

const ZIP: u32 = 1;
const MASKS: u32 = 2;
const BACKGROUND: f32 = 2.5;
/// The file's grid has bricks at these places, and a tile of 8^3 voxels.
const BRICKS: [[i32; 3]; 2] = [[0, 0, 0], [-4096, 4088, 128]];
const TILE: [i32; 3] = [0, 0, 8];

/// How a file is written.
#[derive(Clone, Copy, Debug)]
struct Way {
    version: u32,
    compression: u32,
    /// What is said of inactive values, 0 to 6.
    kind: u8,
    half: bool,
}

/// Bytes that a test puts together.
#[derive(Default)]
struct Out(Vec<u8>);

impl Out {
    fn put(&mut self, bytes: impl AsRef<[u8]>) {
        self.0.extend_from_slice(bytes.as_ref());
    }

    fn word(&mut self, value: u32) {
        self.put(value.to_le_bytes());
    }

    fn text(&mut self, text: &str) {
        self.word(text.len() as u32);
        self.put(text);
    }

    fn reals(&mut self, values: &[f64]) {
        values.iter().for_each(|value| self.put(value.to_le_bytes()));
    }
}

/// Whether a voxel of a brick is active, and which of two inactive values it has otherwise.
fn is_active(voxel: usize) -> bool {
    voxel.is_multiple_of(3)
}

fn is_second(voxel: usize) -> bool {
    voxel.is_multiple_of(2)
}

/// A value that halves have, too.
fn active_value(voxel: usize) -> f32 {
    voxel as f32 / 8.0 - 20.0
}

impl Way {
    /// Values of inactive voxels where a mask does not say second, and where it does.
    fn inactive(self) -> [f32; 2] {
        match self.kind {
            0 | 6 => [BACKGROUND; 2],
            1 => [-BACKGROUND; 2],
            2 => [7.0; 2],
            3 => [-BACKGROUND, BACKGROUND],
            4 => [7.0, BACKGROUND],
            _ => [7.0, -9.0],
        }
    }

    fn value(self, active: bool, voxel: usize) -> f32 {
        if active { active_value(voxel) } else { self.inactive()[usize::from(is_second(voxel))] }
    }

    fn has_masks(self) -> bool {
        self.version >= 222
    }

    /// A node's values, of which those at `left_out` are not stored before version 222.
    fn values(self, out: &mut Out, count: usize, active: impl Fn(usize) -> bool, left_out: impl Fn(usize) -> bool) {
        let value = |voxel: usize| self.value(active(voxel), voxel);
        let mut wanted: Vec<usize> = (0..count).collect();
        if self.has_masks() {
            out.put([self.kind]);
            if matches!(self.kind, 2 | 4 | 5) {
                out.put(7.0_f32.to_le_bytes());
            }
            if self.kind == 5 {
                out.put((-9.0_f32).to_le_bytes());
            }
            if matches!(self.kind, 3..=5) {
                out.put(mask(count, is_second));
            }
            if self.compression & MASKS != 0 && self.kind != 6 {
                wanted.retain(|voxel| active(*voxel));
            }
        } else {
            wanted.retain(|voxel| !left_out(*voxel));
        }
        let bytes: Vec<u8> = match self.half {
            true => wanted.iter().flat_map(|v| f16::from_f32(value(*v)).to_le_bytes()).collect(),
            false => wanted.iter().flat_map(|v| value(*v).to_le_bytes()).collect(),
        };
        if wanted.is_empty() && self.half {
            return;
        }
        if self.compression & ZIP == 0 {
            return out.put(bytes);
        }
        let mut packed = ZlibEncoder::new(Vec::new(), Compression::default());
        packed.write_all(&bytes).unwrap();
        let packed = packed.finish().unwrap();
        // What does not become smaller is stored as it is.
        let is_smaller = packed.len() < bytes.len();
        out.put((if is_smaller { packed.len() as i64 } else { -(bytes.len() as i64) }).to_le_bytes());
        out.put(if is_smaller { packed } else { bytes });
    }

    /// A file of one grid.
    fn file(self) -> Vec<u8> {
        let mut out = Out::default();
        out.put(MAGIC.to_le_bytes());
        out.word(self.version);
        [9, 1].into_iter().for_each(|word| out.word(word));
        out.put([1]);
        if !self.has_masks() {
            out.put([(self.compression & ZIP) as u8]);
        }
        out.put([b'-'; 36]);
        [0, 1].into_iter().for_each(|word| out.word(word));
        out.text("density");
        out.text(if self.half { "Tree_float_5_4_3_HalfFloat" } else { "Tree_float_5_4_3" });
        out.text("");
        let at = out.0.len();
        out.put([0; 24]);
        let mut offsets = vec![out.0.len()];
        if self.has_masks() {
            out.word(self.compression);
        }
        out.word(1);
        ["class", "string"].into_iter().for_each(|text| out.text(text));
        out.text("fog volume");
        out.text("ScaleTranslateMap");
        out.reals(&[1.0, 2.0, 3.0, 0.5, 0.25, 2.0]);
        out.reals(&[1.0; 12]);
        out.word(1);
        out.put(BACKGROUND.to_le_bytes());
        [0, BRICKS.len() as u32].into_iter().for_each(|word| out.word(word));
        for brick in BRICKS {
            let root = brick.map(|c| c.div_euclid(4096) * 4096);
            root.into_iter().for_each(|c| out.put(c.to_le_bytes()));
            let inside = |side: i32, of: i32| brick.map(|c| (c.rem_euclid(side) / of) as usize);
            let [x, y, z] = inside(4096, 128);
            let outer = x << 10 | y << 5 | z;
            let [x, y, z] = inside(128, 8);
            let inner = x << 8 | y << 4 | z;
            let tile = 1;
            out.put(mask(1 << 15, |n| n == outer));
            out.put(mask(1 << 15, |_| false));
            self.values(&mut out, 1 << 15, |_| false, |n| n == outer);
            out.put(mask(1 << 12, |n| n == inner));
            out.put(mask(1 << 12, |n| n == tile));
            self.values(&mut out, 1 << 12, |n| n == tile, |n| n == inner);
            out.put(mask(512, is_active));
        }
        offsets.push(out.0.len());
        for brick in BRICKS {
            out.put(mask(512, is_active));
            if !self.has_masks() {
                brick.into_iter().for_each(|c| out.put(c.to_le_bytes()));
                out.put([1]);
            }
            self.values(&mut out, 512, is_active, |_| false);
        }
        offsets.push(out.0.len());
        for (i, offset) in offsets.iter().enumerate() {
            out.0[at + 8 * i..at + 8 * i + 8].copy_from_slice(&(*offset as u64).to_le_bytes());
        }
        out.0
    }
}

fn mask(count: usize, is_on: impl Fn(usize) -> bool) -> Vec<u8> {
    (0..count / 8).map(|byte| (0..8).map(|bit| u8::from(is_on(8 * byte + bit)) << bit).sum()).collect()
}

/// All grids of a file, read to the last voxel: how many values they have, and their sum.
fn read_all(file: Vec<u8>) -> Result<Vec<(usize, f64)>, ReadError> {
    let mut vdb = Vdb::of(Path::new("a.vdb"), Cursor::new(file))?;
    let mut found = Vec::new();
    for entry in vdb.grids().to_vec() {
        let block = vdb.load(&entry, true)?;
        let (mut count, mut sum) = (0, 0.0);
        block.grid()?.tree.each(|brick| {
            count += brick.values.len();
            sum += brick.values.iter().map(|value| f64::from(*value)).sum::<f64>();
        })?;
        found.push((count, sum));
    }
    Ok(found)
}

/// Every version, packing and kind of inactive values is read as it was written.
#[test]
fn values_are_those_that_were_written() {
    let packings = |version: u32| if version >= 222 { &[0, ZIP, MASKS, ZIP | MASKS][..] } else { &[0, ZIP] };
    let ways = (220..=224).flat_map(|version| packings(version).iter().map(move |packing| (version, *packing)));
    for (version, compression) in ways {
        for (kind, half) in (0..7).flat_map(|kind| [(kind, false), (kind, true)]) {
            let way = Way { version, compression, kind, half };
            let mut vdb = Vdb::of(Path::new("a.vdb"), Cursor::new(way.file())).unwrap();
            let entry = vdb.grids()[0].clone();
            let (name, is_half) = if half { ("half", true) } else { ("float", false) };
            assert_eq!((entry.title(), entry.type_name(), entry.is_half), ("density".into(), name.into(), is_half));
            let block = vdb.load(&entry, true).unwrap();
            let grid = block.grid().unwrap();
            assert_eq!(grid.place.class, "fog volume");
            assert_eq!(grid.place.map.world(glam::DVec3::new(2.0, 4.0, 1.0)), glam::DVec3::new(2.0, 3.0, 5.0));
            // Two bricks of 171 voxels each, and two tiles of 8^3.
            assert_eq!(grid.tree.active(), 2 * (171 + 512), "{way:?}");
            assert_eq!(grid.tree.bounds(), Some([[-4096, 0, 0], [7, 4095, 143]]), "{way:?}");
            let (mut bricks, mut tiles) = (Vec::new(), Vec::new());
            let read = grid.tree.each(|brick| match brick.is_uniform() {
                true if brick.is_active(0) => tiles.push((brick.begin, brick.values.to_vec())),
                true => assert!(way.inactive().contains(&brick.values[0]), "{way:?}"),
                false => bricks.push((brick.begin, brick.values.to_vec())),
            });
            read.unwrap();
            assert_eq!(tiles[0], (TILE, vec![active_value(1)]), "{way:?}");
            assert_eq!(bricks.iter().map(|(begin, _)| *begin).collect::<Vec<_>>(), BRICKS);
            for (_, values) in bricks {
                let expected: Vec<f32> = (0..512).map(|voxel| way.value(is_active(voxel), voxel)).collect();
                assert_eq!(values, expected, "{way:?}");
            }
        }
    }
    assert_eq!(place_in_brick([8, 16, -8], 0o123), [9, 18, -5]);
}

/// The library's own files: what it wrote is what it reads (tests of volumes compare the values).
#[test]
fn grids_are_found_by_name_and_number() {
    let open = |name: &str| Vdb::open(&fixture(name)).unwrap();
    let titles = |vdb: &Vdb| vdb.grids().iter().map(|grid| (grid.title(), grid.type_name())).collect::<Vec<_>>();
    let named = |names: &[(&str, &str)]| names.iter().map(|(a, b)| (a.to_string(), b.to_string())).collect::<Vec<_>>();
    assert_eq!(titles(&open("half")), named(&[("density", "half"), ("velocity", "vec3h"), ("flame", "half")]));
    let mut tiles = open("tiles");
    let second = tiles.find("density[1]").unwrap().clone();
    assert_eq!((second.name.as_str(), second.number, tiles.find("density").unwrap().number), ("density", 1, 0));
    assert!(tiles.find("density[2]").is_none() && tiles.find("nothing").is_none());
    let block = tiles.load(&second, true).unwrap();
    assert_eq!((block.grid().unwrap().tree.background()[0], block.grid().unwrap().tree.active()), (3.0, 64));
    // One that has another's tree is told by that.
    let [own, shared] = ["vel.x", "copy"].map(|name| tiles.find(name).unwrap().clone());
    let [own, shared] = [own, shared].map(|entry| tiles.load(&entry, true).unwrap());
    assert_eq!(shared.grid().unwrap().tree.active(), own.grid().unwrap().tree.active());
    // An empty grid is one.
    let mut half = open("half");
    let flame = half.find("flame").unwrap().clone();
    let block = half.load(&flame, true).unwrap();
    assert_eq!((block.grid().unwrap().tree.active(), block.grid().unwrap().tree.bounds()), (0, None));
}

pub(in crate::io) fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("tests/files/vdb/{name}.vdb"))
}

#[test]
fn what_is_no_such_file_is_said() {
    let good = Way { version: 224, compression: MASKS, kind: 0, half: false }.file();
    let with = |at: usize, bytes: &[u8]| {
        let mut file = good.clone();
        file[at..at + bytes.len()].copy_from_slice(bytes);
        read_all(file).unwrap_err().to_string()
    };
    let type_at = good.windows(4).position(|w| w == b"Tree").unwrap();
    let map_at = good.windows(5).position(|w| w == b"Scale").unwrap();
    let cases = [
        (read_all(b"PK\x03\x04 and more bytes".to_vec()).unwrap_err().to_string(), "is no OpenVDB file"),
        (with(8, &219_u32.to_le_bytes()), "file version 219; expected 220 to 224"),
        (with(20, &[0]), "byte 21: was written to a stream"),
        (with(type_at, b"Tree_bools"), "is of type Tree_bools_5_4_3"),
        (with(map_at, b"Nonli"), "`NonliTranslateMap`; expected an affine one"),
        (with(map_at + 17 + 24, &0.0_f64.to_le_bytes()), "finite axes that span space"),
        (read_all(good[..300].to_vec()).unwrap_err().to_string(), "it is cut off, or damaged"),
    ];
    for (found, expected) in cases {
        assert!(found.starts_with("a.vdb: ") && found.contains(expected), "{found}\n{expected}");
    }
}

/// Whatever bytes are missing or wrong, there is an error or other values, and no more memory than a file needs.
#[test]
fn damage_ends_in_an_error() {
    let zipped = Way { version: 222, compression: ZIP | MASKS, kind: 5, half: true }.file();
    let files = ["plain", "half", "maps", "tiles"].map(|name| std::fs::read(fixture(name)).unwrap());
    for (number, file) in (0..).zip(files.into_iter().chain([zipped])) {
        let whole = read_all(file.clone()).unwrap();
        for size in (0..file.len()).rev().step_by(file.len() / 60) {
            read_all(file[..size].to_vec()).unwrap_err();
        }
        let mut changed = 0;
        for i in 0..240 {
            let mut damaged = file.clone();
            let random = |k: u32, of: usize| crate::random::hash(number, i, k, 0) as usize % of;
            // Most are in headers, where they do most.
            let at = if i % 3 == 0 { random(0, file.len()) } else { random(0, 2000.min(file.len())) };
            match i % 4 {
                0 => damaged[at..(at + 4).min(file.len())].fill(0xFF),
                _ => damaged[at] ^= 1 << random(1, 8),
            }
            changed += usize::from(read_all(damaged).ok().as_ref() != Some(&whole));
        }
        assert!(changed > 20, "{changed} of 240 are told");
    }
}
