//! The host without a window: what it reads back, and what it leaves alone.

use std::time::Duration;

use ash::vk;
use celfx::error::Error;
use celfx::low_level::gpu::headless::{Headless, Options};
use celfx::low_level::smoke::layout;
use celfx::offline::{EffectBuffer, Offline, Scene};
use celfx::smoke::SmokeKind;
use celfx::smoke::{Sequence, Settings};

use crate::common::device;
use crate::common::rig::{Rig, scene};
use crate::common::scenes::{camera, desc, direction, puffs};

const SIZE: [u32; 2] = [48, 36];
const DEPTH: EffectBuffer = EffectBuffer::of::<SmokeKind>(layout::DEPTH);

fn settings() -> Settings {
    Settings { particles: 50, ..Settings::default() }
}

#[test]
fn layers_come_with_the_frame_as_reading_them_alone_has_them() {
    let Some(mut rig) = Rig::new(desc(SIZE, [12; 3], settings())) else { return };
    let offline = rig.offline();
    assert!(offline.picture().is_empty() && offline.layers().is_empty(), "nothing is rendered yet");
    let ids = [layout::PICTURE, layout::SPHERES, layout::DEPTH, layout::CONTROL].map(EffectBuffer::of::<SmokeKind>);
    offline.set_layers(&ids).expect("memory");
    assert_eq!(offline.layers(), [&[0_u8; 0][..]; 4], "nothing is rendered yet");
    let volume = puffs(12, 0.0);
    let first = scene(Sequence::Restart, camera(0.0), direction(-1.0, -1.5, -1.0), Some(&volume));
    offline.frame(&first).expect("rendered");
    let layers: Vec<Vec<u8>> = offline.layers().into_iter().map(<[u8]>::to_vec).collect();
    let picture = offline.picture().to_vec();
    assert!(picture.iter().any(|pixel| pixel[3] > 0.0), "there is smoke");
    assert_eq!(bytemuck::cast_slice::<_, u8>(&picture), &layers[0][..], "over nothing, the effect alone");
    for (id, layer) in ids.into_iter().zip(&layers) {
        assert!(!layer.is_empty() && *layer == offline.read(id, u64::MAX).expect("read"), "{id:?}");
        assert_eq!(layer[..16], offline.read(id, 16).expect("read"), "{id:?}");
    }
    assert_eq!(offline.picture(), picture, "reading a buffer leaves the frame");
    assert!(offline.times().is_some() && offline.times().is_none(), "times are taken once");
}

#[test]
fn only_a_rendered_frame_changes_what_was_read_back() {
    let Some(mut rig) = Rig::new(desc(SIZE, [12; 3], settings())) else { return };
    let offline = rig.offline();
    let volume = puffs(12, 0.0);
    let first = scene(Sequence::Restart, camera(0.0), direction(-1.0, -1.5, -1.0), Some(&volume));
    offline.frame(&first).expect("rendered");
    let picture = offline.picture().to_vec();
    let next = Scene { sequence: Sequence::Advance, camera: camera(90.0), volume: None, ..first };
    offline.frame(&Scene { rendered: false, ..next }).expect("stepped");
    assert!(picture.len() == 48 * 36 && offline.picture() == picture);
    let large = puffs(13, 0.0);
    let refused = offline.frame(&Scene { volume: Some(&large), ..next });
    assert!(matches!(refused, Err(Error::HostResource { name: "volume", .. })), "{refused:?}");
    assert!(offline.picture().is_empty() && offline.times().is_none(), "there is no such frame");
    offline.set_timed(false);
    offline.frame(&next).expect("the next frame is none the worse");
    assert!(offline.picture().len() == picture.len() && offline.picture() != picture, "seen from the side");
    assert!(offline.times().is_none(), "not timed");
}

#[test]
fn a_backdrop_is_under_the_smoke_until_a_colour_is_set() {
    let Some(mut rig) = Rig::new(desc(SIZE, [12; 3], Settings { particles: 0, ..settings() })) else { return };
    let volume = puffs(12, 0.0);
    let given = scene(Sequence::Restart, camera(0.0), direction(0.0, -1.0, 0.0), Some(&volume));
    let offline = rig.offline();
    let wrong = offline.set_backdrop(&[[0.0; 4]; 7]);
    assert!(matches!(wrong, Err(Error::HostResource { name: "background", .. })), "{wrong:?}");
    for key in [1.0, 2.0] {
        let sky: Vec<[f32; 4]> = (0..SIZE[0] * SIZE[1]).map(|i| [i as f32 * key, 0.5, 0.25, 1.0]).collect();
        offline.set_backdrop(&sky).expect("uploaded");
        offline.frame(&given).expect("rendered");
        assert!(offline.picture() == sky, "the very pixels");
    }
    offline.set_background([0.25, 0.5, 0.75, 1.0]);
    offline.frame(&given).expect("rendered");
    assert!(offline.picture().iter().all(|pixel| *pixel == [0.25, 0.5, 0.75, 1.0]));
}

#[test]
fn after_a_wait_that_did_not_end_nothing_is_touched() {
    let Some(found) = device() else { return };
    let index = found.info().index.to_string();
    drop(found);
    // No device renders a frame in no time.
    let options = Options { validate: true, device: Some(index), timeout: Some(Duration::ZERO), ..Options::default() };
    let headless = Headless::new(&options).expect("the same device");
    let messages = headless.messages();
    let mut offline = Offline::new(headless, desc([512, 512], [32; 3], settings())).expect("the effect");
    let volume = puffs(32, 0.0);
    let first = scene(Sequence::Restart, camera(0.0), direction(-1.0, -1.5, -1.0), Some(&volume));
    let is_timeout = |error: &Error| matches!(error, Error::Vulkan { result: vk::Result::TIMEOUT, .. });
    for _ in 0..2 {
        assert!(is_timeout(&offline.frame(&first).expect_err("no time")));
        assert!(offline.picture().is_empty(), "it may still change");
    }
    assert!(is_timeout(&offline.read(DEPTH, 16).expect_err("the device is busy")));
    assert!(is_timeout(&offline.set_layers(&[DEPTH]).expect_err("the device is busy")));
    assert!(is_timeout(&offline.set_backdrop(&[]).expect_err("the device is busy")));
    // Destroys nothing that is in use, which validation would report.
    drop(offline);
    assert_eq!(*messages.lock().expect("nobody panicked"), Vec::<String>::new());
}
