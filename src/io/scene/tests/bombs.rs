//! Small files that ask for much: they are refused by name, and what is legal and looks like them is not.

use std::fs;

use super::faults::{error_after, says};
use super::*;

/// How much memory any small file may take, as [`super::super::budget`] has it.
const LIMIT: u64 = 1 << 28;

fn refused(change: impl FnOnce(&mut GltfFile), place: &str) {
    let error = error_after(change);
    assert!(error.contains(place) && error.contains("would bring what is") && error.contains("at most"), "{error}");
}

/// An accessor without data.
fn zeros(file: &mut GltfFile, kind: &str, count: u64) -> usize {
    file.add("accessors", json!({"componentType": 5126, "type": kind, "count": count}))
}

#[test]
fn accessors_without_data_are_bounded() {
    for count in [LIMIT / 24 + 1, 1 << 40, u64::MAX] {
        refused(
            |file| file.root["accessors"][0] = json!({"componentType": 5126, "type": "VEC3", "count": count}),
            "accessor 0",
        );
    }
    // Primitive by primitive.
    refused(
        |file| {
            let many = zeros(file, "VEC3", 600_000);
            file.root["meshes"][0]["primitives"] = vec![json!({"attributes": {"POSITION": many}}); 1000].into();
        },
        "accessor 1: 600000 values without data",
    );
    // Sparse ones stand on zeros.
    refused(
        |file| {
            let (indices, values) = (file.view(&[0; 4]), file.view(&[0; 12]));
            let sparse = json!({"count": 1, "indices": {"bufferView": indices, "componentType": 5125}, "values": {"bufferView": values}});
            file.root["accessors"][0] =
                json!({"componentType": 5126, "type": "VEC3", "count": 1u64 << 30, "sparse": sparse});
        },
        "accessor 0",
    );
}

#[test]
fn keys_are_bounded() {
    refused(
        |file| {
            let (times, values) = (zeros(file, "SCALAR", 1 << 22), zeros(file, "VEC3", 1 << 22));
            let samplers = vec![json!({"input": times, "output": values}); 300];
            let channel = |i: usize| json!({"sampler": i, "target": {"node": 0, "path": "translation"}});
            let channels: Vec<Value> = (0..300).map(channel).collect();
            file.root["animations"] = json!([{"samplers": samplers, "channels": channels}]);
        },
        "",
    );
}

#[test]
fn weights_of_many_nodes_are_bounded() {
    refused(
        |file| {
            file.root["meshes"][0]["primitives"][0]["targets"] = vec![json!({"POSITION": 0}); 20_000].into();
            file.root["nodes"] = vec![json!({"mesh": 0}); 20_000].into();
            file.root["scenes"][0]["nodes"] = json!([0]);
        },
        "20000 weights",
    );
}

#[test]
fn nodes_and_instances_of_one_mesh_are_bounded() {
    let grid = |file: &mut GltfFile, vertices: u64| {
        let base = zeros(file, "VEC3", vertices);
        file.root["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = base.into();
    };
    refused(
        |file| {
            grid(file, 300_000);
            file.root["nodes"] = vec![json!({"mesh": 0}); 200].into();
            file.root["scenes"][0]["nodes"] = (0..200).collect::<Vec<_>>().into();
        },
        "node ",
    );
    let instanced = |file: &mut GltfFile, count: u64| {
        let translation = zeros(file, "VEC3", count);
        let instancing = json!({"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": translation}}});
        file.root["nodes"][0]["extensions"] = instancing;
    };
    refused(|file| instanced(file, 1 << 40), "node 0, its instances");
    refused(
        |file| {
            grid(file, 30_000);
            instanced(file, 2000);
        },
        "node 0",
    );
    // A name is of all instances.
    refused(
        |file| {
            file.root["nodes"][0]["name"] = "n".repeat(1 << 20).into();
            instanced(file, 1000);
        },
        "node 0: its name",
    );
    // Each pose of each instance looks at all targets.
    refused(
        |file| {
            let moved = file.floats("VEC3", &[1.0; 9]);
            file.root["meshes"][0]["primitives"][0]["targets"] = vec![json!({"POSITION": moved}); 1000].into();
            instanced(file, 50_000);
        },
        "node 0: poses of 3 vertices",
    );
}

#[test]
fn joints_primitives_and_objects_are_bounded() {
    refused(
        |file| {
            let joints = vec![0; 3000];
            file.root["skins"] = vec![json!({"joints": joints}); 1000].into();
        },
        "skin ",
    );
    refused(
        |file| {
            file.root["accessors"][0]["count"] = 0.into();
            file.root["meshes"][0]["primitives"] = vec![json!({"attributes": {"POSITION": 0}}); 3000].into();
            file.root["nodes"] = vec![json!({"mesh": 0}); 3000].into();
            file.root["scenes"][0]["nodes"] = (0..3000).collect::<Vec<_>>().into();
        },
        "node ",
    );
    refused(|file| file.root["nodes"] = vec![json!({}); 600_000].into(), "its JSON: 6000");
}

/// Files of one buffer that is named over and over count once.
#[test]
fn buffers_of_one_file_are_bounded() {
    let folder = Folder::new();
    let path = folder.0.join("mesh.gltf");
    let size = 4 << 20;
    fs::File::create(folder.0.join("a.bin")).unwrap().set_len(size).unwrap();
    let buffers = vec![json!({"uri": "a.bin", "byteLength": size}); 1000];
    let views: Vec<Value> = (0..1000).map(|i| json!({"buffer": i, "byteLength": 36})).collect();
    let accessor = |i: usize| json!({"bufferView": i, "componentType": 5126, "type": "VEC3", "count": 3});
    let accessors: Vec<Value> = (0..1000).map(accessor).collect();
    let primitive = |i: usize| json!({"attributes": {"POSITION": i}});
    let primitives: Vec<Value> = (0..1000).map(primitive).collect();
    let root = json!({
        "asset": {"version": "2.0"}, "buffers": buffers, "bufferViews": views, "accessors": accessors,
        "meshes": [{"primitives": primitives}], "nodes": [{"mesh": 0}],
    });
    fs::write(&path, root.to_string()).unwrap();
    let error =
        AnimatedMesh::read(&path, &Choice::default(), SECONDS).map(|mesh| mesh.vertices()).unwrap_err().to_string();
    says(error, &["mesh.gltf: buffer ", "4194304 bytes of ", "a.bin would bring what is in memory to", "at most"]);
}

#[test]
fn forests_and_targets_that_move_nothing_are_read() {
    // 5000 vertices in 400 nodes, with 100 targets without data.
    let mut file = one_node(json!({}));
    let positions: Vec<f32> = (0..15_000).map(|i| (i % 97) as f32).collect();
    let base = file.floats("VEC3", &positions);
    let still = zeros(&mut file, "VEC3", 5000);
    file.root["meshes"][0]["primitives"][0] =
        json!({"attributes": {"POSITION": base}, "targets": vec![json!({"POSITION": still}); 100], "mode": 5});
    file.root["nodes"] = (0..400).map(|i| json!({"mesh": 0, "translation": [i, 0, 0]})).collect::<Vec<_>>().into();
    file.root["scenes"][0]["nodes"] = (0..400).collect::<Vec<_>>().into();
    let mesh = open(&file).unwrap();
    assert_eq!((mesh.vertices(), mesh.topology().objects.len()), (2_000_000, 400));
    let pose = pose(&mesh, 0.0);
    assert_eq!([pose[1], pose[399 * 5000 + 1]], [[3.0, 4.0, 5.0], [402.0, 4.0, 5.0]]);
}

#[test]
fn targets_without_data_are_of_all_vertices() {
    let error = error_after(|file| {
        let still = zeros(file, "VEC3", 4);
        file.root["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": still}]);
    });
    says(error, &["mesh 0, primitive 0: has 4 displacements; expected 3"]);
}

/// A PNG whose header says another size; its checksum is right.
fn png_that_says(size: [u32; 2]) -> Vec<u8> {
    let mut bytes = looks::picture(image::ImageFormat::Png);
    bytes[16..20].copy_from_slice(&size[0].to_be_bytes());
    bytes[20..24].copy_from_slice(&size[1].to_be_bytes());
    let step = |crc: u32| if crc & 1 == 1 { crc >> 1 ^ 0xedb8_8320 } else { crc >> 1 };
    let crc = bytes[12..29].iter().fold(!0, |crc, &byte| (0..8).fold(crc ^ u32::from(byte), |crc, _| step(crc)));
    bytes[29..33].copy_from_slice(&(!crc).to_be_bytes());
    bytes
}

/// A JPEG whose header says another size.
fn jpeg_that_says(size: [u16; 2]) -> Vec<u8> {
    let mut bytes = looks::picture(image::ImageFormat::Jpeg);
    let frame = bytes.windows(2).position(|marker| marker == [0xff, 0xc0]).unwrap();
    bytes[frame + 5..frame + 7].copy_from_slice(&size[1].to_be_bytes());
    bytes[frame + 7..frame + 9].copy_from_slice(&size[0].to_be_bytes());
    bytes
}

#[test]
fn a_textures_size_is_held_against_a_limit_before_it_is_decoded() {
    for (picture, size) in [
        (png_that_says([32_000, 32_000]), "32000 x 32000 pixels; expected at most 16384 pixels a side"),
        (png_that_says([1, 0x7fff_ffff]), "1 x 2147483647 pixels"),
        (jpeg_that_says([65_000, 65_000]), "65000 x 65000 pixels"),
    ] {
        let mesh = open(&looks::textured(picture)).unwrap();
        let [note] = notes(&mesh)[..] else { panic!("{:?}", mesh.notes()) };
        assert!(note.contains("mesh.gltf: image 0: the picture has ") && note.contains(size), "{note}");
        assert!(note.contains("the texture is left out"), "{note}");
    }
}
