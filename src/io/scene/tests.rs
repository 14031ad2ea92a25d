//! glTF files made here, whose poses are known in closed form.

mod bombs;
mod choices;
mod compressed;
mod faults;
mod gltf_file;
mod instances;
mod legal;
mod looks;
mod poses;
mod reach;
mod shares;
mod welding;

use std::path::Path;

use serde_json::{Value, json};

use self::gltf_file::GltfFile;
use super::*;
use crate::io::tests::Folder;

/// A frame a second, from 0.
const SECONDS: Clock = Clock { first: 0, fps: 1.0 };

/// Reads a file of those parts with the first animation.
fn open(file: &GltfFile) -> Result<AnimatedMesh, ReadError> {
    open_as(file, &Choice::default())
}

fn open_as(file: &GltfFile, choice: &Choice) -> Result<AnimatedMesh, ReadError> {
    let folder = Folder::new();
    let path = folder.0.join("mesh.gltf");
    file.write_gltf(&path);
    AnimatedMesh::open(&Source::File(path), choice, SECONDS)
}

/// The animation of that name.
fn named(animation: &str) -> Choice {
    Choice { animations: vec![Pick::Name(animation.into())], ..Choice::default() }
}

fn notes(mesh: &AnimatedMesh) -> Vec<&str> {
    mesh.notes().iter().map(|note| &note.text[..]).collect()
}

fn pose(mesh: &AnimatedMesh, seconds: f64) -> Vec<[f32; 3]> {
    mesh.pose(seconds).unwrap()
}

/// Compares positions to within `1e-6`.
fn assert_near(found: &[[f32; 3]], expected: &[[f64; 3]], what: &str) {
    assert_eq!(found.len(), expected.len(), "{what}");
    for (found, expected) in found.iter().zip(expected) {
        let off = (0..3).map(|i| (f64::from(found[i]) - expected[i]).abs()).fold(0.0, f64::max);
        assert!(off < 1e-6, "{what}: {found:?} is not {expected:?}");
    }
}

#[test]
fn names_become_sources() {
    let folder = Path::new("shots");
    assert_eq!(Source::named("builtin:spin", folder), Ok(Source::Builtin(Builtin::Spin)));
    assert_eq!(Source::named("fox.glb", folder), Ok(Source::File("shots/fox.glb".into())));
    let error = Source::named("builtin:runn", folder).unwrap_err().to_string();
    assert!(error.contains("builtin:runn: ") && error.contains("builtin:run,"), "{error}");
    let error = AnimatedMesh::read(Path::new("a.fbx"), &Choice::default(), SECONDS).unwrap_err().to_string();
    assert!(error.contains("a.fbx") && error.contains(".glb, .gltf or .npz"), "{error}");
}

#[test]
fn frames_are_timed_from_the_first() {
    let clock = Clock { first: 10, fps: 24.0 };
    assert_eq!([10.0, 22.0, 8.5].map(|frame| clock.seconds(frame)), [0.0, 0.5, -0.0625]);
    let make = |clock| AnimatedMesh::builtin(Builtin::Spin, 100, clock);
    assert_eq!(make(clock).pose(22.0).unwrap(), make(SECONDS).pose(0.5).unwrap());
}

#[test]
fn poses_are_the_same_whatever_the_threads() {
    let mesh = AnimatedMesh::builtin(Builtin::Run, 500, SECONDS);
    let frames: Vec<f64> = (0..7).map(|i| f64::from(i) * 0.1).collect();
    let alone: Vec<_> = frames.iter().map(|&frame| mesh.pose(frame).unwrap()).collect();
    for threads in [0, 1, 2, 3, 7, 100] {
        assert_eq!(mesh.poses(&frames, threads).unwrap(), alone, "{threads}");
    }
    assert_eq!(mesh.poses(&[], 4).unwrap(), Vec::<Vec<[f32; 3]>>::new());
}

/// Real files, where `CELFX_DATA` names a folder that has them in `gltf/`: what they hold, and positions that another
/// implementation of the standard found.
#[test]
fn real_files_are_posed_as_others_pose_them() {
    let Some(data) = std::env::var_os("CELFX_DATA") else {
        eprintln!("skipped: CELFX_DATA names no folder of test data");
        return;
    };
    let read = |name: &str, animation| {
        let path = Path::new(&data).join("gltf").join(name);
        path.exists().then(|| AnimatedMesh::read(&path, &named(animation), SECONDS).unwrap())
    };
    if let Some(fox) = read("Fox.glb", "Run") {
        assert_eq!((fox.vertices(), fox.topology().triangles.len(), fox.topology().objects.len()), (1728, 576, 1));
        assert_eq!(fox.animations().iter().map(|a| &a.name[..]).collect::<Vec<_>>(), ["Survey", "Walk", "Run"]);
        assert_eq!(fox.weld().into_iter().max(), Some(289));
        check_row(&fox, 0.25, 777, FOX_RUN_777);
    }
    if let Some(brain) = read("BrainStem.glb", "animation_0") {
        assert_eq!((brain.vertices(), brain.topology().triangles.len()), (34159, 61666));
        assert_eq!(brain.topology().objects.len(), 59);
        check_row(&brain, 1.1, 20000, BRAIN_STEM_20000);
    }
    if let Some(morph) = read("MorphStressTest.gltf", "TheWave") {
        assert_eq!((morph.vertices(), morph.topology().triangles.len()), (1528, 2412));
        check_row(&morph, 0.7083, 900, MORPH_900);
    }
}

const FOX_RUN_777: [f32; 3] = [-11.031364, 29.51971, -11.799062];
const BRAIN_STEM_20000: [f32; 3] = [0.35307442, 1.306405, 0.29569156];
const MORPH_900: [f32; 3] = [0.34361863, 0.01718727, 0.23281272];

fn check_row(mesh: &AnimatedMesh, seconds: f64, row: usize, expected: [f32; 3]) {
    let found = mesh.pose(seconds).unwrap()[row];
    let near = (0..3).all(|i| (found[i] - expected[i]).abs() <= 1e-6 * expected[i].abs().max(1.0));
    assert!(near, "row {row} at {seconds} s: {found:?} is not {expected:?}");
}

/// One triangle whose corners lie on the axes, in a node with these keys.
fn one_node(node: Value) -> GltfFile {
    let mut file = GltfFile::new();
    let positions = file.floats("VEC3", &[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
    file.root["meshes"] = json!([{"primitives": [{"attributes": {"POSITION": positions}}]}]);
    file.root["nodes"] = json!([{"mesh": 0}]);
    let Value::Object(keys) = node else { return file };
    keys.into_iter().for_each(|(key, value)| file.root["nodes"][0][key] = value);
    file
}
