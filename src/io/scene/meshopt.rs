//! `EXT_meshopt_compression` and `KHR_meshopt_compression`: buffer views whose bytes are compressed.

use ::meshopt::{decode_filter_color, decode_filter_exp, decode_filter_oct, decode_filter_quat};
use ::meshopt::{decode_index_buffer, decode_index_sequence, ffi};
use bytemuck::{cast_slice, cast_slice_mut};

use super::json::Compressed;

/// Why bytes could not be unpacked, and what would have been right.
pub(super) type Fault = (String, &'static str);

const WHOLE: &str = "whole data of that mode, count and stride";

/// The bytes of a buffer view that is compressed into these, whose size is within memory.
pub(super) fn unpack(bytes: &[u8], compressed: &Compressed) -> Result<Vec<u8>, Fault> {
    let (count, stride) = (compressed.count.0 as usize, compressed.byte_stride.0 as usize);
    let filter = compressed.filter.as_deref().filter(|filter| *filter != "NONE");
    match (&compressed.mode[..], filter) {
        ("ATTRIBUTES", filter) => attributes(bytes, count, stride, filter),
        ("TRIANGLES" | "INDICES", Some(filter)) => Err((format!("has indices with a filter, `{filter}`"), "no filter")),
        ("TRIANGLES", None) => triangles(bytes, count, stride),
        ("INDICES", None) => indices(bytes, count, stride),
        (mode, _) => Err((format!("has the mode `{mode}`"), "ATTRIBUTES, TRIANGLES or INDICES")),
    }
}

fn attributes(bytes: &[u8], count: usize, stride: usize, filter: Option<&str>) -> Result<Vec<u8>, Fault> {
    if stride == 0 || stride > 256 || !stride.is_multiple_of(4) {
        return Err((format!("has values of {stride} bytes"), "a multiple of 4, at most 256"));
    }
    let mut words = vec![0u32; count * (stride / 4)];
    // SAFETY: `words` has room for `count` values of `stride` bytes, a multiple of 4 of at most 256, as the decoder
    // demands; of `bytes` it reads as many as it is told, whatever they are.
    let code = unsafe {
        ffi::meshopt_decodeVertexBuffer(words.as_mut_ptr().cast(), count, stride, bytes.as_ptr(), bytes.len())
    };
    if code != 0 {
        return Err(("cannot be decompressed".to_owned(), WHOLE));
    }
    match (filter, stride) {
        (None, _) => {}
        (Some("OCTAHEDRAL"), 4) => decode_filter_oct::<i8>(cast_slice_mut(&mut words)),
        (Some("OCTAHEDRAL"), 8) => decode_filter_oct::<i16>(cast_slice_mut(&mut words)),
        (Some("QUATERNION"), 8) => decode_filter_quat(cast_slice_mut(&mut words)),
        (Some("EXPONENTIAL"), _) => decode_filter_exp::<1>(cast_slice_mut(&mut words)),
        (Some("COLOR"), 4) => decode_filter_color::<u8>(cast_slice_mut(&mut words)),
        (Some("COLOR"), 8) => decode_filter_color::<u16>(cast_slice_mut(&mut words)),
        (Some(filter), _) => {
            let expected = "OCTAHEDRAL or COLOR of 4 or 8, QUATERNION of 8, or EXPONENTIAL";
            return Err((format!("has the filter `{filter}` of {stride} bytes"), expected));
        }
    }
    Ok(cast_slice(&words).to_vec())
}

fn triangles(bytes: &[u8], count: usize, stride: usize) -> Result<Vec<u8>, Fault> {
    let fault = |_| ("cannot be decompressed".to_owned(), WHOLE);
    match stride {
        _ if !count.is_multiple_of(3) => Err((format!("has {count} corners of triangles"), "a multiple of three")),
        2 => decode_index_buffer::<u16>(bytes, count).map(|indices| cast_slice(&indices).to_vec()).map_err(fault),
        4 => decode_index_buffer::<u32>(bytes, count).map(|indices| cast_slice(&indices).to_vec()).map_err(fault),
        _ => Err((format!("has indices of {stride} bytes"), "2 or 4")),
    }
}

fn indices(bytes: &[u8], count: usize, stride: usize) -> Result<Vec<u8>, Fault> {
    let fault = |_| ("cannot be decompressed".to_owned(), WHOLE);
    match stride {
        2 => decode_index_sequence::<u16>(bytes, count).map(|indices| cast_slice(&indices).to_vec()).map_err(fault),
        4 => decode_index_sequence::<u32>(bytes, count).map(|indices| cast_slice(&indices).to_vec()).map_err(fault),
        _ => Err((format!("has indices of {stride} bytes"), "2 or 4")),
    }
}
