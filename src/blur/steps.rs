//! A frame's list: which passes run, over how much, in which order, and why others do not. Pure.

use std::mem::offset_of;

use crate::blur::frame::{Desc, Frame, IntervalInput, PoseInput, Trajectories};
use crate::blur::layout::*;
use crate::blur::params::{
    self, BlurParams, Control, Knot, MOST_KNOTS, ROUNDS, Round, RoundConstants, SeamConstants, SettleConstants,
    VisibilityConstants,
};
use crate::blur::passes::Passes;
use crate::blur::settings::Completion;
use crate::host::Background;
use crate::plan::{Command, Plan};

/// What follows from motion: left out where nothing moves.
const MOTION_STEPS: [&str; 17] = [
    "blur.params",
    "blur.interval",
    "blur.trajectory",
    "blur.extent",
    "blur.seams",
    "blur.refine",
    "blur.visibility",
    "blur.distort",
    "blur.layers",
    "blur.frames",
    "blur.cover",
    "blur.normals",
    "blur.learn",
    "blur.shade",
    "blur.complete",
    "blur.compose",
    "blur.composite",
];

/// Lanes of a workgroup of `fill`, of which there is one a table.
const FILL_LANES: u32 = 256;
/// Dispatches for colours that follow from neighbours: each stays within the loop budget, what is left when all have run
/// stays as it is.
const GRADIENT_DISPATCHES: u32 = 16;
/// As [`GRADIENT_DISPATCHES`], where neither frame shows anything.
const MEAN_DISPATCHES: u32 = 4;

/// Fills a frame's plan.
pub struct Steps<'a> {
    /// To be filled.
    pub plan: &'a mut Plan,
    /// The effect's passes.
    pub passes: &'a Passes,
    /// What it is made for.
    pub desc: &'a Desc,
    /// Its sizes.
    pub layout: &'a Layout,
}

/// Why an output is the image of frame i + 1, if that is known before the device has looked.
pub fn still(desc: &Desc, frame: &Frame) -> Option<&'static str> {
    match &frame.interval {
        None => Some("nothing moves"),
        Some(interval) if interval.counts.clusters == 0 => Some("nothing moves"),
        Some(_) if desc.settings.strength == 0.0 => Some("strength is 0"),
        Some(_) if desc.triangles == 0 => Some("the mesh has no triangles"),
        Some(_) => None,
    }
}

impl Steps<'_> {
    /// Fills it.
    pub fn fill(&mut self, frame: &Frame) {
        self.plan.clear();
        let (from, to, extent) = (HOST_FRAMES[1], TARGET, self.desc.size);
        self.plan.step(self.passes.background, Command::CopyImage { from, to, extent });
        match &frame.mesh {
            Some(_) => {
                self.mesh();
                self.groups();
            }
            None => self.plan.skip("blur.mesh", "unchanged"),
        }
        match &frame.poses {
            Some(poses) => self.poses(poses),
            None => self.plan.skip("blur.poses", "none are new"),
        }
        let still = still(self.desc, frame);
        let Some(interval) = frame.interval.as_ref().filter(|_| still.is_none()) else {
            let reason = still.unwrap_or_default();
            return MOTION_STEPS.iter().for_each(|name| self.plan.skip(name, reason));
        };
        let background = match frame.background {
            Background::Clear(colour) => colour,
            _ => [0.0; 4],
        };
        let outer = frame.outer.map(|image| image.is_some());
        let params = BlurParams::new(self.desc, self.layout, interval, background, outer);
        self.plan.update(self.passes.params, PARAMS, &params);
        self.plan.update(self.passes.params, CONTROL, &Control::reset());
        self.plan.update_slice(self.passes.params, ROUND_LIST, &params::rounds(self.desc));
        self.interval(interval);
        self.trajectory(interval);
        self.extent(interval);
        self.refine();
        self.draw(outer);
        self.frames(outer);
        self.learn();
        self.shade();
    }

    fn mesh(&mut self) {
        let Desc { points, triangles, neighbours, .. } = *self.desc;
        let sizes = [16 * u64::from(triangles), 4 * (u64::from(points) + 1), 4 * u64::from(neighbours)];
        let to = [TRIANGLES, NEIGHBOUR_STARTS, NEIGHBOURS];
        for ((from, to), bytes) in HOST_TOPOLOGY.into_iter().zip(to).zip(sizes).filter(|(_, bytes)| *bytes > 0) {
            self.plan.step(self.passes.mesh, Command::CopyBuffer { from, to, bytes });
        }
    }

    fn groups(&mut self) {
        if self.layout.tables == 0 {
            return;
        }
        let Desc { triangles, groups, group_triangles, .. } = *self.desc;
        let sizes = [16 * u64::from(triangles), 4 * (u64::from(groups) + 1), 4 * u64::from(group_triangles)];
        let to = [CORNER_GROUPS, GROUP_STARTS, GROUP_TRIANGLES];
        for ((from, to), bytes) in HOST_GROUPS.into_iter().zip(to).zip(sizes).filter(|(_, bytes)| *bytes > 0) {
            self.plan.step(self.passes.groups, Command::CopyBuffer { from, to, bytes });
        }
    }

    /// Each to its place, from where frames stand after one another to where they go around.
    fn poses(&mut self, poses: &PoseInput) {
        let bytes = 12 * u64::from(self.desc.points);
        let resident = self.desc.frames_resident;
        let mut done = 0;
        while done < poses.count {
            let place = (poses.first + done) % resident;
            let run = (poses.count - done).min(resident - place);
            let (from, to) = (u64::from(done) * bytes, u64::from(place) * bytes);
            let bytes = u64::from(run) * bytes;
            let command = Command::CopyRange { from: (HOST_POSES, from), to: (POSES, to), bytes };
            self.plan.step(self.passes.poses, command);
            done += run;
        }
    }

    fn interval(&mut self, interval: &IntervalInput) {
        let points = u64::from(self.desc.points);
        let counts = &interval.counts;
        let sizes = [
            16 * points,
            4 * points,
            24 * u64::from(counts.clusters),
            8 * u64::from(counts.hull),
            4 * u64::from(counts.seams),
        ];
        let to = [MOTIONS, LABELS, CLUSTERS, HULL, SEAMS];
        for ((from, to), bytes) in HOST_INTERVAL.into_iter().zip(to).zip(sizes).filter(|(_, bytes)| *bytes > 0) {
            self.plan.step(self.passes.interval, Command::CopyBuffer { from, to, bytes });
        }
    }

    fn points(&self) -> Command {
        Command::Dispatch { threads: [self.desc.points, 1, 1] }
    }

    fn trajectory(&mut self, interval: &IntervalInput) {
        self.plan.step(self.passes.project, Command::Dispatch { threads: [self.desc.points, 4, 1] });
        match interval.trajectories {
            Trajectories::Poses(knots) => {
                let current = &interval.views[1].camera;
                let mut rows = [<Knot as bytemuck::Zeroable>::zeroed(); MOST_KNOTS];
                rows.iter_mut().zip(knots).for_each(|(row, knot)| *row = Knot::new(knot, current, self.desc));
                self.plan.update_slice(self.passes.knots, KNOTS, &rows[..knots.len()]);
                self.plan.step(self.passes.trajectory, self.points());
            }
            Trajectories::Pieces(_) => {
                let piece = size_of::<params::Piece>() as u64;
                let bytes = u64::from(self.desc.points) * piece;
                for segment in 0..interval.segments.len() as u64 {
                    let to = segment * u64::from(self.layout.vertices) * piece;
                    let command =
                        Command::CopyRange { from: (HOST_INTERVAL[5], segment * bytes), to: (SPLINES, to), bytes };
                    self.plan.step(self.passes.pieces, command);
                }
            }
        }
    }

    fn extent(&mut self, interval: &IntervalInput) {
        let seams = interval.counts.seams;
        let rounds = if seams > 0 { self.desc.settings.seam_smoothing } else { 0 };
        self.plan.step(self.passes.extent, self.points());
        for round in 0..rounds {
            let command = Command::Dispatch { threads: [seams, 1, 1] };
            self.plan.step_with(self.passes.seams, command, &SeamConstants { from: round % 2 });
        }
        if rounds == 0 {
            self.plan.skip("blur.seams", "no clusters meet, or seam_smoothing is 0");
        }
        self.plan.step_with(self.passes.settle, self.points(), &SettleConstants { from: rounds % 2 });
    }

    fn refine(&mut self) {
        let triangles = Command::Dispatch { threads: [self.desc.triangles, 1, 1] };
        self.plan.step(self.passes.begin, triangles);
        for round in 0..=ROUNDS {
            let constants = RoundConstants { round };
            let at = |member: usize| Command::DispatchIndirect {
                arguments: ROUND_LIST,
                offset: u64::from(round) * size_of::<Round>() as u64 + member as u64,
            };
            let parity = (round % 2) as usize;
            let (groups, scan) = (at(offset_of!(Round, groups)), at(offset_of!(Round, scan)));
            self.plan.step_with(self.passes.count[parity], groups, &constants);
            self.plan.step_with(self.passes.scan, scan, &constants);
            self.plan.step_with(self.passes.emit[parity], groups, &constants);
        }
    }

    fn draw(&mut self, outer: [bool; 2]) {
        let inner = self.passes.visibility.into_iter().zip([1, 2]);
        let outer = self.passes.outer_visibility.into_iter().zip([0, 3]).zip(outer).filter(|(_, is_there)| *is_there);
        for (pass, frame) in inner.chain(outer.map(|(pass, _)| pass)) {
            let command = Command::Draw { vertices: 3 * self.desc.triangles };
            self.plan.step_with(pass, command, &VisibilityConstants { frame });
        }
        let draw = Command::DrawIndirect { arguments: CONTROL, offset: offset_of!(Control, draw) as u64 };
        for pass in self.passes.distort {
            self.plan.step(pass, draw);
        }
        if !self.desc.layers {
            return self.plan.skip("blur.layers", "no layers are kept");
        }
        let [width, height] = self.desc.size;
        self.plan.step(self.passes.layers, Command::Dispatch { threads: [width, height, 1] });
    }

    fn frames(&mut self, outer: [bool; 2]) {
        for (from, to) in HOST_FRAMES.into_iter().zip(FRAMES) {
            self.plan.step(self.passes.frames, Command::CopyImage { from, to, extent: self.desc.size });
        }
        for i in [0, 1].into_iter().filter(|i| outer[*i]) {
            let command = Command::CopyImage { from: HOST_OUTER[i], to: OUTER_FRAMES[i], extent: self.desc.size };
            self.plan.step(self.passes.outer_frames[i], command);
        }
    }

    fn learn(&mut self) {
        let [width, height] = self.desc.size;
        self.plan.step(self.passes.completing, Command::Fill { buffer: COMPLETING, word: 0 });
        self.plan.update_slice(self.passes.completing, COMPLETING, &params::completing(self.desc));
        self.plan.step(self.passes.cover, Command::Dispatch { threads: [width, height, 1] });
        if self.layout.tables == 0 {
            let reason = "completion does not follow from the surface";
            return ["blur.normals", "blur.learn"].iter().for_each(|name| self.plan.skip(name, reason));
        }
        self.plan.step(self.passes.normals, Command::Dispatch { threads: [self.desc.groups, 2, 1] });
        self.plan.step(self.passes.sums, Command::Fill { buffer: SUMS, word: 0 });
        let pixels = Command::Dispatch { threads: [width, height, 2] };
        self.plan.step(self.passes.learn[0], pixels);
        self.plan.step(self.passes.fill, Command::Dispatch { threads: [FILL_LANES * 4 * self.layout.tables, 1, 1] });
        self.plan.step(self.passes.learn[1], pixels);
        self.plan.step(self.passes.learn[2], pixels);
    }

    /// Samples that get their colour from neighbours: no group runs where there are none.
    fn inward(&mut self, gradient: usize, dispatches: u32) {
        let at = |word: usize| Command::DispatchIndirect { arguments: COMPLETING, offset: 4 * word as u64 };
        self.plan.step(self.passes.border[gradient], at(4 * gradient));
        for _ in 0..dispatches {
            self.plan.step(self.passes.inward[gradient], at(8 + 4 * gradient));
        }
    }

    fn shade(&mut self) {
        let [width, height] = self.desc.size;
        self.plan.step(self.passes.shade, Command::Dispatch { threads: [2 * width, 2 * height, 1] });
        if self.desc.layers {
            self.plan.step(self.passes.sides, Command::Dispatch { threads: [width, height, 1] });
        }
        if self.desc.settings.completion == Completion::Gradient {
            self.inward(1, GRADIENT_DISPATCHES);
        }
        self.inward(0, MEAN_DISPATCHES);
        self.plan.step(self.passes.compose, Command::Dispatch { threads: [width, height, 1] });
        self.plan.step(self.passes.composite, Command::Draw { vertices: 4 });
    }
}

/// Room that a plan of this effect needs: steps, and bytes of updates.
pub fn capacity(desc: &Desc) -> (usize, usize) {
    let steps = 48
        + GRADIENT_DISPATCHES as usize
        + MEAN_DISPATCHES as usize
        + 2
        + desc.segments as usize
        + desc.settings.seam_smoothing as usize
        + 3 * (ROUNDS as usize + 1);
    let bytes = size_of::<BlurParams>() + size_of::<Control>() + MOST_KNOTS * size_of::<Knot>();
    (steps, 4 * COMPLETING_WORDS + bytes + (ROUNDS as usize + 1) * size_of::<Round>())
}
