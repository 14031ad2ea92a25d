//! Run time against error, as SVG and PNG: one log-log panel a pass, coloured by workload; or one a workload, where a
//! pass compares methods that more time makes better, each of which is a line.

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
/// Effects and passes whose variants are a method and how much of it.
const METHODS: [(&str, &str); 2] = [("flame", "accumulate"), ("blur", "refine")];
const TEXT: f64 = 12.0;
const INK: RGBColor = RGBColor(40, 40, 40);
const GRID: RGBColor = RGBColor(222, 222, 222);
/// Colours of workloads or methods, told apart also by those who cannot tell red from green (Okabe and Ito).
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
    let panels = panels(effect, rows);
    let columns = panels.len().clamp(1, COLUMNS);
    let size = [PANEL[0] * columns as u32, PANEL[1] * panels.len().div_ceil(columns).max(1) as u32];
    let svg = folder.join(format!("{effect}.svg"));
    let png = folder.join(format!("{effect}.png"));
    let failed = |path: &Path, e: String| WriteError { path: path.into(), source: std::io::Error::other(e) };

    let mut text = String::new();
    draw(SVGBackend::with_string(&mut text, size.into()), &panels, columns).map_err(|e| failed(&svg, e))?;
    write_atomic(&svg, |file| file.write_all(text.as_bytes()))?;

    let mut bytes = vec![0; size[0] as usize * size[1] as usize * 3];
    draw(BitMapBackend::with_buffer(&mut bytes, size.into()), &panels, columns).map_err(|e| failed(&png, e))?;
    let pixels: Vec<[u8; 4]> = bytes.chunks_exact(3).map(|rgb| [rgb[0], rgb[1], rgb[2], 255]).collect();
    write_png8(&png, size, &pixels)
}

/// What a panel shows.
struct Content<'a> {
    title: String,
    rows: Vec<&'a Row>,
    /// Colours tell methods apart, and not workloads.
    by_method: bool,
}

impl Content<'_> {
    /// What tells a row's colour.
    fn series<'r>(&self, row: &'r Row) -> &'r str {
        if self.by_method { method(&row.variant).0 } else { &row.workload }
    }

    fn label(&self, row: &Row) -> String {
        match (self.by_method, method(&row.variant)) {
            (true, (_, Some(amount))) => amount,
            _ => row.variant.clone(),
        }
    }
}

/// Of "tiles R=4", "expected 8" and "length 15": "tiles" and "R=4", "expected" and "8 bins", "length" and "15 px".
fn method(variant: &str) -> (&str, Option<String>) {
    match variant.rsplit_once(' ') {
        Some((method, amount)) if amount.starts_with("R=") => (method, Some(amount.to_owned())),
        Some((method, amount)) if amount.chars().all(|c| c.is_ascii_digit() || c == '.') => {
            let unit = if method == "expected" { "bins" } else { "px" };
            (method, Some(format!("{amount} {unit}")))
        }
        _ => (variant, None),
    }
}

/// Each name once, in the order in which they come.
fn distinct<'a>(names: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let mut distinct = Vec::new();
    names.for_each(|name| {
        if !distinct.contains(&name) {
            distinct.push(name)
        }
    });
    distinct
}

fn panels<'a>(effect: &str, rows: &[&'a Row]) -> Vec<Content<'a>> {
    let mut panels = Vec::new();
    for pass in distinct(rows.iter().map(|row| row.pass)) {
        let of_pass: Vec<&Row> = rows.iter().filter(|row| row.pass == pass).copied().collect();
        if !METHODS.contains(&(effect, pass)) {
            panels.push(Content { title: format!("{effect} {pass}"), rows: of_pass, by_method: false });
            continue;
        }
        for workload in distinct(of_pass.iter().map(|row| row.workload.as_str())) {
            let rows = of_pass.iter().filter(|row| row.workload == workload).copied().collect();
            // How a workload was cut has no room.
            let name = workload.split(" (").next().unwrap_or(workload);
            panels.push(Content { title: format!("{effect} {pass}, {name}"), rows, by_method: true });
        }
    }
    panels
}

fn draw<B: DrawingBackend>(backend: B, panels: &[Content], columns: usize) -> Result<(), String> {
    let area = backend.into_drawing_area();
    let mut canvas = Canvas { area: &area, failed: None };
    canvas.keep(area.fill(&WHITE));
    for (index, content) in panels.iter().enumerate() {
        let corner = [
            (index % columns) as i32 * PANEL[0] as i32 + MARGIN[0],
            (index / columns) as i32 * PANEL[1] as i32 + MARGIN[1],
        ];
        Panel::new(corner, content).draw(&mut canvas);
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
struct Panel<'a> {
    corner: [i32; 2],
    content: &'a Content<'a>,
    /// Decades of milliseconds.
    time: [i32; 2],
    /// Decades of the error.
    error: [i32; 2],
    /// The lowest decade stands for 0.
    has_zero: bool,
    /// What has a colour of its own.
    series: Vec<&'a str>,
}

/// A row's place in its panel.
struct Dot<'a> {
    at: (i32, i32),
    series: usize,
    row: &'a Row,
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

impl<'a> Panel<'a> {
    fn new(corner: [i32; 2], content: &'a Content<'a>) -> Panel<'a> {
        let rows = &content.rows;
        let time = decades(rows.iter().map(|row| row.gpu_ms));
        let [low, high] = decades(rows.iter().filter_map(|row| row.error_rms));
        let has_zero = rows.iter().any(|row| row.error_rms == Some(0.0));
        let series = distinct(rows.iter().map(|row| content.series(row)));
        Panel { corner, content, time, error: [low - i32::from(has_zero), high], has_zero, series }
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

    fn draw<B: DrawingBackend>(&self, canvas: &mut Canvas<B>) {
        self.axes(canvas);
        let dots: Vec<Dot> = self.content.rows.iter().filter_map(|row| self.dot(row)).collect();
        let around = |x: f64, y: f64, half: f64| [x - half, y - half, x + half, y + half];
        let mut taken: Vec<Place> =
            dots.iter().map(|dot| around(f64::from(dot.at.0), f64::from(dot.at.1), 6.0)).collect();
        if self.content.by_method {
            for line in self.lines(&dots) {
                taken.extend(line.windows(2).flat_map(|ends| along(ends[0], ends[1])).map(|(x, y)| around(x, y, 1.0)));
                let series = dots.iter().find(|dot| line.contains(&dot.at)).map_or(0, |dot| dot.series);
                canvas.line(line, COLOURS[series % COLOURS.len()], 2);
            }
        }
        for dot in &dots {
            let colour = COLOURS[dot.series % COLOURS.len()];
            canvas.dot(dot.at, colour);
            let text = self.content.label(dot.row);
            // What is crowded out is named by the method beside it.
            let place = self.label(dot, &text, &taken);
            let Some(place) = place.or_else(|| (!self.content.by_method).then(|| beside(dot.at, &text))) else {
                continue;
            };
            taken.push(place);
            canvas.text(&text, [place[0], place[3] - 3.0], colour);
        }
    }

    fn dot(&self, row: &'a Row) -> Option<Dot<'a>> {
        let error = row.error_rms.filter(|error| error.is_finite())?;
        let decade = if error > 0.0 { error.log10() } else { f64::from(self.error[0]) };
        let at = (self.x(row.gpu_ms.max(1e-9).log10()), self.y(decade));
        let series = self.series.iter().position(|name| *name == self.content.series(row)).unwrap_or(0);
        Some(Dot { at, series, row })
    }

    /// Through the dots of each method that has several.
    fn lines(&self, dots: &[Dot]) -> Vec<Vec<(i32, i32)>> {
        let of = |series| dots.iter().filter(|dot| dot.series == series).map(|dot| dot.at).collect();
        let lines: Vec<Vec<(i32, i32)>> = (0..self.series.len()).map(of).collect();
        lines.into_iter().filter(|line| line.len() > 1).collect()
    }

    /// Room near a dot that nothing else takes, if there is any. Lines of methods fall: above and to the right of them is
    /// room, then below and to the left; every other method begins there.
    fn label(&self, dot: &Dot, text: &str, taken: &[Place]) -> Option<Place> {
        let (x, y, width) = (f64::from(dot.at.0), f64::from(dot.at.1), font::width(text, TEXT));
        let place = |left: f64, middle: f64| [left, middle - 9.0, left + width, middle + 9.0];
        let (right, left) = (x + 10.0, x - 10.0 - width);
        let candidates: Vec<Place> = if self.content.by_method {
            let above = [(right, -8.0), (right, -16.0), (x - width / 2.0, -18.0), (right, 0.0)];
            let below = [(left, 8.0), (left, 16.0), (x - width / 2.0, 18.0), (left, 0.0)];
            let (first, second) = if dot.series.is_multiple_of(2) { (above, below) } else { (below, above) };
            first.into_iter().chain(second).map(|(left, dy)| place(left, y + dy)).collect()
        } else {
            let rows = [0.0, -16.0, 16.0, -32.0, 32.0, -48.0, 48.0, -64.0, -80.0, -96.0];
            rows.into_iter().flat_map(|dy| [place(right, y + dy), place(left, y + dy)]).collect()
        };
        let free = |place: &Place| {
            let inside = place[0] > f64::from(self.corner[0])
                && place[1] > f64::from(self.corner[1])
                && place[2] < f64::from(self.corner[0] + self.inner()[0])
                && place[3] < f64::from(self.corner[1] + self.inner()[1] + 12);
            inside && !taken.iter().any(|other| overlap(place, other))
        };
        candidates.into_iter().find(free)
    }

    fn axes<B: DrawingBackend>(&self, canvas: &mut Canvas<B>) {
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
            let label = if self.has_zero && decade == self.error[0] { "0".into() } else { format!("1e{decade}") };
            let start = f64::from(left) - 8.0 - font::width(&label, TEXT);
            canvas.text(&label, [start, f64::from(y) + 5.0], INK);
        }
        canvas.line(vec![(left, top), (left, bottom), (right, bottom), (right, top), (left, top)], INK, 1);
        // What comes after a comma differs between workloads.
        let rows = &self.content.rows;
        let of = rows.iter().find_map(|row| row.error_of.as_deref()?.split(',').next()).unwrap_or("not measured");
        let title = format!("{}: rms error against {of}", self.content.title);
        canvas.text(&title, [left.into(), f64::from(top) - 28.0], INK);
        canvas.text("run time in ms", [left.into(), f64::from(bottom) + 50.0], INK);
        let mut x = f64::from(left);
        for (index, name) in self.series.iter().enumerate() {
            let colour = COLOURS[index % COLOURS.len()];
            let fits = x + 16.0 + font::width(name, TEXT) <= f64::from(right);
            let name = if fits { name } else { name.split(" (").next().unwrap_or(name) };
            canvas.dot((x as i32 + 5, top - 10), colour);
            canvas.text(name, [x + 16.0, f64::from(top) - 5.0], colour);
            x += 40.0 + font::width(name, TEXT);
        }
    }
}

/// To the right of a dot.
fn beside(at: (i32, i32), text: &str) -> Place {
    let (x, y) = (f64::from(at.0), f64::from(at.1));
    [x + 10.0, y - 9.0, x + 10.0 + font::width(text, TEXT), y + 9.0]
}

/// Points of a line, a few pixels apart.
fn along(from: (i32, i32), to: (i32, i32)) -> impl Iterator<Item = (f64, f64)> {
    let [x, y] = [to.0 - from.0, to.1 - from.1].map(f64::from);
    let steps = (x.hypot(y) / 4.0).ceil().max(1.0);
    (0..=steps as u32).map(move |step| {
        let share = f64::from(step) / steps;
        (f64::from(from.0) + share * x, f64::from(from.1) + share * y)
    })
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
    fn methods_are_lines_where_passes_compare_them() {
        assert_eq!(method("tiles sobol R=16"), ("tiles sobol", Some("R=16".into())));
        assert_eq!(method("expected 8"), ("expected", Some("8 bins".into())));
        assert_eq!(method("error 0.5"), ("error", Some("0.5 px".into())));
        assert_eq!(method("sorted"), ("sorted", None));
        let report = sample();
        let variants = ["tiles R=4", "tiles R=16", "sorted"];
        let row = |workload: &str, variant: &str| Row {
            effect: "flame",
            pass: "accumulate",
            workload: workload.into(),
            variant: variant.into(),
            ..report.rows[0].clone()
        };
        let rows: Vec<Row> = ["paper", "thin (cut)"].iter().flat_map(|w| variants.map(|v| row(w, v))).collect();
        let rows: Vec<&Row> = rows.iter().collect();
        let panels = panels("flame", &rows);
        let titles: Vec<&str> = panels.iter().map(|content| content.title.as_str()).collect();
        assert_eq!(titles, ["flame accumulate, paper", "flame accumulate, thin"]);
        let panel = Panel::new([0, 0], &panels[1]);
        assert_eq!((panel.series.as_slice(), panel.has_zero), (["tiles", "sorted"].as_slice(), false));
        let dots: Vec<Dot> = panels[1].rows.iter().filter_map(|row| panel.dot(row)).collect();
        assert_eq!(dots.iter().map(|dot| dot.series).collect::<Vec<_>>(), [0, 0, 1]);
        assert_eq!(panel.lines(&dots).len(), 1, "one dot is no line");
        // The same rows of another effect are one panel, coloured by workload.
        assert_eq!(super::panels("smoke", &rows).len(), 1);
    }

    #[test]
    fn axes_span_whole_decades() {
        assert_eq!(decades([0.0, 0.02, 3.0, f64::NAN].into_iter()), [-2, 1]);
        assert_eq!(decades([10.0].into_iter()), [1, 2]);
        assert_eq!(decades(std::iter::empty()), [-1, 0]);
        assert_eq!((plain_power(-2), plain_power(3)), ("0.01".into(), "1000".into()));
    }
}
