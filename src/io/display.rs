//! How linear light becomes the codes of a display: for pictures that people look at.

use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::image::srgb8;

/// What a shot says of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Output {
    /// `"sRGB"`, `"Rec.709"`, `"ACES 2.0 SDR"`, or `"DISPLAY / VIEW"` of an OCIO config.
    pub view: String,
    /// The config: a file, or `ocio://NAME`; none: the one that is built in, of ACES 2.0.
    pub config: Option<PathBuf>,
    /// The config's colour space of linear light with the primaries of Rec. 709; none: found by its usual names.
    pub space: Option<String>,
}

impl Default for Output {
    fn default() -> Output {
        Output { view: SRGB.to_owned(), config: None, space: None }
    }
}

const SRGB: &str = "sRGB";
const REC709: &str = "Rec.709";
/// Gamma of displays after ITU-R BT.1886 with a black of 0.
const REC709_GAMMA: f64 = 2.4;

/// Codes of red, green and blue, 0 to 1, of linear light that is not premultiplied.
type Codes = dyn Fn([f32; 3]) -> [f32; 3] + Send + Sync;

/// A display.
#[derive(Clone)]
pub enum Display {
    /// As in IEC 61966-2-1.
    Srgb,
    /// With a gamma of 2.4.
    Rec709,
    /// As an OCIO config's view has it.
    View(Arc<Codes>),
}

impl fmt::Debug for Display {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Display::Srgb => "Srgb",
            Display::Rec709 => "Rec709",
            Display::View(_) => "View",
        })
    }
}

impl Display {
    /// The one that a shot asks for; or the key that is wrong, and why.
    pub fn new(output: &Output) -> Result<Display, (&'static str, String)> {
        match &output.view[..] {
            SRGB => Ok(Display::Srgb),
            REC709 => Ok(Display::Rec709),
            view => of_config(view, output.config.as_deref(), output.space.as_deref()).map(Display::View),
        }
    }

    /// What shows a picture that has been coded for this one and is read back.
    #[must_use]
    pub fn read_back(&self) -> Display {
        match self {
            Display::View(_) => Display::Srgb,
            other => other.clone(),
        }
    }

    /// Its gamma, where files say it.
    pub(super) fn gamma(&self) -> Option<f64> {
        matches!(self, Display::Rec709).then_some(REC709_GAMMA)
    }

    /// 8-bit pixels with straight alpha of linear premultiplied ones. What is outside 0 to 1 is clamped, NaN is 0.
    pub fn codes(&self, pixels: &[[f32; 4]]) -> Vec<[u8; 4]> {
        let gamma = |[r, g, b]: [f32; 3]| [r, g, b].map(|c| c.max(0.0).powf((1.0 / REC709_GAMMA) as f32));
        match self {
            Display::Srgb => srgb8(pixels),
            Display::Rec709 => coded(pixels, &gamma),
            Display::View(codes) => coded(pixels, &**codes),
        }
    }
}

fn coded(pixels: &[[f32; 4]], codes: &(dyn Fn([f32; 3]) -> [f32; 3] + Send + Sync)) -> Vec<[u8; 4]> {
    // Flat tones: most pixels are as the one before.
    let mut before = ([0.0; 4], [0; 4]);
    let byte = |unit: f32| (unit.clamp(0.0, 1.0) * 255.0).round() as u8;
    let convert = |pixel: &[f32; 4]| {
        if *pixel != before.0 {
            let [r, g, b, alpha] = *pixel;
            let straight = if alpha > 0.0 { [r, g, b].map(|c| c / alpha.min(1.0)) } else { [0.0; 3] };
            let [r, g, b] = if alpha > 0.0 { codes(straight).map(byte) } else { [0; 3] };
            before = (*pixel, [r, g, b, byte(alpha)]);
        }
        before.1
    };
    pixels.iter().map(convert).collect()
}

/// What there is without OpenColorIO.
#[cfg(not(feature = "ocio"))]
fn of_config(view: &str, _: Option<&Path>, _: Option<&str>) -> Result<Arc<Codes>, (&'static str, String)> {
    let built = "this celfx was built without OpenColorIO (cargo build --features ocio)";
    Err(("output.view", format!("{view:?}: allowed: {SRGB:?} or {REC709:?}; {built}")))
}

#[cfg(feature = "ocio")]
fn of_config(view: &str, config: Option<&Path>, space: Option<&str>) -> Result<Arc<Codes>, (&'static str, String)> {
    ocio::of_config(view, config, space)
}

/// Views of OpenColorIO.
#[cfg(feature = "ocio")]
mod ocio {
    use std::path::Path;
    use std::sync::Arc;

    use ::ocio::Config;

    use super::{Codes, REC709, SRGB};

    /// The config that is built in.
    const BUILT_IN: &str = "ocio://cg-config-v4.0.0_aces-v2.0_ocio-v2.5";
    /// Names of views, for short, and what they are in it.
    const SHORT: [(&str, [&str; 2]); 1] = [("ACES 2.0 SDR", ["sRGB - Display", "ACES 2.0 - SDR 100 nits (Rec.709)"])];
    /// What configs call linear light with the primaries of Rec. 709.
    const LINEAR: [&str; 6] = [
        "Linear Rec.709 (sRGB)",
        "lin_rec709",
        "lin_srgb",
        "Utility - Linear - sRGB",
        "Utility - Linear - Rec.709",
        "Linear sRGB",
    ];
    const BETWEEN: &str = " / ";

    pub(super) fn of_config(
        view: &str,
        path: Option<&Path>,
        space: Option<&str>,
    ) -> Result<Arc<Codes>, (&'static str, String)> {
        let name = path.map_or(BUILT_IN.into(), Path::to_string_lossy);
        let config = Config::create_from_file(&name).map_err(|error| {
            ("output.config", format!("{name:?}: {error}; allowed: an OCIO config, or ocio://NAME"))
        })?;
        let short = SHORT.iter().find(|(short, _)| *short == view && path.is_none()).map(|(_, names)| *names);
        let named = |(display, view): (&str, &str)| config.has_view(display, view);
        let pair =
            short.map(|[display, view]| (display, view)).or(view.split_once(BETWEEN)).filter(|pair| named(*pair));
        let Some((display, of_display)) = pair else {
            return Err(("output.view", format!("{view:?}: allowed: {}", allowed(&config, path.is_none()))));
        };
        let spaces = space.map_or(LINEAR.to_vec(), |space| vec![space]);
        let Some(space) = spaces.iter().find(|name| config.has_color_space(name)) else {
            let (expected, names) = ("the name of the config's linear Rec. 709", spaces.join("\", \""));
            return Err(("output.space", format!("no colour space \"{names}\" in {name}: allowed: {expected}")));
        };
        let processor = config
            .get_display_view_processor(space, display, of_display)
            .map_err(|error| ("output.view", format!("{view:?}: {error}")))?;
        let processor = processor.default_cpu_processor();
        Ok(Arc::new(move |mut pixel| {
            processor.apply_rgb(&mut pixel);
            pixel
        }))
    }

    /// The views that there are.
    fn allowed(config: &Config, is_built_in: bool) -> String {
        let mut all = vec![format!("{SRGB:?}"), format!("{REC709:?}")];
        all.extend(SHORT.iter().filter(|_| is_built_in).map(|(short, _)| format!("{short:?}")));
        for display in (0..config.num_displays()).map(|i| config.display(i)) {
            let views = (0..config.num_views(&display)).map(|i| config.view(&display, i));
            all.extend(views.map(|view| format!("\"{display}{BETWEEN}{view}\"")));
        }
        all.join(", ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn display(view: &str) -> Display {
        Display::new(&Output { view: view.to_owned(), ..Output::default() }).expect(view)
    }

    #[test]
    fn codes_are_those_of_the_display() {
        let pixels = [[0.5, 0.25, 0.0, 1.0], [0.25, 0.125, 0.0, 0.5], [2.0, -1.0, f32::NAN, 1.0], [0.0; 4]];
        // By hand, of 0.5 and 0.25.
        for (view, [half, quarter]) in [(SRGB, [188, 137]), (REC709, [191, 143])] {
            let found = display(view).codes(&pixels);
            let expected = [[half, quarter, 0, 255], [half, quarter, 0, 128], [255, 0, 0, 255], [0; 4]];
            assert_eq!(found, expected, "{view}");
        }
    }

    #[cfg(not(feature = "ocio"))]
    #[test]
    fn what_is_not_built_in_is_said() {
        let output = Output { view: "ACES 2.0 SDR".to_owned(), ..Output::default() };
        let (key, why) = Display::new(&output).expect_err("not there");
        assert!(key == "output.view" && why.contains("--features ocio") && why.contains("Rec.709"), "{why}");
    }

    #[cfg(feature = "ocio")]
    #[test]
    fn views_that_are_not_there_are_told_with_those_that_are() {
        let wrong = |output: Output| Display::new(&output).expect_err("wrong");
        let (key, why) = wrong(Output { view: "ACES".to_owned(), ..Output::default() });
        assert!(key == "output.view" && why.contains("\"sRGB - Display / Un-tone-mapped\""), "{why}");
        let aces = "ACES 2.0 SDR".to_owned();
        let (key, _) = wrong(Output { config: Some("no.ocio".into()), view: aces.clone(), ..Output::default() });
        assert_eq!(key, "output.config");
        let (key, why) = wrong(Output { space: Some("lin".to_owned()), view: aces, ..Output::default() });
        assert!(key == "output.space" && why.contains("\"lin\""), "{why}");
        // Without a tone mapping that display is sRGB.
        let pixels: Vec<[f32; 4]> = (0..=1000).map(|i| [i as f32 / 1000.0, 0.5, 0.0, 1.0]).collect();
        let near = |a: &[u8; 4], b: &[u8; 4]| (0..4).all(|c| a[c].abs_diff(b[c]) <= 1);
        let same = display("sRGB - Display / Un-tone-mapped").codes(&pixels);
        assert!(same.iter().zip(display(SRGB).codes(&pixels)).all(|(a, b)| near(a, &b)));
    }
}
