//! The colours of a GIF.

use std::collections::HashMap;

/// Colours of a palette; the 256th is transparency.
const COLOURS: usize = 255;

type Rgb = [u8; 3];

/// At most 255 colours for a whole animation: what each colour of the frames becomes.
pub(super) struct Palette(HashMap<Rgb, Rgb>);

/// Colours that will share one entry of the palette, each with the number of its pixels.
struct Group(Vec<(Rgb, u64)>);

impl Group {
    fn weight(&self) -> u64 {
        self.0.iter().map(|(_, count)| count).sum()
    }

    fn mean(&self) -> [f64; 3] {
        let weight = self.weight() as f64;
        [0, 1, 2].map(|a| self.0.iter().map(|(c, n)| f64::from(c[a]) * *n as f64).sum::<f64>() / weight)
    }

    /// The channel in which the colours differ most, and the sum of squared differences from the mean in it.
    fn spread(&self) -> (usize, f64) {
        let mean = self.mean();
        let spread = |a: usize| self.0.iter().map(|(c, n)| (f64::from(c[a]) - mean[a]).powi(2) * *n as f64).sum();
        let spreads = [0, 1, 2].map(spread);
        (0..3).map(|a| (a, spreads[a])).fold((0, 0.0), |best, next| if next.1 > best.1 { next } else { best })
    }

    /// Splits at the mean of the channel of largest spread, which must be above 0.
    fn split(self) -> [Group; 2] {
        let axis = self.spread().0;
        let mean = self.mean()[axis];
        let (low, high) = self.0.into_iter().partition(|(c, _)| f64::from(c[axis]) <= mean);
        [Group(low), Group(high)]
    }

    /// The colour of most of the pixels, exactly, if there is one: a flat tone. Otherwise the mean.
    fn colour(&self) -> Rgb {
        match self.0.iter().max_by_key(|(_, count)| *count) {
            Some((colour, count)) if 2 * count >= self.weight() => *colour,
            _ => self.mean().map(|c| c.round() as u8),
        }
    }
}

impl Palette {
    /// The palette of these frames. Up to 255 colours are kept as they are.
    pub(super) fn of(frames: &[Vec<[u8; 4]>]) -> Palette {
        let mut counts: HashMap<Rgb, u64> = HashMap::new();
        for run in frames.iter().flat_map(|f| f.chunk_by(|a, b| a == b)) {
            let [r, g, b, a] = run[0];
            if a >= 128 {
                *counts.entry([r, g, b]).or_default() += run.len() as u64;
            }
        }
        let mut colours: Vec<(Rgb, u64)> = counts.into_iter().collect();
        // The order of a hash map differs from run to run; the file must not.
        colours.sort_unstable();
        if colours.len() <= COLOURS {
            return Palette(colours.into_iter().map(|(c, _)| (c, c)).collect());
        }
        let mut groups = vec![(Group(colours), f64::INFINITY)];
        while groups.len() < COLOURS {
            let widest = (0..groups.len()).fold(0, |best, i| if groups[i].1 > groups[best].1 { i } else { best });
            if groups[widest].1 <= 0.0 {
                break;
            }
            let (group, _) = groups.swap_remove(widest);
            for half in group.split() {
                let spread = half.spread().1;
                groups.push((half, spread));
            }
        }
        let entries = groups.iter().flat_map(|(group, _)| {
            let colour = group.colour();
            group.0.iter().map(move |(c, _)| (*c, colour))
        });
        Palette(entries.collect())
    }

    /// The quantised pixel: a colour of the palette with alpha 255, or transparent.
    pub(super) fn nearest(&self, [r, g, b, a]: [u8; 4]) -> [u8; 4] {
        match self.0.get(&[r, g, b]) {
            Some(&[r, g, b]) if a >= 128 => [r, g, b, 255],
            _ => [0; 4],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pixel([r, g, b]: Rgb) -> [u8; 4] {
        [r, g, b, 255]
    }

    #[test]
    fn few_colours_stay_exact() {
        let frame: Vec<[u8; 4]> = (0..255).map(|i| pixel([i, 255 - i, i / 2])).collect();
        let palette = Palette::of(std::slice::from_ref(&frame));
        assert!(frame.iter().all(|&p| palette.nearest(p) == p));
        assert_eq!(palette.nearest([3, 252, 1, 127]), [0; 4]);
    }

    #[test]
    fn flat_tones_stay_exact_among_many_colours() {
        let tones = [[150, 160, 180], [203, 207, 219], [249, 249, 247], [195, 217, 243]];
        let mut frame: Vec<[u8; 4]> = tones.iter().flat_map(|&t| vec![pixel(t); 5000]).collect();
        // Antialiased borders: mixtures of each two tones, far more than 255 colours.
        for (a, b) in [(0, 1), (1, 2), (2, 3), (3, 0), (0, 2)] {
            for i in 1..100u32 {
                let mix = |k: usize| ((u32::from(tones[a][k]) * i + u32::from(tones[b][k]) * (100 - i)) / 100) as u8;
                frame.push(pixel([mix(0), mix(1), mix(2)]));
            }
        }
        let palette = Palette::of(std::slice::from_ref(&frame));
        let mapped: Vec<[u8; 4]> = frame.iter().map(|&p| palette.nearest(p)).collect();
        let distinct: std::collections::HashSet<_> = mapped.iter().collect();
        assert!(distinct.len() <= COLOURS, "{}", distinct.len());
        for (i, &tone) in tones.iter().enumerate() {
            assert_eq!(mapped[5000 * i], pixel(tone), "tone {i}");
        }
        let worst = frame.iter().zip(&mapped).flat_map(|(a, b)| (0..3).map(|k| a[k].abs_diff(b[k]))).max();
        // 500 mixtures on five lines of at most 60 steps in 255 entries: neighbours two or three steps apart merge.
        assert!(worst <= Some(8), "{worst:?}");
    }
}
