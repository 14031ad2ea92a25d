//! From what steps read and write to the barriers between them. Pure: unit tests need no device.
//!
//! A barrier costs a device some microseconds in which it empties itself, and costs little more for what it covers. So
//! there are as few as the order of the steps allows: one before each step that depends on a step since the last one, and
//! it orders all before it with all after it.

use ash::vk;

use crate::gpu::scratch::Overlay;
use crate::host::ImageState;
use crate::plan::{Command, ImageId, Pass, Plan, Resource, Step, Usage};

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
}

/// An image that is brought from one state into another, together with a barrier.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Change {
    /// The image.
    pub image: ImageId,
    /// Its state before.
    pub from: ImageState,
    /// Its state after.
    pub to: ImageState,
}

/// How a frame has touched a resource: after how many barriers last. 0: not at all.
#[derive(Clone, Copy, Debug, Default)]
struct Touched {
    read: u32,
    written: u32,
    /// Whether some step of the frame uses it.
    is_used: bool,
}

/// Derives barriers while a frame's steps go by in order.
#[derive(Debug)]
pub struct Tracker {
    buffers: Vec<Touched>,
    images: Vec<Touched>,
    /// The states of images. Own ones begin and end frames in [`OWN`], unless they are in scratch memory.
    states: Vec<ImageState>,
    /// Which images the host has handed over.
    is_host: Vec<bool>,
    /// Those that change with the barrier that was returned last.
    changes: Vec<Change>,
    /// What has been touched since the last barrier.
    pending: Barrier,
    /// Stages and accesses of the frame.
    frame: (vk::PipelineStageFlags2, vk::AccessFlags2),
    /// Barriers so far.
    count: u32,
    /// What lies where others lay before it in the frame, and each of those.
    successors: Vec<(Resource, Resource)>,
}

impl Tracker {
    /// For resources with ids below the given counts.
    pub fn new(buffers: usize, images: usize) -> Tracker {
        Tracker {
            buffers: vec![Touched::default(); buffers],
            images: vec![Touched::default(); images],
            states: vec![OWN; images],
            is_host: vec![false; images],
            changes: Vec::with_capacity(images),
            pending: Barrier::default(),
            frame: Default::default(),
            count: 0,
            successors: Vec::new(),
        }
    }

    /// For resources some of which lie in the same place.
    #[must_use]
    pub fn with_overlays(mut self, overlays: &[Overlay]) -> Tracker {
        for overlay in overlays {
            let mut before: Vec<Resource> = Vec::new();
            for group in overlay {
                let pairs = group.iter().flat_map(|later| before.iter().map(|earlier| (*later, *earlier)));
                self.successors.extend(pairs);
                before.extend(group);
            }
        }
        self
    }

    /// Begins a frame. Its first barrier orders it after the frame before it, whatever that one ran: it waits for every
    /// stage of this effect's passes.
    pub fn begin(&mut self, plan: &Plan, passes: &[Pass]) {
        self.buffers.fill(Touched::default());
        self.images.fill(Touched::default());
        self.states.fill(OWN);
        self.is_host.fill(false);
        (self.pending, self.frame, self.count) = (Barrier::default(), Default::default(), 0);
        for (_, usage) in passes.iter().flat_map(|pass| &pass.uses) {
            self.pending.src_stage |= usage.stage;
            self.pending.src_access |= usage.writes;
        }
        for step in &plan.steps {
            for_each_use(step, &passes[usize::from(step.pass.0)], |_, usage| {
                self.frame.0 |= usage.stage;
                self.frame.1 |= usage.access();
            });
        }
    }

    /// Notes a buffer that the host has written before the frame.
    pub fn take_buffer(&mut self, stage: vk::PipelineStageFlags2, access: vk::AccessFlags2) {
        self.pending.src_stage |= stage;
        self.pending.src_access |= access;
    }

    /// Notes an image that the host hands over in this state.
    pub fn take_image(&mut self, image: ImageId, state: ImageState) {
        self.states[usize::from(image.0)] = state;
        self.is_host[usize::from(image.0)] = true;
        self.pending.src_stage |= state.stage;
        self.pending.src_access |= state.access;
    }

    /// Notes an own image that the frame begins without: in layout UNDEFINED.
    pub fn discard_image(&mut self, image: ImageId) {
        self.states[usize::from(image.0)].layout = vk::ImageLayout::UNDEFINED;
    }

    /// The barrier that `step` needs before it; then takes the step as done. The first one of a frame brings all
    /// images into the states in which they are used first.
    pub fn before(&mut self, plan: &Plan, index: usize, passes: &[Pass]) -> Barrier {
        let step = &plan.steps[index];
        let pass = &passes[usize::from(step.pass.0)];
        self.changes.clear();
        let mut is_needed = index == 0;
        if index == 0 {
            self.open(plan, passes);
        } else {
            for_each_use(step, pass, |resource, usage| is_needed |= self.change(resource, usage));
            // Copies that follow change theirs together with it, unless an image would change twice.
            let copies = |step: &&Step| is_needed && matches!(step.command, Command::CopyImage { .. });
            for step in plan.steps[index..].iter().take_while(copies).skip(1) {
                let pass = &passes[usize::from(step.pass.0)];
                for_each_use(step, pass, |resource, usage| {
                    if !self.changes.iter().any(|change| Resource::Image(change.image) == resource) {
                        self.change(resource, usage);
                    }
                });
            }
        }
        for_each_use(step, pass, |resource, usage| is_needed |= self.conflicts(resource, usage));
        let barrier = if is_needed { self.barrier() } else { Barrier::default() };
        for_each_use(step, pass, |resource, usage| self.note(resource, usage));
        barrier
    }

    /// The images that change with the barrier that was returned last.
    pub fn changes(&self) -> &[Change] {
        &self.changes
    }

    /// How many barriers the frame has so far; none of them empty.
    pub fn count(&self) -> u32 {
        self.count
    }

    /// The barrier after the last step, if images change with it: those of the host are to be left in `states`.
    pub fn end(&mut self, states: impl Iterator<Item = (ImageId, ImageState)>) -> Barrier {
        self.changes.clear();
        // What no step has used stays without a layout.
        let is_left = |from: &ImageState| ![OWN.layout, vk::ImageLayout::UNDEFINED].contains(&from.layout);
        let own = self.states.iter().enumerate().filter(|(index, from)| !self.is_host[*index] && is_left(from));
        self.changes.extend(own.map(|(index, from)| Change { image: ImageId(index as u16), from: *from, to: OWN }));
        let host = states.map(|(image, to)| Change { image, from: self.states[usize::from(image.0)], to });
        self.changes.extend(host);
        if self.changes.is_empty() { Barrier::default() } else { self.barrier() }
    }

    /// Orders all before with all after.
    fn barrier(&mut self) -> Barrier {
        self.count += 1;
        let (dst_stage, dst_access) = self.frame;
        let mut barrier = Barrier { dst_stage, dst_access, ..std::mem::take(&mut self.pending) };
        if !self.changes.is_empty() {
            // What was in order before an image changes is so through the second half of an earlier barrier.
            barrier.src_stage |= dst_stage;
        }
        barrier
    }

    fn touched(&mut self, resource: Resource) -> &mut Touched {
        match resource {
            Resource::Buffer(id) => &mut self.buffers[usize::from(id.0)],
            Resource::Image(id) => &mut self.images[usize::from(id.0)],
        }
    }

    /// Notes how images are used first.
    fn open(&mut self, plan: &Plan, passes: &[Pass]) {
        for step in &plan.steps {
            for_each_use(step, &passes[usize::from(step.pass.0)], |resource, usage| {
                let Resource::Image(image) = resource else { return };
                if std::mem::replace(&mut self.images[usize::from(image.0)].is_used, true) {
                    return;
                }
                self.change(resource, usage);
            });
        }
    }

    /// Whether an image has to change for this use: notes it.
    fn change(&mut self, resource: Resource, usage: &Usage) -> bool {
        let Resource::Image(image) = resource else { return false };
        let index = usize::from(image.0);
        let layout = layout(self.is_host[index], usage);
        let to = ImageState { stage: usage.stage, access: usage.access(), layout };
        let from = std::mem::replace(&mut self.states[index], to);
        if from.layout != to.layout {
            self.changes.push(Change { image, from, to });
        }
        from.layout != to.layout
    }

    /// Whether a resource was touched since the last barrier so that this use has to wait.
    fn conflicts(&mut self, resource: Resource, usage: &Usage) -> bool {
        let now = self.count;
        let touched = *self.touched(resource);
        let conflicts = touched.written > now || (touched.read > now && !usage.writes.is_empty());
        conflicts || self.evicts(resource)
    }

    /// Whether something that lay in the same place before was touched since the last barrier.
    fn evicts(&mut self, resource: Resource) -> bool {
        let now = self.count;
        (0..self.successors.len()).any(|index| {
            let (later, earlier) = self.successors[index];
            later == resource && {
                let touched = self.touched(earlier);
                touched.read.max(touched.written) > now
            }
        })
    }

    fn note(&mut self, resource: Resource, usage: &Usage) {
        self.pending.src_stage |= usage.stage;
        self.pending.src_access |= usage.writes;
        let now = self.count + 1;
        let touched = self.touched(resource);
        match usage.writes.is_empty() {
            true => touched.read = now,
            false => touched.written = now,
        }
    }
}

/// What a plan uses together with or after what lies in its place later, if it does that to anything: such a plan must not be.
pub fn return_to(plan: &Plan, passes: &[Pass], overlays: &[Overlay]) -> Option<Resource> {
    let mut returned = None;
    for overlay in overlays {
        let group_of = |resource: &Resource| overlay.iter().position(|group| group.contains(resource));
        let mut latest = 0;
        for step in &plan.steps {
            let pass = &passes[usize::from(step.pass.0)];
            for_each_use(step, pass, |resource, _| latest = latest.max(group_of(&resource).unwrap_or(0)));
            for_each_use(step, pass, |resource, _| {
                if group_of(&resource).is_some_and(|group| group < latest) {
                    returned = Some(resource);
                }
            });
        }
    }
    returned
}

/// The state of own images at the start and the end of a frame.
const OWN: ImageState = ImageState {
    stage: vk::PipelineStageFlags2::NONE,
    access: vk::AccessFlags2::NONE,
    layout: vk::ImageLayout::GENERAL,
};

/// The layout in which an image is used so. Own images stay in GENERAL, unless they are copied; the host's take the layout
/// of each use.
pub fn layout(is_host: bool, usage: &Usage) -> vk::ImageLayout {
    match *usage {
        Usage::COPY_SOURCE => vk::ImageLayout::TRANSFER_SRC_OPTIMAL,
        Usage::COPY_TARGET => vk::ImageLayout::TRANSFER_DST_OPTIMAL,
        Usage::COLOUR if is_host => vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL,
        Usage::DEPTH if is_host => vk::ImageLayout::DEPTH_STENCIL_ATTACHMENT_OPTIMAL,
        _ => vk::ImageLayout::GENERAL,
    }
}

/// What a step touches: a transfer its own command's, of all that its pass may.
fn for_each_use(step: &Step, pass: &Pass, mut f: impl FnMut(Resource, &Usage)) {
    let mut copies = |from: Option<Resource>, to: Resource| {
        from.iter().for_each(|from| f(*from, &Usage::COPY_SOURCE));
        f(to, &Usage::COPY_TARGET);
    };
    match step.command {
        Command::Fill { buffer, .. } | Command::Update { buffer, .. } => copies(None, buffer.into()),
        Command::Clear { image, .. } => f(image.into(), &Usage::COLOUR),
        Command::CopyBuffer { from, to, .. } => copies(Some(from.into()), to.into()),
        Command::CopyRange { from, to, .. } => copies(Some(from.0.into()), to.0.into()),
        Command::CopyImage { from, to, .. } => copies(Some(from.into()), to.into()),
        Command::CopyDepth { from, to, .. } => copies(Some(from.into()), to.into()),
        Command::Dispatch { .. }
        | Command::DispatchIndirect { .. }
        | Command::Draw { .. }
        | Command::DrawIndirect { .. } => {
            pass.uses.iter().for_each(|(resource, usage)| f(*resource, usage));
            step.arguments().iter().for_each(|arguments| f(Resource::Buffer(*arguments), &Usage::INDIRECT));
        }
    }
}
