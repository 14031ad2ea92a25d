//! Calls that fail: each is an error with a name, and leaves nothing behind.

use std::time::Duration;

use ash::vk;
use celfx::effect::{Effort, Kernels};
use celfx::error::Error;
use celfx::flame;
use celfx::low_level::gpu::headless::{Headless, NoDevice, Options};
use celfx::offline::{EffectBuffer, Effects, Offline, Scene};
use celfx::smoke::SmokeKind;
use celfx::smoke::{self, Sequence};

use crate::common::faults::{arm, disarm, left, table};
use crate::common::flame::ball;
use crate::common::scenes::{camera, desc, direction, puffs};
use crate::common::{device, device_of, options};

const SIZE: [u32; 2] = [16, 16];

fn effects() -> Effects {
    let smoke = desc(SIZE, [8; 3], smoke::Settings { particles: 10, ..smoke::Settings::default() });
    let flame = crate::common::flame::desc(SIZE, 10, flame::Settings::default());
    Effects::from(smoke).with(flame)
}

/// What a run of the whole host may end with.
#[derive(Debug)]
enum Fault {
    None,
    Device(NoDevice),
    Call(Error),
}

/// Opens a device, renders a frame over a backdrop, and reads a buffer.
fn run(options: &Options, messages: &mut Vec<String>) -> Result<(), Fault> {
    let headless = Headless::new(options).map_err(Fault::Device)?;
    let said = headless.messages();
    let result = render(headless).map_err(Fault::Call);
    messages.append(&mut said.lock().expect("nobody panicked"));
    result
}

fn render(headless: Headless) -> celfx::error::Result<()> {
    let mut offline = Offline::new(headless, effects())?;
    offline.set_backdrop(&[[0.5; 4]; 256])?;
    let (volume, particles) = (puffs(8, 0.0), ball(10, 3));
    offline.frame(&Scene {
        sequence: Sequence::Restart,
        dt: 0.1,
        camera: camera(20.0),
        light: direction(-1.0, -1.5, -1.0),
        volume: Some(&volume),
        particles: Some(&particles),
        rendered: true,
        ..Scene::default()
    })?;
    offline.read(EffectBuffer::of::<SmokeKind>(celfx::low_level::smoke::layout::DEPTH), 64).map(drop)
}

/// Lets each call fail whose number is a multiple of `step`, one a run.
fn each_call_that_fails(step: u32) {
    if device().is_none() {
        return;
    }
    let options = Options { table, ..options() };
    for calls in (0..).step_by(step as usize) {
        let mut messages = Vec::new();
        arm(calls, None);
        let ended = run(&options, &mut messages);
        let failed = disarm();
        assert_eq!(messages, Vec::<String>::new(), "call {calls}: {failed:?} leaves something behind");
        let fault = ended.err().unwrap_or(Fault::None);
        let Some(name) = failed else {
            assert!(matches!(fault, Fault::None), "{fault:?} though nothing failed");
            assert!(calls > 200, "only {calls} calls");
            return;
        };
        let text = match &fault {
            Fault::None => format!("nothing after {name}"),
            Fault::Device(error) => error.to_string(),
            Fault::Call(error) => error.to_string(),
        };
        // The allocator's calls are told by what memory was wanted for.
        let is_memory = matches!(fault, Fault::Call(Error::Allocation { .. }));
        assert!(text.contains(name) || is_memory && text.contains("no memory for "), "call {calls}, {name}: {text}");
    }
}

#[test]
fn some_calls_that_fail_are_errors_with_a_name_and_leave_nothing_behind() {
    each_call_that_fails(41);
}

#[test]
#[ignore = "takes minutes; make test-all runs it"]
fn every_call_that_fails_is_an_error_with_a_name_and_leaves_nothing_behind() {
    each_call_that_fails(1);
}

/// Threads that need the same pipelines divide the work; what one could not make, another makes that needs it.
#[test]
fn threads_divide_pipelines() {
    let Some(device) = device_of(&Options { table, ..options() }) else { return };
    let host = device.host();
    let passes = celfx::program::variants(&device.traits()).expect("allowed settings");
    let small = &passes[..40];
    // Makes them, and counts how many compute pipelines this took; one of so many calls fails.
    let make = |kernels: &Kernels, fails: u32| {
        arm(fails, Some("vkCreateComputePipelines"));
        // SAFETY: valid handles, of one device.
        let result = unsafe { kernels.make(&host, small) };
        let calls = left().map(|left| fails - left);
        disarm();
        (result, calls)
    };
    const NEVER: u32 = 1000;
    let mut alone = Kernels::new();
    let expected = make(&alone, NEVER).1.expect("nothing failed");
    assert!(expected > 10, "{expected}");
    for fails in [NEVER, 3] {
        let mut shared = Kernels::new();
        let counted = std::thread::scope(|scope| {
            let faulty = scope.spawn(|| make(&shared, fails));
            let others = [0, 1].map(|_| scope.spawn(|| make(&shared, NEVER)));
            let (result, calls) = faulty.join().expect("no panic");
            assert!(result.is_ok() || fails != NEVER, "{result:?}");
            let others = others.map(|other| other.join().expect("no panic"));
            others.iter().for_each(|(result, _)| assert!(result.is_ok(), "{result:?}"));
            // One that failed has made those before.
            calls.unwrap_or(fails) + others.into_iter().map(|(_, calls)| calls.expect("nothing failed")).sum::<u32>()
        });
        assert_eq!((counted, shared.count()), (expected, alone.count()), "one in {fails} fails");
        // SAFETY: nothing was submitted.
        unsafe { shared.destroy(&host) };
    }
    // SAFETY: nothing was submitted.
    unsafe { alone.destroy(&host) };
}

#[test]
fn a_lost_device_names_its_pass() {
    let options = Options { table, ..options() };
    // Until a step has run it is submitted alone, and the second one is lost; or all of them are.
    for (longest, lost) in [(Some(Duration::ZERO), 1), (None, 0)] {
        let Some(device) = device_of(&options) else { return };
        let mut offline = device.offline(effects(), Effort::Needed).expect("the effects can be made");
        offline.set_longest_submission(longest);
        let (volume, particles) = (puffs(8, 0.0), ball(10, 3));
        arm(lost, Some("vkWaitForFences"));
        let ended = offline.frame(&Scene {
            sequence: Sequence::Restart,
            dt: 0.1,
            camera: camera(20.0),
            light: direction(-1.0, -1.5, -1.0),
            volume: Some(&volume),
            particles: Some(&particles),
            rendered: true,
            number: 7,
            ..Scene::default()
        });
        assert_eq!(disarm(), Some("vkWaitForFences"), "{ended:?}");
        let smoke = offline.effect::<SmokeKind>().expect("there is smoke, and it comes first");
        let name = |step: usize| smoke.passes()[usize::from(smoke.plan().steps[step].pass.0)].name;
        let expected = match longest {
            Some(_) => format!("frame 7, {}", name(lost as usize)),
            None => format!("frame 7, {} to flame.composite", name(0)),
        };
        match ended {
            Err(Error::Vulkan { object: Some(object), result: vk::Result::ERROR_DEVICE_LOST, .. }) => {
                assert_eq!(object, expected);
            }
            other => panic!("{other:?}"),
        }
    }
}

fn stop(_: Duration) -> bool {
    false
}

fn stop_waiting(waited: Duration) -> bool {
    waited.is_zero()
}

#[test]
fn nothing_is_submitted_after_an_interruption() {
    let Some(mut device) = device_of(&Options { go_on: stop, ..options() }) else { return };
    for name in ["first", "second"] {
        match device.one_time(name, |_, _| Ok(())) {
            Err(Error::Interrupted { what }) => assert_eq!(what, name),
            other => panic!("{other:?}"),
        }
    }
    assert!(!device.is_stuck(), "nothing runs");
}

#[test]
fn an_interruption_ends_a_wait_for_what_does_not_end() {
    // Without an end to the wait of its own.
    let options = Options { go_on: stop_waiting, timeout: None, ..options() };
    let Some(mut device) = device_of(&options) else { return };
    let raw = device.host().device.clone();
    // SAFETY: valid handles. The event is never destroyed: the device may still be using it.
    let event = unsafe { raw.create_event(&vk::EventCreateInfo::default(), None) }.expect("an event");
    let waited = device.one_time("frame 12", |host, commands| {
        let (host_stage, all) = (vk::PipelineStageFlags::HOST, vk::PipelineStageFlags::ALL_COMMANDS);
        // SAFETY: valid handles.
        unsafe { host.device.cmd_wait_events(commands, &[event], host_stage, all, &[], &[], &[]) };
        Ok(())
    });
    assert!(matches!(&waited, Err(Error::Interrupted { what }) if what == "frame 12"), "{waited:?}");
    assert!(device.is_stuck());
    drop(device);
    // SAFETY: the device was left alone, so it is still there; now the work can end.
    unsafe { raw.set_event(event) }.expect("set");
}
