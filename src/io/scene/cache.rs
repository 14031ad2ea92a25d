//! Caches of vertices: `.npz` files with a position per frame and vertex.

use std::collections::HashSet;
use std::path::Path;

use super::MAX_VERTICES;
use super::weld::Welder;
use crate::data::Topology;
use crate::io::ReadError;
use crate::io::array::{Archive, Array, Header, Kind, in_c_order};
use crate::view::{BRIGHTEST, FARTHEST};

/// Most coordinates of a cache: 8 GiB of them.
const MAX_VALUES: u64 = 1 << 31;
/// Most triangles: twice as many as vertices, which is what closed surfaces have.
const MAX_TRIANGLES: u64 = 2 * MAX_VERTICES as u64;

const POSITIONS: &str = "[frames, vertices, 3] of numbers, in metres";
const TRIANGLES: &str = "[m, 3] of integers, rows of `position`";
const COLOURS: &str = "[vertices, 3] of floats, linear RGB, 0 to 1e6";
const SHARES: &str = "[vertices] of floats, share of strength, 0 to 1";
const OBJECTS: &str = "[vertices] of integers, 0 to 4294967295";

/// Positions of every frame.
#[derive(Clone, Debug)]
pub(super) struct Cache {
    vertices: usize,
    /// Frame by frame; at least one.
    positions: Vec<[f32; 3]>,
}

impl Cache {
    pub(super) fn frames(&self) -> u32 {
        (self.positions.len() / self.vertices) as u32
    }

    fn frame(&self, frame: usize) -> &[[f32; 3]] {
        &self.positions[frame * self.vertices..][..self.vertices]
    }

    /// Takes vertices apart that are not at one place in all of the file's frames, whatever a shot shows of them.
    pub(super) fn weld(&self, welder: &mut Welder) {
        self.positions.chunks_exact(self.vertices).for_each(|positions| welder.refine(positions));
    }

    /// Positions at a frame from 0 on: those of the file at a whole number, linear between, constant outside.
    pub(super) fn positions(&self, frame: f64, out: &mut [[f32; 3]]) {
        let last = self.frames() as usize - 1;
        let frame = frame.clamp(0.0, last as f64);
        let (before, share) = (frame.floor() as usize, frame.fract());
        let (a, b) = (self.frame(before), self.frame((before + 1).min(last)));
        for ((out, a), b) in out.iter_mut().zip(a).zip(b) {
            let between = |i: usize| f64::from(a[i]) + share * (f64::from(b[i]) - f64::from(a[i]));
            *out = if share == 0.0 { *a } else { std::array::from_fn(|i| between(i) as f32) };
        }
    }
}

/// Frames and vertices, from the header of `position`; at least one of each.
pub(super) fn extent(archive: &mut Archive) -> Result<[u64; 2], ReadError> {
    let shape = archive.shape("position", 3, Kind::Any, POSITIONS)?;
    let shape = shape.ok_or_else(|| archive.missing("position", POSITIONS))?;
    let [frames, vertices, 3] = shape[..] else { return Err(archive.wrong_shape("position", &shape, POSITIONS)) };
    if frames == 0 || vertices == 0 {
        return Err(archive.wrong_shape("position", &shape, "at least one frame and one vertex"));
    }
    let total = frames.checked_mul(vertices).and_then(|n| n.checked_mul(3)).filter(|&n| n <= MAX_VALUES);
    if total.is_none() || vertices > MAX_VERTICES as u64 {
        let why = format!("of shape {shape:?} is too large");
        return Err(archive.fault("position", why, format!("{MAX_VERTICES} vertices and {MAX_VALUES} values at most")));
    }
    Ok([frames, vertices])
}

/// Reads a cache and what does not change in it.
pub(super) fn read(path: &Path) -> Result<(Cache, Topology), ReadError> {
    let mut archive = Archive::open(path)?;
    let [_, vertices] = extent(&mut archive)?;
    let triangles = triangles(&mut archive, path, vertices)?;
    let (object, objects) = objects(&mut archive, path, vertices)?;
    let vertices = vertices as usize;
    let colour = colours(&mut archive, path, vertices)?;
    let is_mixed = |corners: &[u32; 3]| corners.iter().any(|c| object[*c as usize] != object[corners[0] as usize]);
    if let Some(row) = triangles.iter().position(is_mixed) {
        let names = triangles[row].map(|corner| &objects[object[corner as usize] as usize][..]).join(", ");
        let place = format!("array `triangle`, row {row}");
        return Err(ReadError::at(path, place, format!("has vertices of objects {names}"), "vertices of one object"));
    }
    let positions = archive.read("position", MAX_VALUES)?.map(|array: Array<f32>| array.values).unwrap_or_default();
    let positions = positions.as_chunks().0.to_vec();
    if let Some(at) = positions.iter().position(|p: &[f32; 3]| !p.iter().all(|x| x.abs() <= FARTHEST)) {
        let place = format!("array `position`, frame {}, vertex {}", at / vertices, at % vertices);
        let expected = "three finite numbers, none beyond 1e12 m";
        return Err(ReadError::at(path, place, format!("is {:?} as f32", positions[at]), expected));
    }
    let normal = vec![[0.0; 3]; vertices];
    let double_sided = vec![false; objects.len()];
    let share = shares(&mut archive, path, vertices)?;
    let (material, materials, coordinates) = (vec![0; vertices], vec![String::new()], vec![[0.0; 2]; vertices]);
    let topology = Topology {
        triangles,
        object,
        objects,
        colour,
        share,
        material,
        materials,
        coordinates,
        has_coordinates: false,
        textures: Vec::new(),
        texture: vec![None; vertices],
        texture_place: vec![[0.0; 2]; vertices],
        normal,
        double_sided,
        faceted: false,
    };
    Ok((Cache { vertices, positions }, topology))
}

/// How much a cache holds: vertices, triangles and objects. Nothing of it is kept.
pub(super) fn count(path: &Path) -> Result<[usize; 3], ReadError> {
    let mut archive = Archive::open(path)?;
    let [_, vertices] = extent(&mut archive)?;
    let mut corners = 0;
    each_whole(&mut archive, path, &corners_of(vertices), |_| corners += 1)?
        .ok_or_else(|| archive.missing("triangle", TRIANGLES))?;
    let mut objects = HashSet::from([0]);
    let object = objects_of(vertices);
    if archive.header(object.name)?.is_some() {
        objects.clear();
        each_whole(&mut archive, path, &object, |number| {
            objects.insert(number);
        })?;
    }
    Ok([vertices as usize, corners / 3, objects.len()])
}

/// An array of whole numbers.
struct Whole {
    name: &'static str,
    /// Its shape, in which 0 is any.
    shape: Vec<u64>,
    /// The largest that is allowed.
    most: u32,
    expected: &'static str,
}

fn corners_of(vertices: u64) -> Whole {
    // No more than MAX_VERTICES, and at least one.
    Whole { name: "triangle", shape: vec![0, 3], most: vertices as u32 - 1, expected: TRIANGLES }
}

fn objects_of(vertices: u64) -> Whole {
    Whole { name: "object", shape: vec![vertices], most: u32::MAX, expected: OBJECTS }
}

/// Hands over the numbers in the order of the file; the array's header, or none if there is no such array.
fn each_whole(
    archive: &mut Archive,
    path: &Path,
    Whole { name, shape, most, expected }: &Whole,
    mut take: impl FnMut(u32),
) -> Result<Option<Header>, ReadError> {
    let fits = |found: &[u64]| found.len() == shape.len() && found.iter().zip(shape).all(|(f, s)| *s == 0 || f == s);
    match archive.shape(name, shape.len(), Kind::Whole, expected)? {
        Some(found) if !fits(&found) => return Err(archive.wrong_shape(name, &found, expected)),
        Some(found) if found[0] > MAX_TRIANGLES => {
            let why = format!("of shape {found:?} is too large");
            return Err(archive.fault(name, why, format!("{MAX_TRIANGLES} rows at most")));
        }
        _ => {}
    }
    let (mut at, mut wrong) = (0, None);
    let header = archive.each(name, |value: f64| {
        // Every integer up to 2^53 is exact as f64, and none above it becomes one that is allowed.
        match (0.0..=f64::from(*most)).contains(&value) {
            true => take(value as u32),
            false => wrong = wrong.or(Some((at, value))),
        }
        at += 1;
    })?;
    match (&header, wrong) {
        (Some(Header { shape, fortran_order, .. }), Some((at, value))) => {
            let columns = shape.get(1).map_or(1, |&columns| columns.max(1));
            let row = if *fortran_order { at % shape[0].max(1) } else { at / columns };
            let place = format!("array `{name}`, row {row}");
            Err(ReadError::at(path, place, format!("has {value}"), format!("0 to {most}")))
        }
        _ => Ok(header),
    }
}

/// The numbers, rows one after the other; none if there is no such array.
fn whole(archive: &mut Archive, path: &Path, array: &Whole) -> Result<Option<Vec<u32>>, ReadError> {
    let mut values = Vec::new();
    let header = each_whole(archive, path, array, |value| values.push(value))?;
    let ordered = |Header { shape, fortran_order, .. }| in_c_order(Array { shape, values }, fortran_order).values;
    Ok(header.map(ordered))
}

fn triangles(archive: &mut Archive, path: &Path, vertices: u64) -> Result<Vec<[u32; 3]>, ReadError> {
    let corners = whole(archive, path, &corners_of(vertices))?;
    let corners = corners.ok_or_else(|| archive.missing("triangle", TRIANGLES))?;
    match corners.is_empty() {
        true => Err(archive.fault("triangle", "is empty", "at least one triangle")),
        false => Ok(corners.as_chunks().0.to_vec()),
    }
}

/// The given colours, or white.
fn colours(archive: &mut Archive, path: &Path, vertices: usize) -> Result<Vec<[f32; 3]>, ReadError> {
    match archive.shape("colour", 2, Kind::Float, COLOURS)? {
        None => return Ok(vec![[1.0; 3]; vertices]),
        Some(shape) if shape != [vertices as u64, 3] => return Err(archive.wrong_shape("colour", &shape, COLOURS)),
        Some(_) => {}
    }
    let values = archive.read("colour", MAX_VALUES)?.map(|array: Array<f32>| array.values).unwrap_or_default();
    let colours = values.as_chunks().0.to_vec();
    match colours.iter().position(|c: &[f32; 3]| !c.iter().all(|x| (0.0..=BRIGHTEST).contains(x))) {
        None => Ok(colours),
        Some(row) => {
            let place = format!("array `colour`, row {row}");
            let expected = "three finite numbers, 0 to 1e6";
            Err(ReadError::at(path, place, format!("is {:?} as f32", colours[row]), expected))
        }
    }
}

fn shares(archive: &mut Archive, path: &Path, vertices: usize) -> Result<Vec<f32>, ReadError> {
    match archive.shape("smear", 1, Kind::Float, SHARES)? {
        None => return Ok(vec![1.0; vertices]),
        Some(shape) if shape != [vertices as u64] => return Err(archive.wrong_shape("smear", &shape, SHARES)),
        Some(_) => {}
    }
    let shares = archive.read("smear", MAX_VALUES)?.map(|array: Array<f32>| array.values).unwrap_or_default();
    match shares.iter().position(|share| !(0.0..=1.0).contains(share)) {
        None => Ok(shares),
        Some(row) => {
            let place = format!("array `smear`, row {row}");
            Err(ReadError::at(path, place, format!("is {} as f32", shares[row]), "a share of strength, 0 to 1"))
        }
    }
}

/// Number of each vertex's object, and the objects' names: the numbers of the file, ascending.
fn objects(archive: &mut Archive, path: &Path, vertices: u64) -> Result<(Vec<u32>, Vec<String>), ReadError> {
    let Some(given) = whole(archive, path, &objects_of(vertices))? else {
        return Ok((vec![0; vertices as usize], vec!["0".to_owned()]));
    };
    let mut numbers = given.clone();
    numbers.sort_unstable();
    numbers.dedup();
    // Each of them is among the numbers.
    let object = given.iter().map(|number| numbers.partition_point(|n| n < number) as u32).collect();
    Ok((object, numbers.iter().map(u32::to_string).collect()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::array::tests::{npy, write_archive};
    use crate::io::scene::{AnimatedMesh, Choice, Clock, Pick};
    use crate::io::tests::Folder;

    fn f32s(values: &[f32]) -> Vec<u8> {
        values.iter().flat_map(|v| v.to_le_bytes()).collect()
    }

    /// Two frames of four vertices, numbered.
    fn arrays() -> Vec<(&'static str, Vec<u8>)> {
        let positions: Vec<f32> = (0..24).map(|i| i as f32).collect();
        vec![
            ("position", npy("'<f4'", false, "(2, 4, 3)", &f32s(&positions))),
            ("triangle", npy("'|u1'", false, "(2, 3)", &[0, 1, 2, 2, 1, 0])),
            ("colour", npy("'<f4'", false, "(4, 3)", &f32s(&[0.5; 12]))),
            ("object", npy("'|u1'", false, "(4,)", &[7, 7, 7, 2])),
        ]
    }

    /// Reads the arrays with one replaced, or left out.
    fn with(name: &'static str, bytes: Option<Vec<u8>>) -> Result<AnimatedMesh, ReadError> {
        let mut arrays = arrays();
        arrays.retain(|(n, _)| *n != name);
        arrays.extend(bytes.map(|b| (name, b)));
        let folder = Folder::new();
        let path = folder.0.join("cache.npz");
        write_archive(&path, &arrays);
        AnimatedMesh::read(&path, &Choice::default(), Clock { first: 5, fps: 24.0 })
    }

    #[test]
    fn caches_are_read_whatever_their_types() {
        let mesh = with("none", None).unwrap();
        let topology = mesh.topology();
        assert_eq!((mesh.vertices(), mesh.frames()), (4, Some(2)));
        assert_eq!(topology.triangles, [[0, 1, 2], [2, 1, 0]]);
        assert_eq!((&topology.object[..], &topology.objects[..]), (&[1, 1, 1, 0][..], &["2".into(), "7".into()][..]));
        assert_eq!((topology.colour[3], topology.normal[3]), ([0.5; 3], [0.0; 3]));
        let plain = with("object", None).unwrap();
        assert_eq!((&plain.topology().object[..], plain.topology().objects.len()), (&[0; 4][..], 1));
        assert_eq!(with("colour", None).unwrap().topology().colour, [[1.0; 3]; 4]);
        let wide: Vec<u8> = [0i64, 1, 2, 2, 1, 0].iter().flat_map(|v| v.to_le_bytes()).collect();
        let wide = with("triangle", Some(npy("'<i8'", false, "(2, 3)", &wide))).unwrap();
        assert_eq!(wide.topology().triangles, topology.triangles);
        // Fortran order: frames run fastest, then vertices, then axes.
        let fortran: Vec<u8> =
            (0..24).map(|i| f64::from((i % 2) * 12 + (i / 2 % 4) * 3 + i / 8)).flat_map(f64::to_le_bytes).collect();
        let fortran = with("position", Some(npy("'<f8'", true, "(2, 4, 3)", &fortran))).unwrap();
        assert_eq!(fortran.pose(6.0).unwrap(), mesh.pose(6.0).unwrap());
        let halves = with("position", Some(npy("'<f2'", false, "(1, 4, 3)", &[0x00, 0x3c].repeat(12)))).unwrap();
        assert_eq!(halves.pose(5.0).unwrap(), [[1.0; 3]; 4]);
        let whole = with("position", Some(npy("'|u1'", false, "(1, 4, 3)", &[1; 12]))).unwrap();
        assert_eq!(whole.pose(5.0).unwrap(), [[1.0; 3]; 4]);
        let column = with("object", Some(npy("'|u1'", false, "(4, 1)", &[7, 7, 7, 2]))).unwrap();
        assert_eq!(column.topology().object, topology.object);
        let fortran = with("triangle", Some(npy("'|u1'", true, "(2, 3)", &[0, 2, 1, 1, 2, 0]))).unwrap();
        assert_eq!(fortran.topology().triangles, topology.triangles);
    }

    #[test]
    fn a_cache_is_counted_as_it_is_read() {
        let folder = Folder::new();
        let path = folder.0.join("cache.npz");
        write_archive(&path, &arrays());
        assert_eq!(count(&path).unwrap(), [4, 2, 2]);
        write_archive(&path, &arrays()[..3]);
        assert_eq!(count(&path).unwrap(), [4, 2, 1]);
        write_archive(&path, &arrays()[..1]);
        assert!(count(&path).unwrap_err().to_string().contains("array `triangle`: is missing"));
    }

    #[test]
    fn caches_hold_at_their_ends_and_are_linear_between_frames() {
        let mesh = with("none", None).unwrap();
        let first = |frame: f64| mesh.pose(frame).unwrap()[0];
        assert_eq!([5.0, 4.0, -1e9].map(first), [[0.0, 1.0, 2.0]; 3]);
        assert_eq!([6.0, 7.0, 1e9].map(first), [[12.0, 13.0, 14.0]; 3]);
        assert_eq!(first(5.25), [3.0, 4.0, 5.0]);
        assert_eq!(mesh.camera(5.0), None);
    }

    #[test]
    fn every_fault_names_its_array_and_row() {
        let says = |name: &'static str, bytes: Option<Vec<u8>>, words: &[&str]| {
            let error = with(name, bytes).unwrap_err().to_string();
            assert!(words.iter().all(|w| error.contains(w)) && error.contains("cache.npz"), "{error}");
        };
        let floats = |shape: &str, values: &[f32]| Some(npy("'<f4'", false, shape, &f32s(values)));
        let bytes = |shape: &str, values: &[u8]| Some(npy("'|u1'", false, shape, values));
        says("position", None, &["array `position`: is missing", "[frames, vertices, 3]"]);
        says("position", floats("(4, 3)", &[0.0; 12]), &["array `position`: has shape [4, 3]"]);
        says("position", floats("(0, 4, 3)", &[]), &["`position`: has shape [0, 4, 3]", "at least one frame"]);
        says("colour", bytes("(4, 3)", &[0; 12]), &["array `colour`: elements are integers", "of floats"]);
        says("position", floats("(999999999, 4, 3)", &[0.0; 12]), &["too large", "at most"]);
        says("position", floats("(2, 4, 3)", &[0.0; 23]), &["`position`", "92 bytes", "96 bytes"]);
        for bad in [f32::NAN, f32::INFINITY, 1.1e12, -1.1e12] {
            let mut positions = [0.0; 24];
            positions[3 * 6 + 1] = bad;
            let place = format!("array `position`, frame 1, vertex 2: is [0.0, {bad:?}, 0.0]");
            says("position", floats("(2, 4, 3)", &positions), &[&place, "three finite numbers"]);
        }
        let huge: Vec<u8> = [1e300f64; 12].iter().flat_map(|v| v.to_le_bytes()).collect();
        says("position", Some(npy("'<f8'", false, "(1, 4, 3)", &huge)), &["frame 0, vertex 0: is [inf"]);
        says("triangle", None, &["array `triangle`: is missing", "[m, 3]"]);
        says("triangle", floats("(1, 3)", &[0.0; 3]), &["array `triangle`: elements are floats"]);
        says("triangle", bytes("(3, 2)", &[0; 6]), &["array `triangle`: has shape [3, 2]"]);
        says("triangle", bytes("(0, 3)", &[]), &["array `triangle`: is empty"]);
        says("triangle", bytes("(999999999, 3)", &[]), &["array `triangle`: of shape", "too large", "134217728 rows"]);
        // Columns are together in Fortran order: (0, 1, 2), then (2, 9, 0).
        let fortran = Some(npy("'|u1'", true, "(2, 3)", &[0, 2, 1, 9, 2, 0]));
        says("triangle", fortran, &["array `triangle`, row 1: has 9"]);
        says("triangle", bytes("(2, 3)", &[0, 1, 2, 0, 4, 1]), &["array `triangle`, row 1: has 4; expected 0 to 3"]);
        let negative = [0i8, 1, -2].map(|v| v as u8);
        says("triangle", Some(npy("'|i1'", false, "(1, 3)", &negative)), &["`triangle`, row 0: has -2"]);
        let mixed = ["array `triangle`, row 1: has vertices of objects 7, 2, 7", "of one object"];
        says("triangle", bytes("(2, 3)", &[0, 1, 2, 0, 3, 1]), &mixed);
        says("colour", floats("(3, 3)", &[0.0; 9]), &["array `colour`: has shape [3, 3]"]);
        let mut colours = [0.0; 12];
        colours[7] = -0.5;
        says("colour", floats("(4, 3)", &colours), &["array `colour`, row 2: is [0.0, -0.5, 0.0]"]);
        for bad in [f32::NAN, f32::INFINITY, 1e38, 1.1e6] {
            colours[7] = bad;
            says("colour", floats("(4, 3)", &colours), &["array `colour`, row 2: is [0.0, ", "0 to 1e6"]);
        }
        says("object", bytes("(3,)", &[0; 3]), &["array `object`: has shape [3]"]);
        let folder = Folder::new();
        let path = folder.0.join("cache.npz");
        let walk = Choice { animations: vec![Pick::Name("Walk".into())], ..Choice::default() };
        let error = AnimatedMesh::read(&path, &walk, Clock { first: 0, fps: 1.0 }).unwrap_err();
        assert!(error.to_string().contains("no animations by name"), "{error}");
    }
}
