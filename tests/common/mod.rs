//! What the device tests share: a device under validation, whole effects and the smoke's single passes on it, scenes, and
//! comparison of images.
//!
//! Every device is opened with core and synchronisation validation, and a single message fails the test. Without a
//! device or the layer a test says so and passes, unless `CELFX_REQUIRE_VULKAN=1` (`make test` sets it).
//! `CELFX_DEVICE` chooses a device as `--device` does.
#![allow(dead_code, reason = "each test file uses its part")]

pub mod allocations;
pub mod bench;
pub mod blur;
pub mod faults;
pub mod flame;
pub mod host;
pub mod picture;
pub mod rig;
pub mod scenes;

use std::ops::{Deref, DerefMut};
use std::sync::PoisonError;
use std::time::Duration;

use celfx::low_level::gpu::headless::{Headless, Messages, Options};
use celfx::low_level::smoke::params::{GROUP_BITS, GROUP_MASK, LUMINANCE_ONE};

/// A device whose end, validated destruction included, fails the test if validation has said anything.
pub struct TestDevice {
    // Dropped in this order: what is said about the device's end counts, too.
    headless: Headless,
    verdict: Verdict,
}

/// What validation says; fails the test when it is dropped after saying anything.
pub struct Verdict(Messages);

/// What tests open: under validation, and with an end to every wait, so that a hang is a failure. Long, because a software
/// driver compiles shaders while it runs them and may share its cores.
pub fn options() -> Options {
    let timeout = Some(Duration::from_secs(300));
    Options { validate: true, device: std::env::var("CELFX_DEVICE").ok(), timeout, ..Options::default() }
}

/// A device under validation; none if there is none and the tests may do without.
pub fn device() -> Option<TestDevice> {
    device_of(&options())
}

/// The same, opened so.
pub fn device_of(options: &Options) -> Option<TestDevice> {
    match Headless::new(options) {
        Ok(headless) => {
            let verdict = Verdict(headless.messages());
            Some(TestDevice { headless, verdict })
        }
        Err(error) if std::env::var("CELFX_REQUIRE_VULKAN").is_ok_and(|v| v == "1") => {
            panic!("CELFX_REQUIRE_VULKAN=1, but {error}")
        }
        Err(error) => {
            eprintln!("SKIPPED, no device under validation: {error}");
            None
        }
    }
}

impl TestDevice {
    /// Destroys the device and hands over what validation said, without failing.
    pub fn into_messages(self) -> Vec<String> {
        let TestDevice { headless, verdict } = self;
        drop(headless);
        std::mem::take(&mut *verdict.0.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// What validation has said so far.
    pub fn said(&self) -> Vec<String> {
        self.verdict.said()
    }

    /// The device alone, and the verdict to be kept until the device is gone.
    pub fn split(self) -> (Headless, Verdict) {
        (self.headless, self.verdict)
    }
}

impl Verdict {
    fn said(&self) -> Vec<String> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

impl Deref for TestDevice {
    type Target = Headless;
    fn deref(&self) -> &Headless {
        &self.headless
    }
}

impl DerefMut for TestDevice {
    fn deref_mut(&mut self) -> &mut Headless {
        &mut self.headless
    }
}

impl Drop for Verdict {
    fn drop(&mut self) {
        let said = self.said();
        let text = format!("validation said:\n{}", said.join("\n"));
        match (said.is_empty(), std::thread::panicking()) {
            (true, _) => {}
            // A second panic would end all tests.
            (false, true) => eprintln!("{text}"),
            (false, false) => panic!("{text}"),
        }
    }
}

/// Luminance and group of packed pixels (`glsl/smoke/pixel.glsl`).
pub fn unpacked(pixels: &[u32]) -> (Vec<f64>, Vec<u32>) {
    let luminance = pixels.iter().map(|pixel| f64::from(pixel >> GROUP_BITS) / f64::from(LUMINANCE_ONE)).collect();
    (luminance, pixels.iter().map(|pixel| pixel & GROUP_MASK).collect())
}

/// How far a value is from what is expected; infinite where either is NaN, so that it never passes. Equal infinities are
/// 0 apart.
pub fn apart(actual: f32, expected: f64) -> f64 {
    let difference = (f64::from(actual) - expected).abs();
    match f64::from(actual) == expected {
        true => 0.0,
        false if difference.is_nan() => f64::INFINITY,
        false => difference,
    }
}
