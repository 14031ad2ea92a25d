use super::*;
use crate::io::array::tests::{npy, write_archive};
use crate::io::tests::Folder;
use std::fs;
use std::sync::Arc;

/// 2 x 3 x 4 voxels of numbers that tell where they are; NaN and the largest among them.
fn numbered(velocity: bool) -> Volume {
    let mut density: Vec<f32> = (0..24).map(|i| i as f32 * 0.1).collect();
    density[3..6].copy_from_slice(&[f32::NAN, f32::MAX, f32::MIN]);
    Volume {
        dimensions: [2, 3, 4],
        voxel_size: [0.1, 0.2, 0.25],
        origin: [-1.0, 0.0, 2.5],
        density,
        velocity: velocity.then(|| (0..24).map(|i| [i as f32, -0.5, 1e-30 * i as f32]).collect()),
    }
}

fn bits(volume: &Volume) -> (Vec<u32>, Option<Vec<u32>>) {
    let bits = |values: &[f32]| values.iter().map(|v| v.to_bits()).collect();
    (bits(&volume.density), volume.velocity.as_ref().map(|v| bits(v.as_flattened())))
}

fn f32s(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

/// Arrays of a valid volume of 1 x 2 x 2 voxels.
fn arrays() -> Vec<(&'static str, Vec<u8>)> {
    vec![
        ("density", npy("'<f4'", false, "(2, 2, 1)", &f32s(&[0.0, 1.0, 2.0, 3.0]))),
        ("velocity", npy("'<f4'", false, "(2, 2, 1, 3)", &f32s(&[1.0; 12]))),
        ("voxel_size", npy("'<f8'", false, "()", &0.5f64.to_le_bytes())),
        ("origin", npy("'<i4'", false, "(3,)", &[1, 0, 0, 0, 2, 0, 0, 0, 3, 0, 0, 0])),
    ]
}

fn read_arrays(arrays: &[(&str, Vec<u8>)]) -> Result<Volume, ReadError> {
    let folder = Folder::new();
    let path = folder.0.join("v.npz");
    write_archive(&path, arrays);
    read(&path, &Grids::default())
}

/// The error with one array replaced, or left out.
fn error_with(name: &'static str, bytes: Option<Vec<u8>>) -> String {
    let mut arrays = arrays();
    arrays.retain(|(n, _)| *n != name);
    arrays.extend(bytes.map(|b| (name, b)));
    read_arrays(&arrays).unwrap_err().to_string()
}

#[test]
fn written_volumes_come_back() {
    let folder = Folder::new();
    for velocity in [false, true] {
        let path = folder.0.join("out/v.NPZ");
        let volume = numbered(velocity);
        write_npz(&path, &volume).unwrap();
        let back = read(&path, &Grids::default()).unwrap();
        assert_eq!(bits(&back), bits(&volume));
        assert_eq!(
            (back.dimensions, back.voxel_size, back.origin),
            (volume.dimensions, volume.voxel_size, volume.origin)
        );
    }
    let short = Volume { density: vec![0.0; 3], ..numbered(false) };
    assert!(write_npz(&folder.0.join("short.npz"), &short).is_err());
    assert_eq!(folder.names(), ["out"]);
}

#[test]
fn half_double_and_fortran_order_are_read() {
    let volume = read_arrays(&arrays()).unwrap();
    assert_eq!((volume.dimensions, volume.voxel_size), ([1, 2, 2], [0.5; 3]));
    assert_eq!(volume.origin, [1.0, 2.0, 3.0]);
    let halves: Vec<u8> = [0u16, 0x3c00, 0x4000, 0x4200].iter().flat_map(|v| v.to_be_bytes()).collect();
    // Fortran order: z runs fastest, so the four values are transposed.
    let doubles: Vec<u8> = [0.0f64, 2.0, 1.0, 3.0].iter().flat_map(|v| v.to_le_bytes()).collect();
    let components: Vec<f32> = (0..12).map(|i| i as f32).collect();
    let velocity = npy("'<f4'", true, "(2, 2, 1, 3)", &f32s(&components));
    for density in [npy("'>f2'", false, "(2, 2, 1)", &halves), npy("'<f8'", true, "(2, 2, 1)", &doubles)] {
        let mut arrays = arrays();
        (arrays[0].1, arrays[1].1) = (density, velocity.clone());
        let read = read_arrays(&arrays).unwrap();
        assert_eq!(read.density, volume.density);
        // Index z + 2 y + 4 component in the file; x fastest, then y, then z in memory.
        let expected = [[0.0, 4.0, 8.0], [2.0, 6.0, 10.0], [1.0, 5.0, 9.0], [3.0, 7.0, 11.0]];
        assert_eq!(read.velocity.unwrap(), expected);
    }
}

#[test]
fn integers_and_axes_of_one_are_read() {
    let volume = read_arrays(&arrays()).unwrap();
    let [size, origin] = [[0.5f32; 3], [1.0, 2.0, 3.0]];
    let changed = [
        ("density", npy("'|u1'", false, "(2, 2, 1)", &[0, 1, 2, 3])),
        ("density", npy("'<f4'", false, "(2, 2, 1, 1)", &f32s(&volume.density))),
        ("velocity", npy("'|i1'", false, "(2, 2, 1, 3)", &[1; 12])),
        ("voxel_size", npy("'<f4'", false, "(1, 1)", &f32s(&size[..1]))),
        ("voxel_size", npy("'<f4'", false, "(1, 3)", &f32s(&size))),
        ("origin", npy("'<f4'", true, "(3, 1)", &f32s(&origin))),
    ];
    for (name, bytes) in changed {
        let mut arrays = arrays();
        arrays.retain(|(n, _)| *n != name);
        arrays.push((name, bytes));
        assert_eq!(read_arrays(&arrays).unwrap(), volume, "{name}");
    }
}

#[test]
fn optional_arrays_and_other_names() {
    let mut arrays = arrays();
    arrays.remove(3);
    arrays.remove(1);
    let volume = read_arrays(&arrays).unwrap();
    assert_eq!((volume.velocity, volume.origin), (None, [0.0; 3]));
    arrays.push(("vel", npy("'<f4'", false, "(2, 2, 1, 3)", &f32s(&[2.0; 12]))));
    let folder = Folder::new();
    let path = folder.0.join("v.npz");
    write_archive(&path, &arrays);
    let grids = Grids { velocity: Some("vel".into()), ..Grids::default() };
    assert_eq!(read(&path, &grids).unwrap().velocity, Some(vec![[2.0; 3]; 4]));
    let grids = Grids { velocity: Some("wind".into()), ..Grids::default() };
    // It may be there in other frames.
    assert_eq!(read(&path, &grids).unwrap().velocity, None);
    let sequence = VolumeSequence::new("v.npz", &folder.0, grids, false, 24.0).unwrap();
    let error = sequence.extent([1], []).unwrap_err().to_string();
    assert!(error.contains("v.npz: no frame has a velocity `wind`"), "{error}");
    let grids = Grids { density: Some("fuel".into()), ..Grids::default() };
    assert!(read(&path, &grids).unwrap_err().to_string().contains("array `fuel`: is missing"));
}

#[test]
fn every_fault_names_its_array() {
    let says = |error: String, words: &[&str]| {
        assert!(words.iter().all(|w| error.contains(w)) && error.contains("v.npz"), "{error}");
    };
    says(error_with("density", None), &["array `density`: is missing", "[nz, ny, nx]"]);
    says(error_with("density", Some(npy("'<f4'", false, "(4,)", &[0; 16]))), &["`density`", "[4]", "three axes"]);
    says(error_with("density", Some(npy("'|O'", false, "(2, 2, 1)", &[0; 16]))), &["`|O`", "f16, f32 or f64"]);
    let huge = npy("'<f4'", false, "(1024, 1024, 1025)", &[0; 16]);
    says(error_with("density", Some(huge)), &["too large", "1073741824 values at most"]);
    let promised = npy("'<f4'", false, "(1024, 1024, 1024)", &[0; 16]);
    says(error_with("density", Some(promised)), &["16 bytes", "4294967296 bytes"]);
    let other = npy("'<f4'", false, "(2, 2, 3)", &[0; 48]);
    says(error_with("velocity", Some(other)), &["array `velocity`", "[2, 2, 3]", "[2, 2, 1, 3]"]);
    // The fourth voxel is the second along y and along z.
    for bad in [f32::INFINITY, f32::NEG_INFINITY] {
        let density = npy("'<f4'", false, "(2, 2, 1)", &f32s(&[0.0, f32::NAN, 1.0, bad]));
        says(
            error_with("density", Some(density)),
            &["array `density`, voxel (0, 1, 1): is", "inf", "a finite density"],
        );
    }
    for bad in [f32::INFINITY, -1.1e6] {
        let mut components = [f32::NAN; 12];
        components[10] = bad;
        let velocity = npy("'<f4'", false, "(2, 2, 1, 3)", &f32s(&components));
        says(error_with("velocity", Some(velocity)), &["array `velocity`, voxel (0, 1, 1): is [NaN, ", "m/s"]);
    }
    says(error_with("voxel_size", None), &["array `voxel_size`: is missing", "metres"]);
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-60, 1e60] {
        let scalar = npy("'<f8'", false, "()", &bad.to_le_bytes());
        says(error_with("voxel_size", Some(scalar)), &["array `voxel_size`", "above 0 and finite"]);
        if !(bad <= 0.0 || bad < 1.0) {
            let three = npy("'<f8'", false, "(3,)", &[0.0, bad, 0.0].map(f64::to_le_bytes).concat());
            says(error_with("origin", Some(three)), &["array `origin`", "finite"]);
        }
    }
    let two = npy("'<f8'", false, "(2,)", &[0; 16]);
    says(error_with("voxel_size", Some(two.clone())), &["array `voxel_size`", "[2]"]);
    says(error_with("origin", Some(two)), &["array `origin`", "[2]"]);
}

#[test]
fn files_that_are_no_volumes_are_named() {
    let folder = Folder::new();
    let says = |name: &str, bytes: Option<&[u8]>, words: &[&str]| {
        let path = folder.0.join(name);
        if let Some(bytes) = bytes {
            fs::write(&path, bytes).unwrap();
        }
        let error = read(&path, &Grids::default()).unwrap_err().to_string();
        assert!(words.iter().all(|w| error.contains(w)) && error.contains(name), "{error}");
    };
    says("absent.npz", None, &["No such file"]);
    says("text.npz", Some(b"hello"), &["no zip archive"]);
    says("empty.npz", Some(b""), &["no zip archive"]);
    says("smoke.vdb", Some(b" BDV"), &["is no OpenVDB file"]);
    says("smoke.raw", Some(b""), &[".npz or .vdb"]);
    let path = folder.0.join("whole.npz");
    write_npz(&path, &numbered(true)).unwrap();
    let whole = fs::read(&path).unwrap();
    says("cut.npz", Some(&whole[..whole.len() - 30]), &["cut short"]);
}

#[test]
fn the_extent_of_a_sequence_is_known_from_its_headers() {
    let folder = Folder::new();
    for (frame, dimensions) in [(1, [3, 1, 2]), (2, [1, 4, 2])] {
        let density = vec![1.0; dimensions.iter().product::<u32>() as usize];
        let volume = Volume { dimensions, density, ..numbered(false) };
        write_npz(&folder.0.join(format!("v.{frame:04}.npz")), &volume).unwrap();
    }
    write_npz(&folder.0.join("v.0004.npz"), &numbered(true)).unwrap();
    let open = |name: &str, hold| VolumeSequence::new(name, &folder.0, Grids::default(), hold, 24.0).unwrap();
    let files = open("v.####.npz", true);
    assert_eq!(files.extent(1..=3, []).unwrap(), Extent { dimensions: [3, 4, 2], velocity: false, still: true });
    assert_eq!(
        files.extent(4..=9, []).unwrap(),
        Extent { dimensions: numbered(true).dimensions, velocity: true, still: false }
    );
    // Frames without a velocity, and without smoke, are among the others.
    assert_eq!(files.extent(1..=4, []).unwrap(), Extent { dimensions: [3, 4, 4], velocity: true, still: true });
    let nothing = Volume { dimensions: [2, 0, 3], density: Vec::new(), ..numbered(false) };
    write_npz(&folder.0.join("v.0005.npz"), &nothing).unwrap();
    assert_eq!(files.extent(1..=5, []).unwrap(), files.extent(1..=4, []).unwrap());
    assert_eq!(files.clone().frame(5).unwrap().density, [0.0]);
    let none = files.extent([5], []).unwrap_err().to_string();
    assert!(none.contains("v.0005.npz: density: has no voxels, in any frame"), "{none}");
    let missing = open("v.####.npz", false).extent(1..=4, []).unwrap_err();
    assert_eq!(missing.path, folder.0.join("v.0003.npz"));
    let plume = open("builtin:plume", false);
    let volume = plume.clone().frame(7).unwrap();
    let velocity = volume.velocity.is_some();
    let extent = Extent { dimensions: volume.dimensions, velocity, still: !velocity };
    assert_eq!(plume.extent(1..=1_000_000, []).unwrap(), extent);
}

#[test]
fn sequences_follow_their_files() {
    let folder = Folder::new();
    for frame in [2, 3, 5] {
        let volume = Volume { origin: [frame as f32, 0.0, 0.0], ..numbered(false) };
        write_npz(&folder.0.join(format!("v.{frame:04}.npz")), &volume).unwrap();
    }
    let open = |name: &str, hold| VolumeSequence::new(name, &folder.0, Grids::default(), hold, 24.0).unwrap();
    let mut strict = open("v.####.npz", false);
    assert_eq!(strict.frame(3).unwrap().origin[0], 3.0);
    assert_eq!(strict.frame(2).unwrap().origin[0], 2.0);
    let error = strict.frame(4).unwrap_err().to_string();
    assert!(error.contains("v.0004.npz") && error.contains("hold"), "{error}");

    let mut hold = open("v.####.npz", true);
    let third = hold.frame(3).unwrap();
    assert!(Arc::ptr_eq(&third, &hold.frame(4).unwrap()));
    assert_eq!(hold.frame(5).unwrap().origin[0], 5.0);
    assert_eq!(hold.frame(u32::MAX).map(|_| ()).unwrap_err().path, folder.0.join("v.4294967295.npz"));
    assert_eq!(hold.frame(90).unwrap().origin[0], 5.0);
    let mut is_same = |f| Arc::ptr_eq(&hold.frame(f - 1).unwrap(), &hold.frame(f).unwrap());
    assert_eq!([3, 4, 5, 6, 7].map(&mut is_same), [false, true, false, true, true]);
    assert!(hold.frame(1).unwrap_err().to_string().contains("none of an earlier frame"));

    // Files at 12 a second in a shot of 24, and at 30 of which some are passed over.
    let mut half = open("v.####.npz", false).at_rate(2, 0.5);
    assert_eq!([2, 3, 4, 5].map(|frame| half.frame(frame).unwrap().origin[0]), [2.0, 2.0, 3.0, 3.0]);
    let mut more = open("v.####.npz", false).at_rate(2, 30.0 / 24.0);
    assert_eq!([2, 3].map(|frame| more.frame(frame).unwrap().origin[0]), [2.0, 3.0]);
    assert!(more.frame(6).unwrap_err().to_string().contains("v.0007.npz"));

    let mut single = open("v.0005.npz", false);
    assert!(Arc::ptr_eq(&single.frame(1).unwrap(), &single.frame(900).unwrap()));
    assert!(open("none.npz", true).frame(1).unwrap_err().to_string().contains("none.npz"));
}

#[test]
fn built_in_sequences() {
    let open = |name: &str| VolumeSequence::new(name, Path::new(""), Grids::default(), false, 24.0);
    let mut plume = open("builtin:plume").unwrap();
    assert_eq!(*plume.frame(7).unwrap(), smoke::Builtin::Plume.volume(7, 24.0));
    assert!(!Arc::ptr_eq(&plume.frame(6).unwrap(), &plume.frame(7).unwrap()));
    assert_ne!(plume.frame(7).unwrap(), open("builtin:cloud").unwrap().frame(7).unwrap());
    let error = open("builtin:plum").unwrap_err().to_string();
    assert!(error.contains("builtin:plum:") && error.contains("builtin:plume"), "{error}");
    assert!(open("a##_%d.npz").is_err());
}

/// A real simulation, where there is one beside the checkout.
#[test]
fn the_shared_simulation_is_read() {
    let pattern = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data/smoke64/plume.####.npz");
    let mut sequence =
        VolumeSequence::new(pattern.to_str().unwrap(), Path::new(""), Grids::default(), false, 24.0).unwrap();
    if sequence.source(20).is_err() {
        eprintln!("skipped: no {}", pattern.display());
        return;
    }
    let volume = sequence.frame(20).unwrap();
    assert_eq!((volume.dimensions, volume.voxel_size), ([38, 64, 38], [0.03125; 3]));
    assert_eq!(volume.origin, [-0.59375, 0.0, -0.59375]);
    // As NumPy reads them.
    assert_eq!(volume.density.iter().copied().fold(0.0, f32::max), 0.942_871_1);
    assert_eq!(volume.density[(20 * 64 + 30) * 38 + 18], 0.015_625);
    assert_eq!(volume.velocity.as_ref().unwrap()[(20 * 64 + 30) * 38 + 18][1], 0.165_283_2);
}
