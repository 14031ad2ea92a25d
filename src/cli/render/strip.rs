//! Outputs of all frames together: the contact sheet and the animation.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use super::Failure;
use crate::io::display::Display;
use crate::io::image::{Picture, contact_sheet, write_apng, write_gif, write_png8};

/// Longest side of a contact sheet in pixels.
const SHEET_SIDE: u64 = 4096;
/// Most frames on a contact sheet; of longer sequences it shows evenly spaced ones.
const SHEET_FRAMES: usize = 120;
/// Pixels of transparent gap on a contact sheet.
const GAP: u32 = 4;
/// Most bytes of a whole animation in memory: its palette is that of all frames.
const ANIMATION_BYTES: u64 = 1 << 28;

/// Frames collected for one file, reduced by a whole factor so that all of them find room.
pub(super) struct Strip {
    path: PathBuf,
    kind: Kind,
    size: [u32; 2],
    factor: u32,
    /// Index among the rendered frames -> place in the strip.
    places: Vec<Option<usize>>,
    frames: Mutex<Vec<Vec<[u8; 4]>>>,
}

enum Kind {
    Sheet { columns: u32 },
    Animation { fps: f64 },
}

impl Strip {
    /// A contact sheet of `count` frames of `size` pixels.
    pub(super) fn sheet(path: &Path, size: [u32; 2], count: usize) -> Strip {
        let shown = count.min(SHEET_FRAMES);
        let columns = columns(size, shown as u32);
        let rows = (shown as u32).div_ceil(columns);
        let factor = factor(|side| {
            let width = u64::from(columns) * u64::from(side(size[0]) + GAP);
            let height = u64::from(rows) * u64::from(side(size[1]) + GAP);
            width.max(height) <= SHEET_SIDE + u64::from(GAP)
        });
        let mut places = vec![None; count];
        for place in 0..shown {
            places[place * count / shown] = Some(place);
        }
        Strip::new(path, Kind::Sheet { columns }, size, factor, places)
    }

    /// An animation of `count` frames of `size` pixels.
    pub(super) fn animation(path: &Path, size: [u32; 2], count: usize, fps: f64) -> Strip {
        let factor = factor(|side| {
            let pixels = u64::from(side(size[0])) * u64::from(side(size[1]));
            pixels.saturating_mul(4 * count as u64) <= ANIMATION_BYTES
        });
        Strip::new(path, Kind::Animation { fps }, size, factor, (0..count).map(Some).collect())
    }

    fn new(path: &Path, kind: Kind, size: [u32; 2], factor: u32, places: Vec<Option<usize>>) -> Strip {
        let shown = places.iter().flatten().count();
        Strip { path: path.to_owned(), kind, size, factor, places, frames: Mutex::new(vec![Vec::new(); shown]) }
    }

    /// Takes the frame of this index, linear and premultiplied, to be shown on a display.
    pub(super) fn add(&self, index: usize, pixels: &[[f32; 4]], display: &Display) {
        let Some(place) = self.places.get(index).copied().flatten() else { return };
        let small = match self.factor {
            1 => display.codes(pixels),
            factor => display.codes(&reduced(pixels, self.size, factor)),
        };
        let mut frames = self.frames.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(frame) = frames.get_mut(place) {
            *frame = small;
        }
    }

    /// Writes the file.
    pub(super) fn write(&self) -> Result<(), Failure> {
        let frames = self.frames.lock().unwrap_or_else(PoisonError::into_inner);
        let size = self.size.map(|side| side.div_ceil(self.factor));
        match self.kind {
            Kind::Animation { fps } => match self.path.extension().is_some_and(|e| e.eq_ignore_ascii_case("gif")) {
                true => write_gif(&self.path, size, &frames, fps)?,
                false => write_apng(&self.path, size, &frames, fps)?,
            },
            Kind::Sheet { columns } => {
                let Some(Picture { size, pixels }) = contact_sheet(size, &frames, columns, GAP) else {
                    let why = format!("{}: not every frame of the sheet was rendered", self.path.display());
                    return Err(Failure::new(Failure::OUTPUT, why));
                };
                write_png8(&self.path, size, &pixels)?;
            }
        }
        Ok(())
    }
}

/// Columns that make the sheet of `count` pictures about 4:3.
fn columns(size: [u32; 2], count: u32) -> u32 {
    let aspect = f64::from(size[1]) / f64::from(size[0]);
    // Rounding keeps small strips whole; the conversion saturates.
    ((f64::from(count) * aspect * 4.0 / 3.0).sqrt().round() as u32).clamp(1, count.max(1))
}

/// The smallest factor with which `fits` holds of a side's reduced length; a side is at most 16384.
fn factor(fits: impl Fn(&dyn Fn(u32) -> u32) -> bool) -> u32 {
    (1..16384).find(|factor| fits(&|side: u32| side.div_ceil(*factor))).unwrap_or(16384)
}

/// Means of blocks of `factor` x `factor` pixels.
fn reduced(pixels: &[[f32; 4]], [width, height]: [u32; 2], factor: u32) -> Vec<[f32; 4]> {
    let [width, height, factor] = [width, height, factor].map(|n| n as usize);
    let mut out = Vec::with_capacity(width.div_ceil(factor) * height.div_ceil(factor));
    for rows in pixels.chunks(width * factor) {
        for left in (0..width).step_by(factor) {
            let right = (left + factor).min(width);
            let block = rows.chunks_exact(width).flat_map(|row| &row[left..right]);
            let mut sum = [0.0; 4];
            let mut count = 0.0f32;
            for pixel in block {
                (0..4).for_each(|c| sum[c] += pixel[c]);
                count += 1.0;
            }
            out.push(sum.map(|s: f32| s / count));
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_are_averaged_and_cut_at_the_border() {
        let pixels: Vec<[f32; 4]> = (0..15).map(|i| [i as f32, 0.0, 0.0, 1.0]).collect();
        let small = reduced(&pixels, [5, 3], 2);
        let red: Vec<f32> = small.iter().map(|p| p[0]).collect();
        // Rows 0 1 2 3 4 | 5 6 7 8 9 | 10 11 12 13 14 in blocks of 2 x 2, exact in f32.
        assert_eq!(red, [3.0, 5.0, 6.5, 10.5, 12.5, 14.0]);
        assert!(small.iter().all(|p| p[3] == 1.0));
    }

    #[test]
    fn sheets_and_animations_stay_within_bounds() {
        for (size, count) in
            [([512, 512], 48), ([64, 64], 1), ([16384, 16384], 100_000), ([16384, 1], 7), ([1, 16384], 7)]
        {
            let sheet = Strip::sheet(Path::new("a.png"), size, count);
            let Kind::Sheet { columns } = sheet.kind else { panic!("a sheet") };
            let shown = count.min(SHEET_FRAMES) as u32;
            assert_eq!(sheet.frames.lock().expect("unlocked").len(), shown as usize);
            let [w, h] = size.map(|side| side.div_ceil(sheet.factor) + GAP);
            assert!(columns * w <= 4100 && shown.div_ceil(columns) * h <= 4100, "{size:?} {count}");
            let animation = Strip::animation(Path::new("a.gif"), size, count, 24.0);
            let [w, h] = size.map(|side| u64::from(side.div_ceil(animation.factor)));
            assert!(w * h * 4 * count as u64 <= ANIMATION_BYTES, "{size:?} {count}");
        }
        let whole = Strip::sheet(Path::new("a.png"), [512, 512], 4);
        assert_eq!(whole.factor, 1, "what fits is not reduced");
    }
}
