use std::fs;

use super::*;
use crate::io::tests::Folder;
use crate::io::vdb::tests::fixture;
use crate::io::volume::{VolumeSequence, npz};

fn grids(density: &str) -> Grids {
    Grids { density: Some(density.to_owned()), ..Grids::default() }
}

fn volume(name: &str, grids: &Grids) -> Volume {
    read(&fixture(name), grids).unwrap()
}

/// Each file as OpenVDB 10 itself reads it: its copies of the active box beside it, placed by the formats' definitions.
#[test]
fn volumes_are_those_of_the_library() {
    // With vectors; with staggered ones of halves; turned a quarter; with tiles and a velocity of three grids.
    for name in ["plain", "half", "maps", "tiles"] {
        let found = volume(name, &Grids::default());
        let expected = npz::read(&fixture(name).with_extension("npz"), &Grids::default()).unwrap();
        assert_eq!(found.dimensions, expected.dimensions, "{name}");
        let near = |a: [f32; 3], b: [f32; 3]| (0..3).all(|axis| (a[axis] - b[axis]).abs() < 1e-6);
        assert!(near(found.voxel_size, expected.voxel_size) && near(found.origin, expected.origin), "{name}");
        assert_eq!(found.density, expected.density, "{name}");
        let (found, expected) = (found.velocity.unwrap_or_default(), expected.velocity.unwrap_or_default());
        assert_eq!(found.len(), expected.len(), "{name}");
        // Means of two halves are rounded once.
        assert!(found.iter().zip(&expected).all(|(a, b)| near(*a, *b)), "{name}");
    }
}

/// A slope is one in whatever direction it is turned: between the middles of voxels, nothing is lost.
#[test]
fn what_is_turned_is_found_where_it_is() {
    let found = volume("maps", &grids("rotated"));
    assert_eq!(found.voxel_size, [0.2; 3]);
    let (sin, cos) = 0.5_f64.sin_cos();
    let mut seen = 0;
    let [nx, ny, nz] = found.dimensions.map(|n| n as usize);
    for at in 0..nx * ny * nz {
        let voxel = DVec3::new((at % nx) as f64, (at / nx % ny) as f64, (at / nx / ny) as f64);
        let world = DVec3::from_array(found.origin.map(f64::from)) + 0.2 * (voxel + 0.5) - DVec3::X;
        let own = DVec3::new(cos * world.x + sin * world.y, cos * world.y - sin * world.x, world.z) / 0.2;
        if own.cmpge(DVec3::ZERO).all() && own.cmple(DVec3::splat(7.0)).all() {
            let expected = 1.0 + own.x + 2.0 * own.y + 4.0 * own.z;
            assert!((f64::from(found.density[at]) - expected).abs() < 1e-4, "{voxel}");
            seen += 1;
        }
    }
    assert!((200..512).contains(&seen), "{seen} of 8^3");
    let sum: f64 = found.density.iter().map(|d| f64::from(*d)).sum();
    let all: f64 = (0..512).map(|at| 1.0 + f64::from(at % 8 + 2 * (at / 8 % 8) + 4 * (at / 64))).sum();
    assert!((sum / all - 1.0).abs() < 0.02, "as much smoke as before: {sum} of {all}");
}

/// What the file calls its third axis is up.
#[test]
fn up_can_be_another_axis() {
    let [y, z] = [Up::Y, Up::Z].map(|up| volume("plain", &Grids { up, velocity_scale: 2.0, ..Grids::default() }));
    let [nx, ny, nz] = y.dimensions.map(|n| n as usize);
    assert_eq!(z.dimensions, [nx, nz, ny].map(|n| n as u32));
    let plain = volume("plain", &Grids::default());
    let (first, second) = (y.velocity.unwrap(), z.velocity.unwrap());
    for (at, velocity) in first.iter().enumerate() {
        let [i, j, k] = [at % nx, at / nx % ny, at / nx / ny];
        // (x, y, z) is (x, z, -y).
        let there = i + nx * (k + nz * (ny - 1 - j));
        assert_eq!(z.density[there], y.density[at]);
        let [a, b, c] = *velocity;
        assert_eq!(second[there], [a, c, -b]);
        assert_eq!(*velocity, plain.velocity.as_ref().unwrap()[at].map(|c| 2.0 * c));
    }
    let end = y.origin[1] + y.voxel_size[1] * ny as f32;
    assert_eq!(z.origin, [y.origin[0], y.origin[2], -end]);
    // The same as of an archive.
    let archive = fixture("plain").with_extension("npz");
    let turned = npz::read(&archive, &Grids { up: Up::Z, velocity_scale: 2.0, ..Grids::default() }).unwrap();
    assert_eq!((turned.density, turned.velocity.unwrap(), turned.origin), (z.density, second, z.origin));
}

#[test]
fn what_is_not_there_is_no_smoke() {
    let nothing = volume("plain", &grids("soot"));
    assert_eq!((nothing.dimensions, &nothing.density[..]), ([1; 3], &[0.0][..]));
    assert_eq!(nothing.velocity, Some(vec![[0.0; 3]]));
    // A grid without active voxels, too.
    assert_eq!(volume("half", &grids("flame")).density, [0.0]);
    assert_eq!(contents(&fixture("half"), &grids("flame")).unwrap().dimensions, None);
    let known = contents(&fixture("half"), &Grids::default()).unwrap();
    assert_eq!((known.dimensions, known.velocity), (Some([10; 3]), true));
    let still = Grids { velocity: Some("wind".to_owned()), ..Grids::default() };
    assert!(!contents(&fixture("half"), &still).unwrap().velocity);
    let told = missing(&fixture("plain"), &grids("soot")).to_string();
    assert!(told.contains("in a grid `soot`; this file has the grids [\"density\", \"vel\"]"), "{told}");
}

#[test]
fn what_is_no_density_is_refused() {
    let refused = |name: &str, density: &str| read(&fixture(name), &grids(density)).unwrap_err().to_string();
    let level_set = refused("level_set", "density");
    assert!(level_set.contains("grid `density`: is a level set"), "{level_set}");
    let vectors = refused("plain", "vel");
    assert!(vectors.contains("grid `vel`: is of vectors; expected one density a voxel"), "{vectors}");
}

/// The second grid of a name has another background, which is no part of its box.
#[test]
fn a_number_chooses_among_grids_of_one_name() {
    let second = volume("tiles", &grids("density[1]"));
    assert_eq!(second.dimensions, [4; 3]);
    assert!(second.density.iter().all(|d| (0.5..1.5).contains(d)), "{:?}", second.density);
}

/// Frames without the grid are without smoke, as those before a fire is lit; only where no frame has it is its name wrong.
#[test]
fn a_sequence_may_begin_without_smoke() {
    let folder = Folder::new();
    for (frame, name) in [(1, "plain"), (2, "tiles"), (3, "half")] {
        fs::copy(fixture(name), folder.0.join(format!("s.{frame:04}.vdb"))).unwrap();
    }
    let open = |density: &str| VolumeSequence::new("s.####.vdb", &folder.0, grids(density), false, 24.0).unwrap();
    let mut copies = open("copy");
    let extent = copies.extent(1..=3, []).unwrap();
    assert_eq!((extent.dimensions, extent.velocity), ([10; 3], true));
    let frames = [1, 2, 3].map(|frame| copies.frame(frame).unwrap());
    assert_eq!(frames.each_ref().map(|volume| volume.dimensions), [[1; 3], [10; 3], [1; 3]]);
    for (frame, volume) in (1..).zip(&frames) {
        extent.check(volume, &folder.0.join(format!("s.{frame:04}.vdb"))).unwrap();
    }
    // The first frame alone: another of the shot has the grid, and a velocity.
    let alone = copies.extent([1], 2..=9).unwrap();
    assert_eq!((alone.dimensions, alone.velocity), ([1; 3], true));
    assert!(copies.extent([1], [3]).is_err(), "neither has it");
    let error = open("soot").extent(1..=3, []).unwrap_err().to_string();
    assert!(error.contains("s.0001.vdb") && error.contains("no frame has smoke in a grid `soot`"), "{error}");
}
