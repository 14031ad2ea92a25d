//! Colours that one of the two frames, or both, do not show.

pub mod gradient;
pub mod table;
pub mod tone;

use super::distort::Drawing;
use super::visible::{Colour, Frame, Shaded, Surface, mixture};
use crate::blur::settings::{Completion, Mix};
use table::Table;
use tone::Tones;

/// The colour of every sample of the distorted mesh, premultiplied; 0 where it sees nothing.
///
/// - Where both sides are known: their [`mixture`].
/// - Where frames i - 1 and i + 2 had to help (mask 0): the mixture of the two, or the one that is known.
/// - Where one side is known and the triangle stays where it is: that side. Nothing moves there.
/// - Where one side is known else: by `how`. `None`: that side. `Surface`: the mixture of that side and what
///   [`Tones::predict`] says of the other; that side where it says nothing, as of objects whose colours do not follow from
///   tones. `Gradient`: [`gradient`].
/// - Where nothing is known: with `Surface`, the mixture of what [`Table::typical`] says of both frames, or the one of which
///   it says something. All that is left: `inward`, the mean of the neighbours that have a colour. Samples that this
///   does not reach have no colour: 0.
pub fn complete(
    surface: &Surface,
    drawing: &Drawing,
    frames: [&Frame; 2],
    shaded: &[Shaded],
    how: Completion,
    mixing: Mix,
) -> Vec<Colour> {
    let mix = |time, sides| mixture(mixing, time, sides);
    let tables = (how == Completion::Surface).then(|| {
        let tables = [Table::learn(surface, frames[0], frames[1]), Table::learn(surface, frames[1], frames[0])];
        (tables, Tones::learn(surface, frames))
    });
    let colour = |sample: &Shaded| {
        let fragment = sample.fragment?;
        let normal = |side: usize| frames[side].normal(surface, fragment.base, fragment.weights);
        let own = surface.surfaces[fragment.base as usize];
        match (sample.sides, &tables) {
            ([Some(previous), Some(next)], _) => Some(mix(fragment.time, [previous, next])),
            ([None, None], Some((tables, _))) => {
                let typical = [0, 1].map(|side| tables[side].typical(own, normal(side)));
                match typical {
                    [Some(previous), Some(next)] => Some(mix(fragment.time, [previous, next])),
                    [one, other] => one.or(other),
                }
            }
            ([None, None], None) => None,
            ([one, other], tables) => {
                let known = one.or(other)?;
                if surface.still[fragment.base as usize] || sample.mask == 0 {
                    return Some(known);
                }
                let missing = usize::from(one.is_some());
                let Some((_, tones)) = tables else { return (how == Completion::None).then_some(known) };
                let predicted = tones.predict(own, missing, [normal(0), normal(1)], known);
                let sides = [one, other].map(|side| side.or(predicted).unwrap_or(known));
                Some(mix(fragment.time, sides))
            }
        }
    };
    let mut colours: Vec<Option<Colour>> = shaded.iter().map(colour).collect();
    if how == Completion::Gradient {
        gradient::fill(drawing.raster.size, frames, shaded, &mut colours);
    }
    let empty: Vec<usize> =
        (0..shaded.len()).filter(|place| shaded[*place].fragment.is_some() && colours[*place].is_none()).collect();
    let mean = |_: usize, others: &[usize], colours: &[Option<Colour>]| {
        let sum = |i: usize| others.iter().filter_map(|other| colours[*other]).map(|c| c[i]).sum::<f64>();
        [0, 1, 2, 3].map(|i| sum(i) / others.len() as f64)
    };
    inward(drawing.raster.size, empty, &mut colours, |_, _| true, mean);
    colours.into_iter().map(|colour| colour.unwrap_or([0.0; 4])).collect()
}

/// Gives colours to the samples `pending`, from those with most neighbours inward: in each round, all that have as many
/// neighbours (left, right, above and below, within the picture) with a colour as any has get theirs at once. `counts`
/// says whether a neighbour (second) counts for a sample (first); `value` makes the colour from those that do, in the
/// order named. Ends where no sample that is left has such a neighbour, and returns those.
fn inward(
    size: [u32; 2],
    mut pending: Vec<usize>,
    colours: &mut [Option<Colour>],
    counts: impl Fn(usize, usize) -> bool,
    value: impl Fn(usize, &[usize], &[Option<Colour>]) -> Colour,
) -> Vec<usize> {
    let [width, height] = size.map(|side| side as usize);
    let neighbours = |place: usize| {
        let (x, y) = (place % width, place / width);
        let left = (x > 0).then(|| place - 1);
        let right = (x + 1 < width).then_some(place + 1);
        let above = (y > 0).then(|| place - width);
        let below = (y + 1 < height).then_some(place + width);
        [left, right, above, below]
    };
    loop {
        let known = |place: &usize| -> Vec<usize> {
            let all = neighbours(*place).into_iter().flatten();
            all.filter(|other| colours[*other].is_some() && counts(*place, *other)).collect()
        };
        let known: Vec<Vec<usize>> = pending.iter().map(known).collect();
        let most = known.iter().map(Vec::len).max().unwrap_or(0);
        if most == 0 {
            return pending;
        }
        let ready = pending.iter().zip(&known).filter(|(_, known)| known.len() == most);
        let made: Vec<(usize, Colour)> = ready.map(|(place, known)| (*place, value(*place, known, colours))).collect();
        made.iter().for_each(|(place, colour)| colours[*place] = Some(*colour));
        let mut left = known.iter().map(|known| known.len() < most);
        pending.retain(|_| left.next().unwrap_or(false));
    }
}

#[cfg(test)]
mod tests;
