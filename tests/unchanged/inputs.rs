//! The files that shots read.

use std::fs;

use celfx::io::image;
use npyz::AutoSerialize;

use super::run::{self, Folder};

const SIZE: [u32; 2] = [96, 72];
/// Triangles around one corner: more than one invocation sums up the normals of.
const BLADES: u32 = 1100;

/// Writes all of them.
pub fn write(folder: &Folder) {
    pictures(folder);
    volumes(folder);
    particles(folder);
    meshes(folder);
    camera(folder);
    scene(folder);
    folder.write("bare.toml", "[camera]\neye = [0, 0.7, 2.6]\ntarget = [0, 0.62, 0]\n[flame]\n");
}

fn random(i: u32) -> u32 {
    let x = (i ^ i >> 15).wrapping_mul(0x2c1b_3c6d);
    let x = (x ^ x >> 12).wrapping_mul(0x297a_2d39);
    x ^ x >> 15
}

/// 0 to 1.
fn share(i: u32) -> f32 {
    (random(i) >> 8) as f32 / 16_777_216.0
}

fn pictures(folder: &Folder) {
    let path = |name: &str| folder.0.join(name);
    let count = SIZE[0] * SIZE[1];
    let noise = |frame: u32, i: u32| {
        let [r, g, b, _] = random(i + count * frame).to_le_bytes();
        [r, g, b, if i.is_multiple_of(7) { 128 } else { 255 }]
    };
    let smooth = |frame: u32, i: u32| {
        let [x, y] = [i % SIZE[0], i / SIZE[0]].map(|place| place as f32 / 96.0);
        [x, y, 0.5 + 0.02 * frame as f32 * (x - y), 1.0]
    };
    for frame in (3..=6).chain(20..=23) {
        let noise: Vec<[u8; 4]> = (0..count).map(|i| noise(frame, i)).collect();
        image::write_png8(&path(&format!("frame.{frame:04}.png")), SIZE, &noise).expect("temporary folder");
        let smooth: Vec<[f32; 4]> = (0..count).map(|i| smooth(frame, i)).collect();
        image::write_exr(&path(&format!("frame.{frame:04}.exr")), SIZE, &smooth).expect("temporary folder");
    }
    let sky: Vec<[u8; 4]> = (0..count).map(|i| noise(0, i)).collect();
    image::write_png8(&path("sky.png"), SIZE, &sky).expect("temporary folder");
    let row = [[10, 20, 60, 255], [90, 30, 20, 255], [200, 120, 40, 255], [250, 240, 230, 255]];
    image::write_png8(&path("row.png"), [4, 1], &row).expect("temporary folder");
}

/// An archive of arrays.
fn write_arrays<T: AutoSerialize + Clone>(
    folder: &Folder,
    name: &str,
    arrays: &[(&str, &[u64], &[T])],
) -> run::Archive {
    let mut archive = run::archive(&folder.0.join(name));
    for (name, shape, values) in arrays {
        run::add_array(&mut archive, name, shape, values.iter().cloned());
    }
    archive
}

/// Two volumes of flat voxels that turn, of different sizes; and one of cubes that stands still.
fn volumes(folder: &Folder) {
    for (frame, [nx, ny, nz]) in [(20, [18_u32, 14, 12]), (21, [15, 16, 13])] {
        let places = (0..nx * ny * nz).map(|i| [i % nx, i / nx % ny, i / nx / ny]);
        let density: Vec<f32> =
            places.clone().map(|[x, y, z]| share(x / 3 + 9 * (y / 3 + 9 * (z / 3))) - 0.3).collect();
        let velocity: Vec<f32> =
            places.flat_map(|[x, y, z]| [y as f32 - 7.0, 6.0 - x as f32, z as f32 / 9.0]).collect();
        let [x, y, z] = [nx, ny, nz].map(u64::from);
        write_arrays(
            folder,
            &format!("volume.{frame:04}.npz"),
            &[
                ("density", &[z, y, x], &density),
                ("velocity", &[z, y, x, 3], &velocity),
                ("voxel_size", &[3], &[0.1, 0.12, 0.15]),
                ("origin", &[3], &[-0.8, 0.2, -0.9]),
            ],
        );
    }
    let density: Vec<f32> = (0..4096).map(|i| if random(i).is_multiple_of(5) { 0.0 } else { 1.0 }).collect();
    let block: [(&str, &[u64], &[f32]); 3] =
        [("density", &[16, 16, 16], &density), ("voxel_size", &[3], &[0.08; 3]), ("origin", &[3], &[-1.2, 0.3, -0.6])];
    write_arrays(folder, "block.npz", &block);
}

/// A fire with ids, a few hot particles, none, and some at the ends of what is allowed.
fn particles(folder: &Folder) {
    let write = |name: &str, rows: &[[f32; 4]]| {
        let count = rows.len() as u64;
        let position: Vec<f32> = rows.iter().flat_map(|row| row[..3].to_vec()).collect();
        let temperature: Vec<f32> = rows.iter().map(|row| row[3]).collect();
        let arrays: [(&str, &[u64], &[f32]); 2] =
            [("position", &[count, 3], &position), ("temperature", &[count], &temperature)];
        write_arrays(folder, name, &arrays)
    };
    let row = |i: u32| {
        let [x, y, z, t] = [0, 1, 2, 3].map(|axis| share(4 * i + axis));
        [x - 0.5, 1.2 * y, z - 0.5, 800.0 + 2200.0 * t]
    };
    let ids: Vec<u32> = (0..300).map(|i| i * 77 % 300).collect();
    let mut fire = write("fire.npz", &(0..300).map(row).collect::<Vec<_>>());
    run::add_array(&mut fire, "id", &[300], ids);
    write("few.npz", &[0.0, 0.02, 0.04].map(|x| [x, 0.6, -x, 2990.0]));
    write("none.npz", &[]);
    let (far, hot) = (1e12, 1e6);
    write(
        "extremes.npz",
        &[[0.0, 0.6, 0.0, 3e3], [far, 0.0, -far, 3e3], [0.1, 0.5, 0.1, hot], [1e-38, 0.7, 0.0, 1e-38]],
    );
}

/// A painted fan that turns and goes to the right, the same that jumps, and the same at rest.
fn meshes(folder: &Folder) {
    let pose = |turn: f32, shift: f32| {
        let rim = (0..BLADES).flat_map(move |i| {
            let (sin, cos) = (i as f32 / BLADES as f32 * std::f32::consts::TAU + turn).sin_cos();
            [cos + shift, sin, 0.1 * (i % 50) as f32 / 50.0]
        });
        [shift, 0.0, 0.3].into_iter().chain(rim).collect::<Vec<f32>>()
    };
    let triangles: Vec<u32> = (0..BLADES).flat_map(|i| [0, 1 + i, 1 + (i + 1) % BLADES]).collect();
    let colours: Vec<f32> = (0..=BLADES).flat_map(|i| [0.9, (i % 5) as f32 * 0.2, 0.3]).collect();
    let points = u64::from(BLADES) + 1;
    let write = |name: &str, place: fn(u16) -> [f32; 2]| {
        let poses = (0..6).map(place).flat_map(|[turn, shift]| pose(turn, shift)).collect::<Vec<_>>();
        let arrays: [(&str, &[u64], &[f32]); 2] =
            [("position", &[6, points, 3], &poses), ("colour", &[points, 3], &colours)];
        let mut archive = write_arrays(folder, name, &arrays);
        run::add_array(&mut archive, "triangle", &[u64::from(BLADES), 3], triangles.iter().copied());
    };
    write("fan.npz", |frame| [0.2 * f32::from(frame), 0.1 * f32::from(frame) - 0.3]);
    write("jump.npz", |frame| [0.1 * f32::from(frame), if frame < 2 { -0.8 } else { 0.5 }]);
    write("rest.npz", |_| [0.0, 0.2]);
}

/// Three frames of a camera that comes nearer.
fn camera(folder: &Folder) {
    let matrix = |z: f64| [2.0, 0.0, 0.0, 0.0, 0.0, 2.5, 0.0, -2.5, 0.0, 0.0, -1.0, z - 0.2, 0.0, 0.0, -1.0, z];
    let matrices = [4.5, 4.0, 3.5].map(matrix);
    write_arrays(folder, "camera.npz", &[("view_projection", &[3, 4, 4], matrices.as_flattened())]);
}

/// A textured square that goes to the right, and a camera.
fn scene(folder: &Folder) {
    let floats: [f32; 28] = [
        -1.0, -1.0, 0.0, 1.0, -1.0, 0.0, 1.0, 1.0, 0.0, -1.0, 1.0, 0.3, // positions
        0.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0, // texture coordinates
        0.0, 0.2, // times
        -0.5, 0.0, 0.0, 0.5, 0.2, 0.3, // translations
    ];
    let indices: [u16; 6] = [0, 1, 2, 0, 2, 3];
    let bytes = floats.iter().flat_map(|x| x.to_le_bytes()).chain(indices.iter().flat_map(|i| i.to_le_bytes()));
    fs::write(folder.0.join("scene.bin"), bytes.collect::<Vec<u8>>()).expect("temporary folder");
    let text = r#"{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1]}],
        "nodes": [{"mesh": 0}, {"camera": 0, "translation": [0, 0, 4]}],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1}}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 4, "material": 0}]}],
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}, "doubleSided": true}],
        "textures": [{"source": 0}], "images": [{"uri": "sky.png"}],
        "animations": [{"channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}],
            "samplers": [{"input": 2, "output": 3}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [-1, -1, 0], "max": [1, 1, 0.3]},
            {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC2"},
            {"bufferView": 2, "componentType": 5126, "count": 2, "type": "SCALAR", "min": [0], "max": [0.2]},
            {"bufferView": 3, "componentType": 5126, "count": 2, "type": "VEC3"},
            {"bufferView": 4, "componentType": 5123, "count": 6, "type": "SCALAR"}],
        "bufferViews": [{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 32},
            {"buffer": 0, "byteOffset": 80, "byteLength": 8}, {"buffer": 0, "byteOffset": 88, "byteLength": 24},
            {"buffer": 0, "byteOffset": 112, "byteLength": 12}],
        "buffers": [{"uri": "scene.bin", "byteLength": 124}]}"#;
    folder.write("scene.gltf", text);
}
