//! Shares of strength: of vertices, of names, painted.

use super::looks::{picture, textured};
use super::*;

fn shares(mesh: &AnimatedMesh) -> Vec<f32> {
    mesh.topology().share.clone()
}

#[test]
fn vertices_say_their_share() {
    assert_eq!(shares(&open(&one_node(json!({}))).unwrap()), [1.0; 3]);
    let with = |values: &[f32]| {
        let mut file = one_node(json!({}));
        let accessor = file.floats("SCALAR", values);
        file.root["meshes"][0]["primitives"][0]["attributes"]["_SMEAR"] = accessor.into();
        open(&file)
    };
    assert_eq!(shares(&with(&[0.0, 0.25, 1.0]).unwrap()), [0.0, 0.25, 1.0]);
    for (values, why) in [(&[0.0, 1.5, 1.0][..], "vertex 1 has _SMEAR 1.5"), (&[1.0; 2], "has 2 values of _SMEAR")] {
        let error = with(values).unwrap_err().to_string();
        assert!(error.contains("mesh 0, primitive 0") && error.contains(why), "{error}");
    }
}

#[test]
fn objects_and_materials_have_shares_by_name() {
    let mut file = textured(picture(image::ImageFormat::Png));
    file.root["materials"][0]["name"] = json!("skin");
    file.root["nodes"][0]["name"] = json!("Head");
    let named = |names: &[(&str, f32)]| {
        let mut mesh = open(&file).unwrap();
        let names: Vec<(String, f32)> = names.iter().map(|(name, share)| ((*name).to_owned(), *share)).collect();
        mesh.share_strength(&names).map(|()| shares(&mesh))
    };
    assert_eq!(named(&[]).unwrap(), [1.0; 3]);
    assert_eq!(named(&[("Head", 0.5)]).unwrap(), [0.5; 3]);
    assert_eq!(named(&[("skin", 0.5), ("Head", 0.5)]).unwrap(), [0.25; 3]);
    let error = named(&[("Heat", 0.5)]).unwrap_err().to_string();
    assert!(
        error.contains("nothing is called `Heat`") && error.contains("`Head`") && error.contains("`skin`"),
        "{error}"
    );
}

#[test]
fn a_picture_is_painted_on_texture_coordinates() {
    let folder = Folder::new();
    let path = folder.0.join("smear.png");
    let greys = image::GrayImage::from_raw(2, 2, vec![255, 51, 102, 0]).unwrap();
    greys.save(&path).unwrap();
    let mut file = textured(picture(image::ImageFormat::Png));
    let error = open(&file).unwrap().paint_strength(&path).unwrap_err().to_string();
    assert!(error.contains("no texture coordinates"), "{error}");
    let attributes = &mut file.root["meshes"][0]["primitives"][0]["attributes"];
    attributes["TEXCOORD_0"] = attributes["TEXCOORD_1"].take();
    attributes.as_object_mut().unwrap().remove("TEXCOORD_1");
    file.root["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["texCoord"] = 0.into();
    let mut mesh = open(&file).unwrap();
    mesh.paint_strength(&path).unwrap();
    // At (0.75, 0.25), (1.2, 0.9), (0.9, 0.6): grey as it is painted, not as light.
    for (found, expected) in shares(&mesh).iter().zip([0.2, 0.4, 0.0]) {
        assert!((found - expected).abs() < 1e-3, "{found} {expected}");
    }
    assert!(mesh.paint_strength(&folder.0.join("none.png")).is_err());
}
