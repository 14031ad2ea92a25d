//! What a file may legally be, and exporters make of it: it reads as the plain file does.

use super::*;
use crate::blur::Settings;
use crate::offline::BlurInput;

/// A box of joints and colours: skinned, morphed, textured, animated, in a hierarchy and with a camera. What is legal in one
/// place of a file, it has that place for.
fn plain() -> GltfFile {
    let mut file = GltfFile::new();
    let points: Vec<f32> = (0..8).flat_map(|i| [i & 1, i >> 1 & 1, i >> 2].map(|x| x as f32)).collect();
    let positions = file.floats("VEC3", &points);
    let normals = file.floats("VEC3", &points);
    let joints = file.packed("VEC4", 5121, 8, &[0, 1, 0, 0].repeat(8), false);
    let weights = file.floats("VEC4", &[0.25f32, 0.75, 0.0, 0.0].repeat(8));
    let coordinates = file.floats("VEC2", &[0.25; 16]);
    let moved = file.floats("VEC3", &[0.5; 24]);
    let indices = [0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4, 2, 6, 3, 3, 6, 7];
    let indices = file.packed("SCALAR", 5121, indices.len(), &indices, false);
    let mut picture = std::io::Cursor::new(Vec::new());
    let texels = image::RgbImage::from_pixel(1, 1, image::Rgb([200, 100, 50]));
    texels.write_to(&mut picture, image::ImageFormat::Png).unwrap();
    let picture = file.view(&picture.into_inner());
    let attributes = json!({
        "POSITION": positions, "NORMAL": normals, "TEXCOORD_0": coordinates, "JOINTS_0": joints, "WEIGHTS_0": weights,
    });
    let primitive = json!({"attributes": attributes, "indices": indices, "material": 0, "mode": 4, "targets": [{"POSITION": moved}]});
    file.root["meshes"] = json!([{"primitives": [primitive], "name": "box", "weights": [0.5]}]);
    file.root["nodes"] = json!([
        {"mesh": 0, "skin": 0, "name": "box"}, {"children": [2], "translation": [1, 2, 3]}, {"rotation": [0, 0, 1, 0]},
        {"camera": 0, "translation": [0, 0, 9]},
    ]);
    file.root["scenes"] = json!([{"nodes": [0, 1, 3], "name": "scene"}]);
    file.root["skins"] = json!([{"joints": [1, 2]}]);
    file.root["cameras"] = json!([{"type": "perspective", "perspective": {"yfov": 1, "znear": 0.25, "zfar": 50}}]);
    file.root["images"] = json!([{"bufferView": picture, "mimeType": "image/png"}]);
    file.root["samplers"] = json!([{"wrapS": 33071, "wrapT": 10497, "magFilter": 9728}]);
    file.root["textures"] = json!([{"source": 0, "sampler": 0}]);
    let texture = json!({"index": 0, "texCoord": 0, "extensions": {"KHR_texture_transform": {"offset": [0, 0.5]}}});
    let pbr = json!({"baseColorFactor": [0.5, 1, 0.25, 1], "baseColorTexture": texture});
    file.root["materials"] =
        json!([{"pbrMetallicRoughness": pbr, "normalTexture": {"index": 0}, "alphaMode": "OPAQUE"}]);
    file.animate(1, "translation", "LINEAR", &[0.0, 1.0], &[0.0, 1.0, 2.0, 3.0, 4.0, 5.0]);
    file.animate(0, "weights", "STEP", &[0.5], &[1.0]);
    let sampler = file.root["animations"][1]["samplers"][0].clone();
    file.root["animations"][0]["samplers"].as_array_mut().unwrap().push(sampler);
    let weights = json!({"sampler": 1, "target": {"node": 0, "path": "weights"}});
    file.root["animations"][0]["channels"].as_array_mut().unwrap().push(weights);
    file
}

/// Everything of a file but its notes: what does not change, poses, its camera and its animations.
type Read = (Topology, Vec<Vec<[f32; 3]>>, Option<Camera>, Vec<Animation>);

fn read(file: &GltfFile) -> Read {
    let mesh = open(file).unwrap();
    let poses = [-1.0, 0.0, 0.3, 0.7, 2.0].map(|seconds| pose(&mesh, seconds));
    (mesh.topology().clone(), poses.to_vec(), mesh.camera(0.5), mesh.animations().to_vec())
}

/// Asserts that a file reads as the plain one, with as many notes about `looks` and about the rest.
fn assert_as_plain(what: &str, file: &GltfFile, looks: usize, others: usize) {
    assert!(read(file) == read(&plain()), "{what}");
    let mesh = open(file).unwrap();
    let count = |looks| mesh.notes().iter().filter(|note| note.looks == looks).count();
    assert_eq!((count(true), count(false)), (looks, others), "{what}: {:?}", mesh.notes());
}

/// Calls `change` with every object or every number of a JSON value.
fn everywhere(value: &mut Value, change: &mut impl FnMut(&mut Value)) {
    match value {
        Value::Object(entries) => entries.values_mut().for_each(|entry| everywhere(entry, change)),
        Value::Array(entries) => entries.iter_mut().for_each(|entry| everywhere(entry, change)),
        _ => {}
    }
    change(value);
}

#[test]
fn extras_are_of_any_type_and_anywhere() {
    let deep = format!("{}{}", "[".repeat(100), "]".repeat(100));
    let deep: Value = serde_json::from_str(&deep).unwrap();
    for extras in [json!(null), json!("x"), json!(5), json!(5.5), json!([1, {}]), json!(true), json!({"a": [1]}), deep]
    {
        let mut file = plain();
        everywhere(&mut file.root, &mut |value| {
            // Attributes and targets hold accessors by their names and nothing else.
            if let Value::Object(entries) = value
                && !entries.contains_key("POSITION")
            {
                entries.insert("extras".into(), extras.clone());
            }
        });
        assert_as_plain(&extras.to_string(), &file, 0, 0);
    }
    // Deeper than what reads the file goes itself.
    let path = Path::new("deep.gltf");
    let text =
        format!(r#"{{"asset": {{"version": "2.0"}}, "extras": {}1{}}}"#, "[".repeat(100_000), "]".repeat(100_000));
    gltf::parse(path, text.as_bytes(), &Choice::default()).map(|_| ()).unwrap();
}

#[test]
fn whole_numbers_may_be_written_as_any_number() {
    let mut file = plain();
    everywhere(&mut file.root, &mut |value| {
        if let Some(number) = value.as_u64() {
            *value = json!(number as f64);
        }
    });
    assert!(file.root.to_string().contains("\"count\":8.0"));
    assert_as_plain("with a point", &file, 0, 0);
}

#[test]
fn what_is_not_used_may_hold_anything() {
    let mut file = plain();
    everywhere(&mut file.root, &mut |value| {
        if let Value::Object(entries) = value
            && !entries.contains_key("POSITION")
        {
            entries.insert("unknown".into(), json!({"of": ["tomorrow"]}));
            entries.entry("extensions").or_insert(json!({}))["EXT_tomorrow"] = json!({"nodes": [99]});
        }
    });
    let root = &mut file.root;
    (root["materials"][0]["alphaMode"], root["samplers"][0]["minFilter"]) = ("DITHER".into(), 12345.into());
    (root["images"][0]["mimeType"], root["bufferViews"][0]["target"]) = ("image/jxl".into(), 4.into());
    root["meshes"][0]["primitives"][0]["attributes"]["_FEATURE_ID_0"] = 0.into();
    root["meshes"][0]["primitives"][0]["attributes"]["COLOR_9"] = 0.into();
    file.add("accessors", json!({"componentType": 5130, "type": "MAT2", "count": 3}));
    file.add("textures", json!({"extensions": {"EXT_texture_webp": {"source": 0}}}));
    file.add("scenes", json!({"name": "empty"}));
    assert_as_plain("unknown", &file, 0, 0);
}

#[test]
fn lists_that_are_not_there_are_empty() {
    let mut file = plain();
    file.add("scenes", json!({}));
    file.add("animations", json!({"channels": [], "samplers": []}));
    let animations = open(&file).unwrap().animations().len();
    file.root["animations"].as_array_mut().unwrap().pop();
    assert_eq!(animations, 3);
    assert_as_plain("a scene without nodes", &file, 0, 0);
    file.root["scene"] = 1.into();
    assert!(open(&file).unwrap_err().to_string().contains("no triangles in its scene"));
}

#[test]
fn channels_that_move_no_node_are_passed_over() {
    let pointer =
        |pointer: &str| json!({"path": "pointer", "extensions": {"KHR_animation_pointer": {"pointer": pointer}}});
    for target in [
        json!({"path": "translation"}),
        json!({"path": "rotation", "extras": 5}),
        json!({"path": "weights", "extensions": {"EXT_other": {}}}),
        pointer("/materials/0/emissiveFactor"),
        pointer("/nodes/0/translation"),
        json!({"node": 0, "path": "visible"}),
    ] {
        let mut file = plain();
        file.root["extensionsUsed"] = json!(["KHR_animation_pointer"]);
        let channels = file.root["animations"][0]["channels"].as_array_mut().unwrap();
        channels.insert(0, json!({"sampler": 0, "target": target}));
        channels.push(json!({"sampler": 77, "target": target}));
        assert_as_plain(&target.to_string(), &file, 0, 1);
        assert_eq!(
            notes(&open(&file).unwrap()),
            ["animation 0: 2 of 4 channels move no property of a node: they are not played"]
        );
    }
}

#[test]
fn only_buffers_that_are_read_must_be_there() {
    let folder = Folder::new();
    let path = folder.0.join("mesh.gltf");
    let buffers = |more: &[Value]| {
        let file = plain();
        file.write_gltf(&path);
        let mut root: Value = serde_json::from_slice(&std::fs::read(&path).unwrap()).unwrap();
        root["buffers"].as_array_mut().unwrap().extend(more.iter().cloned());
        root["bufferViews"].as_array_mut().unwrap().push(json!({"buffer": 1, "byteLength": 4}));
        let view = root["bufferViews"].as_array().unwrap().len() - 1;
        std::fs::write(&path, root.to_string()).unwrap();
        (AnimatedMesh::read(&path, &Choice::default(), SECONDS), view, root)
    };
    for unread in [json!({"byteLength": 9}), json!({"byteLength": 9, "uri": "gone.bin"})] {
        let (mesh, view, mut root) = buffers(&[unread]);
        assert_eq!(pose(&mesh.unwrap(), 0.3), pose(&open(&plain()).unwrap(), 0.3));
        root["accessors"][0]["bufferView"] = view.into();
        std::fs::write(&path, root.to_string()).unwrap();
        let error = AnimatedMesh::read(&path, &Choice::default(), SECONDS).unwrap_err().to_string();
        assert!(error.contains("buffer 1"), "{error}");
    }
}

#[test]
fn buffers_may_be_percent_encoded() {
    let folder = Folder::new();
    let path = folder.0.join("mesh.gltf");
    let file = plain();
    let encoded: String = file.bytes.iter().map(|byte| format!("%{byte:02x}")).collect();
    file.write_beside(&path, &format!("data:application/octet-stream,{encoded}"), "unused.bin");
    let mesh = AnimatedMesh::read(&path, &Choice::default(), SECONDS).unwrap();
    assert_eq!(pose(&mesh, 0.3), pose(&open(&file).unwrap(), 0.3));
    assert!(mesh.topology() == open(&file).unwrap().topology());
}

#[test]
fn marks_and_padding_around_the_json_do_not_matter() {
    let file = plain();
    let expected = pose(&open(&file).unwrap(), 0.3);
    let folder = Folder::new();
    let path = folder.0.join("mesh.gltf");
    file.write_gltf(&path);
    let text = std::fs::read(&path).unwrap();
    let marked = [&b"\xef\xbb\xbf"[..], &text].concat();
    let padded = [&text[..], b"\n\n \0\0\0"].concat();
    for text in [marked, padded] {
        let scene = gltf::parse(Path::new("mesh.gltf"), &text, &Choice::default()).unwrap();
        let mut found = expected.clone();
        scene.rig.positions(0.3, &mut found);
        assert_eq!(found, expected);
    }
}

#[test]
fn extensions_of_looks_can_be_done_without() {
    for name in [
        "KHR_materials_unlit",
        "KHR_materials_pbrSpecularGlossiness",
        "KHR_materials_diffuse_transmission",
        "KHR_texture_basisu",
        "EXT_texture_webp",
        "MSFT_texture_dds",
        "KHR_lights_punctual",
        "VRM",
    ] {
        let mut file = plain();
        file.root["extensionsUsed"] = json!([name]);
        assert_as_plain(name, &file, 0, 0);
        file.root["extensionsRequired"] = json!([name]);
        assert_as_plain(name, &file, 1, 0);
        assert!(notes(&open(&file).unwrap())[0].contains(name));
    }
    for name in ["KHR_texture_transform", "KHR_mesh_quantization", "KHR_xmp_json_ld"] {
        let mut file = plain();
        (file.root["extensionsUsed"], file.root["extensionsRequired"]) = (json!([name]), json!([name]));
        assert_as_plain(name, &file, 0, 0);
    }
    // What nobody knows may move something.
    let mut file = plain();
    file.root["extensionsUsed"] = json!(["EXT_of_tomorrow"]);
    assert_as_plain("used", &file, 0, 1);
    assert!(notes(&open(&file).unwrap())[0].contains("EXT_of_tomorrow"));
}

#[test]
fn textures_whose_pictures_only_an_extension_has_are_left_out() {
    let mut file = plain();
    (file.root["extensionsUsed"], file.root["extensionsRequired"]) =
        (json!(["KHR_texture_basisu"]), json!(["KHR_texture_basisu"]));
    let sampler = file.root["textures"][0]["sampler"].clone();
    file.root["textures"][0] = json!({"extensions": {"KHR_texture_basisu": {"source": 0}}});
    let mesh = open(&file).unwrap();
    assert_eq!(mesh.topology().colour, [[0.5, 1.0, 0.25]; 8]);
    let [required, texture] = mesh.notes() else { panic!("{:?}", mesh.notes()) };
    assert!(required.looks && texture.looks && texture.text.starts_with("texture 0 has no PNG or JPEG"), "{texture:?}");
    // A picture that everybody reads, beside it, is used.
    (file.root["textures"][0]["source"], file.root["textures"][0]["sampler"]) = (0.into(), sampler);
    assert_as_plain("with a fallback", &file, 1, 0);
}

#[test]
fn vertices_without_weights_follow_their_first_joint() {
    // By the joint's number, also where it is not the first of the skin, and in both sets of joints.
    for (sets, first) in [(1, 0u8), (1, 1), (2, 0), (2, 1)] {
        let skinned = |weights_of_last: [f32; 4]| {
            let mut file = plain();
            let joints = [[0, 1, 0, 0].repeat(7), vec![first, 1 - first, 9, 9]].concat();
            let joints = file.packed("VEC4", 5121, 8, &joints, false);
            let weights =
                file.floats("VEC4", &[[0.25f32, 0.75, 0.0, 0.0].repeat(7), weights_of_last.to_vec()].concat());
            let zeros = file.floats("VEC4", &[0.0; 32]);
            let attributes = &mut file.root["meshes"][0]["primitives"][0]["attributes"];
            (attributes["JOINTS_0"], attributes["WEIGHTS_0"]) = (joints.into(), weights.into());
            if sets == 2 {
                (attributes["JOINTS_1"], attributes["WEIGHTS_1"]) = (joints.into(), zeros.into());
            }
            file
        };
        let (none, given) = (skinned([0.0; 4]), skinned([1.0, 0.0, 0.0, 0.0]));
        assert!(read(&none) == read(&given), "{sets} {first}");
        let note = "mesh 0, primitive 0: 1 of 8 vertices have no weights: they follow their first joint";
        assert_eq!(notes(&open(&none).unwrap()), [note]);
        assert_eq!(notes(&open(&given).unwrap()), [""; 0]);
    }
}

#[test]
fn indices_that_fill_no_triangle_are_dropped() {
    for rest in 1..3 {
        let mut file = plain();
        let indices = [0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4, 2, 6, 3, 3, 6, 7, 7, 7];
        let indices = file.packed("SCALAR", 5121, 24 + rest, &indices[..24 + rest], false);
        file.root["meshes"][0]["primitives"][0]["indices"] = indices.into();
        assert_as_plain("more indices", &file, 0, 1);
        let note = format!("mesh 0, primitive 0: the last {rest} of {} indices fill no triangle", 24 + rest);
        assert_eq!(notes(&open(&file).unwrap()), [note]);
    }
    // Without indices, too.
    let mut file = GltfFile::new();
    let positions = file.floats("VEC3", &[0.0; 15]);
    file.root["meshes"] = json!([{"primitives": [{"attributes": {"POSITION": positions}}]}]);
    file.root["nodes"] = json!([{"mesh": 0}]);
    let mesh = open(&file).unwrap();
    assert_eq!((&mesh.topology().triangles[..], mesh.notes().len()), (&[[0, 1, 2]][..], 1));
}

#[test]
fn times_may_begin_anywhere() {
    for times in [[-2.0, -1.0], [-1.0, 1.0], [3.0, 4.0]] {
        let mut file = one_node(json!({}));
        file.animate(0, "translation", "LINEAR", &times, &[0.0, 0.0, 0.0, 8.0, 0.0, 0.0]);
        let mesh = open(&file).unwrap();
        let x = |seconds: f32| pose(&mesh, f64::from(seconds))[0][0] - 1.0;
        let [first, last] = times;
        let found = [first - 9.0, first, (first + last) / 2.0, last, last + 9.0].map(x);
        assert_eq!(found, [0.0, 0.0, 4.0, 8.0, 8.0], "{times:?}");
    }
}

#[test]
fn triangles_without_normals_are_flat() {
    let mut file = plain();
    let is_flat = |file: &GltfFile| {
        let mesh = open(file).unwrap();
        let topology = mesh.topology();
        (0..topology.triangles.len()).map(|triangle| topology.is_flat(triangle)).collect::<Vec<_>>()
    };
    // The first vertex is at the origin, and so is its normal here: none. Others of its triangles have one.
    assert_eq!(is_flat(&file), [false; 8]);
    let bare = {
        let mut primitive = file.root["meshes"][0]["primitives"][0].clone();
        primitive["attributes"].as_object_mut().unwrap().remove("NORMAL");
        primitive
    };
    file.root["meshes"][0]["primitives"].as_array_mut().unwrap().push(bare);
    assert_eq!(is_flat(&file), [[false; 8], [true; 8]].concat());
    // What the program makes and caches stay as they are.
    let made = AnimatedMesh::builtin(Builtin::Spin, 100, SECONDS);
    assert!(!made.topology().is_flat(0) && !made.topology().faceted);
}

#[test]
fn flat_triangles_are_drawn_flat() {
    let mut file = plain();
    let view = |_: f64| Camera::default().view([64, 64]);
    let mesh = |file: &GltfFile| {
        let input = BlurInput::new(open(file).unwrap(), view, [0, 1], &Settings::default(), [64, 64], 1).unwrap();
        input.mesh().clone()
    };
    let smooth = mesh(&file);
    assert_eq!(smooth.normal_groups()[0][0], smooth.normal_groups()[4][0], "a vertex that both have");
    file.root["meshes"][0]["primitives"][0]["attributes"].as_object_mut().unwrap().remove("NORMAL");
    let flat = mesh(&file);
    let groups: Vec<[u32; 3]> = (0..8).map(|triangle| [triangle; 3]).collect();
    assert_eq!(flat.normal_groups(), groups);
    assert_eq!((flat.triangles(), flat.points()), (smooth.triangles(), smooth.points()));
}
