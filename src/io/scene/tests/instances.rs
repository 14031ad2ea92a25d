//! `EXT_mesh_gpu_instancing`.

use super::faults::{error_after, says};
use super::*;

/// [`one_node`] of these instances.
fn instanced(attributes: impl FnOnce(&mut GltfFile) -> Value, node: Value) -> GltfFile {
    let mut file = one_node(node);
    let attributes = attributes(&mut file);
    file.root["nodes"][0]["extensions"] = json!({"EXT_mesh_gpu_instancing": {"attributes": attributes}});
    file
}

/// A triangle's corners at that place.
fn at([x, y, z]: [f64; 3]) -> [[f64; 3]; 3] {
    [[x + 1.0, y, z], [x, y + 1.0, z], [x, y, z + 1.0]]
}

#[test]
fn each_instance_is_an_object_where_it_says() {
    let translation = [0.0, 0.0, 0.0, 5.0, 0.0, 0.0, 0.0, -7.0, 0.0];
    let translations = |file: &mut GltfFile| json!({"TRANSLATION": file.floats("VEC3", &translation), "_ID": 0});
    let mut file = instanced(translations, json!({"name": "tree", "translation": [0, 0, 2]}));
    for required in [json!([]), json!(["EXT_mesh_gpu_instancing"])] {
        file.root["extensionsRequired"] = required;
        let mesh = open(&file).unwrap();
        let expected = [[0.0, 0.0, 2.0], [5.0, 0.0, 2.0], [0.0, -7.0, 2.0]].map(at).concat();
        assert_near(&pose(&mesh, 0.0), &expected, "instances");
        assert_eq!(mesh.topology().objects, ["tree 0", "tree 1", "tree 2"]);
        assert_eq!(mesh.topology().object, [0, 0, 0, 1, 1, 1, 2, 2, 2]);
        assert_eq!(mesh.topology().triangles, [[0, 1, 2], [3, 4, 5], [6, 7, 8]]);
    }
}

#[test]
fn instances_are_scaled_then_turned_then_moved_below_their_node() {
    // A quarter about z of (1, 0, 0) is (0, 1, 0).
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let of_byte = |x: f32| (x * 127.0).round() as i8 as u8;
    let of_short = |x: f32| ((x * 32767.0).round() as i16).to_le_bytes();
    let quarter = [0.0, 0.0, half, half];
    let shorts: Vec<u8> = quarter.iter().flat_map(|&x| of_short(x)).collect();
    type Rotation<'a> = &'a dyn Fn(&mut GltfFile) -> usize;
    let rotations: [Rotation; 3] = [
        &|file| file.floats("VEC4", &quarter),
        &|file| file.packed("VEC4", 5120, 1, &quarter.map(of_byte), true),
        &|file| file.packed("VEC4", 5122, 1, &shorts, true),
    ];
    for rotation in rotations {
        let attributes = |file: &mut GltfFile| {
            let (translation, scale) = (file.floats("VEC3", &[10.0, 0.0, 0.0]), file.floats("VEC3", &[2.0, 3.0, 4.0]));
            json!({"TRANSLATION": translation, "ROTATION": rotation(file), "SCALE": scale})
        };
        let file = instanced(attributes, json!({"translation": [0, 0, 1]}));
        let expected = [[10.0, 2.0, 1.0], [7.0, 0.0, 1.0], [10.0, 0.0, 5.0]];
        assert_near(&pose(&open(&file).unwrap(), 0.0), &expected, "all three");
        let file = instanced(|file| json!({"ROTATION": rotation(file)}), json!({}));
        assert_near(&pose(&open(&file).unwrap(), 0.0), &[[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]], "turned");
    }
    let mut file = instanced(|file| json!({"SCALE": file.floats("VEC3", &[2.0, 2.0, 2.0])}), json!({}));
    assert_near(&pose(&open(&file).unwrap(), 0.0), &[[2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0]], "scaled");
    // They follow the node's animation.
    file.animate(0, "translation", "LINEAR", &[0.0, 1.0], &[0.0, 0.0, 0.0, 4.0, 0.0, 0.0]);
    assert_near(&pose(&open(&file).unwrap(), 0.5)[..1], &[[4.0, 0.0, 0.0]], "animated");
}

#[test]
fn a_mirrored_instance_has_its_triangles_turned_over() {
    let scale = [1.0, 1.0, 1.0, -1.0, 1.0, 1.0];
    let mesh = open(&instanced(|file| json!({"SCALE": file.floats("VEC3", &scale)}), json!({}))).unwrap();
    assert_eq!(mesh.topology().triangles, [[0, 1, 2], [3, 5, 4]]);
}

#[test]
fn a_node_without_attributes_or_with_a_skin_shows_its_mesh_once() {
    assert_eq!(open(&instanced(|_| json!({}), json!({}))).unwrap().topology().objects, ["node 0"]);
    let mut file = instanced(|file| json!({"TRANSLATION": file.floats("VEC3", &[0.0; 6])}), json!({"skin": 0}));
    file.root["skins"] = json!([{"joints": [0]}]);
    let mesh = open(&file).unwrap();
    assert_eq!(mesh.vertices(), 3);
    assert_eq!(notes(&mesh), ["node 0 has instances and a skin: it is drawn once"]);
}

#[test]
fn faults_of_instances_are_named() {
    let fault = |attributes: fn(&mut GltfFile) -> Value| {
        error_after(|file| {
            let attributes = attributes(file);
            file.root["nodes"][0]["extensions"] = json!({"EXT_mesh_gpu_instancing": {"attributes": attributes}});
        })
    };
    says(
        fault(|f| json!({"TRANSLATION": f.floats("VEC3", &[0.0; 6]), "SCALE": f.floats("VEC3", &[1.0; 9])})),
        &["node 0, its instances: has ", "another", "as many of each"],
    );
    says(fault(|_| json!({"TRANSLATION": 9})), &["no accessor 9"]);
    says(fault(|f| json!({"ROTATION": f.floats("VEC3", &[0.0; 6])})), &["is of Vec3; expected Vec4"]);
}
