//! What stands still before what moves: smears pass behind it.

use super::sheets::share_of;
use super::tracks::Seen;

/// Side of the squares, in pixels, by which it is found where smears may be. They curve, so those beside count, too.
const SQUARE: usize = 16;

/// Pixels of a frame that stand still and are nearer than what may smear over them. `reach`: frames that smears reach back.
pub(super) fn pixels(seen: &Seen, reach: f32) -> Vec<bool> {
    let [width, height] = seen.sheets.size;
    let squares = [width, height].map(|side| side.div_ceil(SQUARE));
    let farthest = widened(&swept(seen, reach, squares), squares);
    let is_before = |pixel: usize| {
        let square = pixel / width / SQUARE * squares[0] + pixel % width / SQUARE;
        !seen.movers[pixel] && seen.sheets.is_seen(pixel) && share_of(seen.frame.depth[pixel]) < farthest[square]
    };
    (0..width * height).map(is_before).collect()
}

/// The farthest depth of what moves through each square within the frames that smears reach back; below all where nothing does.
fn swept(seen: &Seen, reach: f32, squares: [usize; 2]) -> Vec<f32> {
    let width = seen.sheets.size[0];
    let mut farthest = vec![f32::NEG_INFINITY; squares[0] * squares[1]];
    for pixel in (0..seen.movers.len()).filter(|pixel| seen.movers[*pixel]) {
        let share = share_of(seen.frame.depth[pixel]);
        let way = seen.frame.previous[pixel].map(|c| reach * c / SQUARE as f32);
        let from = [pixel % width, pixel / width].map(|c| (c as f32 + 0.5) / SQUARE as f32);
        // No square is passed over by more than its half: those beside count.
        let steps = way[0].abs().max(way[1].abs()).ceil() as usize;
        for step in 0..=steps {
            let at = [0, 1].map(|axis| (from[axis] + way[axis] * step as f32 / steps.max(1) as f32).floor());
            if (0..2).all(|axis| (0.0..squares[axis] as f32).contains(&at[axis])) {
                let square = &mut farthest[at[1] as usize * squares[0] + at[0] as usize];
                *square = square.max(share);
            }
        }
    }
    farthest
}

/// The farthest of each square and those around it.
fn widened(farthest: &[f32], [columns, rows]: [usize; 2]) -> Vec<f32> {
    let around = |at: usize, side: usize| at.saturating_sub(1)..(at + 2).min(side);
    let of = |square: usize| {
        let (x, y) = (square % columns, square / columns);
        let beside = around(y, rows).flat_map(|row| around(x, columns).map(move |column| row * columns + column));
        beside.map(|beside| farthest[beside]).fold(f32::NEG_INFINITY, f32::max)
    };
    (0..farthest.len()).map(of).collect()
}
