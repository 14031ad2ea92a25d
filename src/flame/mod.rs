//! Fire from particles by stochastic alpha test (Mabuchi, Fujishiro, Ohno: Particle-Based Flame Rendering).
//!
//! Physical particles with a temperature draw render particles at random around them; each is a sprite that a pixel sees
//! where its alpha reaches a threshold; the nearest wins; repetitions are averaged. Nothing is sorted or blended.
//! [`Effect::record`] records it all into the host's command buffer. The [`settings::Mode::Expected`] mode integrates the
//! image that the repetitions converge to.

mod cie;
pub(crate) mod colour;
pub mod desc;
pub mod frame;
mod lamp;
pub(crate) mod layout;
pub(crate) mod limits;
mod mask;
pub(crate) mod params;
pub(crate) mod passes;
#[cfg(any(test, feature = "reference"))]
pub mod reference;
pub mod settings;
mod spacing;
pub(crate) mod steps;
pub(crate) mod tables;

pub use crate::host::{Background, DepthFormat};
use crate::host::{FormatUse, NamedFormat, depth_format, target_format};
pub use desc::{Desc, SceneFormat};
pub use frame::{Frame, ParticleInput, SceneDepth};
pub use lamp::fire_light;
pub use settings::Settings;
pub use spacing::mean_spacing;

use ash::vk;

use crate::effect::{DeviceTraits, Effect, Effort, Kind};
use crate::error::{Error, Result};
use crate::gpu::resources::{Kept, Resources};
use crate::plan::{Pass, Plan};
use crate::view::View;
use layout::Layout;
use mask::Mask;
use params::{FlameParams, Given, Space};
use passes::Passes;
use settings::MOST_REPETITIONS;
use steps::{FrameDelta, Steps};
use tables::Tables;

/// The flame effect. A frame depends on no other, unless it takes the last one's particles or adds to its repetitions.
pub type Flame = Effect<FlameKind>;

/// The parts that are the flame's own.
#[derive(Debug)]
pub struct FlameKind {
    traits: DeviceTraits,
    layout: Layout,
    passes: Passes,
    tables: Tables,
    effort: Effort,
    /// The largest alpha of the mask.
    max_alpha: f32,
    state: State,
}

/// State kept of the frames recorded so far.
#[derive(Clone, Copy, Debug, Default)]
pub struct State {
    /// The view of the last frame; none before the first.
    view: Option<View>,
    /// The view of the last frame that could see fire, and its sprites' size in spreads: what the expected image's table is of.
    lit: Option<(View, f32)>,
    /// Whether tables and mask are on the device.
    has_tables: bool,
    given: Given,
    /// The spread of its frame, if one has been said.
    spread: Option<f32>,
    /// A bound of its particles' temperatures.
    hottest: f32,
    /// Repetitions that the sums on the device hold.
    repetitions: u32,
}

impl Kind for FlameKind {
    const NAME: &'static str = "flame";
    type Desc = Desc;
    type Layout = Layout;
    type Frame<'a> = Frame;
    type Recorded = State;

    fn new(desc: &Desc, traits: &DeviceTraits, effort: Effort) -> Result<FlameKind> {
        desc.validate()?;
        traits.tuning.validate()?;
        traits.check_sides(desc.size)?;
        let tables = Tables::new(desc);
        let layout = Layout::new(desc, &tables, traits)?;
        let passes = Passes::new(desc, &layout, &tables, &traits.tuning);
        // The largest alpha that the device's mask can have, which is the reference's but for rounding.
        let max_alpha = (Mask::new(desc.seed, desc.settings.variants).largest() * 1.000001) as f32;
        Ok(FlameKind { traits: *traits, layout, passes, tables, effort, max_alpha, state: State::default() })
    }

    fn resized(desc: &Desc, size: [u32; 2]) -> Desc {
        Desc { size, ..desc.clone() }
    }

    fn layout(&self) -> &Layout {
        &self.layout
    }

    fn take_passes(&mut self) -> Vec<Pass> {
        std::mem::take(&mut self.passes.list)
    }

    fn plan(&mut self, desc: &Desc, frame: &Frame, plan: &mut Plan) -> Result<State> {
        frame.validate(desc, self.state.view.is_none())?;
        let (delta, state) = self.delta(desc, frame)?;
        let FlameKind { traits, layout, passes, tables, effort, max_alpha, .. } = self;
        let mut params = FlameParams::new(desc, layout, frame, &delta.given, tables, *max_alpha);
        params.is_skipping = effort.skips().into();
        Steps { plan, passes, desc, layout, traits, delta: &delta }.fill(frame, &params, tables);
        Ok(state)
    }

    fn upload(&self, _: &Desc, frame: &Frame, resources: &mut Resources) {
        let particles = frame.particles.filter(|particles| particles.count > 0);
        let buffer = match frame.scene {
            Some(SceneDepth::Buffer(buffer)) => Some(buffer),
            Some(SceneDepth::Image(_)) | None => None,
        };
        resources.set_host_buffer(layout::HOST_POSITIONS, particles.map(|p| p.position_temperature));
        resources.set_host_buffer(layout::HOST_IDS, particles.and_then(|p| p.ids));
        resources.set_host_buffer(layout::HOST_SCENE, buffer);
        resources.set_host_image(layout::TARGET, Some(frame.target));
        resources.set_host_image(layout::BACKGROUND, frame.background.image());
        resources.set_host_image(layout::HOST_DEPTH, frame.scene.and_then(SceneDepth::image));
        resources.set_host_buffer(layout::HOST_PREVIOUS, particles.and_then(|p| p.previous));
        resources.set_host_buffer(layout::HOST_VELOCITIES, particles.and_then(|p| p.velocity));
        resources.set_host_image(layout::MOTION, frame.temporal.motion);
        resources.set_host_image(layout::REACTIVE, frame.temporal.reactive);
    }

    fn recorded(&mut self, _: &Desc, state: State) {
        self.state = state;
    }

    fn forget(&mut self) {
        self.state = State::default();
    }

    fn go_on(&mut self, old: &FlameKind, [before, desc]: [&Desc; 2], kept: &Kept) {
        if !kept.sequence() {
            return;
        }
        let tables = [layout::COLOURS, layout::WEIGHTS, layout::GLOW_WEIGHTS, layout::TONES, layout::MASK];
        let has_room = tables.into_iter().all(|table| kept.buffer(table)) && kept.image(layout::LEVELS);
        let same_mask = (before.seed, before.settings.variants) == (desc.seed, desc.settings.variants);
        let has_tables = old.state.has_tables && has_room && same_mask && old.tables == self.tables;
        // The sums are of another fire, and the expected image's table may be.
        self.state = State { has_tables, repetitions: 0, lit: None, ..old.state };
    }

    fn formats(desc: &Desc) -> Vec<NamedFormat> {
        use vk::FormatFeatureFlags as Use;
        let depth = match desc.scene {
            Some(SceneFormat::Image(depth)) => Some(depth_format(depth, Use::TRANSFER_SRC)),
            Some(SceneFormat::Buffer) | None => None,
        };
        let sums = desc.temporal.motion.map(|_| {
            let features = Use::COLOR_ATTACHMENT | Use::COLOR_ATTACHMENT_BLEND | Use::SAMPLED_IMAGE;
            ("temporal.motion", FormatUse { format: layout::DISPLACEMENT_FORMAT, features })
        });
        let temporal = desc.temporal.formats().chain(sums);
        [target_format(desc.target_format)].into_iter().chain(depth).chain(temporal).collect()
    }
}

impl FlameKind {
    /// The relation of this frame to the ones before, and the state after it.
    fn delta(&self, desc: &Desc, frame: &Frame) -> Result<(FrameDelta, State)> {
        let mut state = self.state;
        if let Some(particles) = &frame.particles {
            let ParticleInput { count, ids, velocity, .. } = particles;
            let velocities = velocity.is_some();
            state.given = Given { count: *count, ids: ids.is_some(), velocities, ..state.given };
            state.hottest = particles.hottest.min(desc.hottest);
        }
        state.spread = frame.spread.or(desc.settings.spread).or(self.state.spread);
        let Some(spread) = state.spread else {
            let allowed = "metres, 0 or above, there or in the frame; celfx::flame::mean_spacing finds the usual one";
            return Err(Error::setting("flame.spread", "none", allowed));
        };
        state.given.spread = spread;
        let space = Space::new(&desc.settings, spread);
        let repetitions = desc.settings.repetitions;
        state.given.before = if frame.accumulate { self.state.repetitions } else { 0 };
        if frame.accumulate {
            self.check_accumulation(frame, &state, state.given.before + repetitions)?;
        }
        state.repetitions = state.given.before + repetitions;
        state.view = Some(frame.view);
        let dark = self.dark(desc, &state, &space);
        // The mask is a layer of frames without fire, too.
        let make_tables = !state.has_tables && (dark.is_none() || desc.layers);
        state.has_tables |= make_tables;
        state.lit = if dark.is_none() { Some((frame.view, space.relative)) } else { state.lit };
        let view_before = frame.temporal.previous.or(self.state.view);
        let (view, has_size) =
            (self.state.lit.map(|lit| lit.0), self.state.lit.is_some_and(|lit| lit.1 == space.relative));
        Ok((FrameDelta { given: state.given, view, has_size, view_before, make_tables, dark }, state))
    }

    /// Only what is the same can be added to.
    fn check_accumulation(&self, frame: &Frame, state: &State, repetitions: u32) -> Result<()> {
        let refuse = |allowed: &str| Err(Error::setting("frame.accumulate", true, allowed));
        match () {
            _ if self.state.repetitions == 0 => refuse("false in the first frame: there is nothing to add to"),
            _ if frame.particles.is_some() => refuse("not with new particles"),
            _ if self.state.view != Some(frame.view) => refuse("not with another view"),
            _ if self.state.spread != state.spread => refuse("not with another spread"),
            _ if repetitions > MOST_REPETITIONS => refuse("up to 1048576 repetitions in all"),
            _ => Ok(()),
        }
    }

    /// Why no fire can be seen, as far as the host can tell.
    fn dark(&self, desc: &Desc, state: &State, space: &Space) -> Option<&'static str> {
        let settings = &desc.settings;
        let size = settings.size_pixels.unwrap_or(space.sprite);
        let alpha = settings.alpha_scale * state.hottest / settings.hottest * self.max_alpha;
        match () {
            _ if state.given.count == 0 => Some("no particles"),
            _ if settings.count == 0.0 => Some("count is 0: no render particles"),
            _ if size == 0.0 => Some("sprites have no size"),
            // A little more than the device's rounding.
            _ if alpha * 1.000001 < settings.threshold || settings.threshold > 1.0 => {
                Some("no particle can pass the alpha test")
            }
            _ => None,
        }
    }
}
