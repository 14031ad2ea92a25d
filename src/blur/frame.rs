//! A host's description of one output.

mod topology;

pub use topology::{GroupInput, MeshSizes, PartInput, TopologyInput};

use crate::blur::desc::{Desc, MOST_SOURCES, check_seams};
use crate::blur::limits::{DRAWN_PLACES, MOST_KNOTS};
use crate::blur::mesh::Lists;
use crate::blur::motion::{Cluster, Interval, Segment, most_bounds, seams};
pub use crate::blur::motion::{FrameView, Knot};
use crate::blur::parts::PartSizes;
use crate::error::{Error, Result};
use crate::host::{Background, Content, DepthFormat, HostBuffer, HostImage, TemporalImages};
use crate::host::{check_background, check_beside, check_buffer as holds, check_depth, check_distinct, check_image};
use crate::shaders::blur::constants::{FRONTS_A_WORD, MOST_SEGMENTS, PIECE_SEGMENTS};
use crate::view::Light;

/// Poses of consecutive frames.
#[derive(Clone, Copy, Debug)]
pub struct PoseInput {
    /// Number of the first frame.
    pub first: u32,
    /// Number of frames, at least 1.
    pub count: u32,
    /// Three `f32` a point and frame, frame by frame: world position in metres, finite. Usage: `TRANSFER_SRC`.
    pub positions: HostBuffer,
}

/// Where in its sources a frame's pose is ([`crate::blur::Desc::sources`]).
#[derive(Clone, Copy, Debug)]
pub struct SkinnedInput {
    /// Number of the frame.
    pub frame: u32,
    /// Where its positions begin in each source, in bytes from the source's own offset: a multiple of 4.
    pub offsets: [u64; MOST_SOURCES],
}

/// Where trajectories come from.
#[derive(Clone, Copy, Debug)]
pub enum Trajectories<'a> {
    /// Made on the device, through these frames; at most 12 segments.
    Poses(&'a [Knot]),
    /// Given: [`Interval::pieces`]. Usage: `TRANSFER_SRC`.
    Pieces(HostBuffer),
}

/// An [`Interval`] on the device. Usage of all buffers: `TRANSFER_SRC`.
#[derive(Clone, Copy, Debug)]
pub struct IntervalInput<'a> {
    /// How much of it there is.
    pub counts: Counts,
    /// [`Interval::segments`].
    pub segments: &'a [Segment],
    /// Frames i - 1, i, i + 1, i + 2; where there is no such frame, the nearest of the others.
    pub views: [FrameView; 4],
    /// Where trajectories come from.
    pub trajectories: Trajectories<'a>,
    /// Which points move together; none exactly if the effect was made for parts, and finds it.
    pub clusters: Option<ClusterInput>,
}

/// The clusters of an [`Interval`] on the device. Usage of all buffers: `TRANSFER_SRC`.
#[derive(Clone, Copy, Debug)]
pub struct ClusterInput {
    /// [`Interval::motion`].
    pub motion: HostBuffer,
    /// [`Interval::labels`].
    pub labels: HostBuffer,
    /// [`Interval::clusters`].
    pub clusters: HostBuffer,
    /// [`Interval::bounds`].
    pub bounds: HostBuffer,
    /// [`Interval::seams`]; not looked at if there are none.
    pub seams: HostBuffer,
    /// [`Interval::fronts`].
    pub fronts: HostBuffer,
}

/// The facts of an [`Interval`] that must be known before the device has it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Counts {
    /// [`Interval::generation`].
    pub generation: u32,
    /// Clusters.
    pub clusters: u32,
    /// Rows and extreme points of all clusters.
    pub bounds: u32,
    /// Points at seams.
    pub seams: u32,
    /// The most neighbours of one of these.
    pub most_neighbours: u32,
    /// The largest |x| + |y| of an extreme point, in pixels; 0 where all clusters have rows.
    pub farthest: f32,
}

impl ClusterInput {
    /// The buffers, in the order of [`crate::blur::layout::HOST_INTERVAL`], and the bytes that are needed of each.
    pub(super) fn sized(&self, counts: &Counts, desc: &Desc) -> [(&'static str, HostBuffer, u64); 6] {
        let points = u64::from(desc.points);
        let Counts { clusters, bounds, seams, .. } = *counts;
        let words = desc.triangles.div_ceil(FRONTS_A_WORD);
        [
            ("the interval's motion", self.motion, 16 * points),
            ("the interval's labels", self.labels, 4 * points),
            ("the interval's clusters", self.clusters, size_of::<Cluster>() as u64 * u64::from(clusters)),
            ("the interval's bounds", self.bounds, 8 * u64::from(bounds)),
            ("the interval's seams", self.seams, 4 * u64::from(seams)),
            ("the interval's fronts", self.fronts, 4 * u64::from(words)),
        ]
    }
}

impl Counts {
    /// Of parts, in generation `generation` of the teeth: the number of frame i divided by `hold`.
    pub fn of_parts(parts: &PartSizes, generation: u32) -> Counts {
        let PartSizes { parts, seams, most_neighbours, .. } = *parts;
        Counts { generation, clusters: parts, seams, most_neighbours, ..Counts::default() }
    }

    /// Of an interval. The seams' neighbours are those of [`crate::blur::Mesh::neighbours`].
    pub fn of(interval: &Interval, neighbours: &Lists) -> Counts {
        let without_rows = interval.clusters.iter().filter(|cluster| !cluster.has_rows());
        let extreme = without_rows.map(|cluster| interval.bounds_of(cluster));
        Counts {
            generation: interval.generation,
            clusters: interval.clusters.len() as u32,
            bounds: interval.bounds.len() as u32,
            seams: interval.seams.len() as u32,
            most_neighbours: seams::most_neighbours(neighbours, &interval.seams),
            farthest: extreme.flatten().map(|[x, y]| x.abs() + y.abs()).fold(0.0, f32::max),
        }
    }
}

/// How frames are drawn that the host has no images of, with [`Desc::toon`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ToonInput {
    /// Frame i + 1, as the interval has it if there is one.
    pub view: FrameView,
    /// Their light.
    pub light: Light,
}

/// A frame that has been drawn, and all that it was drawn from that can change.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drawn {
    view: FrameView,
    light: Light,
}

impl Drawn {
    /// Where its image is among [`crate::blur::layout::TOON`].
    pub(super) fn place(&self, desc: &Desc) -> usize {
        self.view.frame as usize % if desc.draws_outer() { DRAWN_PLACES } else { 2 }
    }

    /// Its number.
    pub(super) fn frame(&self) -> u32 {
        self.view.frame
    }

    /// It, and what it is seen through.
    pub(super) fn view(&self) -> &FrameView {
        &self.view
    }
}

/// The depth of everything but the mesh, which hides the mesh where it is nearer, and takes the mesh's.
///
/// Where it hides the mesh, the image of frame i + 1 stays. It takes the depth that the mesh is drawn at, distorted, or,
/// where nothing moves, as it is in frame i + 1. A pixel has one depth and four samples: what the mesh covers wholly and
/// opaquely has the depth of its farthest sample, the rest has none. [`crate::blur::Blur::edges`] has what is before that,
/// so that what is behind can be blended with it: nothing of the background stays between.
/// Speed lines and after-images hide nothing.
#[derive(Clone, Copy, Debug)]
pub struct DepthInput {
    /// The image, as the view projects it. Usage: `DEPTH_STENCIL_ATTACHMENT`.
    pub host: HostImage,
    /// Frame i + 1, as the interval has it if there is one.
    pub view: FrameView,
}

/// One output, i + 1.
#[derive(Clone, Copy, Debug)]
pub struct Frame<'a> {
    /// The mesh. The first frame after creation needs it; later ones may bring another, with as many of everything or with
    /// [`TopologyInput::sizes`].
    pub mesh: Option<TopologyInput>,
    /// Poses of frames that are not on the device yet.
    pub poses: Option<PoseInput>,
    /// The pose of a frame that the host's own skinning has made; before it, those of `poses` are taken.
    pub skinned: Option<SkinnedInput>,
    /// The motion; none: nothing moves, and the output is the image of frame i + 1.
    pub interval: Option<IntervalInput<'a>>,
    /// Images of frames i and i + 1: linear light (or a format that is read as such), premultiplied, of the target's size
    /// and format. Usage: `TRANSFER_SRC`. None: they are drawn.
    pub images: Option<[HostImage; 2]>,
    /// How they are drawn; needed where there are no images.
    pub toon: Option<ToonInput>,
    /// Images of frames i - 1 and i + 2, as these: they show places that neither of these does. Without: what follows
    /// from colours elsewhere. They need [`Desc::outer`]; with that, frames that are drawn have them by themselves.
    pub outer: [Option<HostImage>; 2],
    /// Depth of what the images of frames i - 1 to i + 2 show, with the mesh or without: where something is before the mesh, an image
    /// does not show it, and the place is completed. Drawn through the interval's views; each is given exactly if its image is
    /// and the effect was made for them. Usage: `TRANSFER_SRC`.
    pub occluders: [Option<HostImage>; 4],
    /// Where it goes. Usage: `COLOR_ATTACHMENT` and `TRANSFER_DST`.
    pub target: HostImage,
    /// The host's depth, given exactly if the effect was made for one.
    pub depth: Option<DepthInput>,
    /// The background where no image shows anything but the mesh, and under frames that are drawn: [`Background::Keep`]
    /// is nothing at all. An image lies under the images of the frames, too, as far as their alpha lets it through: so they may show
    /// the mesh alone. It is as they are.
    pub background: Background,
    /// Outputs for temporal upscalers. What a pixel shows of the mesh is on its trajectory at k', and was where that is at k' - 1 in the
    /// output before; before frame i, if trajectories are not made that far, where the smoothest way through frame i - 1 has it. Nothing is
    /// written where the output is frame i + 1's image because nothing moves, or strength is 0. The mask is the share of what is smeared.
    pub temporal: TemporalImages,
}

/// Why what is given on one side only is refused.
fn one_sided(is_given: bool) -> String {
    let (given, made) = if is_given { ("given", "without") } else { ("missing", "for them") };
    format!("{given}; the effect was made {made}")
}

fn refuse<T>(name: &'static str, why: String) -> Result<T> {
    Err(Error::HostResource { name, why })
}

impl PoseInput {
    fn validate(&self, desc: &Desc) -> Result<()> {
        if self.count > desc.frames_resident {
            let why = format!("{} of them; the effect was made to keep {}", self.count, desc.frames_resident);
            return refuse("poses", why);
        }
        if self.first.checked_add(self.count).is_none() {
            return refuse("poses", "their frame numbers do not fit into 32 bits".to_owned());
        }
        holds("poses", &self.positions, 12 * u64::from(desc.points) * u64::from(self.count))
    }
}

impl SkinnedInput {
    fn validate(&self, desc: &Desc) -> Result<()> {
        if desc.sources.is_empty() {
            return refuse("the skinned pose", one_sided(true));
        }
        for (number, (source, offset)) in desc.sources.iter().zip(self.offsets).enumerate() {
            let end = offset.checked_add(source.bytes());
            if offset % 4 != 0 || end.is_none_or(|end| end > source.buffer.size) {
                let why = format!(
                    "positions of source {number} from byte {offset} on; expected a multiple of 4, and {} bytes from there to lie in the source's {}",
                    source.bytes(),
                    source.buffer.size
                );
                return refuse("the skinned pose", why);
            }
        }
        Ok(())
    }
}

impl IntervalInput<'_> {
    fn validate(&self, desc: &Desc) -> Result<()> {
        let Counts { clusters, bounds, seams, most_neighbours, farthest, .. } = self.counts;
        let points = u64::from(desc.points);
        if clusters.max(seams) > desc.points || u64::from(bounds) > most_bounds(desc.points) {
            let why = format!("{clusters} clusters of {bounds} bounds, {seams} points at seams, of {points} points");
            return refuse("the interval", why);
        }
        check_seams(most_neighbours)?;
        if !farthest.is_finite() {
            return refuse("the interval", "bounds that are not finite".to_owned());
        }
        self.validate_segments(desc)?;
        self.views.iter().try_for_each(|view| view.view.validate())?;
        match (&self.clusters, &desc.parts) {
            (Some(given), None) => {
                for (what, buffer, bytes) in given.sized(&self.counts, desc).iter().filter(|(_, _, bytes)| *bytes > 0) {
                    holds(what, buffer, *bytes)?;
                }
            }
            (None, Some(parts)) if (clusters, bounds, seams) == (parts.parts, 0, parts.seams) => {}
            (None, Some(_)) => return refuse("the interval", "counts of others than the effect's parts".to_owned()),
            (given, _) => {
                let (is, made) = if given.is_some() { ("given", "for parts") } else { ("missing", "without parts") };
                return refuse("the interval's clusters", format!("{is}; the effect was made {made}"));
            }
        }
        match self.trajectories {
            Trajectories::Poses(knots) => knots.iter().try_for_each(|knot| knot.view.view.validate()),
            Trajectories::Pieces(pieces) => {
                holds("the interval's pieces", &pieces, 64 * points * self.segments.len() as u64)
            }
        }
    }

    fn validate_segments(&self, desc: &Desc) -> Result<()> {
        let count = self.segments.len();
        let most = match self.trajectories {
            Trajectories::Poses(knots) if knots.is_empty() || knots.len() > MOST_KNOTS => {
                return refuse("the trajectories' knots", format!("{}; 1 to {MOST_KNOTS} expected", knots.len()));
            }
            Trajectories::Poses(_) => PIECE_SEGMENTS as usize,
            Trajectories::Pieces(_) => MOST_SEGMENTS as usize,
        };
        if count == 0 || count > most.min(desc.segments as usize) {
            let made = desc.segments;
            let why = format!("{count}; 1 to {} expected, with Desc::segments = {made}", most.min(made as usize));
            return refuse("the trajectories' segments", why);
        }
        match self.segments.iter().find(|s| !(s.end > s.begin && s.begin.is_finite() && s.end.is_finite())) {
            Some(s) => refuse("the trajectories' segments", format!("one from {} to {}", s.begin, s.end)),
            None => Ok(()),
        }
    }

    /// Frames whose poses it needs.
    pub(super) fn frames(&self) -> impl Iterator<Item = u32> {
        let knots: &[Knot] = match self.trajectories {
            Trajectories::Poses(knots) => knots,
            Trajectories::Pieces(_) => &[],
        };
        self.views.iter().chain(knots.iter().map(|knot| &knot.view)).map(|view| view.frame)
    }
}

impl Frame<'_> {
    /// An output of nothing yet: what it has is set after.
    pub fn new(target: HostImage) -> Self {
        Frame {
            mesh: None,
            poses: None,
            skinned: None,
            interval: None,
            images: None,
            toon: None,
            outer: [None; 2],
            occluders: [None; 4],
            target,
            depth: None,
            background: Background::Keep,
            temporal: TemporalImages::default(),
        }
    }

    /// `resident`: the frame in each place of the device's poses.
    pub(crate) fn validate(&self, desc: &Desc, first: bool, resident: &[Option<u32>]) -> Result<()> {
        match (&self.mesh, first) {
            (None, true) => return refuse("the mesh", "the first frame needs it".to_owned()),
            (mesh, _) => mesh.iter().try_for_each(|mesh| mesh.validate(desc))?,
        }
        if let Some(poses) = &self.poses {
            poses.validate(desc)?;
        }
        if let Some(skinned) = &self.skinned {
            skinned.validate(desc)?;
        }
        if let Some(interval) = &self.interval {
            interval.validate(desc)?;
            interval.frames().try_for_each(|frame| self.needs(frame, desc, resident))?;
        }
        check_image("target", &self.target, desc.size, desc.target_format, Content::Replaced)?;
        self.validate_depth(desc, resident)?;
        match &self.images {
            Some([previous, next]) => {
                self.validate_image("the image of frame i", previous, desc)?;
                self.validate_image("the image of frame i + 1", next, desc)?;
            }
            None => self.validate_toon(desc, resident)?,
        }
        for (name, image) in ["the image of frame i - 1", "the image of frame i + 2"].into_iter().zip(&self.outer) {
            if let Some(image) = image {
                self.validate_image(name, image, desc)?;
                if !desc.outer {
                    return refuse(name, "given; the effect was made with outer = false".to_owned());
                }
            }
        }
        self.validate_occluders(desc)?;
        check_background(&self.background, desc.size, desc.target_format)?;
        check_distinct("background", self.background.image().as_ref(), &self.target)?;
        self.validate_temporal(desc)
    }

    fn validate_temporal(&self, desc: &Desc) -> Result<()> {
        let (background, [previous, next]) =
            (self.background.image(), self.images.map_or([None; 2], |images| images.map(Some)));
        let depth = self.depth.map(|depth| depth.host);
        let [before, after] = self.outer;
        let [first, second, third, fourth] = self.occluders;
        let others = [background, depth, before, previous, next, after, first, second, third, fourth];
        let others = others.each_ref().map(Option::as_ref);
        self.temporal.check(&desc.temporal, desc.size, &self.target, &others)?;
        self.interval.iter().try_for_each(|interval| self.temporal.check_is_previous(&interval.views[1].view))
    }

    /// An image that colours are taken from while the target is drawn.
    fn validate_image(&self, name: &'static str, image: &HostImage, desc: &Desc) -> Result<()> {
        check_image(name, image, desc.size, desc.target_format, Content::Kept)?;
        check_distinct(name, Some(image), &self.target)
    }

    fn validate_occluders(&self, desc: &Desc) -> Result<()> {
        let inner = self.images.is_some();
        let images = [self.outer[0].is_some(), inner, inner, self.outer[1].is_some()];
        let views = self.interval.as_ref().map(|interval| &interval.views);
        for (i, depth) in self.occluders.iter().enumerate() {
            let made = desc.occluders.filter(|_| images[i]);
            if depth.is_some() != made.is_some() {
                let frame = ["i - 1", "i", "i + 1", "i + 2"][i];
                let why = match desc.occluders {
                    Some(DepthFormat { format, .. }) if depth.is_none() => {
                        format!("missing of frame {frame}; the effect was made with occluders = {format:?}")
                    }
                    Some(_) => format!("given of frame {frame}, of which there is no image"),
                    None => format!("given of frame {frame}; the effect was made without occluders"),
                };
                return refuse("occluders", why);
            }
            let (Some(image), Some(format)) = (depth, made) else { continue };
            match views {
                Some(views) => check_depth("occluders", Some((image, &views[i].view)), desc.size, made)?,
                // Where nothing moves nothing is looked at, and there is no view.
                None => check_image("occluders", image, desc.size, format.format, Content::Kept)?,
            }
        }
        Ok(())
    }

    /// Frames whose poses this output brings.
    pub(super) fn new_poses(&self) -> impl Iterator<Item = u32> + use<> {
        let poses = self.poses.map_or(0..0, |poses| poses.first..poses.first + poses.count);
        poses.chain(self.skinned.map(|skinned| skinned.frame))
    }

    fn needs(&self, frame: u32, desc: &Desc, resident: &[Option<u32>]) -> Result<()> {
        let place = |frame: u32| frame % desc.frames_resident;
        let is_resident = resident.get(place(frame) as usize).copied().flatten() == Some(frame);
        // What a new pose takes the place of is gone.
        let is_covered = self.new_poses().any(|new| place(new) == place(frame));
        match self.new_poses().any(|new| new == frame) || (is_resident && !is_covered) {
            true => Ok(()),
            false => {
                let resident = desc.frames_resident;
                let advice = match desc.sources.is_empty() {
                    true => "bring it",
                    false => {
                        "begin the list of views anew with the frame that is skinned now, and show that without an interval"
                    }
                };
                let why =
                    format!("that of frame {frame} is needed and not on the device, which keeps {resident}: {advice}");
                refuse("poses", why)
            }
        }
    }

    fn validate_depth(&self, desc: &Desc, resident: &[Option<u32>]) -> Result<()> {
        let depth = self.depth.as_ref().map(|DepthInput { host, view }| (host, &view.view));
        check_depth("depth", depth, desc.size, desc.depth)?;
        let Some(DepthInput { host, view }) = &self.depth else { return Ok(()) };
        check_beside(Some(host), &self.target)?;
        view.view.validate()?;
        self.needs(view.frame, desc, resident)?;
        let others = self.interval.as_ref().map(|interval| &interval.views[2]);
        match others.into_iter().chain(self.toon.as_ref().map(|toon| &toon.view)).find(|other| *other != view) {
            Some(other) => {
                refuse("depth", format!("of frame {}; another view than frame {}'s", view.frame, other.frame))
            }
            None => Ok(()),
        }
    }

    fn validate_toon(&self, desc: &Desc, resident: &[Option<u32>]) -> Result<()> {
        let Some(toon) = &self.toon else {
            return refuse("images", "none, and no light to draw frames with".to_owned());
        };
        if !desc.toon {
            return refuse("images", "none; the effect was not made to draw frames".to_owned());
        }
        toon.light.validate()?;
        toon.view.view.validate()?;
        self.needs(toon.view.frame, desc, resident)?;
        let Some(interval) = &self.interval else { return Ok(()) };
        let [_, previous, next, _] = &interval.views;
        match toon.view == *next && previous.frame.checked_add(1) == Some(next.frame) {
            true => Ok(()),
            false => refuse("images", format!("frame {} is drawn, the interval's is {}", toon.view.frame, next.frame)),
        }
    }

    /// Frames i - 1 to i + 2 as they are drawn if there are no images of them; all but i + 1 only if there is an interval,
    /// and the outer ones if they exist and the effect has room for them.
    pub(super) fn drawn(&self, desc: &Desc) -> [Option<Drawn>; 4] {
        let Some(ToonInput { view, light }) = self.toon.filter(|_| self.images.is_none()) else { return [None; 4] };
        let has_outer = desc.draws_outer();
        let [before, previous, after] = match &self.interval {
            Some(IntervalInput { views: [before, previous, next, after], .. }) => [
                Some(*before).filter(|view| has_outer && view.frame.checked_add(1) == Some(previous.frame)),
                Some(*previous),
                Some(*after).filter(|view| has_outer && next.frame.checked_add(1) == Some(view.frame)),
            ],
            None => [None; 3],
        };
        [before, previous, Some(view), after].map(|view| view.map(|view| Drawn { view, light }))
    }
}
