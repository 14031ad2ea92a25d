//! Which vertices are one point, without a look at a pose.

use super::*;

/// The points of a scene's vertices as some of its poses tell them.
fn by_poses(mesh: &AnimatedMesh, seconds: &[f64]) -> Vec<u32> {
    weld(&mesh.topology().object, &mesh.poses(seconds, 2).unwrap())
}

fn every(step: f64, count: u32) -> Vec<f64> {
    (0..count).map(|i| f64::from(i) * step).collect()
}

#[test]
fn what_the_program_makes_is_welded_as_its_poses_tell() {
    for which in [Builtin::Run, Builtin::Spin, Builtin::Crossing] {
        for vertices in [100, 800, 900, 2000, which.usual_vertices(), 30_000] {
            let mesh = AnimatedMesh::builtin(which, vertices, SECONDS);
            let found = mesh.weld();
            assert!(found == by_poses(&mesh, &every(1.0 / which.fps(), which.frames())), "{which:?}, {vertices}");
            assert!(found.iter().max().unwrap() + 1 < found.len() as u32);
        }
    }
}

/// Real files, where `CELFX_DATA` names a folder that has them in `gltf/`.
#[test]
fn real_files_are_welded_as_their_poses_tell() {
    let Some(data) = std::env::var_os("CELFX_DATA") else {
        eprintln!("skipped: CELFX_DATA names no folder of test data");
        return;
    };
    for (name, seconds) in [("Fox.glb", 1.0), ("BrainStem.glb", 4.0), ("MorphStressTest.gltf", 3.0)] {
        let path = Path::new(&data).join("gltf").join(name);
        if path.exists() {
            let mesh = AnimatedMesh::read(&path, &Choice::default(), SECONDS).unwrap();
            let (found, expected) = (mesh.weld(), by_poses(&mesh, &every(seconds / 12.0, 13)));
            let differing = found.iter().zip(&expected).filter(|(a, b)| a != b).count();
            assert!(
                found == expected,
                "{name}: {:?} and {:?} points, {differing}",
                found.iter().max(),
                expected.iter().max()
            );
        }
    }
}

/// Four vertices at one place in pairs, that follow two joints.
fn skinned(weights: [f32; 16], animated: bool) -> GltfFile {
    let mut file = GltfFile::new();
    let corners = [[0.0; 3], [0.0; 3], [1.0, 0.0, 0.0], [1.0, 0.0, 0.0]].concat();
    let positions = file.floats("VEC3", &corners);
    let joints = file.packed("VEC4", 5121, 4, &[[0, 1, 0, 0]; 4].concat(), false);
    let weights = file.floats("VEC4", &weights);
    let indices = file.packed("SCALAR", 5121, 6, &[0, 2, 1, 1, 2, 3], false);
    file.root["meshes"] = json!([{"primitives": [{
        "attributes": {"POSITION": positions, "JOINTS_0": joints, "WEIGHTS_0": weights}, "indices": indices,
    }]}]);
    file.root["nodes"] = json!([{"mesh": 0, "skin": 0}, {"translation": [0, 0, 0]}, {"translation": [0, 0, 0]}]);
    file.root["scenes"] = json!([{"nodes": [0, 1, 2]}]);
    file.root["skins"] = json!([{"joints": [1, 2]}]);
    if animated {
        let times = file.floats("SCALAR", &[0.0, 1000.0]);
        let values = file.floats("VEC3", &[0.0, 0.0, 0.0, 0.0, 5.0, 0.0]);
        file.root["animations"] = json!([{
            "samplers": [{"input": times, "output": values}],
            "channels": [{"sampler": 0, "target": {"node": 2, "path": "translation"}}],
        }]);
    }
    file
}

#[test]
fn vertices_are_one_if_they_follow_the_same_joints_by_the_same_shares() {
    let halves = [0.5, 0.5, 0.0, 0.0];
    let same = [halves; 4].concat().try_into().unwrap();
    assert_eq!(open(&skinned(same, true)).unwrap().weld(), [0, 0, 1, 1]);
    let other = [halves, halves, halves, [0.25, 0.75, 0.0, 0.0]].concat().try_into().unwrap();
    let mesh = open(&skinned(other, true)).unwrap();
    assert_eq!(mesh.weld(), [0, 0, 1, 2]);
    // What is told apart goes apart, however late.
    assert_eq!(by_poses(&mesh, &[0.0]), [0, 0, 1, 1]);
    assert_eq!(by_poses(&mesh, &[0.0, 999.0]), [0, 0, 1, 2]);
}

/// One triangle whose first two corners are at one place, with two morph targets.
fn morphed(weights: Value) -> GltfFile {
    let mut file = GltfFile::new();
    let positions = file.floats("VEC3", &[0.0, -0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0]);
    let same = file.floats("VEC3", &[0.0, 1.0, 0.0, 0.0, 1.0, -0.0, 0.0, 0.0, 0.0]);
    let other = file.floats("VEC3", &[0.0, 1.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 0.0]);
    let targets = json!([{"POSITION": same}, {"POSITION": other}]);
    file.root["meshes"] =
        json!([{"primitives": [{"attributes": {"POSITION": positions}, "targets": targets}], "weights": weights}]);
    file.root["nodes"] = json!([{"mesh": 0}]);
    file
}

#[test]
fn vertices_are_one_if_every_target_that_moves_them_moves_them_together() {
    assert_eq!(open(&morphed(json!([1, 0]))).unwrap().weld(), [0, 0, 1]);
    assert_eq!(open(&morphed(json!([0, 1]))).unwrap().weld(), [0, 1, 2]);
    let mut late = morphed(json!([0, 0]));
    assert_eq!(open(&late).unwrap().weld(), [0, 0, 1]);
    let times = late.floats("SCALAR", &[0.0, 1.0, 1000.0]);
    let values = late.floats("SCALAR", &[0.0, 0.0, 0.0, 0.0, 0.0, 0.5]);
    late.root["animations"] = json!([{
        "samplers": [{"input": times, "output": values}],
        "channels": [{"sampler": 0, "target": {"node": 0, "path": "weights"}}],
    }]);
    assert_eq!(open(&late).unwrap().weld(), [0, 1, 2]);
}
