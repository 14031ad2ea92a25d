//! `celfx render`: a shot to a sequence of pictures.

mod device;
mod encode;
mod input;
mod layered;
mod origin;
mod outputs;
mod strip;
mod video;

use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, sync_channel};
use std::thread;
use std::time::Duration;

use clap::{Args, ValueEnum};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use super::{Common, Failure, memory, print, visible};
use crate::interrupt;
use crate::io::image::Picture;
use crate::io::overlap::{self, Files};
use crate::io::pattern::Pattern;
use crate::io::shot::{Background, Shot};
use crate::io::{picture, remove_stale_parts, write_atomic};
use crate::profile::{self, FrameTimes};
use crate::program::{self, layers};
use device::Renderer;
use encode::{Pool, Shared, no_thread};
use input::{Inputs, Read};
use origin::Origins;
use outputs::{Found, Frame, Outputs};
use strip::Strip;
use video::Video;

const EXAMPLES: &str = "\
Examples:
  celfx render builtin:smoke                               48 frames into ./out
  celfx render my.toml -o out/%04d.png --resume            only what is missing, or made from something else
  celfx render my.toml --frames 12 -o frame.exr            one frame, the same as in the sequence
  celfx render builtin:flame --set flame.mode=expected     fire without grain
  celfx render my.toml --set smoke.sigma=8 --set smoke.shadow=map
  celfx render my.toml --layers layers --profile p.json    every pass's image, and its cost
  celfx render my.toml --layers comp.####.exr              one file a frame for compositing

Frames do not depend on how they are rendered: a frame alone, resumed, or with another number of
threads is the same bit for bit, because smoke is always stepped from the shot's first frame.";

/// Options of `celfx render`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct Options {
    /// The shot: a TOML file, or builtin:smoke, :cloud, :paper_smoke, :flame, :paper_flame, :campfire, :blur or
    /// :paper_blur (`celfx shot` prints them)
    shot: String,
    /// Frames to render, both ends included, within those of the shot [default: all]
    #[arg(long, value_name = "A-B", value_parser = frame_range)]
    frames: Option<[u32; 2]>,
    /// Override one key of the shot; VALUE is TOML, quotes around words may be left out
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// The pictures: .png (8-bit sRGB) or .exr (linear float); #### or %04d is the frame number
    #[arg(short, long, value_name = "PATTERN", default_value = "out/####.png")]
    output: PathBuf,
    /// Also write what each pass made: into a folder, LAYER.####.exr and arrays as .npy; or, with FILE.####.exr, one file a
    /// frame for compositing, with the picture, Z, all layers that are images, and Cryptomatte
    #[arg(long, value_name = "DIR|FILE.####.exr")]
    layers: Option<PathBuf>,
    /// Write the times of all passes: .json (Chrome trace, opens in Perfetto) or .csv
    #[arg(long, value_name = "FILE", value_parser = profile_path)]
    profile: Option<PathBuf>,
    /// Write a contact sheet of the frames
    #[arg(long, value_name = "FILE.png", value_parser = |name: &str| named(name, &["png"]))]
    sheet: Option<PathBuf>,
    /// Write the frames as an animation, too: .gif; .apng, with exact colours and alpha; or .mp4, .mov or .webm,
    /// which take ffmpeg to be installed
    #[arg(long, value_name = "FILE", value_parser = |name: &str| named(name, &["gif", "apng", "mp4", "mov", "webm"]))]
    animation: Option<PathBuf>,
    /// Keep frames that are complete and made from the same settings and input; of those that are not: `again`
    /// renders them again, `strict` refuses to begin
    #[arg(long, value_name = "WHEN", num_args = 0..=1, require_equals = true, default_missing_value = "again")]
    resume: Option<Resume>,
}

/// What becomes of frames that were made from something else.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Resume {
    Again,
    Strict,
}

impl Options {
    /// The files of all frames together, each with its option.
    fn others(&self) -> Vec<Files> {
        let others =
            [("--profile", &self.profile), ("--sheet", &self.sheet), ("--animation", &self.animation)].into_iter();
        let file = |(option, path): (&str, &Option<PathBuf>)| {
            path.as_ref().map(|path| Files::new(format!("{option} {}", path.display()), Pattern::single(path)))
        };
        others.filter_map(file).collect()
    }
}

pub(super) fn frame_range(text: &str) -> Result<[u32; 2], String> {
    let number = |text: &str| text.parse().map_err(|_| "expected A-B or A, for example 1-48".to_owned());
    let (first, last) = text.split_once('-').unwrap_or((text, text));
    match (number(first)?, number(last)?) {
        (first, last) if first <= last => Ok([first, last]),
        _ => Err("the first frame is above the last".to_owned()),
    }
}

fn profile_path(name: &str) -> Result<PathBuf, String> {
    named(name, &["json", "csv"])
}

fn named(name: &str, extensions: &[&str]) -> Result<PathBuf, String> {
    let path = PathBuf::from(name);
    let extension = path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
    match extension.is_some_and(|e| extensions.contains(&e.as_str())) {
        true => Ok(path),
        false => Err(format!("the name must end in .{}", extensions.join(" or ."))),
    }
}

pub(super) fn run(options: &Options, common: &Common) -> Result<(), Failure> {
    memory::doing("reading the shot", None);
    let shot = Arc::new(program::load(&options.shot, &options.set)?);
    let frames = options.frames.unwrap_or(shot.frames);
    shot.check_effects().map_err(|why| Failure::usage(format!("{}: {why}", shot.name)))?;
    let [first, last] = frames;
    if first < shot.frames[0] || last > shot.frames[1] {
        let [a, b] = shot.frames;
        return Err(Failure::usage(format!("--frames {first}-{last}: the shot has frames {a} to {b}")));
    }
    let names = layers::names(|effect| shot.has(effect));
    let layers = options.layers.as_deref().map(|path| (path, &names[..]));
    let outputs = Outputs::new(&options.output, layers, options.others(), (shot.size, shot.fps), frames)?;
    overlap::check(&shot.inputs(), &outputs.all(), shot.frames, frames)?;
    outputs.probe(frames)?;
    interrupt::install(Failure::INTERRUPTED);

    let count = (last - first) as usize + 1;
    let video = options.animation.as_deref().map(|path| Video::new(path, shot.size, shot.fps)).transpose()?.flatten();
    let strips: Vec<Strip> = [
        options.sheet.as_deref().map(|path| Strip::sheet(path, shot.size, count)),
        options
            .animation
            .as_deref()
            .filter(|_| video.is_none())
            .map(|path| Strip::animation(path, shot.size, count, shot.fps)),
    ]
    .into_iter()
    .flatten()
    .collect();
    let timed = options.profile.is_some() || !common.quiet;
    let job = Job { shot: &shot, first, outputs, strips, timed, common };
    memory::doing("reading the shot's input", None);
    let inputs = Inputs::open(&shot)?;
    let mut origins = Origins::new(&shot, inputs.effects())?;
    let missing = job.missing(last, options.resume, &mut origins, &inputs)?;
    // Only what this run will write itself: another one may be at the other frames.
    remove_stale_parts(missing.iter().flat_map(|frame| job.outputs.files(*frame)).chain(job.outputs.others()));
    let times = if missing.is_empty() { Times::default() } else { job.render(&missing, inputs, origins)? };
    job.strips.iter().try_for_each(Strip::write)?;
    video.map_or(Ok(()), |video| video.write((first..=last).map(|frame| job.outputs.picture(frame))))?;
    job.report(&times, missing.len(), count, options.profile.as_deref())
}

/// Costs of rendering.
#[derive(Default)]
struct Times {
    frames: Vec<FrameTimes>,
    /// Whether the device has no clock.
    has_none: bool,
}

/// The frames to render, and where they go.
struct Job<'a> {
    shot: &'a Shot,
    /// First frame that is rendered.
    first: u32,
    outputs: Outputs,
    strips: Vec<Strip>,
    /// Whether passes are timed.
    timed: bool,
    common: &'a Common,
}

impl Job<'_> {
    /// The frames that are to be rendered: all, or with `resume` those whose files are not all there and whole, or were
    /// made from something else.
    fn missing(
        &self,
        last: u32,
        resume: Option<Resume>,
        origins: &mut Origins,
        inputs: &Inputs,
    ) -> Result<Vec<u32>, Failure> {
        let Some(resume) = resume else { return Ok((self.first..=last).collect()) };
        let (mut missing, mut others) = (Vec::new(), Vec::new());
        for frame in self.first..=last {
            interrupt::check()?;
            match self.outputs.find(frame, origins.of(frame, inputs.effects())?) {
                Found::Finished(pixels) => self.collect(frame, &pixels),
                Found::Nothing => missing.push(frame),
                Found::Other => {
                    missing.push(frame);
                    others.push(frame);
                }
            }
        }
        origins.check()?;
        let Some(first) = others.first() else { return Ok(missing) };
        let first = self.outputs.picture(*first);
        let (first, count) = (first.display(), others.len());
        match resume {
            Resume::Again => {
                let (frames, are) = if count == 1 { ("frame", "is") } else { ("frames", "are") };
                let why = "not made from these settings and this input, or of an older version";
                self.say(&format!("{count} {frames} {are} rendered again: {why} (the first is {first})"));
                Ok(missing)
            }
            Resume::Strict => {
                let why = format!("{first} was not made from these settings and this input, or is of an older version");
                let so = if count == 1 { String::new() } else { format!(", and so are {} more frames", count - 1) };
                let expected = "--resume without =strict, which renders them again, or another -o";
                Err(Failure::usage(format!("--resume=strict: {why}{so}; expected {expected}")))
            }
        }
    }

    /// Renders the `missing` frames, which are some.
    fn render(&self, missing: &[u32], mut inputs: Inputs, mut origins: Origins) -> Result<Times, Failure> {
        let has_layers = self.outputs.has_layers();
        let effects = inputs.describe(missing, has_layers, self.common)?;
        inputs.notes(self.shot).iter().for_each(|note| self.say(note));
        let background = background(self.shot)?;
        origins.check()?;
        memory::doing("opening the device", None);
        let mut renderer = Renderer::new(self.common, self.shot, effects, has_layers, self.timed, background.as_ref())?;
        let has_none = !renderer.has_clock();
        if self.common.verbose {
            self.say(&(renderer.describe() + &inputs.choices()));
        }
        let (queue, shared) = Shared::new(self.common.threads());
        let work = |frame: Frame| self.write(&frame);
        let times = thread::scope(|scope| {
            let (ahead, steps) = sync_channel(1);
            let reader = move || inputs.read_ahead(self.shot, origins, missing, &ahead);
            thread::Builder::new().spawn_scoped(scope, reader).map_err(|e| no_thread("reads", &e))?;
            let pool = Pool::start(scope, self.common.threads(), queue, &shared, work)?;
            let rendered = self.step(&mut renderer, missing.len(), &steps, |frame| pool.send(&shared, frame));
            // Frames in the queue are written even if the next one failed or the program was interrupted.
            let written = pool.finish(&shared);
            drop(steps);
            rendered.and_then(|times| written.map(|()| times))
        })?;
        renderer.finish()?;
        Ok(Times { frames: times, has_none })
    }

    /// Takes steps as they come and hands the rendered frames, so many, to `send`.
    fn step(
        &self,
        renderer: &mut Renderer,
        count: usize,
        steps: &Receiver<Read>,
        send: impl Fn(Frame) -> Result<(), Failure>,
    ) -> Result<Vec<FrameTimes>, Failure> {
        let progress = self.progress(count as u64);
        let mut times = Vec::new();
        for step in steps {
            interrupt::check()?;
            let step = step?;
            memory::doing("rendering frame", Some(step.number));
            let (frame, frame_times) = renderer.step(&step)?;
            renderer.remarks().iter().for_each(|remark| self.say(remark));
            if let Some(frame) = frame {
                times.extend(frame_times);
                send(frame)?;
                progress.inc(1);
            }
        }
        progress.finish_and_clear();
        Ok(times)
    }

    fn progress(&self, frames: u64) -> ProgressBar {
        let target = match self.common.quiet {
            true => ProgressDrawTarget::hidden(),
            // Draws only where standard error is a terminal.
            false => ProgressDrawTarget::stderr(),
        };
        let style = ProgressStyle::with_template("{bar:40} {pos}/{len} frames, {elapsed}, {per_sec}, {eta} left");
        let bar = ProgressBar::with_draw_target(Some(frames), target);
        // A frame may take long.
        bar.enable_steady_tick(Duration::from_secs(1));
        match style {
            Ok(style) => bar.with_style(style),
            Err(_) => bar,
        }
    }

    fn write(&self, frame: &Frame) -> Result<(), Failure> {
        memory::doing("writing frame", Some(frame.number));
        self.outputs.write(frame)?;
        self.collect(frame.number, &frame.pixels);
        if self.common.verbose {
            self.say(&format!("wrote {}", self.outputs.picture(frame.number).display()));
        }
        Ok(())
    }

    fn collect(&self, frame: u32, pixels: &[[f32; 4]]) {
        self.strips.iter().for_each(|strip| strip.add((frame - self.first) as usize, pixels));
    }

    /// The profile's file, and the table on standard output.
    fn report(&self, times: &Times, rendered: usize, count: usize, file: Option<&Path>) -> Result<(), Failure> {
        let Times { frames: times, has_none } = times;
        if let Some(path) = file {
            if let Some(why) = untimed(times.len(), rendered, *has_none) {
                self.say(&format!("{}: {why}", path.display()));
            }
            let is_csv = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("csv"));
            let text = if is_csv { profile::csv(times) } else { profile::chrome_trace(times, "celfx") };
            write_atomic(path, |file| file.write_all(text.as_bytes()))?;
        }
        if self.common.quiet {
            return Ok(());
        }
        let kept = count - rendered;
        let mut table = if times.is_empty() { String::new() } else { profile::table(times) };
        if self.common.verbose {
            table += &profile::skips(times);
        }
        let kept = if kept > 0 { format!(", {kept} kept") } else { String::new() };
        let frames = if rendered == 1 { "frame" } else { "frames" };
        let more = if count > 1 { " ..." } else { "" };
        let first = self.outputs.picture(self.first);
        print(&format!("{table}{rendered} {frames} rendered{kept}: {}{more}\n", first.display()))
    }

    fn say(&self, text: &str) {
        if !self.common.quiet {
            // Nothing is left to tell where standard error is closed.
            let _ = writeln!(std::io::stderr(), "celfx: {}", visible(text));
        }
    }
}

/// The remark on a profile that lacks times.
fn untimed(timed: usize, rendered: usize, has_none: bool) -> Option<String> {
    match (timed, rendered) {
        (_, 0) => Some("no frame was rendered, so that the profile has no times".to_owned()),
        (timed, rendered) if timed == rendered => None,
        _ if has_none => {
            Some("the profile has no times: the device's queue has no timestamps (timestampValidBits is 0)".to_owned())
        }
        _ => Some(format!(
            "the profile lacks the times of {} of {rendered} frames: the device did not give them",
            rendered - timed
        )),
    }
}

/// The picture behind the effects, if it is one.
fn background(shot: &Shot) -> Result<Option<Picture<[f32; 4]>>, Failure> {
    let Background::Image(path) = &shot.background else { return Ok(None) };
    Ok(Some(picture::read_frame(path, shot.size)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_that_are_missing_are_told_with_the_reason() {
        let says = |timed, rendered, has_none| untimed(timed, rendered, has_none).unwrap_or_default();
        assert_eq!(says(5, 5, false), "");
        assert!(says(0, 0, false).contains("no frame was rendered"));
        assert!(says(0, 5, true).contains("timestampValidBits is 0"));
        assert!(says(3, 5, false).contains("2 of 5 frames"));
    }

    #[test]
    fn frame_ranges() {
        assert_eq!((frame_range("3-9"), frame_range("7")), (Ok([3, 9]), Ok([7, 7])));
        for wrong in ["9-3", "a-b", "-3", "3-", "", "1-2-3"] {
            assert!(frame_range(wrong).is_err(), "{wrong}");
        }
    }
}
