//! Where vertices are: hierarchy, interpolation, skins and morph targets.

use std::f64::consts::FRAC_PI_2;

use super::*;

/// The corners of [`one_node`], each through a function.
fn corners(place: impl Fn([f64; 3]) -> [f64; 3]) -> Vec<[f64; 3]> {
    [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(place).to_vec()
}

/// Turned about z.
fn turned(angle: f64) -> impl Fn([f64; 3]) -> [f64; 3] {
    let (sin, cos) = angle.sin_cos();
    move |[x, y, z]| [cos * x - sin * y, sin * x + cos * y, z]
}

fn about_z(angle: f64) -> [f32; 4] {
    [0.0, 0.0, (angle / 2.0).sin() as f32, (angle / 2.0).cos() as f32]
}

/// [`one_node`] with an animation.
fn animated(path: &str, interpolation: &str, times: &[f32], values: &[f32]) -> AnimatedMesh {
    let mut file = one_node(json!({}));
    file.animate(0, path, interpolation, times, values);
    open(&file).unwrap()
}

/// The cubic Hermite spline, from the standard.
fn hermite(u: f64, step: f64, [a, leaving, arriving, b]: [f64; 4]) -> f64 {
    (2.0 * u.powi(3) - 3.0 * u.powi(2) + 1.0) * a
        + step * (u.powi(3) - 2.0 * u.powi(2) + u) * leaving
        + (-2.0 * u.powi(3) + 3.0 * u.powi(2)) * b
        + step * (u.powi(3) - u.powi(2)) * arriving
}

#[test]
fn a_mesh_stands_where_its_nodes_put_it() {
    let mesh = open(&one_node(json!({"translation": [1, 2, 3], "scale": [2, 3, 4]}))).unwrap();
    assert_near(&pose(&mesh, 7.0), &corners(|[x, y, z]| [1.0 + 2.0 * x, 2.0 + 3.0 * y, 3.0 + 4.0 * z]), "parts");
    let matrix = [0, 2, 0, 0, -3, 0, 0, 0, 0, 0, 4, 0, 1, 2, 3, 1];
    let mut file = one_node(json!({"matrix": matrix}));
    let by_matrix = corners(|[x, y, z]| [1.0 - 3.0 * y, 2.0 + 2.0 * x, 3.0 + 4.0 * z]);
    assert_near(&pose(&open(&file).unwrap(), 0.0), &by_matrix, "matrix");
    // An animated property replaces that of the matrix.
    file.animate(0, "translation", "LINEAR", &[0.0, 1.0], &[0.0, 0.0, 0.0, 5.0, 0.0, 0.0]);
    let moved = corners(|[x, y, z]| [2.5 - 3.0 * y, 2.0 * x, 4.0 * z]);
    assert_near(&pose(&open(&file).unwrap(), 0.5), &moved, "animated matrix");
}

#[test]
fn children_follow_their_parents_in_any_order() {
    let mut file = one_node(json!({"translation": [10, 0, 0]}));
    file.add("nodes", json!({"children": [0], "rotation": about_z(FRAC_PI_2), "translation": [0, 0, 1]}));
    file.add("nodes", json!({"children": [1], "scale": [2, 2, 2]}));
    file.root["scenes"] = json!([{"nodes": [2]}]);
    let placed = corners(|p| {
        let [x, y, z] = turned(FRAC_PI_2)([p[0] + 10.0, p[1], p[2]]);
        [2.0 * x, 2.0 * y, 2.0 * (z + 1.0)]
    });
    assert_near(&pose(&open(&file).unwrap(), 0.0), &placed, "three deep");
}

#[test]
fn a_mesh_in_two_nodes_is_two_objects() {
    let mut file = one_node(json!({"name": "left", "translation": [5, 0, 0]}));
    file.root["meshes"][0]["name"] = "leg".into();
    file.add("nodes", json!({"mesh": 0, "scale": [-1, 1, 1]}));
    file.add("nodes", json!({"mesh": 0, "name": "elsewhere"}));
    file.root["scenes"] = json!([{"nodes": [1, 0]}]);
    let mesh = open(&file).unwrap();
    let topology = mesh.topology();
    // In the order of the file; the third is not in the scene, and the mirrored one is turned over.
    assert_eq!(
        (&topology.objects[..], &topology.object[..]),
        (&["left".into(), "leg".into()][..], &[0, 0, 0, 1, 1, 1][..])
    );
    assert_eq!(topology.triangles, [[0, 1, 2], [3, 5, 4]]);
    let expected = [corners(|[x, y, z]| [x + 5.0, y, z]), corners(|[x, y, z]| [-x, y, z])].concat();
    assert_near(&pose(&mesh, 0.0), &expected, "both");
}

#[test]
fn steps_and_lines_between_keys_and_rest_outside() {
    let times = [0.5, 1.0, 3.0];
    let values = [1.0, 2.0, 3.0, 5.0, 4.0, 3.0, -3.0, 0.0, 1.0];
    let at = |mesh: &AnimatedMesh, seconds, t: [f64; 3]| {
        let expected = corners(|p| std::array::from_fn(|i| p[i] + t[i]));
        assert_near(&pose(mesh, seconds), &expected, &format!("{seconds} s"));
    };
    let line = animated("translation", "LINEAR", &times, &values);
    let step = animated("translation", "STEP", &times, &values);
    for seconds in [-10.0, 0.0, 0.5] {
        [&line, &step].iter().for_each(|mesh| at(mesh, seconds, [1.0, 2.0, 3.0]));
    }
    for seconds in [3.0, 3.5, 1e9] {
        [&line, &step].iter().for_each(|mesh| at(mesh, seconds, [-3.0, 0.0, 1.0]));
    }
    at(&line, 0.75, [3.0, 3.0, 3.0]);
    at(&line, 1.0, [5.0, 4.0, 3.0]);
    at(&line, 2.5, [-1.0, 1.0, 1.5]);
    at(&step, 0.99, [1.0, 2.0, 3.0]);
    at(&step, 1.0, [5.0, 4.0, 3.0]);
    at(&step, 2.99, [5.0, 4.0, 3.0]);
    assert_eq!(line.animations(), [Animation { name: "0".into(), seconds: 3.0 }]);
    let scaled = animated("scale", "LINEAR", &[0.0, 1.0], &[1.0, 1.0, 1.0, 3.0, 5.0, -7.0]);
    assert_near(&pose(&scaled, 0.25), &corners(|[x, y, z]| [1.5 * x, 2.0 * y, -z]), "scale");
    let single = animated("translation", "CUBICSPLINE", &[1.0], &[9.0, 9.0, 9.0, 1.0, 2.0, 3.0, 9.0, 9.0, 9.0]);
    [0.0, 1.0, 2.0].iter().for_each(|&seconds| at(&single, seconds, [1.0, 2.0, 3.0]));
}

#[test]
fn cubic_splines_are_those_of_the_standard() {
    // In-tangent, value, out-tangent of two keys that are two seconds apart.
    let keys =
        [[9.0, 9.0, 9.0], [1.0, 2.0, 3.0], [0.5, -1.0, 2.0], [-3.0, 0.25, 1.0], [4.0, 0.0, -1.0], [9.0, 9.0, 9.0]];
    let mesh = animated("translation", "CUBICSPLINE", &[1.0, 3.0], keys.map(|k| k.map(|x| x as f32)).as_flattened());
    for u in [0.0, 0.1, 0.5, 0.75, 1.0] {
        let t: [f64; 3] = std::array::from_fn(|i| hermite(u, 2.0, [keys[1][i], keys[2][i], keys[3][i], keys[4][i]]));
        let expected = corners(|p| std::array::from_fn(|i| p[i] + t[i]));
        assert_near(&pose(&mesh, 1.0 + 2.0 * u), &expected, &format!("u {u}"));
    }
}

#[test]
fn rotations_take_the_shorter_way_at_constant_speed() {
    for (from, to) in [(0.0, 2.5), (0.3, -2.0), (-3.0, 3.0), (1.0, 1.0 + 1e-7), (0.7, 0.7)] {
        for sign in [1.0, -1.0] {
            let values = [about_z(from), about_z(to).map(|x| sign * x)];
            let mesh = animated("rotation", "LINEAR", &[0.0, 1.0], values.as_flattened());
            let way = (to - from + std::f64::consts::PI).rem_euclid(std::f64::consts::TAU) - std::f64::consts::PI;
            for u in [0.0, 0.2, 0.5, 0.9, 1.0] {
                assert_near(&pose(&mesh, u), &corners(turned(from + u * way)), &format!("{from} {to} {sign} {u}"));
            }
        }
    }
    // Cubic: component by component, then of length 1. In the file the second is not.
    let (a, b) = (about_z(0.0), about_z(1.2).map(|x| 2.0 * x));
    let (leaving, arriving) = ([0.0, 0.0, 0.4, 0.1], [0.0, 0.0, -0.3, 0.2]);
    let rows = [[9.0; 4], a, leaving, arriving, b, [9.0; 4]];
    let mesh = animated("rotation", "CUBICSPLINE", &[0.0, 1.0], rows.as_flattened());
    for u in [0.0, 0.3, 0.6, 1.0] {
        let [z, w] = [2, 3].map(|i| hermite(u, 1.0, [a[i], leaving[i], arriving[i], b[i]].map(f64::from)));
        assert_near(&pose(&mesh, u), &corners(turned(2.0 * z.atan2(w))), &format!("cubic {u}"));
    }
}

/// A column of points at x = 1 in a skin of two joints: one at the origin, one at y = 1 that hangs on it.
fn skinned(heights: &[f32], influences: impl Fn(&mut GltfFile) -> Value) -> GltfFile {
    let mut file = GltfFile::new();
    let points: Vec<f32> = heights.iter().flat_map(|&y| [1.0, y, 0.0]).collect();
    let mut attributes = influences(&mut file);
    attributes["POSITION"] = file.floats("VEC3", &points).into();
    let mut bind = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0].repeat(2);
    bind[16 + 13] = -1.0;
    let bind = file.floats("MAT4", &bind);
    file.root["meshes"] = json!([{"primitives": [{"attributes": attributes, "mode": 5}]}]);
    // The node of a skinned mesh does not move it.
    file.root["nodes"] = json!([
        {"mesh": 0, "skin": 0, "translation": [100, 0, 0]},
        {"children": [2], "translation": [0, 0, 0]},
        {"translation": [0, 1, 0]},
    ]);
    file.root["skins"] = json!([{"joints": [1, 2], "inverseBindMatrices": bind}]);
    file.root["scenes"] = json!([{"nodes": [0, 1]}]);
    file.animate(2, "rotation", "LINEAR", &[0.0, 1.0], [about_z(0.0), about_z(FRAC_PI_2)].as_flattened());
    file
}

/// Where the second joint takes a point when it has turned by `angle`.
fn bent(angle: f64, [x, y, z]: [f64; 3]) -> [f64; 3] {
    let [x, y, z] = turned(angle)([x, y - 1.0, z]);
    [x, y + 1.0, z]
}

#[test]
fn skins_blend_their_joints() {
    let file = skinned(&[0.0, 1.0, 2.0, 3.0], |file| {
        let joints = file.packed("VEC4", 5121, 4, &[0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 1, 9, 9, 9], false);
        let weights = [[255, 0, 0, 0], [51, 204, 0, 0], [0, 255, 0, 0], [255, 0, 0, 0]];
        let weights = file.packed("VEC4", 5121, 4, weights.as_flattened(), true);
        json!({"JOINTS_0": joints, "WEIGHTS_0": weights})
    });
    let mesh = open(&file).unwrap();
    for seconds in [0.0, 0.5, 1.0] {
        let share = |y: f64, share: f64| {
            let (still, moved) = ([1.0, y, 0.0], bent(FRAC_PI_2 * seconds, [1.0, y, 0.0]));
            std::array::from_fn(|i| (1.0 - share) * still[i] + share * moved[i])
        };
        let expected = [share(0.0, 0.0), share(1.0, 0.8), share(2.0, 1.0), share(3.0, 1.0)];
        assert_near(&pose(&mesh, seconds), &expected, &format!("{seconds} s"));
    }
}

#[test]
fn a_second_set_of_joints_counts_too() {
    let file = skinned(&[0.0, 1.0, 2.0], |file| {
        let u16s = |values: &[u16]| values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<_>>();
        let zero = file.packed("VEC4", 5123, 3, &u16s(&[0; 12]), false);
        let one = file.packed("VEC4", 5123, 3, &u16s(&[1; 12]), false);
        // Weights that do not add up to 1 are taken for their shares.
        let few = file.floats("VEC4", &[0.1f32, 0.0, 0.0, 0.1].repeat(3));
        let more = file.floats("VEC4", &[0.2f32, 0.2, 0.2, 0.0].repeat(3));
        json!({"JOINTS_0": zero, "WEIGHTS_0": few, "JOINTS_1": one, "WEIGHTS_1": more})
    });
    let expected = [0.0, 1.0, 2.0].map(|y| {
        let moved = bent(FRAC_PI_2, [1.0, y, 0.0]);
        std::array::from_fn(|i| 0.25 * [1.0, y, 0.0][i] + 0.75 * moved[i])
    });
    assert_near(&pose(&open(&file).unwrap(), 1.0), &expected, "eight joints");
}

/// Two morph targets: one dense, one sparse that moves the last corner only.
fn morphing() -> GltfFile {
    let mut file = one_node(json!({}));
    let dense = file.floats("VEC3", &[0.5, 0.0, 0.0, 0.0, -0.5, 0.0, 1.0, 1.0, 1.0]);
    let row = file.view(&[2]);
    let moved: Vec<u8> = [0.0f32, 2.0, 4.0].iter().flat_map(|v| v.to_le_bytes()).collect();
    let moved = file.view(&moved);
    let sparse = json!({
        "componentType": 5126, "type": "VEC3", "count": 3,
        "sparse": {
            "count": 1, "indices": {"bufferView": row, "componentType": 5121}, "values": {"bufferView": moved},
        },
    });
    let sparse = file.add("accessors", sparse);
    file.root["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": dense}, {"POSITION": sparse}]);
    file
}

#[test]
fn morph_targets_add_up() {
    let expected =
        |a: f64, b: f64| [[1.0 + 0.5 * a, 0.0, 0.0], [0.0, 1.0 - 0.5 * a, 0.0], [a, a + 2.0 * b, 1.0 + a + 4.0 * b]];
    let check = |file: &GltfFile, seconds: f64, a: f64, b: f64| {
        assert_near(&pose(&open(file).unwrap(), seconds), &expected(a, b), &format!("{a} {b}"));
    };
    let mut file = morphing();
    check(&file, 0.0, 0.0, 0.0);
    file.root["meshes"][0]["weights"] = json!([0.5, -1]);
    check(&file, 0.0, 0.5, -1.0);
    file.root["nodes"][0]["weights"] = json!([2, 0.25]);
    check(&file, 0.0, 2.0, 0.25);
    file.animate(0, "weights", "LINEAR", &[0.0, 2.0], &[0.0, 1.0, 1.0, 0.0]);
    check(&file, 0.5, 0.25, 0.75);
    let mut cubic = morphing();
    // For each key the in-tangents, values and out-tangents of both targets.
    let rows = [9.0, 9.0, 0.1, 0.2, 1.0, -1.0, 0.5, 0.25, 0.8, 0.4, 9.0, 9.0];
    cubic.animate(0, "weights", "CUBICSPLINE", &[0.0, 2.0], &rows);
    check(&cubic, 0.5, hermite(0.25, 2.0, [0.1, 1.0, 0.5, 0.8]), hermite(0.25, 2.0, [0.2, -1.0, 0.25, 0.4]));
}

#[test]
fn quantised_positions_are_read() {
    let mut file = one_node(json!({"scale": [3, 3, 3]}));
    file.root["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    let bytes: Vec<u8> = [32767i16, 0, 0, 0, -32768, 0, 0, 0, 16384].iter().flat_map(|v| v.to_le_bytes()).collect();
    let positions = file.packed("VEC3", 5122, 3, &bytes, true);
    file.root["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = positions.into();
    let expected = [[3.0, 0.0, 0.0], [0.0, -3.0, 0.0], [0.0, 0.0, 3.0 * 16384.0 / 32767.0]];
    assert_near(&pose(&open(&file).unwrap(), 0.0), &expected, "16 bits");
}

#[test]
fn interleaved_values_are_read_by_their_stride() {
    let mut file = one_node(json!({}));
    let bytes: Vec<u8> = (0..16).map(|i| i as f32).flat_map(f32::to_le_bytes).collect();
    let view = file.view(&bytes);
    file.root["bufferViews"][view]["byteStride"] = 16.into();
    let accessor = json!({"bufferView": view, "byteOffset": 4, "componentType": 5126, "type": "VEC3", "count": 4});
    let accessor = file.add("accessors", accessor);
    file.root["meshes"][0]["primitives"][0] = json!({"attributes": {"POSITION": accessor}, "mode": 6});
    let mesh = open(&file).unwrap();
    assert_eq!(pose(&mesh, 0.0), [[1.0, 2.0, 3.0], [5.0, 6.0, 7.0], [9.0, 10.0, 11.0], [13.0, 14.0, 15.0]]);
    assert_eq!(mesh.topology().triangles, [[1, 2, 0], [2, 3, 0]]);
}

#[test]
fn cameras_see_along_their_nodes() {
    let mut file = one_node(json!({"children": [1]}));
    file.add("nodes", json!({"camera": 1, "translation": [0, 0, 5], "scale": [2, 2, 2]}));
    file.root["cameras"] = json!([
        {"type": "orthographic", "orthographic": {"xmag": 1, "ymag": 1, "zfar": 2, "znear": 1}},
        {"type": "perspective", "perspective": {"yfov": 1, "znear": 0.25}},
    ]);
    file.animate(0, "rotation", "LINEAR", &[0.0, 1.0], [about_z(0.0), about_z(FRAC_PI_2)].as_flattened());
    let camera = open(&file).unwrap().camera(1.0).unwrap();
    camera.validate().unwrap();
    assert!((camera.vertical_fov - 1f64.to_degrees()).abs() < 1e-12);
    assert_eq!((camera.near, camera.far), (0.25, f64::INFINITY));
    let [eye, target, up] = [camera.eye, camera.target, camera.up].map(|v| v.as_vec3().to_array());
    assert_near(&[eye, target, up], &[[0.0, 0.0, 5.0], [0.0, 0.0, 4.0], [-1.0, 0.0, 0.0]], "turned");
    file.root["nodes"][1]["camera"] = 0.into();
    let mesh = open(&file).unwrap();
    let camera = mesh.camera(0.0).unwrap();
    assert_eq!((camera.orthographic, camera.near, camera.far), (Some(2.0), 1.0, 2.0));
    assert_eq!(mesh.cameras(), [NamedCamera { name: "0".into(), is_perspective: false }]);
}
