//! The files that a glTF file refers to, found without reading them.

use std::io::{self, Read};
use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::document::without_ends;
use super::reach::beside;
use crate::io::file;

/// Parts of a glTF file that may be elsewhere.
#[derive(Default, Deserialize)]
#[serde(default)]
struct Root {
    buffers: Vec<Resource>,
    images: Vec<Resource>,
}

#[derive(Default, Deserialize)]
#[serde(default)]
struct Resource {
    uri: Option<String>,
}

/// The buffers and images of the glTF file at `path` that are files which it may name. None where it is no glTF file or
/// cannot be understood, which reading it says.
pub fn references(path: &Path) -> Vec<PathBuf> {
    let is_gltf = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("gltf") || e.eq_ignore_ascii_case("glb"));
    let root = if is_gltf {
        json(path).and_then(|json| Ok(serde_json::from_slice(without_ends(&json))?))
    } else {
        Ok(Root::default())
    };
    let Root { buffers, images } = root.unwrap_or_default();
    let uris = buffers.into_iter().chain(images).filter_map(|resource| resource.uri);
    let files = uris.filter(|uri| !uri.starts_with("data:"));
    files.filter_map(|uri| beside(path, &uri).ok()).collect()
}

/// The JSON of a `.gltf` or `.glb` file.
fn json(path: &Path) -> io::Result<Vec<u8>> {
    let mut file = file::open(path)?;
    let mut json = Vec::new();
    file.by_ref().take(20).read_to_end(&mut json)?;
    match json[..] {
        // Its header, and the length and kind of its first chunk.
        [b'g', b'l', b'T', b'F', _, _, _, _, _, _, _, _, a, b, c, d, ..] => {
            json.clear();
            file.take(u32::from_le_bytes([a, b, c, d]).into()).read_to_end(&mut json)?;
        }
        _ => {
            file.read_to_end(&mut json)?;
        }
    }
    Ok(json)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::tests::Folder;
    use std::fs;

    #[test]
    fn buffers_and_images_beside_the_file_are_found() {
        let folder = Folder::new();
        let json = r#"{"asset": {"version": "2.0"},
            "buffers": [{"byteLength": 4}, {"uri": "a%20b.bin"}, {"uri": "data:;base64,AAAA"}],
            "images": [{"uri": "sub/t.png"}, {"bufferView": 0}, {"uri": "https://example.org/t.png"}]}"#;
        let length = (json.len() as u32).to_le_bytes();
        let glb = [b"glTF\x02\0\0\0\xff\0\0\0", &length[..], b"JSON", json.as_bytes(), b"\x04\0\0\0BIN\0\0\0\0\0"];
        fs::create_dir(folder.0.join("sub")).unwrap();
        let expected = ["a b.bin", "sub/t.png"].map(|name| {
            fs::write(folder.0.join(name), "").unwrap();
            folder.0.canonicalize().unwrap().join(name)
        });
        for (name, bytes) in [("t.gltf", json.as_bytes().to_vec()), ("t.glb", glb.concat())] {
            fs::write(folder.0.join(name), bytes).unwrap();
            assert_eq!(references(&folder.0.join(name)), expected, "{name}");
        }
        fs::write(folder.0.join("wrong.gltf"), "{").unwrap();
        fs::write(folder.0.join("t.npz"), json).unwrap();
        for name in ["wrong.gltf", "t.npz", "none.glb"] {
            assert_eq!(references(&folder.0.join(name)), Vec::<PathBuf>::new(), "{name}");
        }
    }
}
