//! What a frame brings: its part of a plan.

use super::Steps;
use crate::blur::desc::{Desc, Source};
use crate::blur::frame::{IntervalInput, PoseInput, SkinnedInput, TopologyInput};
use crate::blur::layout::*;
use crate::blur::params::{GatherConstants, NONE};
use crate::plan::{BufferId, Command, PassId};

impl Steps<'_> {
    pub(super) fn colours(&mut self, mesh: &TopologyInput) {
        let bytes = 48 * u64::from(self.desc.triangles);
        if mesh.colours.is_some() && self.desc.toon && bytes > 0 {
            let command = Command::CopyRange { from: (HOST_COLOURS, 0), to: (TOON_BUFFER, BASE_COLOURS), bytes };
            self.plan.step(self.passes.colours, command);
        }
        let rows = 16 * u64::from(self.desc.texture_rows);
        if mesh.textures.is_some() && self.desc.toon && rows > 0 {
            let to = (TOON_BUFFER, BASE_COLOURS + bytes);
            let command = Command::CopyRange { from: (HOST_TEXTURES, 0), to, bytes: rows };
            self.plan.step(self.passes.textures, command);
        }
    }

    /// Shares of strength: all of it where the host says none.
    pub(super) fn shares(&mut self, mesh: &TopologyInput) {
        match mesh.shares {
            Some(_) => self.copies(self.passes.shares, [HOST_SHARES], [SHARES], [4 * u64::from(self.desc.points)]),
            None => {
                let all = Command::Fill { buffer: SHARES, word: 1.0_f32.to_bits() };
                self.plan.step(self.passes.shares_all, all);
            }
        }
    }

    pub(super) fn mesh(&mut self) {
        let Desc { points, triangles, neighbours, .. } = *self.desc;
        let sizes = [16 * u64::from(triangles), 4 * (u64::from(points) + 1), 4 * u64::from(neighbours)];
        let to = [TRIANGLES, NEIGHBOUR_STARTS, NEIGHBOURS];
        self.copies(self.passes.mesh, HOST_TOPOLOGY, to, sizes);
    }

    pub(super) fn groups(&mut self) {
        if !self.layout.has_normals(self.desc) {
            return;
        }
        let Desc { triangles, groups, group_triangles, .. } = *self.desc;
        let sizes = [16 * u64::from(triangles), 4 * (u64::from(groups) + 1), 4 * u64::from(group_triangles)];
        let to = [CORNER_GROUPS, GROUP_STARTS, GROUP_TRIANGLES];
        self.copies(self.passes.groups, HOST_GROUPS, to, sizes);
    }

    /// Each to its place, from where frames stand after one another to where they go around.
    pub(super) fn poses(&mut self, poses: &PoseInput) {
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

    /// What is found of parts begins empty, else it comes from the host.
    pub(super) fn interval(&mut self, interval: &IntervalInput) {
        let Some(clusters) = &interval.clusters else {
            self.plan.skip(self.passes.interval, "parts are measured on the device");
            let rows = (!self.passes.rows.is_empty()).then_some((ROW_VALUES, 0));
            for (buffer, word) in [(SUPPORT_VALUES, 0), (SUPPORT_POINTS, NONE), (FRONTS, 0)].into_iter().chain(rows) {
                self.plan.step(self.passes.measure_begin, Command::Fill { buffer, word });
            }
            return;
        };
        let sizes = clusters.sized(&interval.counts, self.desc).map(|(.., bytes)| bytes);
        self.copies(self.passes.interval, HOST_INTERVAL, [MOTIONS, LABELS, CLUSTERS, BOUNDS, SEAMS, FRONTS], sizes);
    }

    /// The first bytes of the host's buffers, of each as many.
    fn copies<const N: usize>(
        &mut self,
        pass: PassId,
        from: impl IntoIterator<Item = BufferId>,
        to: [BufferId; N],
        sizes: [u64; N],
    ) {
        for ((from, to), bytes) in from.into_iter().zip(to).zip(sizes).filter(|(_, bytes)| *bytes > 0) {
            self.plan.step(pass, Command::CopyBuffer { from, to, bytes });
        }
    }

    /// What is constant of parts and sources.
    pub(super) fn parts(&mut self, mesh: &TopologyInput) {
        if let (Some(parts), Some(sizes)) = (&mesh.parts, &self.desc.parts) {
            let bytes = parts.sized(sizes, self.desc.points).map(|(_, bytes)| bytes);
            let to = [PART_LABELS, PART_MEMBERS, PART_CHUNKS, PART_ROWS, SEAMS];
            self.copies(self.passes.parts, HOST_PARTS, to, bytes);
        }
        if mesh.source_rows.is_some() {
            let bytes = 4 * u64::from(self.desc.points);
            self.copies(self.passes.parts, [HOST_SOURCE_ROWS], [SOURCE_ROWS], [bytes]);
        }
    }

    /// A pose from where the host's skinning has left it.
    pub(super) fn gather(&mut self, skinned: &SkinnedInput) {
        let Desc { points, frames_resident, sources, .. } = self.desc;
        let pose = 3 * points * (skinned.frame % frames_resident);
        let mut first = 0;
        for ((source, offset), pass) in sources.iter().zip(skinned.offsets).zip(&self.passes.gather) {
            let Source { stride, points: count, .. } = *source;
            let constants = GatherConstants { first, count, offset: (offset / 4) as u32, stride, pose };
            self.plan.step_with(*pass, Command::Dispatch { threads: [count, 1, 1] }, &constants);
            first += count;
        }
    }
}
