//! Results: rows of `look` in `bench.json`, and a table for people.

use std::fmt::Write as _;

use serde::Serialize;

use super::motion::Carried;
use super::still::{Share, mean};

/// What was found in a scene.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct LookRow {
    /// The shot: its file, or `builtin:NAME`.
    pub(crate) scene: String,
    /// Width and height in pixels.
    pub(crate) size: [u32; 2],
    /// First and last frame.
    pub(crate) frames: [u32; 2],
    /// Of its smoke, if it has any.
    pub(crate) smoke: Option<SmokeLook>,
    /// Of its fire, if it has any.
    pub(crate) flame: Option<FlameLook>,
    /// Of its smears, if it has any.
    pub(crate) blur: Option<SmearLook>,
}

/// Means over the frames, or over the pairs of a frame and the next, in percent unless said otherwise; none where there is
/// nothing to take a share of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub(crate) struct SmokeLook {
    /// Pixels of smoke that a line darkens without drawing.
    pub(crate) airbrush: Option<f64>,
    /// Pixels whose tone flips though their surface only moves on.
    pub(crate) tone: Option<f64>,
    /// Pixels whose surface does not move as the smoke does.
    pub(crate) geometry: Option<f64>,
    /// Pixels of ink that are gone a frame later.
    pub(crate) lines_lost: Option<f64>,
    /// Pixels of smoke that are inked.
    pub(crate) ink: Option<f64>,
    /// Borders between tones that are borders of masks, on one surface.
    pub(crate) seams: Option<f64>,
    /// Borders between tones steeper than the Gaussian, on one surface.
    pub(crate) jumps: Option<f64>,
    /// Small pieces of ink a frame.
    pub(crate) ink_specks: Option<f64>,
    /// Small pieces of smoke a frame.
    pub(crate) smoke_specks: Option<f64>,
    /// The largest share of one tone, in the flattest of the views around.
    pub(crate) dead_back: Option<f64>,
}

/// What was found of a fire.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub(crate) struct FlameLook {
    /// Distances of the camera from the fire's middle, in metres, each half of the one before.
    pub(crate) distance: Vec<f64>,
    /// Fine detail there, in levels of 8 bits; none where no fire is seen.
    pub(crate) fine_detail: Vec<Option<f64>>,
}

/// Means over the frames, in percent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub(crate) struct SmearLook {
    /// Vertices on the leading side of their part that are drawn back.
    pub(crate) leading: Option<f64>,
    /// Of what is seen, ink.
    pub(crate) ink: Option<f64>,
    /// The same without smears.
    pub(crate) ink_still: Option<f64>,
    /// Pixels of smears whose sides differ and that show neither.
    pub(crate) mixed: Option<f64>,
}

/// What was counted in each smeared frame: leading, ink, ink without smears, mixed.
#[derive(Clone, Debug, Default)]
pub(super) struct SmearCounts {
    pub(super) frames: Vec<[Share; 4]>,
}

impl SmearCounts {
    pub(super) fn look(&self) -> SmearLook {
        let [leading, ink, ink_still, mixed] =
            [0, 1, 2, 3].map(|which| mean(self.frames.iter().map(|frame| frame[which].percent())));
        SmearLook { leading, ink, ink_still, mixed }
    }
}

/// What was counted in each frame and each pair of frames.
#[derive(Clone, Debug, Default)]
pub(super) struct Counts {
    pub(super) frames: Vec<FrameCounts>,
    pub(super) pairs: Vec<[Share; 3]>,
    /// The largest tone of each view around.
    pub(super) views: Vec<Share>,
}

#[derive(Clone, Copy, Debug, Default)]
pub(super) struct FrameCounts {
    pub(super) airbrush: Share,
    pub(super) ink: Share,
    pub(super) seams: Share,
    pub(super) jumps: Share,
    pub(super) ink_specks: usize,
    pub(super) smoke_specks: usize,
}

impl Counts {
    pub(super) fn add_pair(&mut self, carried: &Carried) {
        self.pairs.push([carried.tone, carried.geometry, carried.lines_lost]);
    }

    pub(super) fn look(&self) -> SmokeLook {
        let frames = |of: fn(&FrameCounts) -> Share| mean(self.frames.iter().map(|frame| of(frame).percent()));
        let pieces = |of: fn(&FrameCounts) -> usize| mean(self.frames.iter().map(|frame| Some(of(frame) as f64)));
        let pairs = |which: usize| mean(self.pairs.iter().map(|pair| pair[which].percent()));
        SmokeLook {
            airbrush: frames(|frame| frame.airbrush),
            tone: pairs(0),
            geometry: pairs(1),
            lines_lost: pairs(2),
            ink: frames(|frame| frame.ink),
            seams: frames(|frame| frame.seams),
            jumps: frames(|frame| frame.jumps),
            ink_specks: pieces(|frame| frame.ink_specks),
            smoke_specks: pieces(|frame| frame.smoke_specks),
            dead_back: self.views.iter().filter_map(|view| view.percent()).reduce(f64::max),
        }
    }
}

/// Title of a column, its goal, its value.
type Column = (&'static str, &'static str, fn(&SmokeLook) -> Option<f64>);

const COLUMNS: [Column; 10] = [
    ("airbrush %", "< 1", |look| look.airbrush),
    ("tone %", "< 2", |look| look.tone),
    ("geometry %", "< 2", |look| look.geometry),
    ("lines lost %", "< 8", |look| look.lines_lost),
    ("ink %", "", |look| look.ink),
    ("seams %", "< 1", |look| look.seams),
    ("jumps %", "< 1", |look| look.jumps),
    ("ink specks", "< 2", |look| look.ink_specks),
    ("smoke specks", "< 2", |look| look.smoke_specks),
    ("dead back %", "< 70", |look| look.dead_back),
];

/// The table: a line a scene, and what is aimed at.
pub(crate) fn table(rows: &[LookRow]) -> String {
    let name = |row: &LookRow| format!("{}, frames {} to {}", row.scene, row.frames[0], row.frames[1]);
    let width = rows.iter().map(|row| name(row).chars().count()).max().unwrap_or(0);
    let line = |name: &str, cell: &dyn Fn(&Column) -> String| {
        let cells: String = COLUMNS.iter().map(|column| format!(" {:>w$}", cell(column), w = column.0.len())).collect();
        format!("{name:width$}{cells}\n")
    };
    let mut text = String::new();
    if rows.iter().any(|row| row.smoke.is_some()) {
        text += "\nlook of smoke\n";
        text += &line("", &|column| column.0.to_owned());
        for (row, look) in rows.iter().filter_map(|row| Some((row, row.smoke.as_ref()?))) {
            text += &line(&name(row), &|column| (column.2)(look).map_or("-".into(), |value| format!("{value:.1}")));
        }
        text += &line("aim", &|column| column.1.to_owned());
    }
    text += &smears(rows);
    for (row, look) in rows.iter().filter_map(|row| Some((row, row.flame.as_ref()?))) {
        let _ = writeln!(text, "\nlook of fire: {}, frame {}", row.scene, middle(row.frames));
        let _ = writeln!(text, "{:>12} {:>28}", "distance m", "fine detail, 8-bit levels");
        for (distance, detail) in look.distance.iter().zip(&look.fine_detail) {
            let detail = detail.map_or("-".into(), |detail| format!("{detail:.2}"));
            let _ = writeln!(text, "{distance:>12.3} {detail:>28}");
        }
    }
    text
}

/// The part of the table that is of smears.
fn smears(rows: &[LookRow]) -> String {
    let mut text = String::new();
    for (row, look) in rows.iter().filter_map(|row| Some((row, row.blur.as_ref()?))) {
        let cell = |value: Option<f64>| value.map_or("-".into(), |value| format!("{value:.1}"));
        let SmearLook { leading, ink, ink_still, mixed } = *look;
        let [leading, ink, still, mixed] = [leading, ink, ink_still, mixed].map(cell);
        let _ = writeln!(
            text,
            "\nlook of smears: {}, frames {} to {}\nleading {leading} % (< 3), ink {ink} % (within 15 % of {still}), mixed {mixed} % (< 1)",
            row.scene, row.frames[0], row.frames[1]
        );
    }
    text
}

/// The frame in the middle.
pub(super) fn middle([first, last]: [u32; 2]) -> u32 {
    first + (last - first) / 2
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_leave_out_what_is_not_there() {
        let frame = |part, whole| FrameCounts { ink: Share::new(part, whole), ink_specks: 3, ..FrameCounts::default() };
        let counts = Counts {
            frames: vec![frame(1, 4), frame(0, 0), frame(3, 4)],
            pairs: vec![[Share::new(1, 10), Share::new(0, 10), Share::default()]; 2],
            views: vec![Share::new(1, 2), Share::new(3, 4), Share::default()],
        };
        let look = counts.look();
        assert_eq!((look.ink, look.ink_specks, look.dead_back), (Some(50.0), Some(3.0), Some(75.0)));
        assert_eq!((look.tone, look.geometry, look.lines_lost), (Some(10.0), Some(0.0), None));
        assert_eq!(Counts::default().look(), SmokeLook::default());
    }

    #[test]
    fn the_table_has_every_scene() {
        let smoke = SmokeLook { airbrush: Some(43.96), ..SmokeLook::default() };
        let flame = FlameLook { distance: vec![2.0, 1.0], fine_detail: vec![Some(4.9), None] };
        let row = |scene: &str, smoke, flame| LookRow {
            scene: scene.into(),
            size: [8, 8],
            frames: [1, 4],
            smoke,
            flame,
            blur: None,
        };
        let rows = [row("builtin:smoke", Some(smoke), None), row("fire.toml", None, Some(flame))];
        let table = table(&rows);
        for text in ["builtin:smoke, frames 1 to 4", "44.0", "fire.toml, frame 2", "4.90", "2.000", "aim", "< 70"] {
            assert!(table.contains(text), "{text} in\n{table}");
        }
        assert_eq!(super::table(&[]), "");
    }
}
