//! Files that somebody else made to do harm: they are refused by name, at once and within little memory.
#![cfg(unix)]

use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::{Command, Output, Stdio};

use serde_json::{Value, json};

use super::run::{Folder, has_device};

/// Address space that the program may use, in KiB: a few times what any small file may become.
const MEMORY: u32 = 1 << 20;

/// Runs the program, killed after a minute; `limit` goes before it.
fn run(folder: &Folder, limit: &str, arguments: &[&str]) -> Output {
    let script = format!("{limit} exec timeout -s KILL 60 \"$0\" \"$@\"");
    let mut command = Command::new("sh");
    command.args(["-c", &script, env!("CARGO_BIN_EXE_celfx")]).args(arguments);
    command.current_dir(&folder.0).stdin(Stdio::null()).output().expect("a shell")
}

fn refused(folder: &Folder, limit: &str, arguments: &[&str], needles: &[&str]) {
    let output = run(folder, limit, arguments);
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(3), "{arguments:?}\n{error}");
    assert!(error.starts_with("celfx: ") && !error.contains("panicked"), "{arguments:?}\n{error}");
    needles.iter().for_each(|needle| assert!(error.contains(needle), "{arguments:?}: no {needle:?} in\n{error}"));
}

/// `inspect` within little memory.
fn inspect(folder: &Folder, file: &str, needles: &[&str]) {
    refused(folder, &format!("ulimit -v {MEMORY};"), &["inspect", file], needles);
}

fn pipe(path: &Path) {
    assert!(Command::new("mkfifo").arg(path).status().expect("mkfifo").success());
}

#[test]
fn pipes_and_devices_are_no_files() {
    let folder = Folder::new();
    let names = ["a.gltf", "a.glb", "a.npz", "a.toml", "a.png", "a.exr", "a.jpg", "im.0001.png", "im.0002.png"];
    for name in names {
        pipe(&folder.0.join(name));
        symlink("/dev/zero", folder.0.join(format!("zero_{name}"))).expect("temporary folder");
    }
    for name in &names[..4] {
        inspect(&folder, name, &[name, "is a pipe, not a file"]);
        let zero = format!("zero_{name}");
        inspect(&folder, &zero, &[&zero, "is a device, not a file"]);
    }
    let shot = |line: &str, name: &str, what: &str| {
        folder.write("shot.toml", &format!("size = [64, 64]\nframes = [1, 2]\n{line}\n"));
        refused(&folder, "", &["render", "shot.toml", "-o", "out/####.png"], &[name, what]);
    };
    for (prefix, what) in [("", "is a pipe, not a file"), ("zero_", "is a device, not a file")] {
        let named = |line: &str, name: &str| {
            let name = format!("{prefix}{name}");
            shot(&line.replace('@', &name), &name, what);
        };
        named("[smoke]\nvolume = \"@\"", "a.npz");
        named("[flame]\nparticles = \"@\"", "a.npz");
        named("[blur]\nscene = \"@\"", "a.npz");
        named("[blur]\nscene = \"@\"", "a.gltf");
        named("[camera]\nfile = \"@\"\n[smoke]", "a.npz");
        named("[camera]\nfile = \"@\"\n[smoke]", "a.glb");
        ["a.png", "a.exr", "a.jpg"].iter().for_each(|name| named("background = \"@\"\n[smoke]", name));
        named("[smoke]\ntones = \"@\"", "a.png");
        if has_device() {
            let line = format!("[blur]\nscene = \"builtin:spin\"\nimages = \"{prefix}im.####.png\"");
            shot(&line, "im.0001.png", "is not a file; 2 of the shot's 2 frames have no image");
        }
    }
}

/// A scene of one triangle whose buffer is at a URI.
fn scene(uri: &str) -> Value {
    json!({
        "asset": {"version": "2.0"},
        "buffers": [{"byteLength": 36, "uri": uri}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 3}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "nodes": [{"mesh": 0}],
        "scenes": [{"nodes": [0]}],
    })
}

#[test]
fn buffers_do_not_reach_what_is_no_file_near_by() {
    let folder = Folder::new();
    pipe(&folder.0.join("a.bin"));
    symlink("/dev/zero", folder.0.join("zero.bin")).expect("temporary folder");
    symlink("/etc/passwd", folder.0.join("link.bin")).expect("temporary folder");
    for (uri, what) in [
        ("a.bin", "is a pipe, not a file"),
        ("zero.bin", "which leads to /dev/zero"),
        ("link.bin", "which leads to /etc/passwd"),
        ("/dev/zero", "is at `/dev/zero`, which is absolute"),
        ("../../../../../../etc/passwd", "leads out of the folder above"),
        ("file:///etc/passwd", "is at `file:///etc/passwd`"),
    ] {
        folder.write("a.gltf", &scene(uri).to_string());
        inspect(&folder, "a.gltf", &["a.gltf: buffer 0: ", what]);
    }
}

#[test]
fn small_scenes_do_not_become_large_ones() {
    let folder = Folder::new();
    fs::write(folder.0.join("a.bin"), [0; 36]).expect("temporary folder");
    let bomb = |change: fn(&mut Value), needles: &[&str]| {
        let mut root = scene("a.bin");
        change(&mut root);
        folder.write("a.gltf", &root.to_string());
        inspect(&folder, "a.gltf", &[&["a.gltf: ", "would bring what is", "bytes at most"], needles].concat());
    };
    bomb(|root| root["accessors"][0]["count"] = json!(u64::MAX), &["accessor 0"]);
    bomb(
        |root| {
            root["meshes"][0]["primitives"][0]["targets"] = vec![json!({"POSITION": 0}); 20_000].into();
            root["nodes"] = vec![json!({"mesh": 0}); 20_000].into();
        },
        &["node ", "20000 weights"],
    );
    bomb(
        |root| {
            root["accessors"] = json!([
                {"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 3},
                {"componentType": 5126, "type": "SCALAR", "count": 1 << 24},
            ]);
            let sampler = |_| json!({"input": 1, "output": 1});
            let channel = |i| json!({"sampler": i, "target": {"node": 0, "path": "translation"}});
            let (samplers, channels): (Vec<_>, Vec<_>) = (0..300).map(|i| (sampler(i), channel(i))).unzip();
            root["animations"] = json!([{"samplers": samplers, "channels": channels}]);
        },
        &["accessor 1: 16777216 values without data"],
    );
    bomb(
        |root| {
            root["accessors"][0] = json!({"componentType": 5126, "type": "VEC3", "count": 3 << 20});
            root["meshes"][0]["primitives"] = vec![json!({"attributes": {"POSITION": 0}}); 500].into();
        },
        &["accessor 0: 3145728 values without data"],
    );
    bomb(
        |root| {
            root["accessors"] = json!([
                {"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 3},
                {"componentType": 5126, "type": "VEC3", "count": 4_000_000},
            ]);
            root["nodes"][0]["extensions"] = json!({"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 1}}});
        },
        &["node 0, its instances: 4000000 instances"],
    );
    bomb(|root| root["nodes"] = vec![json!({}); 1_000_000].into(), &["its JSON: 1000"]);
}
