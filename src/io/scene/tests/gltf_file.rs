//! Writes small glTF files.

use std::fs;
use std::path::Path;

use base64::prelude::*;
use serde_json::{Value, json};

/// The parts of a file.
pub(super) struct GltfFile {
    /// Its JSON, but for the buffer.
    pub(super) root: Value,
    /// Its only buffer.
    pub(super) bytes: Vec<u8>,
}

impl GltfFile {
    pub(super) fn new() -> GltfFile {
        let root = json!({
            "asset": {"version": "2.0"}, "accessors": [], "bufferViews": [], "scenes": [{"nodes": [0]}], "scene": 0,
        });
        GltfFile { root, bytes: Vec::new() }
    }

    /// Adds to one of the lists; the number of the new entry.
    pub(super) fn add(&mut self, list: &str, entry: Value) -> usize {
        let list = &mut self.root[list];
        if list.is_null() {
            *list = json!([]);
        }
        let list = list.as_array_mut().unwrap();
        list.push(entry);
        list.len() - 1
    }

    /// Adds a buffer view.
    pub(super) fn view(&mut self, bytes: &[u8]) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let offset = self.bytes.len();
        self.bytes.extend(bytes);
        self.add("bufferViews", json!({"buffer": 0, "byteOffset": offset, "byteLength": bytes.len()}))
    }

    /// Adds an accessor of floats, `SCALAR` to `MAT4`.
    pub(super) fn floats(&mut self, kind: &str, values: &[f32]) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        let width = match kind {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" => 4,
            _ => 16,
        };
        self.packed(kind, 5126, values.len() / width, &bytes, false)
    }

    /// Adds an accessor of that component type.
    pub(super) fn packed(&mut self, kind: &str, component: u32, count: usize, bytes: &[u8], normalized: bool) -> usize {
        let view = self.view(bytes);
        let accessor = json!({
            "bufferView": view, "componentType": component, "type": kind, "count": count, "normalized": normalized,
        });
        self.add("accessors", accessor)
    }

    /// Adds an animation of one property of a node.
    pub(super) fn animate(&mut self, node: usize, path: &str, interpolation: &str, times: &[f32], values: &[f32]) {
        let input = self.floats("SCALAR", times);
        let kind = match path {
            "rotation" => "VEC4",
            "weights" => "SCALAR",
            _ => "VEC3",
        };
        let output = self.floats(kind, values);
        let animation = json!({
            "samplers": [{"input": input, "output": output, "interpolation": interpolation}],
            "channels": [{"sampler": 0, "target": {"node": node, "path": path}}],
        });
        self.add("animations", animation);
    }

    fn text(&self, uri: Option<String>) -> String {
        let mut root = self.root.clone();
        root["buffers"] = json!([{"byteLength": self.bytes.len()}]);
        if let Some(uri) = uri {
            root["buffers"][0]["uri"] = uri.into();
        }
        root.to_string()
    }

    /// Writes it with the buffer as a data URI.
    pub(super) fn write_gltf(&self, path: &Path) {
        let uri = format!("data:application/octet-stream;base64,{}", BASE64_STANDARD.encode(&self.bytes));
        fs::write(path, self.text(Some(uri))).unwrap();
    }

    /// Writes it with the buffer in a file beside it.
    pub(super) fn write_beside(&self, path: &Path, uri: &str, buffer: &str) {
        fs::write(path, self.text(Some(uri.into()))).unwrap();
        fs::write(path.with_file_name(buffer), &self.bytes).unwrap();
    }

    /// The bytes of a `.glb` file.
    pub(super) fn glb(&self) -> Vec<u8> {
        let mut json = self.text(None).into_bytes();
        json.resize(json.len().next_multiple_of(4), b' ');
        let mut binary = self.bytes.clone();
        binary.resize(binary.len().next_multiple_of(4), 0);
        let chunk = |kind: &[u8], data: &[u8]| [&(data.len() as u32).to_le_bytes()[..], kind, data].concat();
        let chunks = [chunk(b"JSON", &json), chunk(b"BIN\0", &binary)].concat();
        let length = 12 + chunks.len() as u32;
        [&b"glTF"[..], &2u32.to_le_bytes(), &length.to_le_bytes(), &chunks].concat()
    }
}
