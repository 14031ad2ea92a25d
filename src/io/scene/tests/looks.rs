//! The constant part of a mesh: triangles, colours, normals, and which vertices are one.

use std::io::Cursor;

use super::*;
use crate::blur::{Texture, Wrap};

#[test]
fn strips_and_fans_are_taken_apart() {
    let triangles = |mode: u32, indices: Option<(u32, Vec<u8>)>| {
        let mut file = GltfFile::new();
        let positions = file.floats("VEC3", &[0.0; 15]);
        let mut primitive = json!({"attributes": {"POSITION": positions}, "mode": mode});
        if let Some((component, bytes)) = indices {
            let size = [1, 0, 2, 0, 4][component as usize - 5121];
            primitive["indices"] = file.packed("SCALAR", component, bytes.len() / size, &bytes, false).into();
        }
        file.root["meshes"] = json!([{"primitives": [primitive]}]);
        file.root["nodes"] = json!([{"mesh": 0}]);
        open(&file).map(|mesh| mesh.topology().triangles.clone()).map_err(|error| error.to_string())
    };
    let u16s = |values: &[u16]| values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<_>>();
    let u32s = |values: &[u32]| values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<_>>();
    assert_eq!(triangles(5, None).unwrap(), [[0, 1, 2], [1, 3, 2], [2, 3, 4]]);
    assert_eq!(triangles(6, None).unwrap(), [[1, 2, 0], [2, 3, 0], [3, 4, 0]]);
    assert_eq!(triangles(4, Some((5121, vec![4, 2, 0]))).unwrap(), [[4, 2, 0]]);
    assert_eq!(triangles(5, Some((5123, u16s(&[4, 3, 2, 1])))).unwrap(), [[4, 3, 2], [3, 1, 2]]);
    assert_eq!(triangles(6, Some((5125, u32s(&[4, 3, 2, 1])))).unwrap(), [[3, 2, 4], [2, 1, 4]]);
    let error = triangles(4, Some((5121, vec![0, 1, 2, 0, 5, 1]))).unwrap_err();
    assert!(error.contains("mesh 0, primitive 0: index 4 is vertex 5") && error.contains("below 5"), "{error}");
    assert!(triangles(1, None).unwrap_err().contains("no triangles"));
    assert!(triangles(7, None).unwrap_err().contains("unknown mode"));
}

#[test]
fn points_and_lines_are_passed_over_with_a_note() {
    let mut file = one_node(json!({}));
    file.root["meshes"][0]["primitives"].as_array_mut().unwrap().extend([
        json!({"attributes": {"POSITION": 0}, "mode": 1}),
        json!({"attributes": {}}),
        json!({"attributes": {"POSITION": 0, "_TEMPERATURE": 0}}),
    ]);
    let mesh = open(&file).unwrap();
    assert_eq!((mesh.vertices(), mesh.topology().objects.len()), (6, 1));
    assert_eq!(mesh.topology().triangles, [[0, 1, 2], [3, 4, 5]]);
    let [lines, empty] = notes(&mesh)[..] else { panic!("{:?}", mesh.notes()) };
    assert!(lines.contains("mesh 0, primitive 1") && lines.contains("lines"), "{lines}");
    assert!(empty.contains("mesh 0, primitive 2") && empty.contains("no positions"), "{empty}");
}

/// A picture of 2 x 2 texels: red, green; blue, white.
pub(super) fn picture(format: image::ImageFormat) -> Vec<u8> {
    let texels = image::RgbImage::from_raw(2, 2, vec![255, 0, 0, 0, 188, 0, 0, 0, 255, 255, 255, 255]).unwrap();
    let mut bytes = Cursor::new(Vec::new());
    texels.write_to(&mut bytes, format).unwrap();
    bytes.into_inner()
}

/// [`one_node`] in a material of a factor, and three texture coordinates.
pub(super) fn textured(image: Vec<u8>) -> GltfFile {
    let mut file = one_node(json!({}));
    let coordinates = file.floats("VEC2", &[0.75, 0.25, 1.2, 0.9, 0.9, 0.6]);
    file.root["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_1"] = coordinates.into();
    file.root["meshes"][0]["primitives"][0]["material"] = 0.into();
    let view = file.view(&image);
    file.root["images"] = json!([{"bufferView": view, "mimeType": "image/png"}]);
    file.root["textures"] = json!([{"source": 0}]);
    let texture = json!({"index": 0, "texCoord": 1});
    let pbr = json!({"baseColorFactor": [0.5, 1, 0.25, 1], "baseColorTexture": texture});
    file.root["materials"] = json!([{"pbrMetallicRoughness": pbr, "doubleSided": true}]);
    file
}

/// A texel of a texture at a place, the nearest, in linear light.
fn texel(texture: &Texture, place: [f32; 2]) -> [f32; 3] {
    let at = [0, 1].map(|axis| {
        let size = texture.size[axis];
        let within = match texture.wrap[axis] {
            Wrap::Clamp => place[axis],
            Wrap::Mirror => 1.0 - ((place[axis]).rem_euclid(2.0) - 1.0).abs(),
            Wrap::Repeat => place[axis].rem_euclid(1.0),
        };
        ((within * size as f32) as u32).min(size - 1)
    });
    let texel = texture.texels[(at[1] * texture.size[0] + at[0]) as usize];
    texel.map(|c| crate::io::image::linear_from_srgb(f64::from(c) / 255.0) as f32)
}

/// Colours of vertices, each times its texture there.
fn assert_colours(mesh: &AnimatedMesh, expected: [[f32; 3]; 3], within: f32) {
    let topology = mesh.topology();
    let seen = |vertex: usize| {
        let texture = topology.texture[vertex].map(|number| &topology.textures[number as usize]);
        let painted = texture.map_or([1.0; 3], |texture| texel(texture, topology.texture_place[vertex]));
        [0, 1, 2].map(|c| topology.colour[vertex][c] * painted[c])
    };
    let found: Vec<[f32; 3]> = (0..topology.colour.len()).map(seen).collect();
    let near = |i: usize, c: usize| (found[i][c] - expected[i][c]).abs() <= within;
    assert!((0..3).all(|i| (0..3).all(|c| near(i, c))), "{found:?} is not {expected:?}");
}

#[test]
fn colours_are_those_of_material_vertex_and_texture() {
    let plain = open(&one_node(json!({}))).unwrap();
    assert_eq!((&plain.topology().colour[..], &plain.topology().double_sided[..]), (&[[1.0; 3]; 3][..], &[false][..]));
    let mut file = textured(picture(image::ImageFormat::Png));
    let green = 0.502_886_5;
    let expected = [[0.0, green, 0.0], [0.0, 0.0, 0.25], [0.5, 1.0, 0.25]];
    let mesh = open(&file).unwrap();
    assert_colours(&mesh, expected, 1e-6);
    assert_eq!(mesh.topology().double_sided, [true]);
    // The second coordinate lies beyond the edge, the third is moved to the first texel.
    file.root["samplers"] = json!([{"wrapS": 33071, "wrapT": 33071}]);
    file.root["textures"][0]["sampler"] = 0.into();
    let info = &mut file.root["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"];
    info["extensions"] = json!({"KHR_texture_transform": {"offset": [0, -0.5], "texCoord": 1}});
    let colours = file.packed("VEC4", 5121, 3, &[[255, 255, 255, 0], [0, 255, 0, 9], [51, 0, 0, 0]].concat(), true);
    file.root["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = colours.into();
    assert_colours(&open(&file).unwrap(), [[0.0, green, 0.0], [0.0, green, 0.0], [0.0; 3]], 1e-6);
}

#[test]
fn jpeg_textures_and_broken_ones() {
    let noisy = [[0.0, 0.5, 0.0], [0.0, 0.0, 0.25], [0.5, 1.0, 0.25]];
    let flat = image::RgbImage::from_pixel(8, 8, image::Rgb([188, 188, 188]));
    let mut bytes = Cursor::new(Vec::new());
    flat.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
    assert_colours(&open(&textured(bytes.into_inner())).unwrap(), [[0.2514, 0.5029, 0.1257]; 3], 1e-3);
    assert_colours(&open(&textured(picture(image::ImageFormat::Png))).unwrap(), noisy, 0.01);
    let mut broken = textured(b"no picture".to_vec());
    let mesh = open(&broken).unwrap();
    assert_eq!(mesh.topology().colour, [[0.5, 1.0, 0.25]; 3]);
    let [note] = mesh.notes() else { panic!("{:?}", mesh.notes()) };
    assert!(note.text.contains("image 0") && note.text.contains("the texture is left out") && note.looks, "{note:?}");
    broken.root["images"] = json!([{"uri": "nowhere.png"}]);
    let mesh = open(&broken).unwrap();
    assert!(mesh.notes()[0].text.contains("nowhere.png"), "{:?}", mesh.notes());
    // The smallest JPEG picture that decoders take: one of 1 x 1, mid-grey.
    let grey = textured(GREY_JPEG.to_vec());
    assert_colours(&open(&grey).unwrap(), [[0.108, 0.216, 0.054]; 3], 0.01);
}

/// A JPEG picture of one pixel, sRGB 128.
const GREY_JPEG: [u8; 159] = [
    0xff, 0xd8, 0xff, 0xe0, 0x00, 0x10, 0x4a, 0x46, 0x49, 0x46, 0x00, 0x01, 0x01, 0x00, 0x00, 0x01, 0x00, 0x01, 0x00,
    0x00, 0xff, 0xdb, 0x00, 0x43, 0x00, 0x10, 0x0b, 0x0c, 0x0e, 0x0c, 0x0a, 0x10, 0x0e, 0x0d, 0x0e, 0x12, 0x11, 0x10,
    0x13, 0x18, 0x28, 0x1a, 0x18, 0x16, 0x16, 0x18, 0x31, 0x23, 0x25, 0x1d, 0x28, 0x3a, 0x33, 0x3d, 0x3c, 0x39, 0x33,
    0x38, 0x37, 0x40, 0x48, 0x5c, 0x4e, 0x40, 0x44, 0x57, 0x45, 0x37, 0x38, 0x50, 0x6d, 0x51, 0x57, 0x5f, 0x62, 0x67,
    0x68, 0x67, 0x3e, 0x4d, 0x71, 0x79, 0x70, 0x64, 0x78, 0x5c, 0x65, 0x67, 0x63, 0xff, 0xc0, 0x00, 0x0b, 0x08, 0x00,
    0x01, 0x00, 0x01, 0x01, 0x01, 0x11, 0x00, 0xff, 0xc4, 0x00, 0x14, 0x00, 0x01, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
    0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0xff, 0xc4, 0x00, 0x14, 0x10, 0x01, 0x00, 0x00, 0x00,
    0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0xff, 0xda, 0x00, 0x08, 0x01, 0x01,
    0x00, 0x00, 0x3f, 0x00, 0x3f, 0xff, 0xd9,
];

#[test]
fn vertices_that_are_always_at_one_place_are_one() {
    // The second and fourth part in the second frame, the third is of another object, -0 is 0.
    let first = vec![[0.0, 1.0, 2.0], [1.0, 0.0, 0.0], [0.0, 1.0, 2.0], [1.0, 0.0, 0.0], [-0.0, 1.0, 2.0]];
    let mut second = vec![[5.0; 3]; 5];
    second[3] = [5.0, 5.0, 5.000_001];
    let object = [0, 0, 7, 0, 0];
    assert_eq!(weld(&object, &[]), [0, 0, 1, 0, 0]);
    assert_eq!(weld(&object, std::slice::from_ref(&first)), [0, 1, 2, 1, 0]);
    assert_eq!(weld(&object, &[first.clone(), second.clone()]), [0, 1, 2, 3, 0]);
    assert_eq!(weld(&object, &[second, first]), [0, 1, 2, 3, 0]);
    assert_eq!(weld(&[], &[]), [0u32; 0]);
}

#[test]
fn smooth_edges_share_a_normal_and_hard_ones_do_not() {
    // Two triangles that share an edge, each with vertices of its own, at an angle between them.
    let sheet = |degrees: f32, normals: [[f32; 3]; 2]| {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let (a, b) = ([0.0, 0.0, 0.0], [0.0, 0.0, 1.0]);
        let rest = vec![[1.0, 0.0, 0.0], a, b, [-cos, sin, 0.0], b, a];
        let topology = Topology {
            triangles: vec![[0, 1, 2], [3, 4, 5]],
            object: vec![0; 6],
            normal: [[normals[0]; 3], [normals[1]; 3]].concat(),
            ..Topology::default()
        };
        let points = weld(&topology.object, std::slice::from_ref(&rest));
        assert_eq!(points, [0, 1, 2, 3, 2, 1]);
        shading_groups(&topology, &points, &rest)
    };
    let none = [[0.0; 3]; 2];
    assert_eq!(sheet(39.0, none), [0, 1, 2, 3, 2, 1]);
    assert_eq!(sheet(41.0, none), [0, 1, 2, 3, 4, 5]);
    assert_eq!(sheet(80.0, [[0.0, 1.0, 0.0]; 2]), [0, 1, 2, 3, 2, 1]);
    assert_eq!(sheet(10.0, [[0.0, 1.0, 0.0], [0.1, 1.0, 0.0]]), [0, 1, 2, 3, 4, 5]);
}

#[test]
fn an_object_can_be_taken_away() {
    let mesh = AnimatedMesh::builtin(Builtin::Crossing, 300, SECONDS);
    let whole = mesh.topology();
    let rear = whole.without(0);
    assert_eq!((rear.object.len(), rear.colour.len()), (whole.object.len(), whole.colour.len()));
    assert!(rear.triangles.iter().flatten().all(|&corner| rear.object[corner as usize] == 1));
    assert_eq!(rear.triangles.len() + whole.without(1).triangles.len(), whole.triangles.len());
}
