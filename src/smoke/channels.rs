//! What is smoothed beside luminance.

use crate::shaders::smoke::constants::NO_CHANNEL;
use crate::smoke::desc::Desc;

/// The number of the channel of each, if it is smoothed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Channels {
    /// Share of the light that arrives: where tones have a colour of their own in shadow, and for the layer of shadows.
    pub shade: Option<u32>,
    /// The fire's light.
    pub fire: Option<u32>,
    /// The rim, which has its shape once it is smoothed.
    pub rim: Option<u32>,
}

impl Channels {
    /// Those of an effect.
    pub fn new(desc: &Desc) -> Channels {
        let settings = &desc.settings;
        let mut count = 0;
        let mut next = |is_there: bool| {
            count += u32::from(is_there);
            is_there.then(|| count - 1)
        };
        Channels {
            shade: next(settings.casts_shadows() && (settings.has_shaded_tones() || desc.layers)),
            fire: next(desc.fire_light),
            rim: next(desc.rim),
        }
    }

    /// How many there are.
    pub fn count(&self) -> u32 {
        self.all().flatten().count() as u32
    }

    /// As kernels are specialised.
    pub fn words(&self) -> [u32; 3] {
        [self.shade, self.fire, self.rim].map(|channel| channel.unwrap_or(NO_CHANNEL))
    }

    fn all(&self) -> impl Iterator<Item = Option<u32>> {
        [self.shade, self.fire, self.rim].into_iter()
    }
}
