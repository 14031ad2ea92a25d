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
pub mod handles;
pub mod host;
pub mod picture;
pub mod rig;
pub mod scenes;
pub mod temporal;
pub mod views;

use std::ops::{Deref, DerefMut};
use std::sync::{Mutex, Once, PoisonError};
use std::time::Duration;

use celfx::effect::{DeviceTraits, Effort};
use celfx::error::Result;
use celfx::low_level::gpu::headless::{Headless, Messages, Options};
use celfx::low_level::smoke::params::{GROUP_BITS, GROUP_MASK, LUMINANCE_ONE};
use celfx::offline::{Effects, Offline};

/// A device, lent: later tests have it, and the pipelines made on it, again. What validation says, what is left in memory,
/// and what is found at the device's own end fails the tests.
pub struct TestDevice {
    /// None while something else has it.
    headless: Option<Headless>,
    verdict: Verdict,
    is_lent: bool,
}

/// Effects without a window on a device that is lent.
pub struct TestOffline {
    offline: Option<Offline>,
    device: TestDevice,
}

/// What validation says; fails the test when it is dropped after saying anything.
struct Verdict(Messages);

/// Devices that no test has now.
static IDLE: Mutex<Vec<Headless>> = Mutex::new(Vec::new());

/// What tests open: under validation, and with an end to every wait, so that a hang is a failure. Long, because a software
/// driver compiles shaders while it runs them and may share its cores.
pub fn options() -> Options {
    let timeout = Some(Duration::from_secs(300));
    Options { validate: true, device: std::env::var("CELFX_DEVICE").ok(), timeout, ..Options::default() }
}

/// A device under validation; none if there is none and the tests may do without.
pub fn device() -> Option<TestDevice> {
    let idle = IDLE.lock().unwrap_or_else(PoisonError::into_inner).pop();
    match idle {
        Some(headless) => Some(TestDevice::new(headless, true)),
        None => open(&options(), true),
    }
}

/// One of the test's own, opened so.
pub fn device_of(options: &Options) -> Option<TestDevice> {
    open(options, false)
}

fn open(options: &Options, is_lent: bool) -> Option<TestDevice> {
    match Headless::new(options) {
        Ok(headless) => Some(TestDevice::new(headless, is_lent)),
        Err(error) if std::env::var("CELFX_REQUIRE_VULKAN").is_ok_and(|v| v == "1") => {
            panic!("CELFX_REQUIRE_VULKAN=1, but {error}")
        }
        Err(error) => {
            eprintln!("SKIPPED, no device under validation: {error}");
            None
        }
    }
}

/// Ends the devices that no test has any more, when the process ends.
extern "C" fn end() {
    for headless in IDLE.lock().unwrap_or_else(PoisonError::into_inner).drain(..) {
        let messages = headless.messages();
        drop(headless);
        let said = messages.lock().unwrap_or_else(PoisonError::into_inner);
        if !said.is_empty() {
            eprintln!("when the device ended, validation said:\n{}", said.join("\n"));
            std::process::abort();
        }
    }
}

impl TestDevice {
    fn new(headless: Headless, is_lent: bool) -> TestDevice {
        let verdict = Verdict(headless.messages());
        TestDevice { headless: Some(headless), verdict, is_lent }
    }

    /// Makes effects on it.
    ///
    /// # Errors
    /// As [`Offline::new`].
    pub fn offline(mut self, effects: impl Into<Effects>, effort: Effort) -> Result<TestOffline> {
        let offline = Offline::with_effort(self.headless.take().expect("a device"), effects, effort)?;
        Ok(TestOffline { offline: Some(offline), device: self })
    }

    /// Effects on it are fitted to what this makes of its traits.
    pub fn fitted(mut self, change: impl FnOnce(&mut DeviceTraits)) -> TestDevice {
        let mut traits = self.traits();
        change(&mut traits);
        self.fit(Some(traits));
        self
    }

    /// Destroys the device and hands over what validation said, without failing.
    pub fn into_messages(mut self) -> Vec<String> {
        drop(self.headless.take());
        std::mem::take(&mut *self.verdict.0.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// What validation has said so far.
    pub fn said(&self) -> Vec<String> {
        self.verdict.said()
    }
}

impl Drop for TestDevice {
    fn drop(&mut self) {
        let Some(mut headless) = self.headless.take() else { return };
        let is_sound = !std::thread::panicking() && self.said().is_empty() && !headless.is_stuck();
        if !self.is_lent || !is_sound {
            // What is said about its end counts, too.
            drop(headless);
            return;
        }
        headless.fit(None);
        assert_eq!(headless.allocated(), 0, "bytes are left in memory");
        static ENDS: Once = Once::new();
        // SAFETY: the function may be called at the process's end: it uses nothing that is gone then.
        ENDS.call_once(|| assert_eq!(unsafe { libc::atexit(end) }, 0));
        IDLE.lock().unwrap_or_else(PoisonError::into_inner).push(headless);
    }
}

impl Deref for TestDevice {
    type Target = Headless;
    fn deref(&self) -> &Headless {
        self.headless.as_ref().expect("a device")
    }
}

impl DerefMut for TestDevice {
    fn deref_mut(&mut self) -> &mut Headless {
        self.headless.as_mut().expect("a device")
    }
}

impl Drop for TestOffline {
    fn drop(&mut self) {
        self.device.headless = self.offline.take().map(Offline::into_device);
    }
}

impl Deref for TestOffline {
    type Target = Offline;
    fn deref(&self) -> &Offline {
        self.offline.as_ref().expect("effects")
    }
}

impl DerefMut for TestOffline {
    fn deref_mut(&mut self) -> &mut Offline {
        self.offline.as_mut().expect("effects")
    }
}

impl Verdict {
    fn said(&self) -> Vec<String> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
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
