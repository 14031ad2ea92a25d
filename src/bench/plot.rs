//! Run time against error, as SVG and PNG: one log-log panel a pass, in which variants have colours and workloads marks;
//! or one a workload, where a pass compares methods that more time makes better, each of which is a line.

use std::io::Write;
use std::ops::Range;
use std::path::Path;

use plotters::coord::Shift;
use plotters::element::ComposedElement;
use plotters::prelude::*;
use plotters::style::register_font;

use super::report::Row;
use crate::io::image::write_png8;
use crate::io::{WriteError, write_atomic};

/// Size of a panel in pixels.
const PANEL: [u32; 2] = [1000, 600];
const COLUMNS: usize = 2;
/// Effects and passes whose variants are a method and how much of it.
const METHODS: [(&str, &str); 2] = [("flame", "accumulate"), ("blur", "refine")];
const FONT: &str = "sans-serif";
const INK: RGBColor = RGBColor(40, 40, 40);
/// Colours that are told apart also by those who cannot tell red from green (Okabe and Ito), and grey.
const COLOURS: [RGBColor; 8] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(230, 159, 0),
    RGBColor(0, 0, 0),
    RGBColor(150, 150, 150),
];

/// Workloads are a circle, a triangle, a square and a diamond: radius, or corners, in pixels.
const MARKS: [(i32, &[(i32, i32)]); 4] = [
    (6, &[]),
    (0, &[(0, -8), (7, 5), (-7, 5)]),
    (0, &[(-6, -6), (6, -6), (6, 6), (-6, 6)]),
    (0, &[(0, -8), (8, 0), (0, 8), (-8, 0)]),
];

type Mark<C, B> = ComposedElement<C, B, Circle<(i32, i32), i32>, Polygon<(i32, i32)>>;
type Failure<B> = DrawingAreaErrorKind<<B as DrawingBackend>::ErrorType>;

/// Writes `EFFECT.svg` and `EFFECT.png`.
pub(super) fn write(effect: &str, rows: &[&Row], folder: &Path) -> Result<(), WriteError> {
    let svg = folder.join(format!("{effect}.svg"));
    let png = folder.join(format!("{effect}.png"));
    let failed = |path: &Path, e: String| WriteError { path: path.into(), source: std::io::Error::other(e) };
    register_font(FONT, FontStyle::Normal, dejavu::sans::regular()).map_err(|_| failed(&svg, "no font".into()))?;

    let panels = panels(effect, rows);
    let columns = panels.len().clamp(1, COLUMNS);
    let grid = (panels.len().div_ceil(columns).max(1), columns);
    let size = [PANEL[0] * grid.1 as u32, PANEL[1] * grid.0 as u32];
    let mut text = String::new();
    draw(SVGBackend::with_string(&mut text, size.into()), &panels, grid).map_err(|e| failed(&svg, e.to_string()))?;
    write_atomic(&svg, |file| file.write_all(text.as_bytes()))?;

    let mut bytes = vec![0; size[0] as usize * size[1] as usize * 3];
    let bitmap = BitMapBackend::with_buffer(&mut bytes, size.into());
    draw(bitmap, &panels, grid).map_err(|e| failed(&png, e.to_string()))?;
    let pixels: Vec<[u8; 4]> = bytes.chunks_exact(3).map(|rgb| [rgb[0], rgb[1], rgb[2], 255]).collect();
    write_png8(&png, size, &pixels)
}

fn draw<B: DrawingBackend>(backend: B, panels: &[Panel], grid: (usize, usize)) -> Result<(), Failure<B>> {
    let area = backend.into_drawing_area();
    area.fill(&WHITE)?;
    for (panel, area) in panels.iter().zip(area.split_evenly(grid)) {
        panel.draw(&area)?;
    }
    area.present()
}

fn panels<'a>(effect: &str, rows: &[&'a Row]) -> Vec<Panel<'a>> {
    let mut panels = Vec::new();
    for pass in distinct(rows.iter().map(|row| row.pass)) {
        let of_pass: Vec<&Row> = rows.iter().filter(|row| row.pass == pass).copied().collect();
        if !METHODS.contains(&(effect, pass)) {
            panels.push(Panel { title: format!("{effect} {pass}"), rows: of_pass, by_method: false });
            continue;
        }
        for workload in distinct(of_pass.iter().map(|row| row.workload.as_str())) {
            let rows = of_pass.iter().filter(|row| row.workload == workload).copied().collect();
            panels.push(Panel { title: format!("{effect} {pass}, {workload}"), rows, by_method: true });
        }
    }
    panels
}

/// Of "tiles R=4", "expected 8" and "length 15": "tiles" and "R=4", "expected" and "8 bins", "length" and "15 px".
fn method(variant: &str) -> (&str, Option<String>) {
    match variant.rsplit_once(' ') {
        Some((method, amount)) if amount.starts_with("R=") => (method, Some(amount.to_owned())),
        Some((method, amount)) if amount.chars().all(|c| c.is_ascii_digit() || c == '.') => {
            let label = match method {
                "expected" => format!("{amount} bins"),
                "mboit" => format!("{amount} moments"),
                "wavelet" => format!("rank {amount}"),
                _ => format!("{amount} px"),
            };
            (method, Some(label))
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

/// Whole decades and a little more, so that rounding leaves out no line of the grid.
fn span([low, high]: [i32; 2]) -> Range<f64> {
    let room = 0.02 * f64::from(high - low);
    10_f64.powf(f64::from(low) - room)..10_f64.powf(f64::from(high) + room)
}

/// 0.01, 1, 1000.
fn plain_power(decade: i32) -> String {
    let digits = (-decade).max(0) as usize;
    format!("{:.digits$}", 10.0_f64.powi(decade))
}

fn font(size: u32, colour: RGBColor) -> TextStyle<'static> {
    (FONT, size).into_font().color(&colour)
}

/// A dot with the shape of a workload, in a chart or in its legend.
fn mark<C, B: DrawingBackend>(at: C, colour: RGBColor, workload: usize) -> Mark<C, B> {
    let (radius, corners) = MARKS[workload % MARKS.len()];
    let style = colour.mix(0.85).filled();
    EmptyElement::at(at) + Circle::new((0, 0), radius, style) + Polygon::new(corners, style)
}

/// The content of a panel.
struct Panel<'a> {
    title: String,
    rows: Vec<&'a Row>,
    /// Colours tell methods apart, and not variants.
    by_method: bool,
}

impl<'a> Panel<'a> {
    /// The key of a row's colour.
    fn series<'r>(&self, row: &'r Row) -> &'r str {
        if self.by_method { method(&row.variant).0 } else { &row.variant }
    }

    /// Names of series and of workloads, each with its colour and its mark.
    fn legend(&self) -> [Vec<(&'a str, RGBColor, usize)>; 2] {
        let series = distinct(self.rows.iter().map(|row| self.series(row))).into_iter().enumerate();
        let workloads = distinct(self.rows.iter().map(|row| row.workload.as_str())).into_iter().enumerate();
        [
            series.map(|(index, name)| (name, COLOURS[index % COLOURS.len()], 0)).collect(),
            workloads.map(|(index, name)| (name, INK, index)).collect(),
        ]
    }

    fn draw<B: DrawingBackend>(&self, area: &DrawingArea<B, Shift>) -> Result<(), Failure<B>> {
        let [mut names, workloads] = self.legend();
        if workloads.len() > 1 {
            names.push((" ", WHITE, 0));
            names.extend(workloads);
        }
        let mut widest = 0;
        for (name, ..) in &names {
            widest = area.estimate_text_size(name, &font(17, INK))?.0.max(widest);
        }
        let (left, right) = area.split_horizontally(PANEL[0] - widest - 60);
        self.draw_chart(&left)?;

        let mut chart = ChartBuilder::on(&right).margin_top(54).build_cartesian_2d(0..1, 0..1)?;
        for (name, colour, shape) in names {
            let legend = move |(x, y)| mark((x + 6, y - 2), colour, shape);
            chart.draw_series([] as [Pixel<(i32, i32)>; 0])?.label(name).legend(legend);
        }
        let mut labels = chart.configure_series_labels();
        labels.position(SeriesLabelPosition::UpperLeft).legend_area_size(20).margin(0).label_font(font(17, INK)).draw()
    }

    fn draw_chart<B: DrawingBackend>(&self, area: &DrawingArea<B, Shift>) -> Result<(), Failure<B>> {
        let [low, high] = decades(self.rows.iter().filter_map(|row| row.error_rms));
        // The lowest decade stands for 0.
        let has_zero = self.rows.iter().any(|row| row.error_rms == Some(0.0));
        let low = low - i32::from(has_zero);
        let lowest = 10_f64.powi(low);
        // What comes after a comma differs between workloads.
        let of = self.rows.iter().find_map(|row| row.error_of.as_deref()?.split(',').next());
        let mut chart = ChartBuilder::on(area)
            .caption(&self.title, font(22, INK))
            .margin(20)
            .x_label_area_size(60)
            .y_label_area_size(90)
            .build_cartesian_2d(
                span(decades(self.rows.iter().map(|row| row.gpu_ms))).log_scale(),
                span([low, high]).log_scale(),
            )?;
        chart
            .configure_mesh()
            .x_desc("run time in ms")
            .y_desc(of.map_or("rms error, not measured".into(), |of| format!("rms error against {of}")))
            .x_label_formatter(&|ms| plain_power(ms.log10().round() as i32))
            .y_label_formatter(&|&at| if has_zero && at < 2.0 * lowest { "0".into() } else { format!("{at:.0e}") })
            .x_labels(8)
            .y_labels(8)
            .max_light_lines(10)
            .bold_line_style(RGBColor(205, 205, 205))
            .light_line_style(RGBColor(240, 240, 240))
            .axis_style(INK)
            .label_style(font(17, INK))
            .axis_desc_style(font(17, INK))
            .draw()?;

        let [series, workloads] = self.legend();
        let mut amounts = Vec::new();
        let ((x, y), [min, max]) = (chart.plotting_area().get_pixel_range(), [i32::MIN, i32::MAX]);
        let mut taken =
            vec![[min, min, x.start, max], [x.end, min, max, max], [min, min, max, y.start], [min, y.end, max, max]];
        for (index, (name, colour, _)) in series.into_iter().enumerate() {
            for &(workload, _, shape) in &workloads {
                let of = self.rows.iter().filter(|row| self.series(row) == name && row.workload == workload);
                let mut line = Vec::new();
                for row in of {
                    let Some(error) = row.error_rms.filter(|error| error.is_finite()) else { continue };
                    let at = (row.gpu_ms.max(1e-9), error.max(lowest));
                    line.push(at);
                    amounts.push((method(&row.variant).1, at, colour, index % 2));
                }
                let pixels: Vec<(i32, i32)> = line.iter().map(|at| chart.backend_coord(at)).collect();
                taken.extend(pixels.windows(2).flat_map(|ends| along(ends[0], ends[1])).map(|at| around(at, 1)));
                taken.extend(pixels.into_iter().map(|at| around(at, 6)));
                chart.draw_series(LineSeries::new(line.iter().copied(), colour.stroke_width(2)))?;
                chart.draw_series(line.into_iter().map(|at| mark(at, colour, shape)))?;
            }
        }
        // How much of a method each dot is. What is crowded out is told by those beside it.
        for (text, at, colour, first) in amounts.into_iter().filter(|_| self.by_method) {
            let (Some(text), style) = (text, font(15, colour)) else { continue };
            let size = area.estimate_text_size(&text, &style)?;
            if let Some(offset) = room(chart.backend_coord(&at), size, first, &mut taken) {
                chart.draw_series([EmptyElement::at(at) + Text::new(text, offset, style)])?;
            }
        }
        Ok(())
    }
}

/// Rectangle of pixels: left, top, right, bottom.
type Place = [i32; 4];

fn around((x, y): (i32, i32), half: i32) -> Place {
    [x - half, y - half, x + half, y + half]
}

/// Points of a line.
fn along(from: (i32, i32), to: (i32, i32)) -> impl Iterator<Item = (i32, i32)> {
    (0..=64).map(move |step| (from.0 + (to.0 - from.0) * step / 64, from.1 + (to.1 - from.1) * step / 64))
}

/// Where beside a dot a text has room that nothing takes, if there is any. Lines of methods fall: above and to the right
/// of them is room, or below and to the left.
fn room((x, y): (i32, i32), size: (u32, u32), first: usize, taken: &mut Vec<Place>) -> Option<(i32, i32)> {
    let (width, height) = (size.0 as i32, size.1 as i32);
    let mut offsets = [(8, -4 - height), (-8 - width, 4), (9, -height / 2), (-9 - width, -height / 2)];
    offsets.rotate_left(first);
    let place = |offset: &(i32, i32)| [x + offset.0, y + offset.1, x + offset.0 + width, y + offset.1 + height];
    let apart = |a: &Place, b: &Place| a[0] >= b[2] || b[0] >= a[2] || a[1] >= b[3] || b[1] >= a[3];
    let offset = offsets.into_iter().find(|at| taken.iter().all(|other| apart(&place(at), other)))?;
    taken.push(place(&offset));
    Some(offset)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::report::tests::sample;

    #[test]
    fn both_files_hold_what_was_measured() -> Result<(), Box<dyn std::error::Error>> {
        let folder = std::env::temp_dir().join(format!("celfx-plot-{}", std::process::id()));
        let report = sample();
        write("smoke", &report.rows.iter().collect::<Vec<_>>(), &folder)?;
        let svg = std::fs::read_to_string(folder.join("smoke.svg"))?;
        let texts =
            ["smoke gaussian", "run time in ms", "rms error against f64 reference", "direct", "naive", "growth"];
        for text in texts.into_iter().chain(["rms error, not measured", "10", "1000", "1e-7", "0"]) {
            assert!(svg.contains(&format!(">\n{text}\n</text>")), "{text}");
        }
        // Three rows have an error; each of four variants is in a legend, too.
        assert_eq!(svg.matches("<circle").count(), 7);
        let png = crate::io::image::read_png(&folder.join("smoke.png"))?;
        assert_eq!(png.size, [2 * PANEL[0], 2 * PANEL[1]]);
        let dark = png.pixels.iter().filter(|p| p[0] < 0.1).count();
        assert!(dark > 3000, "{dark} dark pixels");
        std::fs::remove_dir_all(&folder)?;
        Ok(())
    }

    #[test]
    fn methods_are_series_where_passes_compare_them() {
        assert_eq!(method("tiles sobol R=16"), ("tiles sobol", Some("R=16".into())));
        assert_eq!(method("expected 8"), ("expected", Some("8 bins".into())));
        assert_eq!(method("mboit 6"), ("mboit", Some("6 moments".into())));
        assert_eq!(method("wavelet 3"), ("wavelet", Some("rank 3".into())));
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
        let names =
            |panel: &Panel| panel.legend().map(|names| names.iter().map(|name| name.0.to_owned()).collect::<Vec<_>>());
        let panels = panels("flame", &rows);
        let titles: Vec<&str> = panels.iter().map(|panel| panel.title.as_str()).collect();
        assert_eq!(titles, ["flame accumulate, paper", "flame accumulate, thin (cut)"]);
        assert_eq!(names(&panels[1]), [vec!["tiles", "sorted"], vec!["thin (cut)"]]);
        // The same rows of another effect are one panel, in which variants are apart.
        let panels = super::panels("smoke", &rows);
        assert_eq!((panels.len(), names(&panels[0]).map(|names| names.len())), (1, [3, 2]));
    }

    #[test]
    fn axes_span_whole_decades() {
        assert_eq!(decades([0.0, 0.02, 3.0, f64::NAN].into_iter()), [-2, 1]);
        assert_eq!(decades([10.0].into_iter()), [1, 2]);
        assert_eq!(decades(std::iter::empty()), [-1, 0]);
        assert_eq!((plain_power(-2), plain_power(3)), ("0.01".into(), "1000".into()));
    }

    #[test]
    fn labels_take_no_room_twice() {
        let mut taken = Vec::new();
        let places: Vec<_> = (0..5).map(|_| room((100, 100), (40, 10), 0, &mut taken)).collect();
        assert_eq!(places, [Some((8, -14)), Some((-48, 4)), None, None, None]);
        assert_eq!(room((100, 130), (40, 10), 1, &mut taken), Some((-48, 4)));
        assert_eq!(along((0, 0), (64, -64)).last(), Some((64, -64)));
    }
}
