//! `celfx render`: a shot to a sequence of pictures.

mod cache;
mod device;
mod encode;
mod input;
mod layered;
mod origin;
mod outputs;
mod reader;
mod strip;
mod turns;
mod video;

use std::ffi::OsString;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, sync_channel};
use std::thread;
use std::time::Duration;

use clap::{Args, ValueEnum};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use super::{Common, Failure, frames, memory, print, visible};
use crate::interrupt;
use crate::io::display::Display;
use crate::io::image::{Packing, Picture};
use crate::io::overlap::{self, Files};
use crate::io::pattern::Pattern;
use crate::io::shot::{Background, Shot};
use crate::io::{picture, remove_stale_parts, write_atomic};
use crate::profile::{self, FrameTimes};
use crate::program::layers::Wanted;
use crate::program::{self, layers};
use cache::Cache;
use device::Renderer;
use encode::{Pool, Shared, no_thread};
use input::Inputs;
use origin::Origins;
use outputs::{Found, Frame, Outputs};
use reader::{Read, Reader, Step};
use strip::Strip;
use turns::Turns;
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
  celfx render my.toml --resume --cache cache              as often as there are machines, at the same time

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
    /// Add motion vectors to the layers: pixels to the right and up, from what a pixel shows to where it was a frame before
    #[arg(long, requires = "layers")]
    motion: bool,
    /// How one file a frame for compositing is packed, always without loss [default: zip]
    #[arg(long, value_name = "NAME")]
    compression: Option<Packing>,
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
    /// renders them again, `strict` refuses to begin. Processes that write the same frames share them: each is rendered once
    #[arg(long, value_name = "WHEN", num_args = 0..=1, require_equals = true, default_missing_value = "again")]
    resume: Option<Resume>,
    /// Keep what smoke leaves behind from frame to frame in this folder, and begin there: a process that renders later frames need
    /// not step through all before them. Any shots and processes may share it; it may be emptied at any time
    #[arg(long, value_name = "DIR")]
    cache: Option<PathBuf>,
}

/// What becomes of frames that were made from something else.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Resume {
    Again,
    Strict,
}

impl Options {
    /// The options whose files are of all frames together, and these files.
    pub(super) fn of_all_frames(&self) -> impl Iterator<Item = (&'static str, &Path)> {
        let all = [("--profile", &self.profile), ("--sheet", &self.sheet), ("--animation", &self.animation)];
        all.into_iter().filter_map(|(option, path)| Some((option, path.as_deref()?)))
    }

    fn others(&self) -> Vec<Files> {
        let file =
            |(option, path): (&str, &Path)| Files::new(format!("{option} {}", path.display()), Pattern::single(path));
        self.of_all_frames().map(file).collect()
    }

    /// The shot, and the frames of it that are asked for.
    pub(super) fn shot(&self) -> Result<(Arc<Shot>, [u32; 2]), Failure> {
        let shot = Arc::new(program::load(&self.shot, &self.set)?);
        let frames = self.frames.unwrap_or(shot.frames);
        shot.check_effects().map_err(|why| Failure::usage(format!("{}: {why}", shot.name)))?;
        let [first, last] = frames;
        if first < shot.frames[0] || last > shot.frames[1] {
            let [a, b] = shot.frames;
            return Err(Failure::usage(format!("--frames {first}-{last}: the shot has frames {a} to {b}")));
        }
        Ok((shot, frames))
    }

    /// As on the command line, but for frames and files of all of them: what parts of a sequence have in common. They resume.
    pub(super) fn arguments(&self) -> Vec<OsString> {
        let Options { shot, set, output, layers, motion, compression, resume, cache, .. } = self;
        let resume = if *resume == Some(Resume::Strict) { "--resume=strict" } else { "--resume" };
        let mut all = vec![OsString::from(shot)];
        all.extend(set.iter().flat_map(|set| ["--set".into(), set.into()]));
        all.extend(["--output".into(), output.into()]);
        all.extend(frames::path("--layers", layers));
        all.extend(motion.then(|| "--motion".into()));
        let packing = compression.and_then(|packing| packing.to_possible_value());
        all.extend(frames::option("--compression", &packing.map(|value| value.get_name().to_owned())));
        all.extend(frames::path("--cache", cache));
        all.push(resume.into());
        all
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
    let (shot, frames) = options.shot()?;
    let [first, last] = frames;
    let mut names = layers::names(|effect| shot.has(effect));
    names.extend(options.motion.then_some(layers::VECTORS));
    let layers = options.layers.as_deref().map(|path| (path, &names[..]));
    let outputs = Outputs::new(&options.output, layers, options.others(), (shot.size, shot.fps), frames)?;
    let display = Display::new(&shot.output).map_err(|(key, why)| Failure::usage(format!("{key} = {why}")))?;
    let outputs = outputs.packed(options.compression)?.shown_on(display);
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
    let cache = options.cache.as_deref().map(Cache::new);
    let claims = options.resume.is_some();
    let vectors = options.motion;
    let job = Job { shot: &shot, first, outputs, strips, timed, vectors, claims, cache, common };
    memory::doing("reading the shot's input", None);
    let (inputs, mut origins) = job.open()?;
    let missing = job.missing(last, options.resume, &mut origins, &inputs)?;
    // Only what this run will write itself: another one may be at the other frames.
    let own = if claims { &[][..] } else { &missing };
    remove_stale_parts(own.iter().flat_map(|frame| job.outputs.files(*frame)).chain(job.outputs.others()));
    let times = job.render_all(missing, inputs, origins)?;
    job.strips.iter().try_for_each(Strip::write)?;
    let shown = (first..=last).map(|frame| job.outputs.picture(frame));
    video.map_or(Ok(()), |video| video.write(shown, &job.outputs.display(true)))?;
    job.report(&times, count, options.profile.as_deref())
}

/// Costs of rendering.
#[derive(Default)]
struct Times {
    /// Frames that were rendered.
    rendered: usize,
    frames: Vec<FrameTimes>,
    /// Whether the device has no clock.
    has_none: bool,
}

/// The frames to render, and where they go.
struct Job<'a> {
    shot: &'a Arc<Shot>,
    /// First frame that is rendered.
    first: u32,
    outputs: Outputs,
    strips: Vec<Strip>,
    /// Whether passes are timed.
    timed: bool,
    /// Whether there are motion vectors among the layers.
    vectors: bool,
    /// Whether frames are claimed.
    claims: bool,
    cache: Option<Cache>,
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
                Found::Finished(pixels) => self.collect(frame, &pixels, true),
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

    /// Renders the `missing` frames, but for those that other processes do.
    fn render_all(&self, mut missing: Vec<u32>, inputs: Inputs, origins: Origins) -> Result<Times, Failure> {
        let collect = |frame, pixels: &[[f32; 4]]| self.collect(frame, pixels, true);
        let turns = Turns::new(&self.outputs, self.claims, &collect);
        let mut opened = Some((inputs, origins));
        let mut times = Times::default();
        while !missing.is_empty() {
            let (inputs, origins) = match opened.take() {
                Some(opened) => opened,
                None => self.open()?,
            };
            let others = self.render(&missing, inputs, origins, &turns, &mut times)?;
            if turns.is_unsure() {
                self.say("the folder's file system has no locks: frames may be rendered by several processes");
            }
            if !others.is_empty() {
                let (count, s) = (others.len(), if others.len() == 1 { "" } else { "s" });
                self.say(&format!("waiting for {count} frame{s} that other processes render"));
            }
            missing = turns.wait(others)?;
        }
        Ok(times)
    }

    /// The shot's input, and hashes of what its frames are made from.
    fn open(&self) -> Result<(Inputs, Origins<'_>), Failure> {
        let inputs = Inputs::open(self.shot)?;
        let origins = Origins::new(self.shot, inputs.effects())?;
        Ok((inputs, origins))
    }

    /// Renders those of the `missing` frames, which are some, that no other process is at; the others, with their origins.
    fn render(
        &self,
        missing: &[u32],
        mut inputs: Inputs,
        mut origins: Origins,
        turns: &Turns,
        times: &mut Times,
    ) -> Result<Vec<(u32, u128)>, Failure> {
        let wanted = self.outputs.wanted();
        let effects = inputs.describe(missing, wanted != Wanted::None, self.common)?;
        let effects = if self.vectors { effects.with_vectors() } else { effects };
        inputs.notes(self.shot).iter().for_each(|note| self.say(note));
        let background = background(self.shot)?;
        origins.check()?;
        memory::doing("opening the device", None);
        let mut renderer = Renderer::new(self.common, self.shot, effects, wanted, self.timed, background.as_ref())?;
        times.has_none = !renderer.has_clock();
        if self.common.verbose {
            self.say(&(renderer.describe() + &inputs.choices()));
        }
        let (queue, shared) = Shared::new(self.common.threads());
        let work = |frame: Frame| self.write(frame);
        let others = thread::scope(|scope| {
            let (ahead, steps) = sync_channel(1);
            let reader = Reader { shot: self.shot, inputs, origins, turns, cache: self.cache.as_ref() };
            let reader = move || reader.run(missing, &ahead);
            let reader = thread::Builder::new().spawn_scoped(scope, reader).map_err(|e| no_thread("reads", &e))?;
            let pool = Pool::start(scope, self.common.threads(), queue, &shared, work)?;
            let rendered = self.step(&mut renderer, missing.len(), &steps, times, |frame| pool.send(&shared, frame));
            // Frames in the queue are written even if the next one failed or the program was interrupted.
            let written = pool.finish(&shared);
            drop(steps);
            rendered.and(written)?;
            reader.join().map_err(|_| Failure::new(Failure::DEVICE, "the thread that reads frames has failed"))
        })?;
        renderer.finish()?;
        Ok(others)
    }

    /// Takes steps as they come and hands the rendered frames, at most so many, to `send`.
    fn step(
        &self,
        renderer: &mut Renderer,
        count: usize,
        steps: &Receiver<Read>,
        times: &mut Times,
        send: impl Fn(Frame) -> Result<(), Failure>,
    ) -> Result<(), Failure> {
        let progress = self.progress(count as u64);
        for step in steps {
            interrupt::check()?;
            let mut step = step?;
            memory::doing("rendering frame", Some(step.number));
            let (frame, frame_times) = renderer.step(&mut step)?;
            renderer.remarks().iter().for_each(|remark| self.say(remark));
            if let Some(frame) = frame {
                times.rendered += 1;
                times.frames.extend(frame_times);
                send(frame)?;
                progress.inc(1);
            }
            self.keep(renderer, &step)?;
        }
        progress.finish_and_clear();
        Ok(())
    }

    /// Keeps what a step leaves, if it is to be kept. Without it all goes on as well, only slower.
    fn keep(&self, renderer: &mut Renderer, step: &Step) -> Result<(), Failure> {
        if let (Some(cache), Some(key)) = (&self.cache, step.keeps) {
            let past = renderer.past()?;
            cache.write(key, &past).unwrap_or_else(|error| self.say(&format!("--cache: {error}")));
        }
        Ok(())
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

    fn write(&self, frame: Frame) -> Result<(), Failure> {
        memory::doing("writing frame", Some(frame.number));
        self.outputs.write(&frame)?;
        drop(frame.claim);
        self.collect(frame.number, &frame.pixels, false);
        if self.common.verbose {
            self.say(&format!("wrote {}", self.outputs.picture(frame.number).display()));
        }
        Ok(())
    }

    /// Shows a frame, which was read from its picture's file or has just been made, in what is of all frames together.
    fn collect(&self, frame: u32, pixels: &[[f32; 4]], is_read: bool) {
        let display = self.outputs.display(is_read);
        self.strips.iter().for_each(|strip| strip.add((frame - self.first) as usize, pixels, &display));
    }

    /// The profile's file, and the table on standard output.
    fn report(&self, times: &Times, count: usize, file: Option<&Path>) -> Result<(), Failure> {
        let Times { frames: times, has_none, rendered } = times;
        if let Some(path) = file {
            if let Some(why) = untimed(times.len(), *rendered, *has_none) {
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
        let frames = if *rendered == 1 { "frame" } else { "frames" };
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
