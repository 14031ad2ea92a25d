use std::fs;
use std::sync::Arc;

use super::*;
use crate::io::array::tests::{npy, write_archive};
use crate::io::tests::Folder;

fn f32s(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

/// Arrays of two valid particles.
fn arrays() -> Vec<(&'static str, Vec<u8>)> {
    vec![
        ("position", npy("'<f4'", false, "(2, 3)", &f32s(&[0.0, 1.0, 2.0, 3.0, 4.0, 5.0]))),
        ("temperature", npy("'<f4'", false, "(2,)", &f32s(&[900.0, 3000.0]))),
        ("id", npy("'<u4'", false, "(2,)", &[7, 0, 0, 0, 255, 255, 255, 255])),
    ]
}

fn read_arrays(arrays: &[(&str, Vec<u8>)]) -> Result<Particles, ReadError> {
    let folder = Folder::new();
    let path = folder.0.join("p.npz");
    write_archive(&path, arrays);
    read(&path)
}

/// The arrays with one replaced, or left out.
fn with(name: &'static str, bytes: Option<Vec<u8>>) -> Result<Particles, ReadError> {
    let mut arrays = arrays();
    arrays.retain(|(n, _)| *n != name);
    arrays.extend(bytes.map(|b| (name, b)));
    read_arrays(&arrays)
}

/// Writes so many particles, the last of that temperature.
fn write(path: &Path, count: usize, last: f32) {
    let mut temperature = vec![1000.0; count];
    temperature.iter_mut().last().into_iter().for_each(|t| *t = last);
    let positions = npy("'<f4'", false, &format!("({count}, 3)"), &f32s(&vec![0.5; 3 * count]));
    let temperatures = npy("'<f4'", false, &format!("({count},)"), &f32s(&temperature));
    write_archive(path, &[("position", positions), ("temperature", temperatures)]);
}

#[test]
fn particles_are_read_whatever_their_types() {
    let expected = Particles {
        position: vec![[0.0, 1.0, 2.0], [3.0, 4.0, 5.0]],
        temperature: vec![900.0, 3000.0],
        id: Some(vec![7, u32::MAX]),
        velocity: None,
    };
    assert_eq!(read_arrays(&arrays()).unwrap(), expected);
    assert_eq!(with("id", None).unwrap(), Particles { id: None, ..expected.clone() });
    let velocities = npy("'<f4'", false, "(2, 3)", &f32s(&[0.5, 0.0, -1.0, 2.0, 0.0, 3.0]));
    let velocity = Some(vec![[0.5, 0.0, -1.0], [2.0, 0.0, 3.0]]);
    assert_eq!(with("velocity", Some(velocities)).unwrap(), Particles { velocity, ..expected.clone() });
    for (shape, values) in [("(3, 2)", [0.0; 6]), ("(2, 3)", [0.0, 0.0, 0.0, 0.0, f32::NAN, 0.0])] {
        let message = with("velocity", Some(npy("'<f4'", false, shape, &f32s(&values)))).unwrap_err().to_string();
        assert!(message.contains("velocity"), "{message}");
    }
    // Fortran order: the coordinates of one axis are together.
    let doubles: Vec<u8> = [0.0f64, 3.0, 1.0, 4.0, 2.0, 5.0].iter().flat_map(|v| v.to_le_bytes()).collect();
    assert_eq!(with("position", Some(npy("'<f8'", true, "(2, 3)", &doubles))).unwrap(), expected);
    let halves: Vec<u8> = [0x6308u16, 0x69dc].iter().flat_map(|v| v.to_be_bytes()).collect();
    assert_eq!(with("temperature", Some(npy("'>f2'", false, "(2,)", &halves))).unwrap(), expected);
    let wide: Vec<u8> = [7i64, 4_294_967_295].iter().flat_map(|v| v.to_le_bytes()).collect();
    assert_eq!(with("id", Some(npy("'<i8'", false, "(2,)", &wide))).unwrap(), expected);
    let bytes = with("id", Some(npy("'|u1'", false, "(2,)", &[3, 200]))).unwrap();
    assert_eq!(bytes.id, Some(vec![3, 200]));
    let kelvin = [900i32, 3000].map(i32::to_le_bytes).concat();
    assert_eq!(with("temperature", Some(npy("'<i4'", false, "(2,)", &kelvin))).unwrap(), expected);
    let column = with("temperature", Some(npy("'<i4'", true, "(2, 1)", &kelvin))).unwrap();
    assert_eq!(column, expected);
    let column = with("id", Some(npy("'<u4'", false, "(2, 1)", &[7, 0, 0, 0, 255, 255, 255, 255]))).unwrap();
    assert_eq!(column, expected);
    let whole = with("position", Some(npy("'|u1'", false, "(2, 3)", &[0, 1, 2, 3, 4, 5]))).unwrap();
    assert_eq!(whole, expected);
}

#[test]
fn no_particles_are_particles() {
    let folder = Folder::new();
    let path = folder.0.join("p.npz");
    write(&path, 0, 0.0);
    assert_eq!(read(&path).unwrap(), Particles::default());
    let sequence = ParticleSequence::new("p.npz", &folder.0, (), false, 24.0).unwrap();
    assert_eq!(sequence.extent(1..=9).unwrap(), ParticleExtent { most: 0, hottest: 1.0 });
}

#[test]
fn every_fault_names_its_array_and_row() {
    let says = |name: &'static str, bytes: Option<Vec<u8>>, words: &[&str]| {
        let error = with(name, bytes).unwrap_err().to_string();
        assert!(words.iter().all(|w| error.contains(w)) && error.contains("p.npz"), "{error}");
    };
    let floats = |shape: &str, values: &[f32]| Some(npy("'<f4'", false, shape, &f32s(values)));
    says("position", None, &["array `position`: is missing", "[n, 3]"]);
    says("position", floats("(6,)", &[0.0; 6]), &["array `position`: has shape [6]", "[n, 3]"]);
    says("position", floats("(3, 2)", &[0.0; 6]), &["array `position`: has shape [3, 2]", "[n, 3]"]);
    says("position", floats("(3, 3)", &[0.0; 9]), &["array `temperature`: has shape [2]"]);
    says("position", Some(npy("'<f4'", false, "(268435457, 3)", &[0; 24])), &["too large", "268435456 particles"]);
    says("position", Some(npy("'<f4'", false, "(2, 3)", &[0; 20])), &["`position`", "20 bytes", "24 bytes"]);
    says("temperature", None, &["array `temperature`: is missing", "kelvin"]);
    says("temperature", floats("(1, 2)", &[1.0; 2]), &["`temperature`: has shape [1, 2]"]);
    says("temperature", floats("(2, 2)", &[1.0; 4]), &["`temperature`: has shape [2, 2]"]);
    says("id", floats("(2,)", &[1.0; 2]), &["array `id`: elements are floats", "integers"]);
    says("id", Some(npy("'<u4'", false, "(3,)", &[0; 12])), &["array `id`: has shape [3]"]);
    for bad in [0.0, -0.0, -1.0, f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 3e38, 1.1e6] {
        let needle = format!("`temperature`, row 1: is {bad} as f32");
        says(
            "temperature",
            floats("(2,)", &[900.0, bad]),
            &[&needle, "expected kelvin, above 0 and finite, at most 1e6"],
        );
    }
    let tiny: Vec<u8> = [1e-60f64, 1.0].iter().flat_map(|v| v.to_le_bytes()).collect();
    says("temperature", Some(npy("'<f8'", false, "(2,)", &tiny)), &["row 0: is 0 as f32"]);
    for bad in [f32::NAN, f32::INFINITY, 1.1e12] {
        let position = floats("(2, 3)", &[0.0, 0.0, 0.0, 1.0, bad, 1.0]);
        says("position", position, &["`position`, row 1: is [1.0, ", "three finite numbers"]);
    }
    let ids = |values: [i64; 2]| Some(npy("'<i8'", false, "(2,)", &values.map(i64::to_le_bytes).concat()));
    says("id", ids([0, -1]), &["`id`, row 1: is -1", "0 to 4294967295"]);
    says("id", ids([1 << 32, 0]), &["`id`, row 0: is 4294967296"]);
    says("id", Some(npy("'<u8'", false, "(2,)", &[255; 16])), &["`id`, row 0: is 18446744073709552000"]);
}

#[test]
fn files_that_are_no_particles_are_named() {
    let folder = Folder::new();
    for (name, needle) in [
        ("a.ply", "is no PLY file"),
        ("a.CSV", "no x, y and z"),
        ("a.txt", "not a file of particles by its name; expected a name that ends in .npz, .ply or .csv"),
        ("a.npz", "no zip archive"),
    ] {
        fs::write(folder.0.join(name), "x").unwrap();
        let mut sequence = ParticleSequence::new(name, &folder.0, (), false, 24.0).unwrap();
        for error in [sequence.frame(1).unwrap_err(), sequence.extent(1..=2).unwrap_err()] {
            let error = error.to_string();
            assert!(error.contains(name) && error.contains(needle), "{error}");
        }
    }
}

#[test]
fn sequences_follow_their_files_and_know_their_extent() {
    let folder = Folder::new();
    for (frame, count, last) in [(1, 3, 1200.0), (2, 5, 800.0), (4, 2, 2500.0)] {
        write(&folder.0.join(format!("p.{frame:04}.npz")), count, last);
    }
    let open = |name: &str, hold| ParticleSequence::new(name, &folder.0, (), hold, 24.0).unwrap();
    let mut hold = open("p.####.npz", true);
    assert_eq!(hold.extent(1..=3).unwrap(), ParticleExtent { most: 5, hottest: 1200.0 });
    assert_eq!(hold.extent(1..=9).unwrap(), ParticleExtent { most: 5, hottest: 2500.0 });
    assert!(Arc::ptr_eq(&hold.frame(2).unwrap(), &hold.frame(3).unwrap()));
    let mut is_same = |f| Arc::ptr_eq(&hold.frame(f - 1).unwrap(), &hold.frame(f).unwrap());
    assert_eq!([2, 3, 4, 5].map(&mut is_same), [false, true, false, true]);
    let strict = open("p.%04d.npz", false);
    let error = strict.extent(1..=4).unwrap_err().to_string();
    assert!(error.contains("p.0003.npz: no such file; expected particles for frame 3"), "{error}");
    // One in the middle that cannot be used is found before the first frame.
    write(&folder.0.join("p.0003.npz"), 4, f32::NAN);
    let error = strict.extent(1..=4).unwrap_err().to_string();
    assert!(error.contains("p.0003.npz: `temperature`, row 3: is NaN"), "{error}");
    let mut single = open("p.0001.npz", false);
    assert!(Arc::ptr_eq(&single.frame(1).unwrap(), &single.frame(7).unwrap()));
}

#[test]
fn built_in_sequences() {
    let open = |name: &str| ParticleSequence::new(name, Path::new(""), (), false, 24.0);
    let mut random = open("builtin:random").unwrap();
    assert_eq!(*random.frame(7).unwrap(), flame::Builtin::Random.particles(7, 24.0));
    assert!(!Arc::ptr_eq(&random.frame(6).unwrap(), &random.frame(7).unwrap()));
    assert_eq!(random.extent(1..=1_000_000).unwrap(), flame::Builtin::Random.extent());
    let error = open("builtin:sph").unwrap_err().to_string();
    assert!(error.contains("builtin:sph: ") && error.contains("not built yet"), "{error}");
    let error = open("builtin:rand").unwrap_err().to_string();
    assert!(error.contains("builtin:rand: ") && error.contains("builtin:random"), "{error}");
}

/// The extent of text is that of the particles that it has.
#[test]
fn tables_are_sequences_too() {
    let folder = Folder::new();
    for (frame, temperature) in [(1, 900), (2, 1500)] {
        let rows = format!("0;0;0;{temperature}\n").repeat(frame);
        fs::write(folder.0.join(format!("p.{frame:04}.csv")), format!("x;y;z;temperature\n{rows}")).unwrap();
    }
    let mut tables = ParticleSequence::new("p.####.csv", &folder.0, (), false, 24.0).unwrap();
    assert_eq!(tables.extent(1..=2).unwrap(), ParticleExtent { most: 2, hottest: 1500.0 });
    assert_eq!(tables.frame(2).unwrap().position.len(), 2);
}
