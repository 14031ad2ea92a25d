//! What a frame's one file for compositing has: the picture, depth, layers that are images, and who is where.
//!
//! Names are those that Nuke, Blender and OpenImageIO take for layers: `smoke_tone.R`, in capitals and with one dot. Colours are
//! half floats; all that is no colour is not.

use std::collections::BTreeMap;

use crate::io::image::Channel;
use crate::program::EFFECTS;
use crate::program::layers::{Layer, LayerData, Shown, Who};

/// Depth where nothing is seen, as Blender writes it: programs that read it do not all know infinity.
const NOTHING: f32 = 1e10;
/// Name of the Cryptomatte layer.
const CRYPTOMATTE: &str = "CryptoObject";
/// Farthest pixel, to each side, whose place ink without one takes.
const INK_REACH: usize = 16;

/// Names and values of texts in a header.
pub(super) type Texts = Vec<(String, String)>;

/// The channels of a picture so wide with its layers, and the texts of its header.
pub(super) fn channels(width: usize, picture: &[[f32; 4]], layers: &[Layer]) -> (Vec<Channel>, Texts) {
    let things: Vec<Things> = things(layers, width).collect();
    let mut all = colour("", picture);
    all.extend(layers.iter().flat_map(of_layer));
    if things.is_empty() {
        return (all, Vec::new());
    }
    let nearest = |pixel: usize| things.iter().map(|things| things.depth[pixel]).fold(NOTHING, f32::min);
    all.push(plain("Z".to_owned(), (0..picture.len()).map(nearest).collect()));
    let (mattes, texts) = cryptomatte(&things, picture.len());
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
        LayerData::Vector(pixels) => {
            let of = |(c, end): (usize, &str)| plain(format!("{name}{end}"), pixels.iter().map(|v| v[c]).collect());
            ["X", "Y"].into_iter().enumerate().map(of).collect()
        }
        LayerData::Objects { samples, .. } => {
            let of = |(c, end): (usize, &str)| {
                plain(format!("{name}{end}"), samples.iter().map(|sample| sample[c] as f32).collect())
            };
            ["R", "G", "B", "A"].into_iter().enumerate().map(of).collect()
        }
        LayerData::Array { .. } => Vec::new(),
    }
}

/// What is seen of an effect, a value a pixel.
struct Things<'a> {
    /// The effect's name.
    effect: &'static str,
    /// Infinite where nothing is.
    depth: Vec<f32>,
    who: Seen<'a>,
}

/// Who is seen of an effect.
enum Seen<'a> {
    /// One thing, or, if there are ids, what has these numbers.
    Effect { alpha: Vec<f32>, id: Vec<f32> },
    /// Numbers at four samples, from 1, and their names.
    Objects(&'a [[u32; 4]], &'a [String]),
}

impl Things<'_> {
    /// Most things that a pixel shows.
    fn most(&self) -> usize {
        match self.who {
            Seen::Effect { .. } => 1,
            Seen::Objects(..) => 4,
        }
    }

    /// The things that a pixel shows: the number of each, and its share.
    fn shares(&self, pixel: usize) -> impl Iterator<Item = (Option<u32>, f32)> {
        let mut all = [None; 4];
        match &self.who {
            Seen::Effect { alpha, id } if alpha[pixel] > 0.0 => {
                all[0] = Some((id.get(pixel).map(|id| *id as u32), alpha[pixel].min(1.0)));
            }
            Seen::Effect { .. } => {}
            Seen::Objects(samples, _) => {
                for (i, number) in samples[pixel].iter().enumerate().filter(|(_, number)| **number > 0) {
                    // The first of those that see the same has the share of all.
                    let same = samples[pixel].iter().filter(|other| *other == number).count();
                    let is_first = !samples[pixel][..i].contains(number);
                    all[i] = is_first.then_some((Some(*number), 0.25 * same as f32));
                }
            }
        }
        all.into_iter().flatten()
    }

    /// What a number stands for.
    fn name(&self, number: Option<u32>) -> String {
        match (&self.who, number) {
            (Seen::Objects(_, names), Some(number)) => {
                names.get(number as usize - 1).cloned().unwrap_or_else(|| number.to_string())
            }
            (_, Some(number)) => format!("{}.{number}", self.effect),
            (_, None) => self.effect.to_owned(),
        }
    }
}

/// Of all effects that say it. What ink alone covers is of the thing around which it is drawn.
fn things<'a>(layers: &'a [Layer], width: usize) -> impl Iterator<Item = Things<'a>> {
    let data = |name: &str| layers.iter().find(|layer| layer.name == name).map(|layer| &layer.data);
    let value = move |name: &str| match data(name) {
        Some(LayerData::Value(values)) => Some(&values[..]),
        _ => None,
    };
    EFFECTS.iter().filter_map(move |entry| {
        let Shown { depth, who } = entry.shown.as_ref()?;
        let (effect, depth) = (entry.name(), value(depth)?);
        match who {
            Who::Objects(objects) => {
                let Some(LayerData::Objects { samples, names }) = data(objects) else { return None };
                Some(Things { effect, depth: depth.to_vec(), who: Seen::Objects(samples, names) })
            }
            Who::Effect { colour, id } => {
                let Some(LayerData::Colour(colour)) = data(colour) else { return None };
                let alpha: Vec<f32> = colour.iter().map(|[.., alpha]| *alpha).collect();
                let from = inked(depth, &alpha, width);
                let at = |values: &[f32]| -> Vec<f32> { from.iter().map(|pixel| values[*pixel]).collect() };
                let id = id.and_then(value).map(at).unwrap_or_default();
                // What there is and is not drawn, as fire too cool for a tone, is nowhere.
                let is_drawn = |(depth, alpha): (f32, &f32)| if *alpha > 0.0 { depth } else { f32::INFINITY };
                let depth = at(depth).into_iter().zip(&alpha).map(is_drawn).collect();
                Some(Things { effect, depth, who: Seen::Effect { alpha, id } })
            }
        }
    })
}

/// The pixel whose place each has: its own, or, where it has a share of a picture and no depth, the nearest with one.
fn inked(depth: &[f32], alpha: &[f32], width: usize) -> Vec<usize> {
    let (columns, rows) = (width.max(1), depth.len() / width.max(1));
    let nearest = |pixel: usize| {
        let (x, y) = (pixel % columns, pixel / columns);
        (1..=INK_REACH).find_map(|reach| {
            let [left, right] = [x.saturating_sub(reach), (x + reach + 1).min(columns)];
            let [above, below] = [y.saturating_sub(reach), (y + reach + 1).min(rows)];
            let around = (above..below).flat_map(|row| (left..right).map(move |column| row * columns + column));
            let away = |at: &usize| x.abs_diff(at % columns).pow(2) + y.abs_diff(at / columns).pow(2);
            // Those in the corners of the square are farther than some outside of it.
            around.filter(|at| depth[*at].is_finite() && away(at) <= reach * reach).min_by_key(away)
        })
    };
    let is_ink = |pixel: usize| depth[pixel].is_infinite() && alpha[pixel] > 0.0;
    (0..depth.len()).map(|pixel| if is_ink(pixel) { nearest(pixel).unwrap_or(pixel) } else { pixel }).collect()
}

/// Ids and shares of what is seen in a picture of so many pixels, as Cryptomatte 1.2 has them, and the names for the header.
fn cryptomatte(things: &[Things], pixels: usize) -> (Vec<Channel>, Texts) {
    // By the effect and the number, so that a name is made once and not for each pixel.
    let mut names: BTreeMap<(&str, Option<u32>), (String, u32)> = BTreeMap::new();
    let mut id_of = |things: &Things, number: Option<u32>| {
        let (_, id) = names.entry((things.effect, number)).or_insert_with(|| {
            let name = things.name(number);
            let id = id(&name);
            (name, id)
        });
        *id
    };
    let most = things.iter().map(Things::most).sum::<usize>().next_multiple_of(2);
    // Of each pixel an id and a share of each thing, the largest first.
    let ranks = |pixel: usize| -> Vec<(u32, f32)> {
        let mut there: Vec<&Things> = things.iter().collect();
        there.sort_by(|a, b| a.depth[pixel].total_cmp(&b.depth[pixel]));
        let mut open = 1.0;
        let mut all = Vec::with_capacity(most);
        for things in there {
            let mut covered = 0.0;
            for (number, share) in things.shares(pixel).filter(|_| open > 0.0) {
                all.push((id_of(things, number), open * share));
                covered += share;
            }
            open *= 1.0 - covered;
        }
        all.sort_by(|a, b| b.1.total_cmp(&a.1));
        all.resize(most, (0, 0.0));
        all
    };
    let all: Vec<Vec<(u32, f32)>> = (0..pixels).map(ranks).collect();
    let channels = (0..most).step_by(2).flat_map(|rank| {
        let names = [("R", rank, false), ("G", rank, true), ("B", rank + 1, false), ("A", rank + 1, true)];
        names.map(|(name, rank, is_share)| {
            let value = |ranks: &Vec<(u32, f32)>| if is_share { ranks[rank].1 } else { f32::from_bits(ranks[rank].0) };
            plain(format!("{CRYPTOMATTE}{:02}.{name}", rank / 2), all.iter().map(value).collect())
        })
    });
    let channels = channels.collect();
    (channels, texts(names.into_values()))
}

/// `names`: each with its id.
fn texts(names: impl Iterator<Item = (String, u32)>) -> Texts {
    // The specification's own way to tell the layers of a file apart.
    let key = &format!("{:08x}", murmur(CRYPTOMATTE.as_bytes()))[..7];
    let manifest: BTreeMap<String, String> = names.map(|(name, id)| (name, format!("{id:08x}"))).collect();
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
    fn ink_has_the_place_of_what_is_nearest() {
        let none = f32::INFINITY;
        let depth = [none, none, 3.0, none, none, none, none, 5.0, none, none];
        let alpha = [0.0, 1.0, 1.0, 0.5, 1.0, 0.0, 0.0, 1.0, 1.0, 1.0];
        assert_eq!(inked(&depth, &alpha, 5), [0, 2, 2, 2, 2, 5, 6, 7, 7, 7]);
    }

    #[test]
    fn names_are_hashed_as_cryptomatte_does() {
        // Of the reference implementation, and the specification's examples.
        for (name, expected) in [("", 0), ("hello", 0x248b_fa47), ("hello, world", 0x149b_bb7f)] {
            assert_eq!(murmur(name.as_bytes()), expected, "{name}");
        }
        assert!((0..100_000).all(|i| f32::from_bits(id(&format!("smoke.{i}"))).is_normal()));
    }

    const PICTURE: [[f32; 4]; 4] = [[0.25, 0.5, 0.75, 1.0]; 4];

    #[test]
    fn layers_are_named_as_compositors_name_them() {
        let layers = vec![
            Layer { name: "smoke.outline.inner", data: LayerData::Value(vec![0.5; 4]) },
            Layer { name: "flame.mean", data: LayerData::Rgb(vec![[0.25; 3]; 4]) },
            Layer { name: "smoke.spheres", data: LayerData::table(5, vec![0.5; 10]) },
        ];
        let (channels, texts) = channels(4, &PICTURE, &layers);
        let names: Vec<(&str, bool)> = channels.iter().map(|channel| (&channel.name[..], channel.is_half)).collect();
        let colours = ["R", "G", "B", "A", "flame_mean.R", "flame_mean.G", "flame_mean.B"].map(|name| (name, true));
        let expected = [&colours[..4], &[("smoke_outline_inner.Y", false)], &colours[4..]].concat();
        assert_eq!((names, texts.len()), (expected, 0));
    }

    #[test]
    fn a_pixel_s_shares_are_those_of_what_is_before_and_behind() {
        let colour = |alphas: [f32; 4]| LayerData::Colour(alphas.map(|alpha| [0.0, 0.0, 0.0, alpha]).into());
        let none = f32::INFINITY;
        let layers = vec![
            Layer { name: "smoke.id", data: LayerData::Value(vec![2.0, 2.0, 0.0, 0.0]) },
            Layer { name: "smoke.depth", data: LayerData::Value(vec![3.0, 3.0, none, none]) },
            Layer { name: "smoke", data: colour([0.25, 1.0, 0.75, 0.0]) },
            Layer { name: "flame", data: colour([0.5, 0.5, 0.5, 0.0]) },
            Layer { name: "flame.depth", data: LayerData::Value(vec![4.0, 2.0, 4.0, none]) },
        ];
        let (channels, texts) = channels(4, &PICTURE, &layers);
        let of = |name: &str| &channels.iter().find(|channel| channel.name == name).expect(name).values[..];
        // Ink beside the smoke is as far away as that: before the fire.
        assert_eq!(of("Z"), [3.0, 2.0, 3.0, NOTHING]);
        let [smoke, flame] = ["smoke.2", "flame"].map(|name| f32::from_bits(id(name)));
        // Fire behind a quarter of smoke has more than it; before smoke, half; behind ink, half of what that leaves.
        assert_eq!(of("CryptoObject00.R"), [flame, flame, smoke, 0.0]);
        assert_eq!(of("CryptoObject00.G"), [0.375, 0.5, 0.75, 0.0]);
        assert_eq!(of("CryptoObject00.B"), [smoke, smoke, flame, 0.0]);
        assert_eq!(of("CryptoObject00.A"), [0.25, 0.5, 0.125, 0.0]);
        let manifest = texts.iter().find(|(name, _)| name.ends_with("/manifest")).expect("names");
        assert_eq!(manifest.1, format!("{{\"flame\":\"{:08x}\",\"smoke.2\":\"{:08x}\"}}", id("flame"), id("smoke.2")));
        assert!(
            texts.iter().all(|(name, _)| name.starts_with("cryptomatte/")
                && name.split('/').nth(1).is_some_and(|key| key.len() == 7))
        );
    }
}
