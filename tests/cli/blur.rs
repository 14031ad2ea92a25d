//! Shots with the blur of an animated mesh.

use std::fs;
use std::path::Path;

use celfx::io::{image, picture};
use npyz::NpyFile;

use super::run::{self, Folder, celfx, has_device};
use super::{fails, succeeds};

const SIZE: [u32; 2] = [72, 48];
const SHOT: &str = "size = [72, 48]\nframes = [3, 7]\n[camera]\nfile = \"builtin:spin\"\n[blur]\nscene = \"builtin:spin\"\n\
    tooth_width = 60\n";

/// A shot with images, all different, some of them partly transparent.
fn with_images(more: &str) -> Folder {
    let folder = Folder::new();
    folder.write("shot.toml", &format!("{SHOT}images = \"in/####.png\"\n{more}"));
    fs::create_dir(folder.0.join("in")).expect("temporary folder");
    for frame in 3..=7 {
        write_image(&folder.0.join(format!("in/{frame:04}.png")), SIZE, frame);
    }
    folder
}

fn write_image(path: &Path, size: [u32; 2], frame: u32) {
    let pixel = |i: u32| {
        let byte = |shift: u32| (i.wrapping_mul(2_654_435_761).wrapping_add(frame * 40_503) >> shift) as u8;
        let alpha = if i.is_multiple_of(7) { 128 + (frame as u8) } else { 255 };
        [byte(8), byte(16), byte(24), alpha]
    };
    let pixels: Vec<[u8; 4]> = (0..size[0] * size[1]).map(pixel).collect();
    image::write_png8(path, size, &pixels).expect("temporary folder");
}

fn array(path: &Path) -> (Vec<u64>, Vec<f32>) {
    let bytes = fs::read(path).expect("an array");
    let shape = NpyFile::new(&bytes[..]).expect("an array").shape().to_vec();
    (shape, NpyFile::new(&bytes[..]).expect("an array").into_vec().expect("floats"))
}

/// A cache of these positions, [frames, vertices, 3], and one triangle.
pub fn write_cache(path: &Path, frames: u64, vertices: u64, values: &[f32]) {
    let mut archive = run::archive(path);
    run::add_array(&mut archive, "position", &[frames, vertices, 3], values.iter().copied());
    run::add_array(&mut archive, "triangle", &[1, 3], [0_u32, 1, 2]);
}

#[test]
fn an_image_is_behind_what_is_drawn() {
    if !has_device() {
        return;
    }
    let folder = Folder::new();
    write_image(&folder.0.join("sky.png"), SIZE, 1);
    folder.write("shot.toml", SHOT);
    let render = |background: &str| {
        let (output, set) = (format!("{}/####.png", background.len()), format!("background={background}"));
        succeeds(&folder, &["render", "shot.toml", "-q", "--set", &set, "-o", &output, run::validate()]);
        let path = |frame| folder.0.join(output.replace("####", &format!("{frame:04}")));
        (3..=7).map(|frame| picture::read(&path(frame)).expect("readable").pixels).collect::<Vec<_>>()
    };
    let sky = picture::read(&folder.0.join("sky.png")).expect("readable").pixels;
    let colour = render("[1.0, 0.0, 1.0]");
    for (frame, (over_colour, over_sky)) in colour.iter().zip(render("sky.png")).enumerate() {
        let bare: Vec<usize> = (0..sky.len()).filter(|i| over_colour[*i] == [1.0, 0.0, 1.0, 1.0]).collect();
        assert!(bare.len() > sky.len() / 4 && bare.len() < sky.len(), "frame {frame}: {} bare pixels", bare.len());
        assert!(bare.iter().all(|i| over_sky[*i] == sky[*i]), "frame {frame}: the sky is not what it is");
    }
}

#[test]
fn a_blurred_frame_alone_equals_the_frame_of_the_sequence() {
    if !has_device() {
        return;
    }
    let folder = with_images("");
    let render = ["render", "shot.toml", "-q", run::validate()];
    succeeds(&folder, &[&render[..], &["-o", "all/####.exr", "--layers", "all", "--threads", "3"]].concat());
    for frame in ["3", "4", "6"] {
        let alone = ["--frames", frame, "-o", "alone/####.exr", "--layers", "alone", "--threads", "1"];
        succeeds(&folder, &[&render[..], &alone].concat());
    }
    let names = run::names(&folder.0.join("alone"));
    assert_eq!(names.len(), 3 * 11, "three frames, a picture and ten layers each: {names:?}");
    for name in names {
        let [all, alone] = ["all", "alone"].map(|of| fs::read(folder.0.join(of).join(&name)).expect(&name));
        assert!(all == alone, "{name} differs");
    }
    // The first frame is its image, the others are not.
    for (frame, is_image) in [("0003", true), ("0004", false), ("0007", false)] {
        let [given, made] = [format!("in/{frame}.png"), format!("all/{frame}.exr")]
            .map(|name| picture::read(&folder.0.join(name)).expect("a picture").pixels);
        assert_eq!(given == made, is_image, "{frame}");
    }
    let (shape, rows) = array(&folder.0.join("all/blur.vertices.0005.npy"));
    assert!(shape[0] > 1000 && shape[1] == 8, "{shape:?}");
    assert!(rows.chunks(8).any(|row| row[4] > 0.0) && rows.chunks(8).all(|row| (0.0..=1.0).contains(&row[7])));
    let (shape, _) = array(&folder.0.join("all/blur.triangles.0005.npy"));
    assert!(shape[0] > 1000 && shape[1..] == [3, 4], "{shape:?}");
    for (layer, channels) in [("previous", 4), ("next", 4), ("subframe", 1), ("mask", 1), ("colour", 4)] {
        let read = image::read_exr(&folder.0.join(format!("all/blur.{layer}.0005.exr"))).expect(layer);
        assert_eq!((read.channels.len(), read.size), (channels, SIZE), "{layer}");
    }
    let mask = image::read_exr(&folder.0.join("all/blur.mask.0005.exr")).expect("a layer");
    let values = &mask.channels[0].1;
    assert!([2.0, 3.0, 4.0].iter().all(|value| values.contains(value)), "next, both and background");
    // What is missing is rendered as it was.
    for name in ["0006.exr", "blur.vertices.0004.npy"] {
        let path = folder.0.join("all").join(name);
        let before = fs::read(&path).expect(name);
        fs::remove_file(&path).expect(name);
        succeeds(&folder, &[&render[..], &["-o", "all/####.exr", "--layers", "all", "--resume"]].concat());
        assert!(fs::read(&path).expect(name) == before, "{name} differs after --resume");
    }
}

#[test]
fn without_strength_images_come_back_bit_for_bit() {
    if !has_device() {
        return;
    }
    let folder = with_images("strength = 0\n");
    succeeds(&folder, &["render", "shot.toml", "-q", "-o", "out/####.png"]);
    // Drawn all the same, for the layers.
    succeeds(&folder, &["render", "shot.toml", "-q", "-o", "drawn/####.png", "--layers", "layers"]);
    for frame in 3..=7 {
        let bytes = |of: &str| {
            let decoded = picture::read(&folder.0.join(format!("{of}/{frame:04}.png"))).expect("a picture");
            image::srgb8(&decoded.pixels)
        };
        assert!(bytes("in") == bytes("out") && bytes("in") == bytes("drawn"), "frame {frame}");
    }
}

#[test]
fn trajectories_can_be_the_scenes_own() {
    if !has_device() {
        return;
    }
    let folder = with_images("");
    let render = |more: &[&str]| {
        succeeds(&folder, &[&["render", "shot.toml", "-q", "--frames", "5", "-o", "a.exr"], more].concat());
        run::shown(&folder.0.join("a.exr"))
    };
    let spline = render(&[]);
    let exact = render(&["--set", "blur.trajectory=exact", run::validate()]);
    assert!(spline != exact, "a turn is not a cubic");
}

#[test]
fn images_that_do_not_fit_are_3_and_named() {
    let folder = with_images("");
    let image = |name: &str| folder.0.join("in").join(name);
    let whole = fs::read(image("0005.png")).expect("written");
    let says = |needles: &[&str]| fails(&folder, &["render", "shot.toml", "-o", "out/####.png"], 3, needles);
    fs::remove_file(image("0005.png")).expect("written");
    says(&["0005.png", "no such file", "1 of the shot's 5 frames", "frames 3 to 7"]);
    fs::write(image("0005.png"), &whole[..whole.len() / 2]).expect("temporary folder");
    if !has_device() {
        return;
    }
    says(&["0005.png", "PNG"]);
    write_image(&image("0005.png"), [48, 72], 5);
    says(&["0005.png", "48 x 72", "72 x 48, as the shot's size"]);
}

/// What is not needed for the frames that are rendered is not looked at: neither images, nor poses.
#[test]
fn work_follows_what_is_rendered() {
    let folder = with_images("");
    fs::remove_file(folder.0.join("in/0007.png")).expect("written");
    let render = ["render", "shot.toml", "-q", "-o", "out/####.png", "--frames"];
    let needles = ["0007.png", "no such file", "1 of the 4 frames that are needed of the shot's 5", "frames 4 to 7"];
    fails(&folder, &[&render[..], &["6"]].concat(), 3, &needles);
    if !has_device() {
        return;
    }
    succeeds(&folder, &[&render[..], &["3-5"]].concat());
    // In the last of a million frames the mesh is nowhere.
    let floats = |values: &[f32]| values.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<_>>();
    let corners = floats(&[10.0, 0.0, 0.0, 0.0, 10.0, 0.0, 0.0, 0.0, 10.0]);
    let keys = floats(&[0.0, 999_999.0, 1.0, 1.0, 1.0, 3e38, 1.0, 1.0]);
    fs::write(folder.0.join("far.bin"), [corners, keys].concat()).expect("temporary folder");
    let gltf = r#"{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "animations": [{"channels": [{"sampler": 0, "target": {"node": 0, "path": "scale"}}],
            "samplers": [{"input": 1, "output": 2, "interpolation": "STEP"}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [10, 10, 10]},
            {"bufferView": 1, "componentType": 5126, "count": 2, "type": "SCALAR", "min": [0], "max": [999999]},
            {"bufferView": 2, "componentType": 5126, "count": 2, "type": "VEC3"}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 8},
            {"buffer": 0, "byteOffset": 44, "byteLength": 24}],
        "buffers": [{"uri": "far.bin", "byteLength": 68}]}"#;
    folder.write("far.gltf", gltf);
    folder.write("far.toml", "size = [72, 48]\nframes = [0, 999999]\nfps = 1\n[blur]\nscene = \"far.gltf\"\n");
    let render = ["render", "far.toml", "-q", "-o", "far/####.png", "--frames"];
    succeeds(&folder, &[&render[..], &["1-2"]].concat());
    fails(&folder, &[&render[..], &["999999"]].concat(), 3, &["far.gltf", "vertex 0, frame 999999", "finite"]);
}

#[test]
fn meshes_that_cannot_be_blurred_are_3_and_named() {
    let folder = with_images("");
    let render = |scene: &str, more: &[&str], code: i32, needles: &[&str]| {
        let scene = format!("blur.scene={scene}");
        fails(
            &folder,
            &[&["render", "shot.toml", "-o", "out/####.png", "--set", &scene], more].concat(),
            code,
            needles,
        );
    };
    render("missing.glb", &[], 3, &["missing.glb"]);
    let mut values = [0.5_f32; 5 * 3 * 3];
    values[3 * 9 + 2 * 3 + 1] = f32::NAN;
    write_cache(&folder.0.join("nan.npz"), 5, 3, &values);
    render("nan.npz", &[], 3, &["nan.npz", "frame 3, vertex 2", "finite"]);
    write_cache(&folder.0.join("short.npz"), 4, 3, &[0.5; 4 * 3 * 3]);
    render("short.npz", &[], 3, &["short.npz", "`position`: has 4 frames", "at least 5", "frames 3 to 7"]);
    let gltf = r#"{"asset": {"version": "2.0"}, "extensionsRequired": ["KHR_of_tomorrow"], "extensionsUsed": ["KHR_of_tomorrow"]}"#;
    folder.write("new.gltf", gltf);
    render("new.gltf", &[], 3, &["new.gltf", "KHR_of_tomorrow"]);
    let bytes: Vec<u8> = [[0.0_f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]
        .as_flattened()
        .iter()
        .flat_map(|x| x.to_le_bytes())
        .collect();
    fs::write(folder.0.join("mesh.bin"), bytes).expect("temporary folder");
    let gltf = r#"{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}], "buffers": [{"uri": "mesh.bin", "byteLength": 36}]}"#;
    folder.write("mesh.gltf", gltf);
    render("mesh.gltf", &["--set", "blur.animation=Walk"], 3, &["mesh.gltf", "Walk"]);
    render("mesh.gltf", &["--set", "blur.animation=[0]"], 3, &["mesh.gltf", "no number 0", "has none"]);
    render("builtin:spin", &["--set", "blur.animation=Walk"], 2, &["blur.animation", "glTF"]);
    render("mesh.gltf", &["--set", "camera.file=mesh.gltf"], 3, &["mesh.gltf", "has no camera"]);
    folder.write("camera.gltf", CAMERA);
    render("camera.gltf", &[], 3, &["camera.gltf", "no triangles"]);
}

/// A file that holds a camera and nothing else.
const CAMERA: &str = r#"{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
    "nodes": [{"camera": 0, "translation": [0, 1, 4]}],
    "cameras": [{"type": "perspective", "perspective": {"yfov": 0.7, "znear": 0.1}}]}"#;

#[test]
fn a_camera_may_be_all_that_a_file_holds() {
    let folder = with_images("");
    folder.write("camera.gltf", CAMERA);
    assert!(succeeds(&folder, &["inspect", "camera.gltf"]).contains("0 triangles"));
    if has_device() {
        let camera = ["--set", "camera.file=camera.gltf", "--frames", "4", "-o", "a.png", "-q"];
        succeeds(&folder, &[&["render", "shot.toml"], &camera[..]].concat());
    }
}

#[test]
fn what_of_a_scene_is_passed_over_is_said_once() {
    let folder = with_images("");
    let bytes = [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0].iter().flat_map(|x| x.to_le_bytes());
    fs::write(folder.0.join("mesh.bin"), bytes.collect::<Vec<u8>>()).expect("temporary folder");
    let gltf = r#"{"asset": {"version": "2.0"}, "extensionsRequired": ["KHR_materials_sheen"],
        "scenes": [{"nodes": [0, 1, 2]}], "nodes": [{"mesh": 0}, {"camera": 0, "translation": [0, 0, 4]}, {"camera": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}, {"attributes": {"POSITION": 0}, "mode": 0}]}],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 0.7, "znear": 0.1}}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}], "buffers": [{"uri": "mesh.bin", "byteLength": 36}]}"#;
    folder.write("mesh.gltf", gltf);
    folder.write("drawn.toml", SHOT);
    let notes = ["mesh 0, primitive 1 is of points or lines", "requires KHR_materials_sheen", "camera `0`, of 2"];
    let inspected = succeeds(&folder, &["inspect", "mesh.gltf"]);
    assert!(notes[..2].iter().all(|note| inspected.contains(note)), "{inspected}");
    assert!(inspected.contains("camera `0`: perspective\ncamera `1`: perspective\n"), "{inspected}");
    if !has_device() {
        return;
    }
    let said = |shot: &str, more: &[&str]| {
        let scene = ["--set", "blur.scene=mesh.gltf", "--set", "camera.file=mesh.gltf"];
        let output = celfx(&folder, &[&["render", shot, "--frames", "4", "-o", "a.png"], &scene[..], more].concat())
            .output()
            .expect("the program runs");
        let error = String::from_utf8(output.stderr).expect("UTF-8");
        assert!(output.status.success(), "{error}");
        notes.map(|note| error.matches(note).count())
    };
    assert_eq!(said("drawn.toml", &[]), [1, 1, 1]);
    // Nothing is lost of the looks of images.
    assert_eq!(said("shot.toml", &[]), [1, 0, 1]);
    assert_eq!(said("drawn.toml", &["-q"]), [0, 0, 0]);
}

#[test]
fn a_refinement_that_is_cut_short_is_said() {
    if !has_device() {
        return;
    }
    let folder = with_images("");
    let close = ["camera.eye=[0.5, 1.0, 4.0]", "camera.target=[0.5, 1.0, 0.0]", "camera.vertical_fov=0.2"];
    let mut arguments = vec!["render", "shot.toml", "--frames", "5", "-o", "a.png", "--set", "blur.tolerance=0"];
    close.iter().for_each(|set| arguments.extend(["--set", set]));
    let output = celfx(&folder, &arguments).output().expect("the program runs");
    let error = String::from_utf8(output.stderr).expect("UTF-8");
    assert!(output.status.success(), "{error}");
    assert!(["celfx: frame 5: ", "triangles", "blur.tolerance = 0"].iter().all(|word| error.contains(word)), "{error}");
}

#[test]
fn frames_without_images_are_drawn() {
    if !has_device() {
        return;
    }
    let folder = Folder::new();
    let small = ["--set", "size=[64, 64]", "--frames", "2-3", "-q"];
    succeeds(&folder, &[&["render", "builtin:blur", "-o", "a.####.png", run::validate()], &small[..]].concat());
    let [two, three] = ["a.0002.png", "a.0003.png"].map(|name| picture::read(&folder.0.join(name)).expect(name).pixels);
    assert!(two.iter().any(|pixel| *pixel != two[0]) && two != three, "something is seen, and moves");
    let alone = ["--frames", "3", "-o", "b.png"];
    succeeds(&folder, &[&["render", "builtin:blur", "-q", "--set", "size=[64, 64]"], &alone[..]].concat());
    assert!(fs::read(folder.0.join("b.png")).expect("alone") == fs::read(folder.0.join("a.0003.png")).expect("three"));
}

#[test]
fn a_shot_of_it_can_be_printed_and_inspected() {
    let folder = Folder::new();
    let text = succeeds(&folder, &["shot", "builtin:blur"]);
    assert!(text.contains("[blur]") && text.contains("tooth_width = 12.0"), "{text}");
    folder.write("shot.toml", &text);
    for shot in ["builtin:blur", "shot.toml"] {
        assert!(succeeds(&folder, &["inspect", shot]).contains("effects: blur"), "{shot}");
    }
}

/// The brightest colours that are taken, in after-images, too, whose image is in half precision.
#[test]
fn the_brightest_images_make_finite_pictures() {
    if !has_device() {
        return;
    }
    let folder = Folder::new();
    folder.write("shot.toml", &format!("{SHOT}images = \"in/####.exr\"\n[blur.ghosts]\ncount = 3\nopacity = 1.0\n"));
    let pixels = vec![[1e6_f32, 1e6, 1e6, 1.0]; (SIZE[0] * SIZE[1]) as usize];
    for frame in 3..=7 {
        image::write_exr(&folder.0.join(format!("in/{frame:04}.exr")), SIZE, &pixels).expect("temporary folder");
    }
    let render = ["render", "shot.toml", "-q", "--frames", "5-6", "-o", "o/####.exr", run::validate()];
    succeeds(&folder, &render);
    for frame in 5..=6 {
        let pixels = picture::read(&folder.0.join(format!("o/{frame:04}.exr"))).expect("a picture").pixels;
        assert!(pixels.as_flattened().iter().all(|channel| channel.is_finite()), "frame {frame}");
        assert!(pixels.iter().any(|pixel| pixel[0] > 0.0 && pixel[0] < 1e6), "after-images are seen in frame {frame}");
    }
}
