//! Frames of a shot with their layers, in memory: what `celfx render --layers` would write.

use std::any::Any;
use std::rc::Rc;
use std::sync::Arc;

use glam::DVec3;

use crate::bench::{BenchError, Watch};
use crate::data::Volume;
use crate::gpu::headless::Headless;
use crate::io::picture;
use crate::io::shot::{Background, Shot};
use crate::offline::{EffectBuffer, Effects, Offline, Scene};
use crate::program::layers::{self, Layer, LayerData, Rendered, Wanted};
use crate::program::smoke::Smoke;
use crate::program::{self, Brought, EFFECTS, Input};
use crate::smoke::Sequence;
use crate::smoke::reference::grid::Grid;
use crate::view::{Camera, Projection};

/// What a frame brings, by the effect's name.
type AllBrought = Vec<(&'static str, Rc<dyn Brought>)>;

/// A shot on the device. Frames must be asked for in order.
pub(super) struct Take<'a> {
    offline: Offline,
    shot: &'a Arc<Shot>,
    inputs: Vec<(&'static str, Box<dyn Input>)>,
    effects: Effects,
    buffers: Vec<EffectBuffer>,
    /// The frame that was stepped to last, and what it brought.
    at: Option<(u32, AllBrought)>,
    /// What has brought the last volume.
    volume: Option<Rc<dyn Brought>>,
    watch: &'a dyn Watch,
}

/// A rendered frame.
pub(super) struct Still {
    /// What it was seen through.
    pub(super) projection: Projection,
    /// Linear RGBA, premultiplied.
    pub(super) picture: Vec<[f32; 4]>,
    layers: Vec<Layer>,
}

impl Still {
    fn layer(&self, name: &str) -> Option<&LayerData> {
        self.layers.iter().find(|layer| layer.name == name).map(|layer| &layer.data)
    }

    /// A layer of one value a pixel, or an array; empty if there is none.
    pub(super) fn values(&self, name: &str) -> &[f32] {
        match self.layer(name) {
            Some(LayerData::Value(values) | LayerData::Array { values, .. }) => values,
            _ => &[],
        }
    }

    /// A layer with channels R G B A; empty if there is none.
    pub(super) fn colours(&self, name: &str) -> &[[f32; 4]] {
        match self.layer(name) {
            Some(LayerData::Colour(colours)) => colours,
            _ => &[],
        }
    }
}

impl<'a> Take<'a> {
    /// Makes the effects that draw the frames `rendered` of a shot, which ascend.
    ///
    /// # Errors
    /// What the shot names cannot be read; the device fails.
    pub(super) fn new(
        device: Headless,
        shot: &'a Arc<Shot>,
        rendered: &[u32],
        watch: &'a dyn Watch,
    ) -> Result<Take<'a>, BenchError> {
        let mut inputs = Vec::new();
        for effect in EFFECTS {
            inputs.extend((effect.open)(shot)?.map(|input| (effect.name(), input)));
        }
        let threads = std::thread::available_parallelism().map_or(1, usize::from);
        let mut effects = Effects::default();
        for (_, input) in &mut inputs {
            input.prepare(rendered, threads)?;
            effects = input.describe(effects, rendered, true)?;
        }
        let mut offline = Offline::new(device, effects.clone())?;
        let buffers = layers::buffers(&effects, Wanted::All);
        offline.set_layers(&buffers)?;
        offline.set_timed(false);
        match &shot.background {
            Background::Image(path) => offline.set_backdrop(&picture::read_frame(path, shot.size)?.pixels)?,
            Background::Colour([r, g, b]) => offline.set_background([*r, *g, *b, 1.0]),
            Background::None => offline.set_background([0.0; 4]),
        }
        Ok(Take { offline, shot, inputs, effects, buffers, at: None, volume: None, watch })
    }

    /// Hands the device back.
    pub(super) fn into_device(self) -> Headless {
        self.offline.into_device()
    }

    /// A frame of the shot. What has a past is stepped from the shot's first frame.
    pub(super) fn frame(&mut self, number: u32) -> Result<Still, BenchError> {
        let has_past = self.inputs.iter().any(|(_, input)| input.has_past());
        let next = self.at.as_ref().map_or(self.shot.frames[0], |(last, _)| last + 1);
        for before in (next..number).filter(|_| has_past) {
            self.step(before, false)?;
        }
        self.step(number, true)?;
        Ok(self.still(self.shot.camera(number)))
    }

    /// The frame that was rendered last, as another camera sees it.
    pub(super) fn seen(&mut self, camera: Camera) -> Result<Still, BenchError> {
        self.check()?;
        if let Some((number, all)) = &self.at {
            let mut scene = program::scene(self.shot, *number, true);
            all.iter().for_each(|(_, brought)| brought.put(&mut scene));
            // Volume and particles are on the device.
            let held = Scene { sequence: Sequence::Hold, camera, volume: None, particles: None, ..scene };
            self.offline.frame(&held)?;
        }
        Ok(self.still(camera))
    }

    fn step(&mut self, number: u32, rendered: bool) -> Result<(), BenchError> {
        self.check()?;
        let mut all = AllBrought::new();
        for (name, input) in &mut self.inputs {
            all.extend(input.read(number, rendered)?.map(|brought| (*name, brought.into())));
        }
        let mut scene = program::scene(self.shot, number, rendered);
        for (_, brought) in &all {
            let had_volume = scene.volume.is_some();
            brought.put(&mut scene);
            if !had_volume && scene.volume.is_some() {
                self.volume = Some(brought.clone());
            }
        }
        self.offline.frame(&scene)?;
        self.at = Some((number, all));
        Ok(())
    }

    fn check(&self) -> Result<(), BenchError> {
        if self.watch.is_interrupted() { Err(BenchError::Interrupted) } else { Ok(()) }
    }

    /// What the device has rendered.
    fn still(&self, camera: Camera) -> Still {
        let brought = self.at.iter().flat_map(|(_, brought)| brought);
        let rendered = Rendered {
            effects: &self.effects,
            picture: self.offline.picture(),
            buffers: self.buffers.iter().copied().zip(self.offline.layers()).collect(),
            brought: brought.map(|(name, brought)| (*name, &**brought as &dyn Any)).collect(),
            skipped: Vec::new(),
        };
        let projection = Projection::of_valid(&camera.view(self.shot.size), self.shot.size);
        Still { projection, picture: rendered.picture.to_vec(), layers: rendered.layers(Wanted::All) }
    }

    /// How the frame stepped to last moves smoke; none where no frame has brought a volume.
    pub(super) fn motion(&self) -> Option<Motion> {
        let (number, _) = self.at.as_ref()?;
        let exposure = self.shot.part::<Smoke>()?.exposure;
        let frames = if exposure.is_held(number + 1) { 0 } else { exposure.on() };
        Some(Motion { volume: self.volume.clone()?, seconds: f64::from(frames) / self.shot.fps })
    }
}

/// The motion of a frame's volume.
pub(super) struct Motion {
    /// What has brought the volume.
    volume: Rc<dyn Brought>,
    /// Until the next frame.
    seconds: f64,
}

impl Motion {
    /// Smallest side of a voxel in metres.
    pub(super) fn voxel(&self) -> f64 {
        self.grid().smallest_side()
    }

    /// Where a place (metres, world) is in the next frame: moved by the velocity there, between voxels' centres linear.
    pub(super) fn moved(&self) -> impl Fn(DVec3) -> DVec3 {
        let grid = self.grid();
        move |place| place + grid.velocity_at(place) * self.seconds
    }

    fn grid(&self) -> Grid<'_> {
        let mut scene = Scene::default();
        self.volume.put(&mut scene);
        // It is here because it has brought one.
        scene.volume.map_or(Grid::EMPTY, Volume::grid)
    }
}
