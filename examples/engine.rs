//! A renderer that draws a sky and a wall, and has all three effects in its picture: a box of its own that is smeared where it moves,
//! smoke and fire. They hide each other, the wall hides them, and the picture changes its size on the way.
//!
//! `cargo run --example engine` writes engine.png, the last frame.

use ash::vk;
use celfx::blur::{self, Blur, FrameView, Interval, Mesh, MeshInput, Motion, Pose, Window};
use celfx::error::Result;
use celfx::flame::{self, Flame, ParticleInput, SceneDepth, SceneFormat};
use celfx::host::{Background, DepthFormat, Host, HostImage, ImageState};
use celfx::low_level::gpu::headless::{Headless, Options};
use celfx::low_level::gpu::image::{Image, ImageDesc};
use celfx::low_level::gpu::scratch::Lifetime;
use celfx::low_level::gpu::transfer::{Copy, Download, Upload, record_readback};
use celfx::profile::Timing;
use celfx::smoke::{self, Sequence, Smoke, VolumeInput};
use celfx::view::{Camera, Light, Projection};
use glam::{DVec3, Quat, Vec3};

pub const FRAMES: u32 = 20;
const COLOUR: vk::Format = vk::Format::R8G8B8A8_UNORM;
const DEPTH: DepthFormat = DepthFormat { format: vk::Format::D32_SFLOAT, reversed: true };

/// A layout between two users of an image: the second waits for all that came before.
const fn after_all(layout: vk::ImageLayout) -> ImageState {
    let (stage, access) = (vk::PipelineStageFlags2::ALL_COMMANDS, vk::AccessFlags2::MEMORY_WRITE);
    ImageState { stage, access, layout }
}
const DRAWN: ImageState = after_all(vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL);
const TESTED: ImageState = after_all(vk::ImageLayout::DEPTH_STENCIL_ATTACHMENT_OPTIMAL);

/// Sky, target and depth.
fn images(device: &mut Headless, extent: [u32; 2]) -> Result<[Image; 3]> {
    let (host, allocator) = device.parts();
    let mut make = |name, format, usage| {
        let usage = usage | vk::ImageUsageFlags::TRANSFER_SRC | vk::ImageUsageFlags::TRANSFER_DST;
        let desc = ImageDesc { name, extent, layers: 1, array_view: false, format, usage, lifetime: Lifetime::Kept };
        // SAFETY: the device's own handles.
        unsafe { Image::new(&host, allocator, &desc) }
    };
    let (colour, depth) = (vk::ImageUsageFlags::COLOR_ATTACHMENT, vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT);
    Ok([make("sky", COLOUR, colour)?, make("target", COLOUR, colour)?, make("depth", DEPTH.format, depth)?])
}

fn given(image: &Image, from: ImageState, to: ImageState) -> HostImage {
    HostImage::new(image.handle, image.view, image.desc.format, image.desc.extent, from, to)
}

/// The renderer's own drawing: a sky, and a wall three metres ahead, whose depth is this.
unsafe fn draw(host: &Host, commands: vk::CommandBuffer, [sky, _, depth]: &[Image; 3], wall: f32) {
    let barriers = [(sky, DRAWN), (depth, TESTED)].map(|(image, to)| {
        let range = vk::ImageSubresourceRange::default().aspect_mask(image.aspect).level_count(1).layer_count(1);
        let barrier = vk::ImageMemoryBarrier2::default().src_stage_mask(to.stage).src_access_mask(to.access);
        let barrier = barrier.dst_stage_mask(to.stage).dst_access_mask(vk::AccessFlags2::MEMORY_READ | to.access);
        barrier.new_layout(to.layout).image(image.handle).subresource_range(range)
    });
    let attached = |image: &Image, state: ImageState| {
        vk::RenderingAttachmentInfo::default().image_view(image.view).image_layout(state.layout)
    };
    let (colours, nearest, [width, height]) = ([attached(sky, DRAWN)], attached(depth, TESTED), depth.desc.extent);
    let columns = |x: u32, width: u32| vk::Rect2D {
        offset: vk::Offset2D { x: x as i32, y: 0 },
        extent: vk::Extent2D { width, height },
    };
    let clear = |area: vk::Rect2D, float32, depth| {
        let colour = vk::ClearValue { color: vk::ClearColorValue { float32 } };
        let depth = vk::ClearValue { depth_stencil: vk::ClearDepthStencilValue { depth, stencil: 0 } };
        let attached = |aspect, value| vk::ClearAttachment::default().aspect_mask(aspect).clear_value(value);
        let clears = [attached(vk::ImageAspectFlags::COLOR, colour), attached(vk::ImageAspectFlags::DEPTH, depth)];
        let rects = [vk::ClearRect::default().rect(area).layer_count(1)];
        // SAFETY: the caller's, while both are attached.
        unsafe { host.device.cmd_clear_attachments(commands, &clears, &rects) };
    };
    let info = vk::RenderingInfo::default().render_area(columns(0, width)).layer_count(1);
    // SAFETY: the caller's.
    unsafe {
        host.device.cmd_pipeline_barrier2(commands, &vk::DependencyInfo::default().image_memory_barriers(&barriers));
        host.device.cmd_begin_rendering(commands, &info.color_attachments(&colours).depth_attachment(&nearest));
        clear(columns(0, width), [0.55, 0.7, 0.9, 1.0], 0.0);
        clear(columns(width * 5 / 8, width / 8), [0.45, 0.35, 0.3, 1.0], wall);
        host.device.cmd_end_rendering(commands);
    }
}

/// The corners of a box that swings to and fro, in a frame.
fn box_at(frame: u32) -> Vec<[f32; 3]> {
    let t = frame as f32 * 0.35;
    let corner = |i: u32| 0.35 * (2.0 * Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32) - 1.0);
    (0..8).map(|i| (Quat::from_rotation_y(t) * corner(i) + Vec3::new(1.2 * t.sin(), 1.4, 0.3)).to_array()).collect()
}

/// All frames; the pixels of the last one, and their size.
pub fn render(device: &mut Headless) -> Result<(Vec<u8>, [u32; 2])> {
    let mut size = [320, 180];
    let mut drawn = images(device, size)?;
    let quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
    let triangles: Vec<[u32; 3]> = quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
    let input = MeshInput { vertices: 8, triangles: &triangles, objects: None, weld: None, normals: None, rest: None };
    let mesh = Mesh::new(&input)?.faceted(|_| true);
    let mut poses = vec![mesh.gather(&box_at(0)).unwrap_or_default()];
    let (plume, fire) = (celfx::simulate::smoke::Builtin::Plume, celfx::simulate::flame::Builtin::Random);
    // What comes is not known: trajectories go through past frames, which stay on the device.
    let settings = blur::Settings { trajectory: blur::settings::Trajectory::Past, ..blur::Settings::default() };
    let desc = blur::Desc::new(&mesh, size, settings);
    let desc = blur::Desc { target_format: COLOUR, toon: true, depth: Some(DEPTH), frames_resident: 16, ..desc };
    let of_smoke = smoke::Settings { particles: 600, ..smoke::Settings::default() };
    let of_smoke = smoke::Desc::new(size, plume.volume(0, 24.0).dimensions, of_smoke);
    let of_smoke = smoke::Desc { target_format: COLOUR, depth: Some(DEPTH), edges: true, ..of_smoke };
    let of_flame = flame::Settings { spread: Some(0.03), ..flame::Settings::default() };
    let of_flame = flame::Desc::new(size, fire.particles(0, 24.0).position.len() as u32, of_flame);
    let of_flame = flame::Desc { target_format: COLOUR, scene: Some(SceneFormat::Image(DEPTH)), ..of_flame };
    let (host, kernels, allocator) = device.making();
    // SAFETY, here and below: the device's own handles; frames go to one queue, and each is waited for.
    let mut blur = unsafe { Blur::new(&host, kernels, allocator, desc)? };
    let mut smoke = unsafe { Smoke::new(&host, kernels, allocator, of_smoke)? };
    let mut flame = unsafe { Flame::new(&host, kernels, allocator, of_flame)? };
    let (mut packed, mut uploads, mut shown) = (blur::Upload::default(), <[Upload; 3]>::default(), Download::default());
    let (mut motion, mut interval) = (Motion::new(&blur.desc().settings, size)?, Interval::default());
    for n in 1..FRAMES {
        if n == FRAMES / 2 {
            size = [400, 225];
            let new = images(device, size)?;
            let (host, kernels, allocator) = device.making();
            unsafe {
                std::mem::replace(&mut drawn, new).iter_mut().for_each(|image| image.destroy(&host, allocator));
                blur.resize(&host, kernels, allocator, size)?.destroy(&host, allocator);
                smoke.resize(&host, kernels, allocator, size)?.destroy(&host, allocator);
                flame.resize(&host, kernels, allocator, size)?.destroy(&host, allocator);
            }
            motion = Motion::new(&blur.desc().settings, size)?;
        }
        let view = Camera { eye: DVec3::new(0.0, 1.2, 4.5), target: 1.1 * DVec3::Y, ..Camera::default() }.view(size);
        let [offset, factor] = Projection::new(&view, size)?.depth_terms;
        // What moves from the frame before to this one.
        poses.push(mesh.gather(&box_at(n)).unwrap_or_default());
        let window: Vec<Pose> = poses.iter().map(|positions| Pose { positions, view: &view, cut: false }).collect();
        let window = Window { frame: n - 1, poses: &window, current: n as usize - 1, between: &[] };
        motion.renew(&mut interval, &mesh, &window, None, 1)?;
        let views = [n.saturating_sub(2), n - 1, n, n].map(|frame| FrameView { frame, view });
        packed.clear();
        if n == 1 {
            packed.mesh(&mesh, &[[0.9, 0.5, 0.2]; 8]);
        }
        let new = if n == 1 { 0 } else { n };
        packed.poses(new, &poses[new as usize..]);
        packed.interval(&interval, true);
        let (volume, fire) = (plume.volume(24 + n, 24.0), fire.particles(24 + n, 24.0));
        let rows = fire.position.iter().zip(&fire.temperature).map(|([x, y, z], t)| [x - 0.9, *y, *z, *t]);
        let rows: Vec<[f32; 4]> = rows.collect();
        let (host, allocator) = device.parts();
        let mut upload = |place: usize, bytes| unsafe { uploads[place].write(&host, allocator, "upload", bytes) };
        let density = upload(1, bytemuck::cast_slice(&volume.density))?;
        let (placed, rows_at) = (packed.placed(upload(0, packed.bytes())?), upload(2, bytemuck::cast_slice(&rows))?);
        unsafe { shown.fit(&host, allocator, "shown", 4 * u64::from(size[0]) * u64::from(size[1]))? };
        let [sky, target, tested] = &drawn;
        let tested = given(tested, TESTED, TESTED);
        device.one_time("frame", |host, commands| unsafe {
            draw(host, commands, &drawn, (offset + factor / 3.0) as f32);
            let frame = blur::Frame {
                mesh: placed.mesh,
                poses: placed.poses,
                interval: placed.interval(&interval, &mesh, views, None),
                toon: Some(blur::ToonInput { view: views[2], light: Light::default() }),
                depth: Some(blur::DepthInput { host: tested, view: views[2] }),
                background: Background::Copy(given(sky, DRAWN, DRAWN)),
                ..blur::Frame::new(given(target, after_all(vk::ImageLayout::UNDEFINED), DRAWN))
            };
            blur.record(host, commands, &frame, &mut Timing::None)?;
            let (dimensions, voxel_size, origin) = (volume.dimensions, volume.voxel_size, volume.origin);
            let volume = VolumeInput { dimensions, voxel_size, origin, density, velocity: None };
            let frame = smoke::Frame::new(view, volume, given(target, DRAWN, DRAWN));
            let sequence = if n == 1 { Sequence::Restart } else { Sequence::Advance };
            let frame = smoke::Frame { sequence, depth: Some(tested), edges: blur.edges(), ..frame };
            smoke.record(host, commands, &frame, &mut Timing::None)?;
            let particles = ParticleInput::new(rows.len() as u32, rows_at);
            let shown_next = given(target, DRAWN, after_all(vk::ImageLayout::TRANSFER_SRC_OPTIMAL));
            let frame = flame::Frame::new(view, particles, shown_next);
            let frame = flame::Frame { number: n, scene: Some(SceneDepth::Image(tested)), ..frame };
            flame.record(host, commands, &frame, &mut Timing::None)?;
            let copy = [Copy { from: (target.handle, size), to: 0 }];
            shown.buffer().into_iter().for_each(|to| record_readback(host, commands, &copy, &[], to));
            Ok(())
        })?;
    }
    let (pixels, (host, allocator)) = (shown.bytes().to_vec(), device.parts());
    unsafe {
        let _ = [blur.retire(), smoke.retire(), flame.retire()].map(|retired| retired.destroy(&host, allocator));
        uploads.iter_mut().for_each(|upload| upload.destroy(&host, allocator));
        drawn.iter_mut().for_each(|image| image.destroy(&host, allocator));
        shown.destroy(&host, allocator);
    }
    Ok((pixels, size))
}

fn main() -> std::result::Result<(), Box<dyn std::error::Error>> {
    let (pixels, [width, height]) = render(&mut Headless::new(&Options::default())?)?;
    image::save_buffer("engine.png", &pixels, width, height, image::ExtendedColorType::Rgba8)?;
    println!("frame {FRAMES} is in engine.png");
    Ok(())
}
