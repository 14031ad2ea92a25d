//! Pass `frame`: a whole frame, volume in, picture out, particles moved on, with what the settings trade. The error is that
//! of the picture against the reference in f64 with the same settings; a shadow map's is exact hard shadows.

use super::{EFFECT, scene};
use crate::bench::measure::{Deviation, interleaved};
use crate::bench::report::{Accuracy, Row, Subject};
use crate::bench::rig::{EffectId, Rig};
use crate::bench::{Outcome, Session};
use crate::error::Result;
use crate::offline;
use crate::smoke::reference::coverage::{self, Coverage};
use crate::smoke::reference::groups::Ranges;
use crate::smoke::reference::{masked, outline, render, shadow, tone};
use crate::smoke::settings::{Outline, Shadow};
use crate::smoke::{Sequence, Settings};
use crate::view::Light;

const PASS: &str = "frame";
type Change = fn(Settings) -> Settings;
const VARIANTS: [(&str, Change); 6] = [
    ("default", |settings| settings),
    ("map 2048", |settings| Settings { shadow: Shadow::Map, shadow_map: 2048, ..settings }),
    ("no shadow", |settings| Settings { shadow: Shadow::None, ..settings }),
    ("sigma 8", |settings| Settings { sigma: 8.0, ..settings }),
    ("sigma 0", |settings| Settings { sigma: 0.0, ..settings }),
    ("no outline", |settings| {
        let outline = Outline { strength: 0.0, ..settings.outline };
        Settings { outline, ..settings }
    }),
];
/// Name, pixels, and what `--quick` divides the sides by.
const WORKLOADS: [(&str, [u32; 2], u32); 2] = [("paper", scene::PAPER, 1), ("1920x1080", scene::FULL_HD, 4)];
const PARTICLES: u32 = 500;

/// The common part of the variants' references: they differ in shading, not in spheres.
struct Seen {
    size: [u32; 2],
    depth: Vec<f64>,
    /// Groups of the spheres that are seen.
    id: Vec<u32>,
    ranges: Ranges,
    /// Luminance with exact shadows and without.
    shadowed: Vec<f64>,
    open: Vec<f64>,
    coverage: Vec<Coverage>,
    voxel: f64,
}

pub(super) fn measure(session: &mut Session) -> Outcome {
    for (name, size, cut) in WORKLOADS {
        let (name, size) = session.picture(name, size, cut);
        let variants = session.wanted(PASS, &name, &VARIANTS);
        if !variants.is_empty() {
            session.next(&format!("smoke frame {name}"))?;
            measure_workload(session, &name, size, &variants)?;
            session.rig.clear();
        }
    }
    Ok(())
}

fn measure_workload(session: &mut Session, name: &str, size: [u32; 2], variants: &[&(&str, Change)]) -> Outcome {
    let volume = scene::plume(scene::PAPER_VOXELS);
    let voxel = volume.voxel_size.iter().copied().fold(f32::INFINITY, f32::min).into();
    let rig = &mut session.rig;
    let first = scene::first_scene(scene::camera(), &volume);
    let mut seen = None;
    let mut effects = Vec::new();
    let mut accuracies = Vec::new();
    for (_, change) in variants {
        let settings = change(Settings { particles: PARTICLES, ..Settings::default() });
        let effect = rig.effect(scene::desc(size, &volume, settings.clone(), false))?;
        // The first frame compiles every kernel, and is compared.
        rig.frame(effect, &first)?;
        let seen = match &seen {
            Some(seen) => seen,
            None => seen.insert(Seen::new(rig, effect, size, &settings, voxel)?),
        };
        let picture = rig.picture(effect)?;
        accuracies.push(seen.accuracy(&settings, &picture));
        effects.push(effect);
    }
    let next = offline::Scene { sequence: Sequence::Advance, ..first };
    for effect in &effects {
        rig.frame(*effect, &next)?;
    }
    let times = interleaved(variants.len(), session.quick, |i| rig.frame(effects[i], &next))?;
    for ((((variant, _), times), accuracy), effect) in variants.iter().zip(&times).zip(&accuracies).zip(effects) {
        let work = session.rig.work_of_frame(effect, &next)?;
        let (variant, workload) = ((*variant).to_owned(), name.to_owned());
        let subject = Subject { pass: PASS, variant, workload, items: PARTICLES.into() };
        session.rows.push(Row::new(EFFECT, subject, times, accuracy, work, &session.limits));
    }
    Ok(())
}

impl Seen {
    fn new(rig: &mut Rig, effect: EffectId, size: [u32; 2], settings: &Settings, voxel: f64) -> Result<Seen> {
        let (spheres, groups) = scene::spheres(rig, effect, PARTICLES, settings.fade)?;
        let ranges = scene::ranges(rig, effect, settings)?;
        let (view, light) = (scene::camera().view(size), Light::default());
        let drawn = render::drawn(&view, size, settings.smallest.into(), &spheres);
        let hits = render::raycast(&view, size, &drawn);
        let share = shadow::shadow(&view, size, &spheres, &hits, light.source, 0.0);
        let shadowed = render::luminance(&view, size, &drawn, &hits, &light, &share);
        let open = render::luminance(&view, size, &drawn, &hits, &light, &vec![1.0; hits.len()]);
        let (depth, id) = (render::depth(&hits), render::id(&hits, &groups));
        let coverage = coverage::coverage(&view, size, &drawn, &hits);
        Ok(Seen { size, depth, id, ranges, shadowed, open, coverage, voxel })
    }

    /// Of all channels of the pixels where there is smoke in one of the two pictures.
    fn accuracy(&self, settings: &Settings, picture: &[[f32; 4]]) -> Accuracy {
        let luminance = if settings.casts_shadows() { &self.shadowed } else { &self.open };
        let (id, smooth) = masked(settings, self.size, luminance, &self.depth, self.id.clone(), &self.ranges);
        let tones = tone::tones(self.size, &smooth, &id, settings.mask, &settings.tones, settings.tone_softness.into());
        let outline =
            outline::outline(self.size, &self.depth, &scene::camera().view(self.size), self.voxel, &settings.outline);
        let mut expected = tone::composite(&tones, &outline, &id, &settings.outline);
        if settings.is_antialiased() {
            expected = coverage::covered(&expected, &self.coverage);
        }
        let smoke = |(pixel, expected): &(&[f32; 4], &[f64; 4])| pixel[3] != 0.0 || expected[3] != 0.0;
        let channels = |(pixel, expected): (&[f32; 4], &[f64; 4])| {
            [0, 1, 2, 3].map(|channel| (f64::from(pixel[channel]) - expected[channel]).abs())
        };
        let differences = picture.iter().zip(&expected).filter(smoke).flat_map(channels).collect();
        let of = "f64 reference frame, linear channels 0 to 1 where there is smoke".to_owned();
        Deviation::of(differences).map(|deviation| (deviation, of))
    }
}
