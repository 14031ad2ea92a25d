//! How surfaces go on below what hides them: a little further than they are seen.
//!
//! Where one surface moves from before another, a smear of the first lays bare what no pixel of the two frames shows. As far as
//! they move apart, the second is taken to go on as it does at its border.

use super::sheets::{DEPTH_JUMP, Sheets, bounds, share_of};
use super::tracks::{Seen, widened};
use crate::io::passes::PassFrame;

/// The farthest that a surface goes on, in pixels.
const MOST: usize = 24;
/// How far apart depths of surfaces that touch may be, as a share of it.
const TOUCHING: f32 = 0.003;
/// Pixels that are seen by which what goes on reaches up from below.
const OVERLAP: usize = 1;

/// A pixel below which a surface goes on.
#[derive(Clone, Copy, Debug)]
struct Below {
    /// The pixel that shows the surface where it goes below.
    from: usize,
    /// How many pixels it goes on at most.
    length: usize,
}

/// A frame in which what goes on below is seen, its surfaces there, and the pixels to be meshed of it. `reach`: frames that smears
/// reach back.
pub(super) fn extended(seen: &Seen, reach: f32) -> (PassFrame, Sheets, Vec<bool>) {
    let [width, height] = seen.sheets.size;
    let mut below: Vec<Option<Below>> = vec![None; width * height];
    let mut edge = Vec::new();
    for step in 1..=MOST {
        let mut found: Vec<(usize, Below)> = Vec::new();
        let mut spread = |pixel: usize, from: usize, length: Option<usize>| {
            for other in beside(pixel, [width, height]) {
                let length = length.unwrap_or_else(|| apart(&seen.frame, from, other, reach));
                if step <= length && below[other].is_none() && hides(seen, other, from) {
                    found.push((other, Below { from, length }));
                }
            }
        };
        match step {
            1 => (0..width * height).filter(|pixel| seen.movers[*pixel]).for_each(|pixel| spread(pixel, pixel, None)),
            _ => edge.iter().for_each(|(pixel, Below { from, length })| spread(*pixel, *from, Some(*length))),
        }
        // Of several the nearest, then the first.
        let share = |pixel: usize| share_of(seen.frame.depth[pixel]);
        found.sort_by(|(a, of_a), (b, of_b)| {
            a.cmp(b).then(share(of_a.from).total_cmp(&share(of_b.from))).then(of_a.from.cmp(&of_b.from))
        });
        found.dedup_by_key(|(pixel, _)| *pixel);
        found.iter().for_each(|(pixel, of)| below[*pixel] = Some(*of));
        edge = found;
    }
    let mut frame = seen.frame.clone();
    for (pixel, Below { from, .. }) in below.iter().enumerate().filter_map(|(pixel, of)| Some((pixel, (*of)?))) {
        frame.depth[pixel] = seen.frame.depth[from];
        frame.id[pixel] = seen.frame.id[from];
        frame.previous[pixel] = carried(&seen.sheets, &seen.frame.previous, from, pixel);
        if let (Some(next), Some(own)) = (&mut frame.next, &seen.frame.next) {
            next[pixel] = carried(&seen.sheets, own, from, pixel);
        }
    }
    let mask: Vec<bool> = below.iter().map(Option::is_some).collect();
    let [low, high] = bounds(&mask, width).unwrap_or_default();
    // Borders are told from two pixels to each side.
    let around = [0, 1].map(|axis| {
        let most = seen.sheets.size[axis];
        [low[axis].saturating_sub(OVERLAP + 2), (high[axis] + OVERLAP + 2).min(most)]
    });
    let mut sheets = Sheets::within(&frame, [[around[0][0], around[1][0]], [around[0][1], around[1][1]]]);
    sheets.tear(&frame.previous);
    // Some of those that are seen, too, so that no gap is between.
    let mask = (0..OVERLAP).fold(mask, |mask, _| widened(&sheets, &mask));
    (frame, sheets, mask)
}

fn beside(pixel: usize, [width, height]: [usize; 2]) -> impl Iterator<Item = usize> {
    let (x, y) = (pixel % width, pixel / width);
    let (left, right) = ((x > 0).then(|| pixel - 1), (x + 1 < width).then_some(pixel + 1));
    let (above, below) = ((y > 0).then(|| pixel - width), (y + 1 < height).then_some(pixel + width));
    [left, right, above, below].into_iter().flatten()
}

/// Whether a pixel shows a surface that moves and lies before that of another one, or touches it.
fn hides(seen: &Seen, pixel: usize, other: usize) -> bool {
    let share = |pixel: usize| share_of(seen.frame.depth[pixel]);
    let behind = share(other) - share(pixel);
    let is_same = seen.frame.id[pixel] == seen.frame.id[other] && behind.abs() <= DEPTH_JUMP;
    seen.movers[pixel] && !is_same && behind > -TOUCHING
}

/// How far what two pixels show moves apart, in whole pixels and one more.
fn apart(frame: &PassFrame, a: usize, b: usize, reach: f32) -> usize {
    let [x, y] = [0, 1].map(|c| frame.previous[a][c] - frame.previous[b][c]);
    2 + (reach * (x * x + y * y).sqrt()).ceil() as usize
}

/// A vector as it goes on from a pixel to another, as it changes at the first.
fn carried(sheets: &Sheets, vectors: &[[f32; 2]], from: usize, to: usize) -> [f32; 2] {
    let width = sheets.size[0];
    let [left, right, above, below] = sheets.beside(from);
    let slope = |before: Option<usize>, after: Option<usize>, c: usize| {
        let ends = [before.unwrap_or(from), after.unwrap_or(from)];
        let steps = (usize::from(before.is_some()) + usize::from(after.is_some())).max(1);
        (vectors[ends[1]][c] - vectors[ends[0]][c]) / steps as f32
    };
    let away = |of: fn(usize, usize) -> usize| of(to, width) as f32 - of(from, width) as f32;
    let (dx, dy) = (away(|pixel, width| pixel % width), away(|pixel, width| pixel / width));
    [0, 1].map(|c| vectors[from][c] + dx * slope(left, right, c) + dy * slope(above, below, c))
}
