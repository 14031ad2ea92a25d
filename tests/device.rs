//! The device under the other tests: that validation reports what it must report, that the profiler tells the truth,
//! and that the comparison of images can fail.
#![cfg(feature = "cli")]

mod common;

use std::time::Duration;

use ash::vk;
use celfx::error::{Error, Result};
use celfx::host::Host;
use celfx::low_level::gpu::buffer::{Buffer, BufferDesc};
use celfx::low_level::gpu::debug;
use celfx::low_level::gpu::headless::{self, Headless, Options};
use celfx::low_level::gpu::profiler::{Profiler, Timing, queries};
use celfx::profile::Clock;
use common::picture::{Picture, Tolerance, compare};
use common::{TestDevice, device, host};

const BYTES: u64 = 1 << 20;

fn buffers<const N: usize>(device: &mut TestDevice) -> [Buffer; N] {
    let (host, allocator) = device.parts();
    // SAFETY: the handles are the device's own.
    [(); N].map(|()| unsafe { Buffer::new(&host, allocator, &BufferDesc::storage("test", BYTES)) }.expect("a buffer"))
}

fn destroy(device: &mut TestDevice, mut buffers: impl AsMut<[Buffer]>) {
    host::destroy(device, buffers.as_mut(), []);
}

unsafe fn copy(host: &Host, commands: vk::CommandBuffer, from: &Buffer, to: &Buffer) {
    let region = [vk::BufferCopy::default().size(BYTES)];
    // SAFETY: the caller's.
    unsafe { host.device.cmd_copy_buffer(commands, from.handle, to.handle, &region) };
}

unsafe fn fill(host: &Host, commands: vk::CommandBuffer, buffer: &Buffer, word: u32) {
    // SAFETY: the caller's.
    unsafe { host.device.cmd_fill_buffer(commands, buffer.handle, 0, BYTES, word) };
}

unsafe fn transfer_barrier(host: &Host, commands: vk::CommandBuffer) {
    // SAFETY: the caller's.
    unsafe { host::barrier(host, commands, host::TRANSFER_WRITTEN, host::TRANSFERRED) };
}

fn assert_said(said: &[String], what: &str) {
    assert!(said.iter().any(|message| message.contains(what)), "no {what} in {said:#?}");
}

#[test]
fn a_clean_program_says_nothing() {
    let Some(mut device) = device() else { return };
    let buffers = buffers::<2>(&mut device);
    let recorded = device.one_time("fill and copy", |host, commands| {
        // SAFETY: valid handles, and a barrier between write and read.
        unsafe {
            debug::begin_label(host, commands, "fill and copy");
            fill(host, commands, &buffers[0], 1);
            transfer_barrier(host, commands);
            copy(host, commands, &buffers[0], &buffers[1]);
            debug::end_label(host, commands);
        }
        Ok(())
    });
    recorded.expect("it runs");
    destroy(&mut device, buffers);
    assert_eq!(device.into_messages(), Vec::<String>::new());
}

#[test]
fn validation_reports_missing_barriers_between_transfers() {
    for (name, hazard) in [
        ("read after write", "SYNC-HAZARD-READ-AFTER-WRITE"),
        ("write after read", "SYNC-HAZARD-WRITE-AFTER-READ"),
        ("write after write", "SYNC-HAZARD-WRITE-AFTER-WRITE"),
    ] {
        let Some(mut device) = device() else { return };
        let buffers = buffers::<2>(&mut device);
        let recorded = device.one_time(name, |host, commands| {
            // SAFETY: valid handles; the missing barrier makes contents undefined that nobody looks at.
            unsafe {
                match name {
                    "read after write" => {
                        fill(host, commands, &buffers[0], 1);
                        copy(host, commands, &buffers[0], &buffers[1]);
                    }
                    "write after read" => {
                        copy(host, commands, &buffers[0], &buffers[1]);
                        fill(host, commands, &buffers[0], 1);
                    }
                    _ => {
                        fill(host, commands, &buffers[0], 1);
                        fill(host, commands, &buffers[0], 2);
                    }
                }
            }
            Ok(())
        });
        recorded.expect("it runs");
        destroy(&mut device, buffers);
        assert_said(&device.into_messages(), hazard);
    }
}

/// `glslangValidator --target-env vulkan1.3 --target-env spirv1.5` of `layout(local_size_x = 8) in;
/// layout(binding = 0) readonly buffer A { uint a[]; }; layout(binding = 1) writeonly buffer B { uint b[]; };
/// void main() { b[gl_GlobalInvocationID.x] = a[gl_GlobalInvocationID.x]; }`
#[rustfmt::skip]
const COPY: &[u32] = &[
    0x7230203, 0x10500, 0x8000b, 0x21, 0x0, 0x20011, 0x1, 0x6000b, 0x1, 0x4c534c47, 0x6474732e, 0x3035342e, 0x0,
    0x3000e, 0x0, 0x1, 0x8000f, 0x5, 0x4, 0x6e69616d, 0x0, 0xa, 0xf, 0x17, 0x60010, 0x4, 0x11, 0x8, 0x1, 0x1,
    0x40047, 0x7, 0x6, 0x4, 0x40048, 0x8, 0x0, 0x19, 0x50048, 0x8, 0x0, 0x23, 0x0, 0x30047, 0x8, 0x2, 0x40047, 0xa,
    0x22, 0x0, 0x40047, 0xa, 0x21, 0x1, 0x40047, 0xf, 0xb, 0x1c, 0x40047, 0x14, 0x6, 0x4, 0x40048, 0x15, 0x0, 0x18,
    0x50048, 0x15, 0x0, 0x23, 0x0, 0x30047, 0x15, 0x2, 0x40047, 0x17, 0x22, 0x0, 0x40047, 0x17, 0x21, 0x0, 0x40047,
    0x20, 0xb, 0x19, 0x20013, 0x2, 0x30021, 0x3, 0x2, 0x40015, 0x6, 0x20, 0x0, 0x3001d, 0x7, 0x6, 0x3001e, 0x8, 0x7,
    0x40020, 0x9, 0xc, 0x8, 0x4003b, 0x9, 0xa, 0xc, 0x40015, 0xb, 0x20, 0x1, 0x4002b, 0xb, 0xc, 0x0, 0x40017, 0xd,
    0x6, 0x3, 0x40020, 0xe, 0x1, 0xd, 0x4003b, 0xe, 0xf, 0x1, 0x4002b, 0x6, 0x10, 0x0, 0x40020, 0x11, 0x1, 0x6,
    0x3001d, 0x14, 0x6, 0x3001e, 0x15, 0x14, 0x40020, 0x16, 0xc, 0x15, 0x4003b, 0x16, 0x17, 0xc, 0x40020, 0x1a, 0xc,
    0x6, 0x4002b, 0x6, 0x1e, 0x8, 0x4002b, 0x6, 0x1f, 0x1, 0x6002c, 0xd, 0x20, 0x1e, 0x1f, 0x1f, 0x50036, 0x2, 0x4,
    0x0, 0x3, 0x200f8, 0x5, 0x50041, 0x11, 0x12, 0xf, 0x10, 0x4003d, 0x6, 0x13, 0x12, 0x60041, 0x1a, 0x1b, 0x17,
    0xc, 0x13, 0x4003d, 0x6, 0x1c, 0x1b, 0x60041, 0x1a, 0x1d, 0xa, 0xc, 0x13, 0x3003e, 0x1d, 0x1c, 0x100fd, 0x10038
];

/// The pipeline of [`COPY`] with two buffers bound to it.
struct CopyKernel {
    module: vk::ShaderModule,
    set_layout: vk::DescriptorSetLayout,
    layout: vk::PipelineLayout,
    pipeline: vk::Pipeline,
    pool: vk::DescriptorPool,
    set: vk::DescriptorSet,
}

impl CopyKernel {
    unsafe fn new(host: &Host, from: &Buffer, to: &Buffer) -> CopyKernel {
        let kind = vk::DescriptorType::STORAGE_BUFFER;
        let binding = vk::DescriptorSetLayoutBinding::default()
            .descriptor_type(kind)
            .descriptor_count(1)
            .stage_flags(vk::ShaderStageFlags::COMPUTE);
        let bindings = [binding.binding(0), binding.binding(1)];
        let size = [vk::DescriptorPoolSize { ty: kind, descriptor_count: 2 }];
        let ranges = [from, to].map(|b| vk::DescriptorBufferInfo { buffer: b.handle, offset: 0, range: BYTES });
        // SAFETY: the caller's.
        unsafe {
            let info = vk::ShaderModuleCreateInfo::default().code(COPY);
            let module = host.device.create_shader_module(&info, None).expect("a module");
            let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
            let set_layout = host.device.create_descriptor_set_layout(&info, None).expect("a set layout");
            let layouts = [set_layout];
            let info = vk::PipelineLayoutCreateInfo::default().set_layouts(&layouts);
            let layout = host.device.create_pipeline_layout(&info, None).expect("a layout");
            let stage = vk::PipelineShaderStageCreateInfo::default()
                .stage(vk::ShaderStageFlags::COMPUTE)
                .module(module)
                .name(c"main");
            let info = [vk::ComputePipelineCreateInfo::default().stage(stage).layout(layout)];
            let pipelines = host.device.create_compute_pipelines(host.pipeline_cache, &info, None);
            let pipeline = pipelines.expect("a pipeline")[0];
            let info = vk::DescriptorPoolCreateInfo::default().max_sets(1).pool_sizes(&size);
            let pool = host.device.create_descriptor_pool(&info, None).expect("a pool");
            let info = vk::DescriptorSetAllocateInfo::default().descriptor_pool(pool).set_layouts(&layouts);
            let set = host.device.allocate_descriptor_sets(&info).expect("a set")[0];
            let write = vk::WriteDescriptorSet::default().dst_set(set).descriptor_type(kind).buffer_info(&ranges);
            host.device.update_descriptor_sets(&[write], &[]);
            CopyKernel { module, set_layout, layout, pipeline, pool, set }
        }
    }

    unsafe fn dispatch(&self, host: &Host, commands: vk::CommandBuffer) {
        let point = vk::PipelineBindPoint::COMPUTE;
        // SAFETY: the caller's; the buffer holds more than the 64 words that are touched.
        unsafe {
            host.device.cmd_bind_pipeline(commands, point, self.pipeline);
            host.device.cmd_bind_descriptor_sets(commands, point, self.layout, 0, &[self.set], &[]);
            host.device.cmd_dispatch(commands, 8, 1, 1);
        }
    }

    unsafe fn destroy(&self, host: &Host) {
        // SAFETY: the caller's.
        unsafe {
            host.device.destroy_descriptor_pool(self.pool, None);
            host.device.destroy_pipeline(self.pipeline, None);
            host.device.destroy_pipeline_layout(self.layout, None);
            host.device.destroy_descriptor_set_layout(self.set_layout, None);
            host.device.destroy_shader_module(self.module, None);
        }
    }
}

#[test]
fn validation_reports_a_missing_barrier_between_dispatches() {
    for with_barrier in [true, false] {
        let Some(mut device) = device() else { return };
        let buffers = buffers::<3>(&mut device);
        // SAFETY: valid handles, and each dispatch is waited for before anything is destroyed. Without the barrier the
        // contents are undefined; nobody looks at them.
        unsafe {
            let [first, second] = [0, 1].map(|i| CopyKernel::new(&device.host(), &buffers[i], &buffers[i + 1]));
            let recorded = device.one_time("dispatch twice", |host, commands| {
                first.dispatch(host, commands);
                if with_barrier {
                    let stage = vk::PipelineStageFlags2::COMPUTE_SHADER;
                    let written = (stage, vk::AccessFlags2::SHADER_STORAGE_WRITE);
                    host::barrier(host, commands, written, (stage, vk::AccessFlags2::SHADER_STORAGE_READ));
                }
                second.dispatch(host, commands);
                Ok(())
            });
            recorded.expect("it runs");
            first.destroy(&device.host());
            second.destroy(&device.host());
        }
        destroy(&mut device, buffers);
        let said = device.into_messages();
        match with_barrier {
            true => assert_eq!(said, Vec::<String>::new()),
            false => assert_said(&said, "SYNC-HAZARD-READ-AFTER-WRITE"),
        }
    }
}

#[test]
fn validation_reports_a_missing_barrier_between_submissions() {
    let Some(mut device) = device() else { return };
    let buffers = buffers::<2>(&mut device);
    let mut submissions = Vec::new();
    for second in [false, true] {
        let commands = device.begin().expect("commands");
        // SAFETY: valid handles; the missing barrier makes contents undefined that nobody looks at.
        unsafe {
            match second {
                false => fill(&device.host(), commands.raw(), &buffers[0], 1),
                true => copy(&device.host(), commands.raw(), &buffers[0], &buffers[1]),
            }
        }
        submissions.push(device.start(commands, "one of two").expect("submitted"));
    }
    for submission in submissions {
        device.wait(submission).expect("it runs");
    }
    destroy(&mut device, buffers);
    assert_said(&device.into_messages(), "SYNC-HAZARD-READ-AFTER-WRITE");
}

#[test]
fn validation_reports_wrong_use_and_leaks() {
    let Some(mut device) = device() else { return };
    let [buffer] = buffers::<1>(&mut device);
    let recorded = device.one_time("a fill that is not aligned", |host, commands| {
        // SAFETY: wrong on purpose (the offset is no multiple of 4), and within the buffer.
        unsafe { host.device.cmd_fill_buffer(commands, buffer.handle, 2, 4, 0) };
        Ok(())
    });
    recorded.expect("it runs");
    destroy(&mut device, [buffer]);
    // SAFETY: valid handles. The fence is leaked on purpose.
    unsafe { device.host().device.create_fence(&vk::FenceCreateInfo::default(), None) }.expect("a fence");
    let said = device.into_messages();
    assert_said(&said, "VUID-vkCmdFillBuffer-dstOffset-00025");
    assert_said(&said, "VUID-vkDestroyDevice-device");
}

#[test]
fn nothing_is_submitted_if_recording_fails() {
    let Some(mut device) = device() else { return };
    for _ in 0..2 {
        let failed: Result<()> =
            device.one_time("never", |_, _| Err(Error::HostResource { name: "test", why: "on purpose".into() }));
        assert!(failed.is_err());
        device.one_time("empty", |_, _| Ok(())).expect("the commands can be used again");
    }
}

/// Records `names` as steps of one fill each, and one that is skipped.
fn record(
    device: &mut TestDevice,
    buffer: &Buffer,
    names: &[&'static str],
    timing: &mut Timing,
    frame: Option<(usize, u32)>,
) {
    let recorded = device.one_time("steps", |host, commands| {
        // SAFETY: valid handles; nothing of the slot is in flight.
        unsafe {
            if let (Timing::Profiler(profiler), Some((slot, frame))) = (&mut *timing, frame) {
                profiler.begin_frame(host, commands, slot, frame)?;
            }
            for name in names {
                transfer_barrier(host, commands);
                timing.begin_scope(host, commands, name);
                fill(host, commands, buffer, 0);
                timing.end_scope(host, commands);
            }
            timing.skip("test.skipped", "nothing to do");
        }
        Ok(())
    });
    recorded.expect("it runs");
}

#[test]
fn profiled_steps_are_in_order_merged_and_cover_the_work() {
    let Some(mut device) = device() else { return };
    let [buffer] = buffers::<1>(&mut device);
    let family = device.queue_family();
    // SAFETY: the device's own handles.
    let mut profiler = unsafe { Profiler::new(&device.host(), family, 2, 4) }.expect("a profiler");
    assert!(profiler.is_supported(), "lavapipe, SwiftShader and all GPUs of note have timestamps");
    let mut last = 0;
    for frame in 0..4 {
        let slot = frame as usize % 2;
        // SAFETY: as above; nothing is in flight.
        assert_eq!(unsafe { profiler.collect(&device.host(), slot) }, None, "nothing is there yet");
        let names = ["test.fill", "test.fill", "test.other", "test.fill", "test.fifth"];
        record(&mut device, &buffer, &names, &mut Timing::Profiler(&mut profiler), Some((slot, frame)));
        // SAFETY: as above.
        let times = unsafe { profiler.collect(&device.host(), slot) }.expect("the frame is done");
        let rows: Vec<_> = times.passes.iter().map(|p| p.name).collect();
        assert_eq!((times.frame, rows), (frame, vec!["test.fill", "test.other", "test.fill"]));
        assert_eq!(times.skipped[0].0, "test.fifth", "it was made for four steps");
        assert_eq!(times.skipped[1], ("test.skipped", "nothing to do"));
        for pass in &times.passes {
            assert!(last <= pass.begin_ns && pass.begin_ns < pass.end_ns, "{times:?} after {last}");
            last = pass.end_ns;
        }
        assert_eq!(times.total_ns(), times.passes[2].end_ns - times.passes[0].begin_ns);
    }
    // SAFETY: as above.
    unsafe {
        record(&mut device, &buffer, &["test.fill"], &mut Timing::Profiler(&mut profiler), Some((0, 4)));
        record(&mut device, &buffer, &["test.fill"], &mut Timing::Profiler(&mut profiler), Some((0, 5)));
        assert_eq!(profiler.dropped(), 1);
        assert_eq!(profiler.collect(&device.host(), 0).map(|times| times.frame), Some(5));
        let commands = device.begin().expect("commands");
        assert!(profiler.begin_frame(&device.host(), commands.raw(), 2, 6).is_err(), "there are two slots");
        device.submit(commands, "empty").expect("it runs");
        profiler.destroy(&device.host());
    }
    destroy(&mut device, [buffer]);
}

/// The step that a device was lost in is the one that has begun and not ended.
#[test]
fn the_step_that_runs_is_known() {
    let Some(mut device) = device() else { return };
    let family = device.queue_family();
    // SAFETY: the device's own handles.
    let mut profiler = unsafe { Profiler::new(&device.host(), family, 1, 4) }.expect("a profiler");
    let recorded = device.one_time("steps", |host, commands| {
        // SAFETY: valid handles; nothing of the slot is in flight.
        unsafe {
            profiler.begin_frame(host, commands, 0, 1)?;
            let mut timing = Timing::Profiler(&mut profiler);
            timing.begin_scope(host, commands, "test.before");
            timing.end_scope(host, commands);
            timing.begin_scope(host, commands, "test.lost");
        }
        Ok(())
    });
    recorded.expect("it runs");
    // SAFETY: the queries have been reset on the device.
    unsafe {
        assert_eq!(profiler.running(&device.host(), 0), Some("test.lost"));
        assert_eq!(profiler.collect(&device.host(), 0), None, "it has not ended");
        profiler.destroy(&device.host());
    }
}

#[test]
fn the_hosts_own_queries_are_filled_two_a_step() {
    let Some(mut device) = device() else { return };
    let [buffer] = buffers::<1>(&mut device);
    const FIRST: u32 = 3;
    let info = vk::QueryPoolCreateInfo::default().query_type(vk::QueryType::TIMESTAMP).query_count(FIRST + queries(2));
    // SAFETY: the device's own handles; the pool is reset before it is written, and read when all is done.
    unsafe {
        let pool = device.host().device.create_query_pool(&info, None).expect("a query pool");
        let reset = device.one_time("reset", |host, commands| {
            host.device.cmd_reset_query_pool(commands, pool, 0, FIRST + queries(2));
            Ok(())
        });
        reset.expect("it runs");
        let mut timing = Timing::Queries { pool, first: FIRST, count: FIRST + queries(2) };
        record(&mut device, &buffer, &["test.a", "test.b"], &mut timing, None);
        assert!(matches!(timing, Timing::Queries { first, .. } if first == FIRST + queries(2)));
        let mut ticks = [[0_u64; 2]; 2];
        let flags = vk::QueryResultFlags::TYPE_64;
        let mut flat = [0_u64; 4];
        device.host().device.get_query_pool_results(pool, FIRST, &mut flat, flags).expect("all are written");
        ticks.iter_mut().zip(flat.chunks(2)).for_each(|(pair, two)| pair.copy_from_slice(two));
        let times = Clock::new(64, 1.0).expect("64 bits").frame(0, ["test.a", "test.b"], &ticks);
        assert_eq!(times.passes.len(), 2);
        assert!(times.passes.iter().all(|p| p.begin_ns < p.end_ns), "{times:?}");
        assert!(times.passes[0].end_ns <= times.passes[1].begin_ns, "{times:?}");
        device.host().device.destroy_query_pool(pool, None);
    }
    destroy(&mut device, [buffer]);
}

#[test]
fn a_hang_is_an_error_that_names_the_work_and_leaves_it_alone() {
    let Some(device) = device() else { return };
    let index = device.info().index.to_string();
    drop(device);
    // The work waits for an event that nobody sets in time, so it hangs however fast or busy the machine is.
    let timeout = Some(Duration::from_millis(20));
    let options = Options { validate: true, device: Some(index), timeout, ..Options::default() };
    let mut headless = Headless::new(&options).expect("the same device");
    let messages = headless.messages();
    let raw = headless.host().device.clone();
    // SAFETY: valid handles. The event is never destroyed: the device may still be using it.
    let event = unsafe { raw.create_event(&vk::EventCreateInfo::default(), None) }.expect("an event");
    let waited = headless.one_time("frame 12", |host, commands| {
        let (host_stage, all) = (vk::PipelineStageFlags::HOST, vk::PipelineStageFlags::ALL_COMMANDS);
        // SAFETY: valid handles.
        unsafe { host.device.cmd_wait_events(commands, &[event], host_stage, all, &[], &[], &[]) };
        Ok(())
    });
    let error = waited.expect_err("nobody set the event");
    let Error::Vulkan { call, object, result } = &error else { panic!("{error:?}") };
    assert_eq!((*call, object.as_deref(), *result), ("vkWaitForFences", Some("frame 12"), vk::Result::TIMEOUT));
    // Neither waits, which would never end, nor destroys what is in use, which validation would report.
    drop(headless);
    // SAFETY: the device was left alone, so it is still there; now the work can end.
    unsafe { raw.set_event(event) }.expect("set");
    assert_eq!(*messages.lock().expect("nobody panicked"), Vec::<String>::new());
}

/// Not a test of its own: what [`without_a_device_the_error_says_what_to_do`] runs in other environments.
#[test]
fn open_and_say() {
    if std::env::var_os("CELFX_OPEN_AND_SAY").is_some() {
        match Headless::new(&Options { validate: true, ..Options::default() }) {
            Ok(headless) => println!("opened {}", headless.info()),
            Err(error) => println!("{error}"),
        }
    }
}

/// What [`open_and_say`] says where these variables have this value.
fn said(variables: &[&str], value: &str) -> String {
    let mut command = std::process::Command::new(std::env::current_exe().expect("this test"));
    command.args(["--exact", "open_and_say", "--nocapture"]).env("CELFX_OPEN_AND_SAY", "1");
    variables.iter().for_each(|variable| _ = command.env(variable, value));
    let output = command.output().expect("this test runs");
    assert!(output.status.success(), "{output:?}");
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// Newer validation layers say that they have VK_EXT_layer_settings, which loaders up to 1.3.261 refuse to enable.
#[test]
fn a_layer_that_is_newer_than_the_loader_is_used() {
    let Some(device) = device() else { return };
    drop(device);
    let name = "vulkan/explicit_layer.d/VkLayer_khronos_validation.json";
    let manifest = ["/usr/share", "/usr/local/share", "/etc"].map(|folder| std::path::Path::new(folder).join(name));
    let Some(text) = manifest.iter().find_map(|path| std::fs::read_to_string(path).ok()) else {
        eprintln!("SKIPPED, the layer's description is in none of {manifest:?}");
        return;
    };
    let mut newer: serde_json::Value = serde_json::from_str(&text).expect("a description in JSON");
    let settings = serde_json::json!({"name": "VK_EXT_layer_settings", "spec_version": "2"});
    newer["layer"]["instance_extensions"].as_array_mut().expect("extensions").push(settings);
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("newer_layer");
    std::fs::create_dir_all(&folder).expect("the temporary folder can be written");
    std::fs::write(folder.join("layer.json"), newer.to_string()).expect("the temporary folder can be written");
    let text = said(&["VK_LAYER_PATH"], folder.to_str().expect("a path in UTF-8"));
    assert!(text.contains("opened"), "{text}");
}

#[test]
fn without_a_device_the_error_says_what_to_do() {
    let Some(device) = device() else { return };
    drop(device);
    let broken = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("broken_icd.json");
    std::fs::write(&broken, "no JSON").expect("the temporary folder can be written");
    let broken = broken.to_str().expect("a path in UTF-8");
    let drivers = ["VK_DRIVER_FILES", "VK_ICD_FILENAMES"];
    for (variables, value, expected) in [
        (&drivers[..], "/nonexistent", ["no Vulkan driver", "apt install libvulkan1 mesa-vulkan-drivers"]),
        // Older loaders call this OUT_OF_HOST_MEMORY, newer ones pass over the file.
        (&drivers[..], broken, ["Vulkan driver", "apt install libvulkan1 mesa-vulkan-drivers"]),
        (&["VK_LAYER_PATH"], "/nonexistent", ["VK_LAYER_KHRONOS_validation", "apt install vulkan-validationlayers"]),
        (&["CELFX_NOTHING"], "", ["opened", "Vulkan 1."]),
    ] {
        let text = said(variables, value);
        assert!(expected.iter().all(|part| text.contains(part)), "{value}: {text}");
    }
}

#[test]
fn the_report_lists_the_device_that_is_used() {
    let Some(device) = device() else { return };
    let wanted = std::env::var("CELFX_DEVICE").ok();
    let report = headless::report(wanted.as_deref()).expect("devices");
    let used: Vec<_> = report.devices.iter().filter(|d| d.used).collect();
    assert_eq!(used.len(), 1);
    assert_eq!((&used[0].name, used[0].index), (&device.info().name, device.info().index));
    assert!(used[0].lacks.is_empty() && report.to_string().contains(&used[0].name));
}

/// A picture of 16 x 8 pixels without symmetry.
fn picture() -> Picture {
    let value = |i: usize| (i * 37 % 101) as f32 / 101.0;
    Picture { size: [16, 8], channels: 4, values: (0..16 * 8 * 4).map(value).collect() }
}

#[test]
fn the_comparison_of_images_passes_what_is_equal_and_nothing_else() {
    let expected = picture();
    let exact = |actual: &Picture| compare(actual, &expected, Tolerance::EXACT);
    let close = |actual: &Picture| compare(actual, &expected, Tolerance { value: 1.0 / 255.0, pixels: 2 });
    let changed = |change: &dyn Fn(&mut Picture)| {
        let mut actual = picture();
        change(&mut actual);
        actual
    };
    assert_eq!(exact(&picture()), Ok(()));
    assert!(exact(&changed(&|p| p.values[77] = p.values[77].next_up())).is_err(), "one bit");
    assert_eq!(close(&changed(&|p| p.values.iter_mut().for_each(|v| *v += 0.003))), Ok(()));
    assert!(close(&changed(&|p| p.values.iter_mut().for_each(|v| *v += 0.005))).is_err(), "a little brighter");
    assert_eq!(close(&changed(&|p| p.values[..8].fill(9.0))), Ok(()), "two pixels may differ");
    assert!(close(&changed(&|p| p.values[..9].fill(9.0))).is_err(), "three may not");
    assert!(close(&changed(&|p| p.values.rotate_right(4))).is_err(), "moved by a pixel");
    assert!(close(&changed(&|p| p.values.chunks_mut(4).for_each(|c| c.swap(0, 2)))).is_err(), "channels swapped");
    assert!(close(&changed(&|p| p.values.fill(0.0))).is_err(), "black");
    assert!(close(&changed(&|p| p.size = [8, 16])).is_err(), "another shape");
    assert!(close(&changed(&|p| p.values.truncate(508))).is_err(), "a pixel is missing");
    for bad in [f32::NAN, f32::INFINITY] {
        let actual = changed(&|p| p.values[5] = bad);
        assert!(
            close(&actual).is_err() && compare(&actual, &actual, Tolerance::EXACT).is_err(),
            "{bad} equals nothing"
        );
    }
}
