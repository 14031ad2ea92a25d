//! What the device tests share: a device under validation, and comparison of images.
//!
//! Every device is opened with core and synchronisation validation, and a single message fails the test. Without a
//! device or the layer a test says so and passes, unless `CELFX_REQUIRE_VULKAN=1` (`make test` sets it).
//! `CELFX_DEVICE` chooses a device as `--device` does.
#![allow(dead_code, reason = "each test file uses its part")]

pub mod picture;

use std::ops::{Deref, DerefMut};
use std::sync::PoisonError;

use celfx::gpu::headless::{Headless, Messages, Options};

/// A device whose end, validated destruction included, fails the test if validation has said anything.
pub struct TestDevice {
    /// None once it is destroyed.
    headless: Option<Headless>,
    messages: Messages,
}

/// A device under validation; none if there is none and the tests may do without.
pub fn device() -> Option<TestDevice> {
    let options = Options { validate: true, device: std::env::var("CELFX_DEVICE").ok(), ..Options::default() };
    match Headless::new(&options) {
        Ok(headless) => {
            let messages = headless.messages();
            Some(TestDevice { headless: Some(headless), messages })
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
    pub fn into_messages(mut self) -> Vec<String> {
        self.headless = None;
        std::mem::take(&mut *self.messages.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// What validation has said so far.
    pub fn said(&self) -> Vec<String> {
        self.messages.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

impl Deref for TestDevice {
    type Target = Headless;
    fn deref(&self) -> &Headless {
        self.headless.as_ref().expect("a device that is not destroyed")
    }
}

impl DerefMut for TestDevice {
    fn deref_mut(&mut self) -> &mut Headless {
        self.headless.as_mut().expect("a device that is not destroyed")
    }
}

impl Drop for TestDevice {
    fn drop(&mut self) {
        self.headless = None;
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
