//! A host's depth: it occludes the smoke, and the smoke writes its own.

use ash::vk;
use celfx::low_level::gpu::profiler::Timing;
use celfx::low_level::gpu::transfer::{CLEARED, COPIED_FROM, record_depth};
use celfx::low_level::smoke::layout;
use celfx::smoke::{DepthFormat, Desc, Frame, Sequence, Smoke};
use celfx::view::{Camera, Projection};

use crate::common::scenes::camera;
use crate::common::{device, host};
use crate::host::{SIZE, Slot, effect};

const FORMAT: vk::Format = vk::Format::D32_SFLOAT;
const PIXELS: usize = (SIZE[0] * SIZE[1]) as usize;

#[test]
fn a_hosts_depth_occludes_the_smoke_and_takes_its_depth() {
    for (reversed, far) in [(false, 50.0), (true, 50.0), (true, f32::INFINITY)] {
        let Some(mut device) = device() else { return };
        let mut image = host::image(&mut device, SIZE, FORMAT);
        let desc = Desc { depth: Some(DepthFormat { format: FORMAT, reversed }), ..effect() };
        let (host, kernels, allocator) = device.making();
        // SAFETY: the handles are the device's own.
        let mut smoke = unsafe { Smoke::new(&host, kernels, allocator, desc) }.expect("an effect");
        let mut slot = Slot::new(&mut device, SIZE);
        let good = slot.frame(0);
        let view = Camera { far: far.into(), ..camera(0.0) }.view(SIZE).with_reversed(reversed);
        let terms = Projection::of_valid(&view, SIZE).depth_terms.map(|term| term as f32);
        let stored = |z: f32| terms[0] + terms[1] / z;
        let mut behind = |wall: f32, sequence| {
            let target = host::host_image(&image, SIZE, FORMAT, CLEARED, COPIED_FROM);
            let frame = Frame { sequence, view, depth: Some(target), ..good };
            host::run(&mut device, |host, commands| {
                // SAFETY: everything is the test's own, and the frame is waited for.
                unsafe {
                    record_depth(host, commands, image.handle, stored(wall));
                    smoke.record(host, commands, &frame, &mut Timing::None).expect("a frame");
                    slot.show(host, commands);
                }
            });
            let alpha: Vec<f32> = slot.pixels().iter().map(|pixel| f32::from_bits(pixel[3])).collect();
            let own = host::read(&mut device, smoke.buffer(layout::DEPTH), PIXELS);
            (alpha, host::read_image::<f32>(&mut device, &image, SIZE), own)
        };
        let (alpha, _, own): (_, _, Vec<f32>) = behind(40.0, Sequence::Restart);
        let mut seen: Vec<f32> = own.iter().copied().filter(|z| z.is_finite()).collect();
        assert!(seen.len() > 300, "{} pixels of smoke", seen.len());
        assert!((0..PIXELS).all(|i| (alpha[i] == 1.0) == own[i].is_finite()), "nothing is in front");
        seen.sort_by(f32::total_cmp);
        let wall = seen[seen.len() / 2];
        let (alpha, drawn, own) = behind(wall, Sequence::Hold);
        let mut counts = [0; 2];
        for i in 0..PIXELS {
            // Two roundings of numbers below 1 decide: depths that differ by less may go either way.
            let (smoke, wall) = (stored(own[i].min(1e30)), stored(wall));
            if (smoke - wall).abs() < 4.0 * f32::EPSILON {
                continue;
            }
            let in_front = own[i].is_finite() && (smoke > wall) == reversed;
            counts[usize::from(in_front)] += 1;
            assert_eq!(alpha[i], if in_front { 1.0 } else { 0.0 }, "pixel {i}");
            let expected = if in_front { smoke } else { wall };
            assert!((drawn[i] - expected).abs() <= 2.0 * f32::EPSILON, "pixel {i}: {} for {expected}", drawn[i]);
        }
        assert!(counts.iter().all(|n| *n > 100), "{counts:?}");
        slot.destroy(&mut device);
        host::destroy(&mut device, [], [&mut image]);
        let (host, allocator) = device.parts();
        // SAFETY: every frame has been waited for.
        unsafe { smoke.destroy(&host, allocator) };
    }
}
