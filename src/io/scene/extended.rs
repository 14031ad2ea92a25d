//! What extensions say in a glTF file's JSON, as far as the crate's model of it leaves them out.

use std::collections::BTreeMap;
use std::path::Path;

use serde::Deserialize;

use super::document::json_error;
use crate::io::ReadError;

/// Extensions of a file's nodes, buffers and buffer views, in the order of these.
#[derive(Debug, Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub(super) struct Extensions {
    pub(super) nodes: Vec<Entry<NodeExtensions>>,
    pub(super) buffers: Vec<Entry<BufferExtensions>>,
    pub(super) buffer_views: Vec<Entry<ViewExtensions>>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Entry<E> {
    pub(super) extensions: E,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct NodeExtensions {
    #[serde(rename = "EXT_mesh_gpu_instancing")]
    pub(super) instancing: Option<Instancing>,
}

/// `EXT_mesh_gpu_instancing`: accessors by name, of one value an instance.
#[derive(Debug, Deserialize)]
pub(super) struct Instancing {
    pub(super) attributes: BTreeMap<String, u32>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct BufferExtensions {
    #[serde(rename = "KHR_meshopt_compression")]
    khr: Fallback,
    #[serde(rename = "EXT_meshopt_compression")]
    ext: Fallback,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct Fallback {
    fallback: bool,
}

impl BufferExtensions {
    /// Whether the buffer is for readers that cannot decompress.
    pub(super) fn is_fallback(&self) -> bool {
        self.khr.fallback || self.ext.fallback
    }
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct ViewExtensions {
    #[serde(rename = "KHR_meshopt_compression")]
    khr: Option<Compressed>,
    #[serde(rename = "EXT_meshopt_compression")]
    ext: Option<Compressed>,
}

impl ViewExtensions {
    /// How the view is compressed, if it is; the extension has two names.
    pub(super) fn compressed(&self) -> Option<&Compressed> {
        self.khr.as_ref().or(self.ext.as_ref())
    }
}

/// `EXT_meshopt_compression`: where the compressed bytes are, and what they become.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Compressed {
    pub(super) buffer: usize,
    #[serde(default)]
    pub(super) byte_offset: u64,
    pub(super) byte_length: u64,
    pub(super) byte_stride: u64,
    pub(super) count: u64,
    pub(super) mode: String,
    pub(super) filter: Option<String>,
}

impl Extensions {
    pub(super) fn read(path: &Path, json: &[u8]) -> Result<Extensions, ReadError> {
        serde_json::from_slice(json).map_err(|error| json_error(path, error))
    }
}
