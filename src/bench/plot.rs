//! Run time against error, one log-log panel a pass, as SVG and PNG.

use std::io::Write;
use std::path::Path;

use plotters::prelude::*;

use super::font;
use super::report::Row;
use crate::io::image::write_png8;
use crate::io::{WriteError, write_atomic};

/// Size of a panel in pixels.
const PANEL: [u32; 2] = [900, 620];
/// Room around its frame: left, top, right, bottom.
const MARGIN: [i32; 4] = [110, 50, 30, 70];
const COLUMNS: usize = 2;
const TEXT: f64 = 12.0;
const INK: RGBColor = RGBColor(40, 40, 40);
const GRID: RGBColor = RGBColor(222, 222, 222);
/// Colours of workloads, told apart also by those who cannot tell red from green (Okabe and Ito).
const COLOURS: [RGBColor; 6] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(230, 159, 0),
];

/// Writes `EFFECT.svg` and `EFFECT.png`.
pub(super) fn write(effect: &str, rows: &[&Row], folder: &Path) -> Result<(), WriteError> {
    let mut passes: Vec<&str> = rows.iter().map(|row| row.pass).collect();
    passes.dedup();
    let columns = passes.len().clamp(1, COLUMNS);
    let size = [PANEL[0] * columns as u32, PANEL[1] * passes.len().div_ceil(columns).max(1) as u32];
    let svg = folder.join(format!("{effect}.svg"));
    let png = folder.join(format!("{effect}.png"));
    let failed = |path: &Path, e: String| WriteError { path: path.into(), source: std::io::Error::other(e) };

    let mut text = String::new();
    draw(SVGBackend::with_string(&mut text, size.into()), &passes, columns, rows).map_err(|e| failed(&svg, e))?;
    write_atomic(&svg, |file| file.write_all(text.as_bytes()))?;

    let mut bytes = vec![0; size[0] as usize * size[1] as usize * 3];
    draw(BitMapBackend::with_buffer(&mut bytes, size.into()), &passes, columns, rows).map_err(|e| failed(&png, e))?;
    let pixels: Vec<[u8; 4]> = bytes.chunks_exact(3).map(|rgb| [rgb[0], rgb[1], rgb[2], 255]).collect();
    write_png8(&png, size, &pixels)
}

fn draw<B: DrawingBackend>(backend: B, passes: &[&str], columns: usize, rows: &[&Row]) -> Result<(), String> {
    let area = backend.into_drawing_area();
    let mut canvas = Canvas { area: &area, failed: None };
    canvas.keep(area.fill(&WHITE));
    for (index, pass) in passes.iter().enumerate() {
        let corner = [
            (index % columns) as i32 * PANEL[0] as i32 + MARGIN[0],
            (index / columns) as i32 * PANEL[1] as i32 + MARGIN[1],
        ];
        let points: Vec<&Row> = rows.iter().filter(|row| row.pass == *pass).copied().collect();
        Panel::new(corner, &points).draw(&mut canvas, pass, &points);
    }
    let end = area.present();
    canvas.keep(end);
    canvas.failed.map_or(Ok(()), Err)
}

/// Draws lines, dots and text; remembers the first failure.
struct Canvas<'a, B: DrawingBackend> {
    area: &'a DrawingArea<B, plotters::coord::Shift>,
    failed: Option<String>,
}

impl<B: DrawingBackend> Canvas<'_, B> {
    fn keep<E: std::fmt::Display>(&mut self, result: Result<(), E>) {
        if let (None, Err(error)) = (&self.failed, result) {
            self.failed = Some(error.to_string());
        }
    }

    fn line(&mut self, points: Vec<(i32, i32)>, colour: RGBColor, width: u32) {
        let result = self.area.draw(&PathElement::new(points, colour.stroke_width(width)));
        self.keep(result);
    }

    fn text(&mut self, text: &str, at: [f64; 2], colour: RGBColor) {
        for line in font::lines(text, at, TEXT) {
            self.line(line, colour, 1);
        }
    }

    fn dot(&mut self, at: (i32, i32), colour: RGBColor) {
        let result = self.area.draw(&Circle::new(at, 5, colour.filled()));
        self.keep(result);
    }
}

/// Where a panel is and what its axes span.
struct Panel {
    corner: [i32; 2],
    /// Decades of milliseconds.
    time: [i32; 2],
    /// Decades of the error; the lowest stands for 0.
    error: [i32; 2],
    workloads: Vec<String>,
}

/// The decades that hold the positive ones of these values.
fn decades(values: impl Iterator<Item = f64>) -> [i32; 2] {
    let logs: Vec<f64> = values.filter(|value| *value > 0.0 && value.is_finite()).map(f64::log10).collect();
    let low = logs.iter().copied().fold(f64::INFINITY, f64::min);
    let high = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if logs.is_empty() {
        return [-1, 0];
    }
    let low = low.floor() as i32;
    [low, (high.ceil() as i32).max(low + 1)]
}

/// Rectangle of a text: left, top, right, bottom.
type Place = [f64; 4];

fn overlap(a: &Place, b: &Place) -> bool {
    a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3]
}

impl Panel {
    fn new(corner: [i32; 2], rows: &[&Row]) -> Panel {
        let time = decades(rows.iter().map(|row| row.gpu_ms));
        let [low, high] = decades(rows.iter().filter_map(|row| row.error_rms));
        let mut workloads: Vec<String> = rows.iter().map(|row| row.workload.clone()).collect();
        workloads.dedup();
        Panel { corner, time, error: [low - 1, high], workloads }
    }

    fn inner(&self) -> [i32; 2] {
        [PANEL[0] as i32 - MARGIN[0] - MARGIN[2], PANEL[1] as i32 - MARGIN[1] - MARGIN[3]]
    }

    fn x(&self, decade: f64) -> i32 {
        let [low, high] = self.time.map(f64::from);
        self.corner[0] + ((decade - low) / (high - low) * f64::from(self.inner()[0])).round() as i32
    }

    fn y(&self, decade: f64) -> i32 {
        let [low, high] = self.error.map(f64::from);
        let inner = self.inner()[1];
        self.corner[1] + inner - ((decade - low) / (high - low) * f64::from(inner)).round() as i32
    }

    fn draw<B: DrawingBackend>(&self, canvas: &mut Canvas<B>, pass: &str, rows: &[&Row]) {
        self.axes(canvas, pass, rows);
        let mut taken: Vec<Place> = Vec::new();
        let mut dots = Vec::new();
        for row in rows {
            let Some(error) = row.error_rms.filter(|error| error.is_finite()) else { continue };
            let decade = if error > 0.0 { error.log10() } else { f64::from(self.error[0]) };
            let at = (self.x(row.gpu_ms.max(1e-9).log10()), self.y(decade));
            let workload = self.workloads.iter().position(|name| *name == row.workload).unwrap_or(0);
            dots.push((at, COLOURS[workload % COLOURS.len()], row));
            let (x, y) = (f64::from(at.0), f64::from(at.1));
            taken.push([x - 6.0, y - 6.0, x + 6.0, y + 6.0]);
        }
        for (at, colour, row) in dots {
            canvas.dot(at, colour);
            let place = self.label(at, &row.variant, &taken);
            taken.push(place);
            canvas.text(&row.variant, [place[0], place[3] - 3.0], colour);
        }
    }

    /// Room beside a dot that nothing else takes, if there is any.
    fn label(&self, at: (i32, i32), text: &str, taken: &[Place]) -> Place {
        let (x, y, width) = (f64::from(at.0), f64::from(at.1), font::width(text, TEXT));
        let place = |left: f64, middle: f64| [left, middle - 9.0, left + width, middle + 9.0];
        let rows = [0.0, -16.0, 16.0, -32.0, 32.0, -48.0, 48.0, -64.0, -80.0, -96.0];
        let beside = rows.into_iter().flat_map(|dy| [place(x + 10.0, y + dy), place(x - 10.0 - width, y + dy)]);
        let free = |place: &Place| {
            let inside = place[0] > f64::from(self.corner[0])
                && place[1] > f64::from(self.corner[1])
                && place[2] < f64::from(self.corner[0] + self.inner()[0])
                && place[3] < f64::from(self.corner[1] + self.inner()[1] + 12);
            inside && !taken.iter().any(|other| overlap(place, other))
        };
        beside.into_iter().find(free).unwrap_or_else(|| place(x + 10.0, y))
    }

    fn axes<B: DrawingBackend>(&self, canvas: &mut Canvas<B>, pass: &str, rows: &[&Row]) {
        let [left, top] = self.corner;
        let [right, bottom] = [left + self.inner()[0], top + self.inner()[1]];
        for decade in self.time[0]..=self.time[1] {
            let x = self.x(decade.into());
            canvas.line(vec![(x, top), (x, bottom)], GRID, 1);
            let label = plain_power(decade);
            let middle = f64::from(x) - font::width(&label, TEXT) / 2.0;
            canvas.text(&label, [middle, f64::from(bottom) + 22.0], INK);
        }
        for decade in self.error[0]..=self.error[1] {
            let y = self.y(decade.into());
            canvas.line(vec![(left, y), (right, y)], GRID, 1);
            let label = if decade == self.error[0] { "0".into() } else { format!("1e{decade}") };
            let start = f64::from(left) - 8.0 - font::width(&label, TEXT);
            canvas.text(&label, [start, f64::from(y) + 5.0], INK);
        }
        canvas.line(vec![(left, top), (left, bottom), (right, bottom), (right, top), (left, top)], INK, 1);
        // What comes after a comma differs between workloads.
        let of = rows.iter().find_map(|row| row.error_of.as_deref()?.split(',').next()).unwrap_or("not measured");
        let effect = rows.first().map_or("", |row| row.effect);
        canvas.text(&format!("{effect} {pass}: rms error against {of}"), [left.into(), f64::from(top) - 28.0], INK);
        canvas.text("run time in ms", [left.into(), f64::from(bottom) + 50.0], INK);
        let mut x = f64::from(left);
        for (index, workload) in self.workloads.iter().enumerate() {
            let colour = COLOURS[index % COLOURS.len()];
            canvas.dot((x as i32 + 5, top - 10), colour);
            canvas.text(workload, [x + 16.0, f64::from(top) - 5.0], colour);
            x += 40.0 + font::width(workload, TEXT);
        }
    }
}

/// 0.01, 1, 1000.
fn plain_power(decade: i32) -> String {
    let digits = (-decade).max(0) as usize;
    format!("{:.digits$}", 10.0_f64.powi(decade))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::report::tests::sample;

    #[test]
    fn both_files_hold_ink() -> Result<(), Box<dyn std::error::Error>> {
        let folder = std::env::temp_dir().join(format!("celfx-plot-{}", std::process::id()));
        let report = sample();
        write("smoke", &report.rows.iter().collect::<Vec<_>>(), &folder)?;
        let svg = std::fs::read_to_string(folder.join("smoke.svg"))?;
        assert!(svg.starts_with("<svg") && svg.matches("<polyline").count() > 100 && svg.contains("<circle"));
        let png = crate::io::image::read_png(&folder.join("smoke.png"))?;
        assert_eq!(png.size, [2 * PANEL[0], 2 * PANEL[1]]);
        let dark = png.pixels.iter().filter(|p| p[0] < 0.1).count();
        assert!(dark > 3000, "{dark} dark pixels");
        std::fs::remove_dir_all(&folder)?;
        Ok(())
    }

    #[test]
    fn axes_span_whole_decades() {
        assert_eq!(decades([0.0, 0.02, 3.0, f64::NAN].into_iter()), [-2, 1]);
        assert_eq!(decades([10.0].into_iter()), [1, 2]);
        assert_eq!(decades(std::iter::empty()), [-1, 0]);
        assert_eq!((plain_power(-2), plain_power(3)), ("0.01".into(), "1000".into()));
    }
}
