//! Files that cannot be read say why; none makes the program panic.

use std::fs;

use super::*;

/// The error of [`one_node`] after a change.
pub(super) fn error_after(change: impl FnOnce(&mut GltfFile)) -> String {
    let mut file = one_node(json!({}));
    change(&mut file);
    let error = open(&file).map(|mesh| mesh.vertices()).unwrap_err().to_string();
    assert!(error.contains("mesh.gltf: ") && error.contains("; expected "), "{error}");
    error
}

pub(super) fn says(error: String, words: &[&str]) {
    assert!(words.iter().all(|word| error.contains(word)), "{error}");
}

#[test]
fn extensions_that_are_required_and_unknown_are_named() {
    for name in ["KHR_draco_mesh_compression", "KHR_animation_pointer", "EXT_other"] {
        let error = error_after(|file| file.root["extensionsRequired"] = json!(["KHR_materials_unlit", name]));
        says(error, &["extensionsRequired", name, "does without it"]);
    }
    let mut file = one_node(json!({}));
    file.root["extensionsUsed"] = json!(["KHR_draco_mesh_compression"]);
    file.root["extensionsRequired"] = json!(["KHR_materials_unlit"]);
    open(&file).unwrap();
}

#[test]
fn every_fault_names_its_place() {
    says(error_after(|file| file.root["asset"]["version"] = "1.0".into()), &["asset: is glTF 1.0", "2.0"]);
    says(error_after(|file| file.root["asset"]["minVersion"] = "2.1".into()), &["asset: needs glTF 2.1", "2.0"]);
    says(error_after(|file| file.root["scene"] = 5.into()), &["there is no scene 5", "below 1"]);
    says(error_after(|file| file.root["nodes"][0]["mesh"] = 5.into()), &["no mesh 5"]);
    says(error_after(|file| file.root["nodes"][0]["skin"] = 5.into()), &["no skin 5"]);
    says(error_after(|file| file.root["nodes"][0]["camera"] = 5.into()), &["no camera 5"]);
    says(error_after(|file| file.root["nodes"][0]["children"] = json!([1])), &["no node 1"]);
    says(error_after(|file| file.root["nodes"][0]["children"] = json!([0])), &["nodes: a node is its own ancestor"]);
    let two_parents = json!([{"mesh": 0}, {"children": [0]}, {"children": [0]}]);
    says(error_after(|file| file.root["nodes"] = two_parents), &["node 0: is the child of two nodes"]);
    says(error_after(|file| file.root["nodes"][0]["scale"] = json!([1e39, 1, 1])), &["node 0: is not finite"]);
    let primitive =
        |key: &'static str, value: Value| error_after(move |file| file.root["meshes"][0]["primitives"][0][key] = value);
    says(primitive("indices", 9.into()), &["no accessor 9"]);
    says(primitive("material", 9.into()), &["no material 9"]);
    says(primitive("attributes", json!({"POSITION": 9})), &["no accessor 9"]);
    says(primitive("indices", 0.into()), &["accessor 0: is of floats", "integers"]);
    let accessor = |key: &'static str, value: Value| error_after(move |file| file.root["accessors"][0][key] = value);
    says(accessor("type", "VEC2".into()), &["accessor 0: is of Vec2; expected Vec3"]);
    says(accessor("type", "VEC5".into()), &["accessor 0: has an unknown type"]);
    says(accessor("componentType", 5130.into()), &["accessor 0: has an unknown type"]);
    says(accessor("bufferView", 9.into()), &["no buffer view 9"]);
    says(accessor("count", 4.into()), &["accessor 0: 4 values of 12 bytes", "buffer view 0 of 36 bytes"]);
    says(accessor("byteOffset", 4.into()), &["from byte 4"]);
    says(accessor("byteOffset", u64::MAX.into()), &["accessor 0"]);
    says(accessor("count", (u64::MAX / 2).into()), &["accessor 0"]);
    let zeros = json!({"componentType": 5126, "type": "VEC3", "count": 1u64 << 40});
    says(error_after(|file| file.root["accessors"][0] = zeros), &["values without data", "at most"]);
    let view = |key: &'static str, value: Value| error_after(move |file| file.root["bufferViews"][0][key] = value);
    says(view("buffer", 1.into()), &["no buffer 1"]);
    says(view("byteLength", 40.into()), &["buffer view 0: 40 bytes from byte 0", "36 bytes"]);
    says(view("byteOffset", u64::MAX.into()), &["buffer view 0"]);
    says(view("byteStride", 8.into()), &["stride of 8 bytes", "12 at least"]);
    let nan = error_after(|file| file.bytes[12..16].copy_from_slice(&f32::NAN.to_le_bytes()));
    says(nan, &["accessor 0, value 1: is not finite"]);
}

#[test]
fn faults_of_animations_and_skins_are_named() {
    let animated =
        |path: &str, times: &[f32], values: &[f32]| error_after(|f| f.animate(0, path, "LINEAR", times, values));
    says(
        animated("translation", &[0.0, 1.0], &[0.0; 3]),
        &["animation 0, channel 0: has 3 numbers for 2 keys", "3 for each"],
    );
    says(animated("translation", &[1.0, 0.0], &[0.0; 6]), &["channel 0: has times that do not ascend"]);
    says(animated("translation", &[], &[]), &["times that do not ascend, or none"]);
    says(animated("weights", &[0.0], &[1.0]), &["has 1 numbers for 1 keys", "0 for each key"]);
    let changed = |change: fn(&mut Value)| {
        error_after(|file| {
            file.animate(0, "translation", "LINEAR", &[0.0], &[0.0; 3]);
            change(&mut file.root["animations"][0]);
        })
    };
    says(changed(|a| a["channels"][0]["sampler"] = 1.into()), &["no animation sampler 1"]);
    says(changed(|a| a["channels"][0]["target"]["node"] = 1.into()), &["no node 1"]);
    says(changed(|a| a["samplers"][0]["output"] = 9.into()), &["no accessor 9"]);
    says(changed(|a| a["samplers"][0]["interpolation"] = "MAGIC".into()), &["unknown interpolation", "STEP"]);
    let skinned = |joints: Value, weights: &[f32], bind: usize| {
        error_after(|file| {
            let weights = file.floats("VEC4", weights);
            let numbers = file.packed("VEC4", 5121, 3, &[0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0], false);
            let bind = file.floats("MAT4", &vec![0.0; 16 * bind]);
            file.root["skins"] = json!([{"joints": joints, "inverseBindMatrices": bind}]);
            file.root["nodes"][0]["skin"] = 0.into();
            let attributes = &mut file.root["meshes"][0]["primitives"][0]["attributes"];
            (attributes["JOINTS_0"], attributes["WEIGHTS_0"]) = (numbers.into(), weights.into());
        })
    };
    says(skinned(json!([0]), &[0.25; 12], 1), &["mesh 0, primitive 0: vertex 1 follows joint 1", "below 1"]);
    says(skinned(json!([0, 0]), &[0.25; 8], 2), &["has 2 weights; expected 3"]);
    says(skinned(json!([0, 0]), &[0.5, -0.5, 0.0, 0.0].repeat(3), 2), &["vertex 0 has weights that add up to 0"]);
    says(skinned(json!([]), &[0.0; 12], 0), &["vertex 0 follows joint 0", "below 0"]);
    says(skinned(json!([0, 0]), &[0.25; 12], 1), &["skin 0: has 1 inverse bind matrices", "each of 2 joints"]);
    says(skinned(json!([0, 7]), &[0.25; 12], 2), &["no node 7"]);
}

#[test]
fn buffers_can_be_anywhere_near() {
    let folder = Folder::new();
    let path = folder.0.join("mesh.gltf");
    let file = one_node(json!({}));
    file.write_beside(&path, "two%20words.bin", "two words.bin");
    let read = || AnimatedMesh::read(&path, &Choice::default(), SECONDS);
    let expected = pose(&open(&file).unwrap(), 0.0);
    assert_eq!(pose(&read().unwrap(), 0.0), expected);
    fs::write(folder.0.join("two words.bin"), [0; 35]).unwrap();
    says(read().unwrap_err().to_string(), &["buffer 0: has 35 bytes; expected 36 bytes"]);
    fs::remove_file(folder.0.join("two words.bin")).unwrap();
    says(read().unwrap_err().to_string(), &["buffer 0", "two words.bin"]);
    file.write_beside(&path, "https://example.org/a.bin", "a.bin");
    says(read().unwrap_err().to_string(), &["buffer 0: is at `https://example.org/a.bin`"]);
    file.write_beside(&path, "../../a.bin", "a.bin");
    says(read().unwrap_err().to_string(), &["buffer 0: is at `../../a.bin`", "expected a relative path"]);
    file.write_beside(&path, "data:text/plain,hello", "a.bin");
    says(read().unwrap_err().to_string(), &["buffer 0: has 5 bytes; expected 36 bytes"]);
    file.write_beside(&path, "data:text/plain;base64,*", "a.bin");
    says(read().unwrap_err().to_string(), &["buffer 0: a data URI that cannot be decoded", "base64"]);
    let path = folder.0.join("mesh.GLB");
    fs::write(&path, file.glb()).unwrap();
    assert_eq!(pose(&AnimatedMesh::read(&path, &Choice::default(), SECONDS).unwrap(), 0.0), expected);
}

#[test]
fn no_damage_to_a_file_panics() {
    let mut file = one_node(json!({"translation": [1, 2, 3]}));
    file.animate(0, "rotation", "CUBICSPLINE", &[0.0, 1.0], &[0.5; 24]);
    let whole = file.glb();
    let read = |bytes: &[u8]| {
        let scene = gltf::parse(Path::new("damaged.glb"), bytes, &Choice::default())?;
        scene.rig.positions(0.5, &mut [[0.0; 3]; 3]);
        Ok::<(), ReadError>(())
    };
    read(&whole).unwrap();
    for cut in 0..whole.len() - file.bytes.len() {
        assert!(read(&whole[..cut]).is_err(), "cut at {cut}");
    }
    for at in 0..whole.len() {
        for value in [b'9', whole[at] ^ 0x10] {
            let mut damaged = whole.clone();
            damaged[at] = value;
            // Not every byte matters; what counts is that it returns.
            let _ = read(&damaged);
        }
    }
    says(read(b"glTF\x01\0\0\0").unwrap_err().to_string(), &["byte 4: version 1"]);
    says(read(b"hello").unwrap_err().to_string(), &["its JSON"]);
}

#[test]
fn poses_that_overflow_are_refused() {
    let mesh = open(&one_node(json!({"scale": [1, 3e38, 1], "translation": [0, 2e38, 0]}))).unwrap();
    says(mesh.pose(4.0).unwrap_err().to_string(), &["vertex 0, frame 4: is at [1.0, 2e38, 0.0]", "finite", "1e12"]);
    says(mesh.poses(&[4.0, 5.0], 2).unwrap_err().to_string(), &["vertex 0, frame 4"]);
    let mesh = open(&one_node(json!({"scale": [1, 3e38, 1], "translation": [0, -2e38, 0]}))).unwrap();
    says(mesh.pose(4.0).unwrap_err().to_string(), &["vertex 0, frame 4"]);
    let far = open(&one_node(json!({"translation": [0, 9e11, 0]}))).unwrap();
    assert!(far.pose(4.0).is_ok());
}
