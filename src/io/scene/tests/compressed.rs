//! `EXT_meshopt_compression`, of what the reference encoder makes.

use ::meshopt::{EncodeExpMode, encode_filter_exp, encode_filter_oct, encode_filter_quat};
use ::meshopt::{encode_index_buffer, encode_index_sequence, encode_vertex_buffer, encode_vertex_buffer_level};
use base64::prelude::*;

use super::faults::says;
use super::*;

const EXT: &str = "EXT_meshopt_compression";

/// A file whose data are compressed; buffer 1 stands for what they become.
struct Compressed {
    file: GltfFile,
    name: &'static str,
}

impl Compressed {
    fn new(name: &'static str) -> Compressed {
        let mut file = one_node(json!({}));
        file.root["extensionsRequired"] = json!([name, "KHR_mesh_quantization"]);
        Compressed { file, name }
    }

    /// Adds a buffer view of `count` values of `stride` bytes.
    fn view(&mut self, encoded: &[u8], [count, stride]: [usize; 2], mode: &str, filter: &str) -> usize {
        let compressed = self.file.view(encoded);
        let place = self.file.root["bufferViews"][compressed].clone();
        let mut extension = json!({
            "buffer": 0, "byteOffset": place["byteOffset"], "byteLength": encoded.len(),
            "count": count, "byteStride": stride, "mode": mode,
        });
        if !filter.is_empty() {
            extension["filter"] = filter.into();
        }
        let mut view = json!({"buffer": 1, "byteLength": count * stride, "extensions": {self.name: extension}});
        if mode == "ATTRIBUTES" {
            view["byteStride"] = stride.into();
        }
        self.file.add("bufferViews", view)
    }

    fn accessor(&mut self, view: usize, kind: &str, component: u32, count: usize, normalized: bool) -> usize {
        let accessor = json!({
            "bufferView": view, "componentType": component, "type": kind, "count": count, "normalized": normalized,
        });
        self.file.add("accessors", accessor)
    }

    fn primitive(&mut self) -> &mut Value {
        &mut self.file.root["meshes"][0]["primitives"][0]
    }

    /// The text of the file with both buffers.
    fn text(&self) -> String {
        let folder = Folder::new();
        let path = folder.0.join("mesh.gltf");
        self.file.write_gltf(&path);
        let mut root: Value = serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap();
        let fallback = json!({"byteLength": 1u64 << 40, "extensions": {self.name: {"fallback": true}}});
        root["buffers"].as_array_mut().unwrap().push(fallback);
        root.to_string()
    }

    fn open(&self) -> Result<gltf::Scene, ReadError> {
        gltf::parse(Path::new("mesh.gltf"), self.text().as_bytes(), &Choice::default())
    }
}

/// Positions of 300 vertices, and triangles of all.
fn grid() -> (Vec<[f32; 3]>, Vec<u32>) {
    let positions = (0..300).map(|i| [(i % 20) as f32, (i / 20) as f32, ((i * i) % 7) as f32 * 0.25]).collect();
    let corner = |i: u32| [i, i + 1, i + 20, i + 1, i + 21, i + 20];
    (positions, (0..279).filter(|i| i % 20 != 19).flat_map(corner).collect())
}

/// The grid, compressed; indices of 2 bytes or 4.
fn whole(name: &'static str, size: usize, mode: &str) -> Compressed {
    let (positions, triangles) = grid();
    let mut file = Compressed::new(name);
    let version = i32::from(name != EXT);
    let encoded = encode_vertex_buffer_level(&positions, 2, Some(version)).unwrap();
    let view = file.view(&encoded, [300, 12], "ATTRIBUTES", "");
    let position = file.accessor(view, "VEC3", 5126, 300, false);
    let encoded = match mode {
        "TRIANGLES" => encode_index_buffer(&triangles, 300).unwrap(),
        _ => encode_index_sequence(&triangles, 300).unwrap(),
    };
    let view = file.view(&encoded, [triangles.len(), size], mode, "NONE");
    let indices = file.accessor(view, "SCALAR", if size == 2 { 5123 } else { 5125 }, triangles.len(), false);
    *file.primitive() = json!({"attributes": {"POSITION": position}, "indices": indices});
    file
}

/// Triangles with their smallest corner first: the encoder may turn them.
fn sorted(triangles: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let turned = |&[a, b, c]: &[u32; 3]| [[a, b, c], [b, c, a], [c, a, b]].into_iter().min().unwrap();
    triangles.iter().map(turned).collect()
}

#[test]
fn positions_and_indices_of_all_modes_come_back() {
    let (positions, triangles) = grid();
    for name in [EXT, "KHR_meshopt_compression"] {
        for (size, mode) in [(2, "TRIANGLES"), (4, "TRIANGLES"), (2, "INDICES"), (4, "INDICES")] {
            let scene = whole(name, size, mode).open().unwrap();
            let mut found = vec![[0.0; 3]; 300];
            scene.rig.positions(0.0, &mut found);
            assert_eq!(found, positions, "{name} {mode} {size}");
            assert_eq!(sorted(&scene.topology.triangles), sorted(triangles.as_chunks().0), "{name} {mode} {size}");
        }
    }
}

#[test]
fn filters_are_undone() {
    let directions: Vec<[f32; 4]> =
        (0..3).map(|i| (i as f32, 0.6)).map(|(a, z)| [a.cos() * 0.8, a.sin() * 0.8, z, 0.0]).collect();
    let mut file = Compressed::new(EXT);
    let normal = |file: &mut Compressed, encoded: Vec<u8>, stride: usize, component: u32| {
        let view = file.view(&encoded, [3, stride], "ATTRIBUTES", "OCTAHEDRAL");
        let accessor = file.accessor(view, "VEC3", component, 3, true);
        file.primitive()["attributes"]["NORMAL"] = accessor.into();
        file.open().unwrap().topology.normal
    };
    let near = |found: &[[f32; 3]], within: f32| {
        let pairs = found.iter().zip(&directions).flat_map(|(a, b)| (0..3).map(move |i| (a[i] - b[i]).abs()));
        assert!(pairs.fold(0.0, f32::max) < within, "{found:?}");
    };
    let eight: Vec<[i8; 4]> = encode_filter_oct(&directions, 8);
    let sixteen: Vec<[i16; 4]> = encode_filter_oct(&directions, 16);
    // Steps of 8 bits and of 16.
    near(&normal(&mut file, encode_vertex_buffer(&eight).unwrap(), 4, 5120), 2.0 / 127.0);
    near(&normal(&mut file, encode_vertex_buffer(&sixteen).unwrap(), 8, 5122), 4.0 / 32767.0);

    let moved = [[1.5f32, -2.25, 1000.0], [0.001, 0.0, 7.0], [-3.0, 4.0, 5.0]];
    let encoded = encode_filter_exp(&moved, 15, EncodeExpMode::Separate);
    let view = file.view(&encode_vertex_buffer(&encoded).unwrap(), [3, 12], "ATTRIBUTES", "EXPONENTIAL");
    let accessor = file.accessor(view, "VEC3", 5126, 3, false);
    file.primitive()["attributes"]["POSITION"] = accessor.into();
    let mut found = [[0.0; 3]; 3];
    file.open().unwrap().rig.positions(0.0, &mut found);
    let near = |a: f32, b: f32| (a - b).abs() <= b.abs() * 2.0f32.powi(-14);
    assert!(found.iter().zip(&moved).all(|(a, b)| (0..3).all(|i| near(a[i], b[i]))), "{found:?}");

    // A quarter about z, as an instance's rotation.
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let mut file = Compressed::new("KHR_meshopt_compression");
    let encoded = encode_vertex_buffer(&encode_filter_quat(&[[0.0, 0.0, half, half]], 16)).unwrap();
    let view = file.view(&encoded, [1, 8], "ATTRIBUTES", "QUATERNION");
    let rotation = file.accessor(view, "VEC4", 5122, 1, true);
    file.file.root["nodes"][0]["extensions"] =
        json!({"EXT_mesh_gpu_instancing": {"attributes": {"ROTATION": rotation}}});
    file.open().unwrap().rig.positions(0.0, &mut found);
    // A step of 16 bits.
    assert!((found[0][1] - 1.0).abs() < 1e-4 && found[0][0].abs() < 1e-4, "{found:?}");
}

#[test]
fn faults_of_compressed_views_are_named() {
    let fault = |key: &'static str, value: Value| {
        let mut file = whole(EXT, 2, "TRIANGLES");
        let views = file.file.root["bufferViews"].as_array_mut().unwrap();
        let view = views.iter().position(|view| view["extensions"][EXT]["mode"] == "TRIANGLES").unwrap();
        views[view]["extensions"][EXT][key] = value;
        let error = file.open().map(|scene| scene.topology.objects).unwrap_err().to_string();
        assert!(error.contains("mesh.gltf: "), "{error}");
        error
    };
    says(fault("mode", "MAGIC".into()), &["buffer view ", "`MAGIC`", "ATTRIBUTES, TRIANGLES or INDICES"]);
    says(fault("filter", "OCTAHEDRAL".into()), &["indices with a filter, `OCTAHEDRAL`", "no filter"]);
    says(fault("byteStride", 3.into()), &["indices of 3 bytes", "2 or 4"]);
    says(fault("byteStride", 0.into()), &["indices of 0 bytes", "2 or 4"]);
    says(fault("count", 4.into()), &["4 corners", "multiple of three"]);
    says(fault("count", 3_000.into()), &["cannot be decompressed", "that mode, count and stride"]);
    says(fault("count", (1u64 << 40).into()), &["1099511627776 compressed values would bring", "at most"]);
    says(fault("byteLength", 1_000_000.into()), &["1000000 bytes from byte", "a part of its buffer"]);
    says(fault("buffer", 1.into()), &["buffer 1: has neither"]);
    says(fault("buffer", 7.into()), &["no buffer 7"]);
    says(fault("mode", "ATTRIBUTES".into()), &["values of 2 bytes", "multiple of 4, at most 256"]);
    let with_stride = |stride: usize, filter: &str| {
        let mut file = Compressed::new(EXT);
        let encoded = encode_vertex_buffer(&[[7u32; 3]; 3]).unwrap();
        let view = file.view(&encoded, [3, stride], "ATTRIBUTES", filter);
        let positions = file.accessor(view, "VEC3", 5126, 3, false);
        file.primitive()["attributes"]["POSITION"] = positions.into();
        file.open().map(|scene| scene.topology.objects).unwrap_err().to_string()
    };
    says(with_stride(12, "QUATERNION"), &["filter `QUATERNION` of 12 bytes", "QUATERNION of 8"]);
    says(with_stride(12, "MAGIC"), &["filter `MAGIC`"]);
    says(with_stride(260, ""), &["values of 260 bytes", "at most 256"]);
}

/// Whatever bytes there are, decoding returns; a truncated stream is refused.
#[test]
fn no_damage_to_compressed_bytes_panics() {
    for (name, mode) in [(EXT, "TRIANGLES"), ("KHR_meshopt_compression", "INDICES")] {
        let whole = whole(name, 2, mode);
        let views = whole.file.root["bufferViews"].as_array().unwrap().clone();
        let root = whole.text();
        let read = |root: &str, bytes: &[u8]| {
            let mut root: Value = serde_json::from_str(root).unwrap();
            let uri = format!("data:application/octet-stream;base64,{}", BASE64_STANDARD.encode(bytes));
            root["buffers"][0]["uri"] = uri.into();
            gltf::parse(Path::new("mesh.gltf"), root.to_string().as_bytes(), &Choice::default())
                .map(|scene| scene.topology.objects)
        };
        read(&root, &whole.file.bytes).unwrap();
        for (number, view) in views.iter().enumerate().filter(|(_, view)| view["buffer"] == 1) {
            let extension = &view["extensions"][name];
            let [first, length] = ["byteOffset", "byteLength"].map(|key| extension[key].as_u64().unwrap() as usize);
            for cut in 0..length {
                let mut damaged: Value = serde_json::from_str(&root).unwrap();
                damaged["bufferViews"][number]["extensions"][name]["byteLength"] = cut.into();
                assert!(read(&damaged.to_string(), &whole.file.bytes).is_err(), "{mode}: cut at {cut}");
            }
            for at in first..first + length {
                let mut damaged = whole.file.bytes.clone();
                damaged[at] ^= 1 << (at % 8);
                // Not every bit matters; what counts is that it returns.
                let _ = read(&root, &damaged);
            }
        }
    }
}
