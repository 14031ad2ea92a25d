//! What a frame's one file for compositing has: the picture, depth, layers that are images, and who is where.
//!
//! Names are those that Nuke, Blender and OpenImageIO take for layers: `smoke_tone.R`, in capitals and with one dot. Colours are
//! half floats; all that is no colour is not.

use std::collections::BTreeMap;

use super::outputs::Frame;
use crate::io::image::Channel;
use crate::program::layers::{Layer, LayerData};

/// Depth where nothing is seen, as Blender writes it: programs that read it do not all know infinity.
const NOTHING: f32 = 1e10;
/// Name of the Cryptomatte layer.
const CRYPTOMATTE: &str = "CryptoObject";

/// Farthest pixel, to each side, whose id ink without one takes.
const INK_REACH: usize = 16;

/// The channels of a frame so wide, and the texts of its header.
pub(super) fn channels(frame: &Frame, width: usize) -> (Vec<Channel>, Vec<(String, String)>) {
    let mut all = colour("", &frame.pixels);
    all.extend(depth(&frame.layers).map(|values| plain("Z".to_owned(), values)));
    all.extend(frame.layers.iter().flat_map(of_layer));
    let (mattes, texts) = cryptomatte(&frame.layers, width);
    all.extend(mattes);
    (all, texts)
}

fn plain(name: String, values: Vec<f32>) -> Channel {
    Channel { name, values, is_half: false }
}

fn colour<const N: usize>(layer: &str, pixels: &[[f32; N]]) -> Vec<Channel> {
    let names = ["R", "G", "B", "A"].into_iter().take(N).enumerate();
    let channel = |(c, name): (usize, &str)| {
        let values = pixels.iter().map(|pixel| pixel[c]).collect();
        Channel { name: format!("{layer}{name}"), values, is_half: true }
    };
    names.map(channel).collect()
}

/// Those of a layer: arrays have none.
fn of_layer(layer: &Layer) -> Vec<Channel> {
    let name = format!("{}.", layer.name.replace('.', "_"));
    match &layer.data {
        LayerData::Value(values) => vec![plain(format!("{name}Y"), values.clone())],
        LayerData::Rgb(pixels) => colour(&name, pixels),
        LayerData::Colour(pixels) => colour(&name, pixels),
        LayerData::Array { .. } => Vec::new(),
    }
}

/// The values of a layer.
fn values<'a>(layers: &'a [Layer], name: &str) -> Option<&'a [f32]> {
    layers.iter().find(|layer| layer.name == name).and_then(|layer| match &layer.data {
        LayerData::Value(values) => Some(&values[..]),
        _ => None,
    })
}

/// The opacity of a layer.
fn alpha(layers: &[Layer], name: &str) -> Option<Vec<f32>> {
    layers.iter().find(|layer| layer.name == name).and_then(|layer| match &layer.data {
        LayerData::Colour(pixels) => Some(pixels.iter().map(|[.., alpha]| *alpha).collect()),
        _ => None,
    })
}

/// View depth of what is nearest, if an effect has such.
fn depth(layers: &[Layer]) -> Option<Vec<f32>> {
    let depths: Vec<&[f32]> = ["smoke.depth", "flame.depth"].iter().filter_map(|name| values(layers, name)).collect();
    let pixels = depths.first()?.len();
    let nearest = |pixel: usize| depths.iter().map(|depth| depth[pixel]).fold(NOTHING, f32::min);
    Some((0..pixels).map(nearest).collect())
}

/// Who is seen in a pixel: a hash of the name, and the share of the pixel.
type Seen = [(u32, f32); 2];

/// Ids and coverage of smoke's groups and of fire, as Cryptomatte 1.2 has them, with the names in the header. None without
/// such.
fn cryptomatte(layers: &[Layer], width: usize) -> (Vec<Channel>, Vec<(String, String)>) {
    let smoke = values(layers, "smoke.id").zip(alpha(layers, "smoke")).zip(values(layers, "smoke.depth"));
    let smoke = smoke.map(|((id, alpha), depth)| ((inked(id, &alpha, width), alpha), depth));
    let flame = alpha(layers, "flame").zip(values(layers, "flame.depth"));
    let pixels = smoke.as_ref().map(|((id, _), _)| id.len()).or(flame.as_ref().map(|(_, depth)| depth.len()));
    let Some(pixels) = pixels else { return Default::default() };
    let mut names: BTreeMap<String, u32> = BTreeMap::new();
    let mut id_of = |name: String| *names.entry(name.clone()).or_insert_with(|| id(&name));
    let seen = |pixel: usize| -> Seen {
        let smoke = smoke.as_ref().map(|((id, alpha), depth)| (id[pixel], alpha[pixel], depth[pixel]));
        let smoke = smoke.filter(|(id, alpha, _)| *id > 0.0 && *alpha > 0.0);
        let flame = flame.as_ref().map(|(alpha, depth)| (alpha[pixel], depth[pixel])).filter(|(alpha, _)| *alpha > 0.0);
        let is_first = smoke.zip(flame).is_none_or(|((.., before), (_, behind))| before <= behind);
        let smoke = smoke.map(|(number, alpha, _)| (id_of(format!("smoke.{number}")), alpha.min(1.0)));
        let flame = flame.map(|(alpha, _)| (id_of("flame".to_owned()), alpha.min(1.0)));
        let [front, behind] = if is_first { [smoke, flame] } else { [flame, smoke] };
        let front = front.unwrap_or_default();
        let behind = behind.map_or((0, 0.0), |(id, alpha)| (id, alpha * (1.0 - front.1)));
        // The largest first; what has no share has no name.
        let mut both = [front, behind].map(|(id, share)| if share > 0.0 { (id, share) } else { (0, 0.0) });
        both.sort_by(|a, b| b.1.total_cmp(&a.1));
        both
    };
    let all: Vec<Seen> = (0..pixels).map(seen).collect();
    let value = |rank: usize, is_share: bool| {
        let of = |seen: &Seen| if is_share { seen[rank].1 } else { f32::from_bits(seen[rank].0) };
        all.iter().map(of).collect::<Vec<f32>>()
    };
    let channels = [("R", 0, false), ("G", 0, true), ("B", 1, false), ("A", 1, true)];
    let channels =
        channels.map(|(name, rank, is_share)| plain(format!("{CRYPTOMATTE}00.{name}"), value(rank, is_share)));
    (channels.into(), texts(&names))
}

/// Ids of smoke, of which ink around it has that of the nearest pixel, by squares around it.
fn inked(ids: &[f32], alpha: &[f32], width: usize) -> Vec<f32> {
    let (columns, rows) = (width.max(1), ids.len() / width.max(1));
    let nearest = |pixel: usize| {
        let (x, y) = (pixel % columns, pixel / columns);
        (1..=INK_REACH).find_map(|reach| {
            let [left, right] = [x.saturating_sub(reach), (x + reach + 1).min(columns)];
            let [above, below] = [y.saturating_sub(reach), (y + reach + 1).min(rows)];
            let around = (above..below).flat_map(|row| (left..right).map(move |column| [column, row]));
            let seen = around.filter(|[column, row]| ids[row * columns + column] > 0.0);
            let nearest = seen.min_by_key(|[column, row]| x.abs_diff(*column).pow(2) + y.abs_diff(*row).pow(2));
            nearest.map(|[column, row]| ids[row * columns + column])
        })
    };
    let is_ink = |pixel: usize| ids[pixel] == 0.0 && alpha[pixel] > 0.0;
    (0..ids.len()).map(|pixel| if is_ink(pixel) { nearest(pixel).unwrap_or(0.0) } else { ids[pixel] }).collect()
}

fn texts(names: &BTreeMap<String, u32>) -> Vec<(String, String)> {
    // The specification's own way to tell the layers of a file apart.
    let key = &format!("{:08x}", murmur(CRYPTOMATTE.as_bytes()))[..7];
    let manifest: BTreeMap<&str, String> = names.iter().map(|(name, id)| (&name[..], format!("{id:08x}"))).collect();
    let manifest = serde_json::to_string(&manifest).unwrap_or_default();
    let texts = [
        ("name", CRYPTOMATTE.to_owned()),
        ("hash", "MurmurHash3_32".to_owned()),
        ("conversion", "uint32_to_float32".to_owned()),
        ("manifest", manifest),
    ];
    texts.map(|(what, text)| (format!("cryptomatte/{key}/{what}"), text)).into()
}

/// The bits of a name's id: its hash, changed so that they are a float that is neither 0, denormal, infinite nor NaN.
fn id(name: &str) -> u32 {
    let hash = murmur(name.as_bytes());
    let exponent = hash >> 23 & 255;
    if exponent == 0 || exponent == 255 { hash ^ 1 << 23 } else { hash }
}

/// MurmurHash3, x86, 32 bits, seed 0 (Appleby, public domain).
fn murmur(bytes: &[u8]) -> u32 {
    let mixed = |block: u32| block.wrapping_mul(0xcc9e_2d51).rotate_left(15).wrapping_mul(0x1b87_3593);
    let (blocks, rest) = bytes.as_chunks::<4>();
    let mut hash = blocks.iter().fold(0_u32, |hash, block| {
        (hash ^ mixed(u32::from_le_bytes(*block))).rotate_left(13).wrapping_mul(5).wrapping_add(0xe654_6b64)
    });
    if !rest.is_empty() {
        let block = rest.iter().rev().fold(0, |block, byte| block << 8 | u32::from(*byte));
        hash ^= mixed(block);
    }
    hash ^= bytes.len() as u32;
    hash = (hash ^ hash >> 16).wrapping_mul(0x85eb_ca6b);
    hash = (hash ^ hash >> 13).wrapping_mul(0xc2b2_ae35);
    hash ^ hash >> 16
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ink_around_smoke_is_of_the_nearest_group() {
        let ids = [0.0, 0.0, 3.0, 0.0, 0.0, 0.0, 0.0, 5.0, 0.0, 0.0];
        let alpha = [0.0, 1.0, 1.0, 0.5, 1.0, 0.0, 0.0, 1.0, 1.0, 1.0];
        assert_eq!(inked(&ids, &alpha, 5), [0.0, 3.0, 3.0, 3.0, 3.0, 0.0, 0.0, 5.0, 5.0, 5.0]);
    }

    #[test]
    fn names_are_hashed_as_cryptomatte_does() {
        // Of the reference implementation, and the specification's examples.
        for (name, expected) in [("", 0), ("hello", 0x248b_fa47), ("hello, world", 0x149b_bb7f)] {
            assert_eq!(murmur(name.as_bytes()), expected, "{name}");
        }
        assert!((0..100_000).all(|i| f32::from_bits(id(&format!("smoke.{i}"))).is_normal()));
    }

    fn frame(layers: Vec<Layer>) -> Frame {
        let pixels = vec![[0.25, 0.5, 0.75, 1.0]; 3];
        Frame { layers, pixels, ..Frame::of_nothing(1) }
    }

    #[test]
    fn layers_are_named_as_compositors_name_them() {
        let layers = vec![
            Layer { name: "smoke.outline.inner", data: LayerData::Value(vec![0.5; 3]) },
            Layer { name: "flame.mean", data: LayerData::Rgb(vec![[0.25; 3]; 3]) },
            Layer { name: "smoke.spheres", data: LayerData::table(5, vec![0.5; 10]) },
        ];
        let (channels, texts) = channels(&frame(layers), 3);
        let names: Vec<(&str, bool)> = channels.iter().map(|channel| (&channel.name[..], channel.is_half)).collect();
        let colours = ["R", "G", "B", "A", "flame_mean.R", "flame_mean.G", "flame_mean.B"].map(|name| (name, true));
        let expected = [&colours[..4], &[("smoke_outline_inner.Y", false)], &colours[4..]].concat();
        assert_eq!((names, texts.len()), (expected, 0));
    }

    #[test]
    fn a_pixel_s_shares_are_those_of_what_is_before_and_behind() {
        let colour = |alphas: [f32; 3]| LayerData::Colour(alphas.map(|alpha| [0.0, 0.0, 0.0, alpha]).into());
        let layers = vec![
            Layer { name: "smoke.id", data: LayerData::Value(vec![2.0, 2.0, 0.0]) },
            Layer { name: "smoke.depth", data: LayerData::Value(vec![3.0, 3.0, f32::INFINITY]) },
            Layer { name: "smoke", data: colour([0.25, 1.0, 0.0]) },
            Layer { name: "flame", data: colour([0.5, 0.5, 0.0]) },
            Layer { name: "flame.depth", data: LayerData::Value(vec![4.0, 2.0, f32::INFINITY]) },
        ];
        let (channels, texts) = channels(&frame(layers), 3);
        let of = |name: &str| &channels.iter().find(|channel| channel.name == name).expect(name).values[..];
        assert_eq!(of("Z"), [3.0, 2.0, NOTHING]);
        let [smoke, flame] = ["smoke.2", "flame"].map(|name| f32::from_bits(id(name)));
        // Fire behind a quarter of smoke has more; before smoke, half of it.
        assert_eq!([of("CryptoObject00.R"), of("CryptoObject00.B")], [[flame, flame, 0.0], [smoke, smoke, 0.0]]);
        assert_eq!([of("CryptoObject00.G"), of("CryptoObject00.A")], [[0.375, 0.5, 0.0], [0.25, 0.5, 0.0]]);
        let manifest = texts.iter().find(|(name, _)| name.ends_with("/manifest")).expect("names");
        assert_eq!(manifest.1, format!("{{\"flame\":\"{:08x}\",\"smoke.2\":\"{:08x}\"}}", id("flame"), id("smoke.2")));
        assert!(
            texts.iter().all(|(name, _)| name.starts_with("cryptomatte/")
                && name.split('/').nth(1).is_some_and(|key| key.len() == 7))
        );
    }
}
