//! From what steps read and write to the barriers between them. Pure: unit tests need no device.

use ash::vk;

use crate::plan::{Pass, Plan, Resource, Step, Usage};

/// A memory barrier before a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Barrier {
    /// Stages waited for.
    pub src_stage: vk::PipelineStageFlags2,
    /// Writes made available.
    pub src_access: vk::AccessFlags2,
    /// Stages that wait.
    pub dst_stage: vk::PipelineStageFlags2,
    /// Accesses that the writes are made visible to.
    pub dst_access: vk::AccessFlags2,
}

impl Barrier {
    /// Nothing to wait for.
    pub fn is_empty(&self) -> bool {
        self.src_stage.is_empty()
    }

    fn add(&mut self, src_stage: vk::PipelineStageFlags2, src_access: vk::AccessFlags2, usage: &Usage) {
        self.src_stage |= src_stage;
        self.src_access |= src_access;
        self.dst_stage |= usage.stage;
        self.dst_access |= usage.access();
    }
}

/// Accesses to a resource since the frame began.
#[derive(Clone, Copy, Debug, Default)]
struct History {
    /// The last write.
    write_stage: vk::PipelineStageFlags2,
    write_access: vk::AccessFlags2,
    /// Whom barriers have already shown that write to; the oldest is forgotten first, which only costs a barrier.
    visible: [(vk::PipelineStageFlags2, vk::AccessFlags2); 4],
    next_visible: usize,
    /// Stages that read since the last write, less those that a barrier has waited for.
    read_stage: vk::PipelineStageFlags2,
}

/// Derives barriers while a frame's steps go by in order.
#[derive(Debug)]
pub struct Tracker {
    buffers: Vec<History>,
    images: Vec<History>,
}

impl Tracker {
    /// For resources with ids below the given counts.
    pub fn new(buffers: usize, images: usize) -> Tracker {
        Tracker { buffers: vec![History::default(); buffers], images: vec![History::default(); images] }
    }

    /// Begins a frame. The barrier returned orders it after the frame before it, whatever that one ran: it covers
    /// every stage and access of this plan's passes, and nothing that they don't use.
    pub fn begin(&mut self, plan: &Plan, passes: &[Pass]) -> Barrier {
        self.buffers.fill(History::default());
        self.images.fill(History::default());
        let mut barrier = Barrier::default();
        for pass in passes {
            for (_, usage) in &pass.uses {
                barrier.src_stage |= usage.stage;
                barrier.src_access |= usage.writes;
            }
        }
        for step in &plan.steps {
            for_each_use(step, &passes[usize::from(step.pass.0)], |_, usage| {
                barrier.dst_stage |= usage.stage;
                barrier.dst_access |= usage.access();
            });
        }
        barrier
    }

    /// Notes a write that happened before the frame, by the host.
    pub fn written_before(&mut self, resource: Resource, stage: vk::PipelineStageFlags2, access: vk::AccessFlags2) {
        let history = self.history(resource);
        *history = History { write_stage: stage, write_access: access, ..History::default() };
    }

    /// The barrier that `step` needs before it; then takes the step as done.
    pub fn before(&mut self, step: &Step, pass: &Pass) -> Barrier {
        let mut barrier = Barrier::default();
        for_each_use(step, pass, |resource, usage| self.require(resource, usage, &mut barrier));
        if !barrier.is_empty() {
            self.apply(&barrier);
        }
        for_each_use(step, pass, |resource, usage| self.note(resource, usage));
        barrier
    }

    fn history(&mut self, resource: Resource) -> &mut History {
        match resource {
            Resource::Buffer(id) => &mut self.buffers[usize::from(id.0)],
            Resource::Image(id) => &mut self.images[usize::from(id.0)],
        }
    }

    fn require(&mut self, resource: Resource, usage: &Usage, barrier: &mut Barrier) {
        let history = *self.history(resource);
        let shown = |(stage, access): &(vk::PipelineStageFlags2, vk::AccessFlags2)| {
            stage.contains(usage.stage) && access.contains(usage.access())
        };
        if !history.write_stage.is_empty() && !history.visible.iter().any(shown) {
            barrier.add(history.write_stage, history.write_access, usage);
        }
        if !usage.writes.is_empty() && !history.read_stage.is_empty() {
            barrier.add(history.read_stage, vk::AccessFlags2::NONE, usage);
        }
    }

    /// A memory barrier is global: whatever it covers is in order for every resource.
    fn apply(&mut self, barrier: &Barrier) {
        for history in self.buffers.iter_mut().chain(&mut self.images) {
            let covered = barrier.src_stage.contains(history.write_stage)
                && barrier.src_access.contains(history.write_access)
                && !history.write_stage.is_empty();
            if covered {
                history.visible[history.next_visible] = (barrier.dst_stage, barrier.dst_access);
                history.next_visible = (history.next_visible + 1) % history.visible.len();
            }
        }
    }

    fn note(&mut self, resource: Resource, usage: &Usage) {
        let history = self.history(resource);
        if usage.writes.is_empty() {
            history.read_stage |= usage.stage;
        } else {
            *history = History { write_stage: usage.stage, write_access: usage.writes, ..History::default() };
        }
    }
}

fn for_each_use(step: &Step, pass: &Pass, mut f: impl FnMut(Resource, &Usage)) {
    for (resource, usage) in &pass.uses {
        f(*resource, usage);
    }
    if let Some(arguments) = step.arguments() {
        f(Resource::Buffer(arguments), &Usage::INDIRECT);
    }
}
