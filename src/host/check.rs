//! What can be said of a host's images before anything is recorded.

use ash::vk;
use ash::vk::Handle as _;

use super::{Background, DepthFormat, FormatUse, Host, HostBuffer, HostImage};
use crate::error::{Error, Result};
use crate::shaders::common::constants::{FLOATS, UNORM_16, UNORM_24};
use crate::view::{BRIGHTEST, View};

/// What happens to what an image holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Content {
    /// It is read, or drawn over.
    Kept,
    /// All of it is replaced.
    Replaced,
}

pub(super) fn refuse<T>(name: &'static str, why: String) -> Result<T> {
    Err(Error::HostResource { name, why })
}

/// Why what is given on one side only is refused: by the frame, or by the field of a `Desc` that the effect was made with.
pub(crate) fn mismatch<T: std::fmt::Debug>(field: &str, is_given: bool, made: Option<T>) -> String {
    match made {
        Some(made) if !is_given => format!("missing; the effect was made with {field} = {made:?}"),
        _ => format!("given; the effect was made without {field}"),
    }
}

/// Refuses an image in which a picture of this size does not lie, or of another format, and states that no image can be in.
pub(crate) fn check_image(
    name: &'static str,
    image: &HostImage,
    size: [u32; 2],
    format: vk::Format,
    content: Content,
) -> Result<()> {
    let is_undefined = |layout| matches!(layout, vk::ImageLayout::UNDEFINED | vk::ImageLayout::PREINITIALIZED);
    match image {
        _ if (0..2)
            .any(|axis| image.offset[axis].checked_add(size[axis]).is_none_or(|end| end > image.extent[axis])) =>
        {
            let (extent, offset) = (image.extent, image.offset);
            refuse(name, format!("{extent:?} pixels, in which {size:?} from {offset:?} on do not lie"))
        }
        _ if image.format != format => refuse(name, format!("{:?}; expected {format:?}", image.format)),
        _ if image.samples != vk::SampleCountFlags::TYPE_1 => {
            refuse(name, format!("{:?} samples a pixel; resolve it into an image with one", image.samples))
        }
        _ if image.image.is_null() || image.view.is_null() => refuse(name, "a null handle".to_owned()),
        _ if content == Content::Kept && image.state_in.layout == vk::ImageLayout::UNDEFINED => {
            refuse(name, "state_in has layout UNDEFINED, in which it holds nothing, but its content is used".to_owned())
        }
        _ if is_undefined(image.state_out.layout) => {
            let layout = image.state_out.layout;
            refuse(name, format!("state_out has layout {layout:?}, into which no image can be brought"))
        }
        _ => Ok(()),
    }
}

/// Refuses a target and a background that do not fit a picture of this size and format.
pub(crate) fn check_target(
    target: &HostImage,
    background: &Background,
    size: [u32; 2],
    format: vk::Format,
) -> Result<()> {
    let content = match background {
        Background::Keep => Content::Kept,
        Background::Clear(_) | Background::Copy(_) => Content::Replaced,
    };
    check_image("target", target, size, format, content)?;
    check_background(background, size, format)?;
    check_distinct("background", background.image().as_ref(), target)
}

/// Refuses a background that does not fit a picture of this size and format, or that is too bright.
pub(crate) fn check_background(background: &Background, size: [u32; 2], format: vk::Format) -> Result<()> {
    match background {
        Background::Copy(image) => check_image("background", image, size, format, Content::Kept),
        Background::Clear(colour) if !colour.iter().all(|c| c.abs() <= BRIGHTEST) => {
            Err(Error::setting("frame.background", format!("{colour:?}"), "linear RGBA, none beyond 1e6"))
        }
        Background::Clear(_) | Background::Keep => Ok(()),
    }
}

/// Refuses depth that is attached beside the target and lies elsewhere: all of a render pass do in the same place.
pub(crate) fn check_beside(depth: Option<&HostImage>, target: &HostImage) -> Result<()> {
    match depth {
        Some(depth) if depth.offset != target.offset => {
            refuse("depth", format!("offset {:?}; expected {:?}, as the target's", depth.offset, target.offset))
        }
        _ => Ok(()),
    }
}

/// Refuses an image that is read and is the target at once.
pub(crate) fn check_distinct(name: &'static str, image: Option<&HostImage>, target: &HostImage) -> Result<()> {
    match image {
        Some(image) if is_same(image, target) => refuse(name, "it is the target's image".to_owned()),
        _ => Ok(()),
    }
}

/// Whether both are the same layer of the same level of an image.
pub(super) fn is_same(a: &HostImage, b: &HostImage) -> bool {
    (a.image, a.base_mip, a.base_layer) == (b.image, b.base_mip, b.base_layer)
}

/// Refuses depth that an effect was not made for, or that goes another way than the view projects it; none is expected exactly if
/// it was made for none.
pub(crate) fn check_depth(
    name: &'static str,
    depth: Option<(&HostImage, &View)>,
    size: [u32; 2],
    made: Option<DepthFormat>,
) -> Result<()> {
    let ((image, view), made) = match (depth, made) {
        (Some(depth), Some(made)) => (depth, made),
        (None, None) => return Ok(()),
        (depth, made) => return refuse(name, mismatch(name, depth.is_some(), made.map(|made| made.format))),
    };
    if view.reversed != made.reversed {
        let allowed = format!("{}, as the depth that the effect was made for", made.reversed);
        return Err(Error::setting("view.reversed", view.reversed, allowed));
    }
    check_image(name, image, size, made.format, Content::Kept)
}

/// Refuses a buffer that holds fewer bytes than are read from it.
pub(crate) fn check_buffer(name: &'static str, buffer: &HostBuffer, needed: u64) -> Result<()> {
    match buffer {
        _ if buffer.size < needed => refuse(name, format!("{} bytes; {needed} expected", buffer.size)),
        _ if buffer.buffer.is_null() && needed > 0 => refuse(name, "a null handle".to_owned()),
        _ => Ok(()),
    }
}

/// A format of the host's images, and what the device must be able to use it as.
pub(crate) type NamedFormat = (&'static str, FormatUse);

/// What a target's format must be good for: it is drawn over, copied to and from, and sampled.
pub(crate) fn target_format(format: vk::Format) -> NamedFormat {
    use vk::FormatFeatureFlags as Use;
    let drawn = Use::COLOR_ATTACHMENT | Use::COLOR_ATTACHMENT_BLEND;
    let features = drawn | Use::SAMPLED_IMAGE | Use::TRANSFER_SRC | Use::TRANSFER_DST;
    ("target_format", FormatUse { format, features })
}

/// What a depth image's format must be good for.
pub(crate) fn depth_format(format: DepthFormat, features: vk::FormatFeatureFlags) -> NamedFormat {
    ("depth.format", FormatUse { format: format.format, features })
}

/// What a depth image of this format is made of when it is copied to a buffer.
pub(crate) fn words_of(format: vk::Format) -> u32 {
    match format {
        vk::Format::D16_UNORM | vk::Format::D16_UNORM_S8_UINT => UNORM_16,
        vk::Format::X8_D24_UNORM_PACK32 | vk::Format::D24_UNORM_S8_UINT => UNORM_24,
        _ => FLOATS,
    }
}

/// The aspects of an image of this format.
pub(crate) fn aspect_of(format: vk::Format) -> vk::ImageAspectFlags {
    use vk::ImageAspectFlags as Aspect;
    match format {
        vk::Format::D16_UNORM | vk::Format::X8_D24_UNORM_PACK32 | vk::Format::D32_SFLOAT => Aspect::DEPTH,
        vk::Format::D16_UNORM_S8_UINT | vk::Format::D24_UNORM_S8_UINT | vk::Format::D32_SFLOAT_S8_UINT => {
            Aspect::DEPTH | Aspect::STENCIL
        }
        vk::Format::S8_UINT => Aspect::STENCIL,
        _ => Aspect::COLOR,
    }
}

/// Refuses formats that the device cannot use so.
///
/// # Safety
/// `host` holds valid handles.
pub(crate) unsafe fn check_formats(host: &Host, formats: &[NamedFormat]) -> Result<()> {
    for (name, FormatUse { format, features }) in formats {
        // SAFETY: the caller's.
        let has = unsafe { host.instance.get_physical_device_format_properties(host.physical_device, *format) };
        let lacks = *features & !has.optimal_tiling_features;
        if !lacks.is_empty() {
            return refuse(name, format!("{format:?}, which this device has not as {lacks:?}"));
        }
        let depth = name.starts_with("depth");
        if depth != aspect_of(*format).contains(vk::ImageAspectFlags::DEPTH) {
            return refuse(name, format!("{format:?}, {} depth", if depth { "which has no" } else { "which is" }));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::host::ImageState;
    use crate::view::Camera;

    const SIZE: [u32; 2] = [8, 4];
    const FORMAT: vk::Format = vk::Format::R8G8B8A8_UNORM;

    fn image(number: u64) -> HostImage {
        let state = ImageState { layout: vk::ImageLayout::GENERAL, ..ImageState::default() };
        let (image, view) = (vk::Image::from_raw(number), vk::ImageView::from_raw(number));
        HostImage::new(image, view, FORMAT, SIZE, state, state)
    }

    fn with_layouts(state_in: vk::ImageLayout, state_out: vk::ImageLayout) -> HostImage {
        let of = |layout| ImageState { layout, ..ImageState::default() };
        HostImage { state_in: of(state_in), state_out: of(state_out), ..image(1) }
    }

    fn said(result: Result<()>) -> String {
        result.err().map(|error| error.to_string()).unwrap_or_default()
    }

    #[test]
    fn a_target_whose_content_is_used_has_some() {
        let check = |image: &HostImage, background| said(check_target(image, &background, SIZE, FORMAT));
        let new = with_layouts(vk::ImageLayout::UNDEFINED, vk::ImageLayout::GENERAL);
        assert!(check(&new, Background::Keep).starts_with("target: state_in has layout UNDEFINED"));
        assert_eq!(check(&new, Background::Clear([0.0; 4])), "");
        assert_eq!(check(&new, Background::Copy(image(2))), "");
        assert_eq!(check(&image(1), Background::Keep), "");
    }

    #[test]
    fn samples_are_to_be_resolved() {
        let many = HostImage { samples: vk::SampleCountFlags::TYPE_4, ..image(1) };
        let said = said(check_target(&many, &Background::Keep, SIZE, FORMAT));
        assert_eq!(said, "target: TYPE_4 samples a pixel; resolve it into an image with one");
    }

    #[test]
    fn no_image_is_left_undefined() {
        for layout in [vk::ImageLayout::UNDEFINED, vk::ImageLayout::PREINITIALIZED] {
            let left = with_layouts(vk::ImageLayout::GENERAL, layout);
            let said = said(check_target(&left, &Background::Keep, SIZE, FORMAT));
            assert!(said.starts_with("target: state_out has layout"), "{said}");
        }
    }

    #[test]
    fn a_background_is_another_image_than_the_target() {
        let check = |background| said(check_target(&image(1), &Background::Copy(background), SIZE, FORMAT));
        assert_eq!(check(image(1)), "background: it is the target's image");
        assert_eq!(check(image(2)), "");
        assert_eq!(check(HostImage { base_layer: 1, ..image(1) }), "");
        let missing = HostImage { view: vk::ImageView::null(), ..image(2) };
        assert_eq!(check(missing), "background: a null handle");
    }

    #[test]
    fn depth_goes_the_way_of_the_format() {
        let mut view = Camera::default().view(SIZE);
        for (reversed, made) in [(false, false), (false, true), (true, false), (true, true)] {
            view.reversed = reversed;
            let made = DepthFormat { format: FORMAT, reversed: made };
            let said = said(check_depth("depth", Some((&image(3), &view)), SIZE, Some(made)));
            assert_eq!(said.is_empty(), reversed == made.reversed, "{said}");
            assert!(said.is_empty() || said.starts_with(&format!("view.reversed = {reversed}: {}", made.reversed)));
        }
    }
}
