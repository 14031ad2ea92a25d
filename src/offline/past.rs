//! What frames go on from, in memory of the host: so that a sequence goes on elsewhere, or later.

use ash::vk;

use super::{EffectBuffer, Offline};
use crate::error::Result;
use crate::gpu::transfer::record_upload;
use crate::plan::BufferId;

impl Offline {
    /// What the next frame goes on from, besides what it brings itself ([`Self::go_on_from`]); empty if no effect has a past.
    ///
    /// # Errors
    /// As [`Offline::read`].
    pub fn past(&mut self) -> Result<Vec<u8>> {
        let mut all = Vec::new();
        for (effect, (words, buffers)) in self.pasts() {
            all.extend((words.len() as u64).to_le_bytes());
            all.extend(words.iter().flat_map(|word| word.to_le_bytes()));
            for id in buffers {
                let bytes = self.read(EffectBuffer { effect, id: *id }, u64::MAX)?;
                all.extend((bytes.len() as u64).to_le_bytes());
                all.extend(bytes);
            }
        }
        Ok(all)
    }

    /// Makes the next frame the one after that of [`Self::past`]: it brings all that a first one does, but does not restart. False,
    /// and nothing has changed, if that is of other effects.
    ///
    /// # Errors
    /// No memory; a failed Vulkan call; a device that does not answer.
    pub fn go_on_from(&mut self, past: &[u8]) -> Result<bool> {
        self.check_free()?;
        let Some(parts) = self.taken_apart(past) else { return Ok(false) };
        let bytes: Vec<u8> =
            parts.iter().flat_map(|part| part.buffers.iter().flat_map(|(_, bytes)| *bytes)).copied().collect();
        let (host, allocator) = self.device.parts();
        // SAFETY: the device is this host's own, and every submission has been waited for.
        let from = unsafe { self.parts.upload.write(&host, allocator, "past upload", &bytes)? };
        let mut at = 0;
        let mut copies = Vec::new();
        for (to, bytes) in parts.iter().flat_map(|part| &part.buffers) {
            copies.push((at, *to));
            at += bytes.len() as u64;
        }
        self.device.one_time("what went before", |host, commands| {
            // SAFETY: all buffers are alive, large enough, and in no other use.
            unsafe { record_upload(host, commands, from.buffer, &copies) };
            Ok(())
        })?;
        let words: Vec<(&str, Vec<u32>)> = parts.into_iter().map(|part| (part.effect, part.words)).collect();
        for (name, player) in &mut self.parts.players {
            if let Some((_, words)) = words.iter().find(|(effect, _)| effect == name) {
                player.go_on_from(words);
            }
        }
        Ok(true)
    }

    /// What effects that have a past go on from: words, and buffers.
    fn pasts(&self) -> Vec<(&'static str, Past)> {
        let players = self.parts.players.iter();
        players.filter_map(|(name, player)| Some((*name, player.past()?))).collect()
    }

    /// The parts of what [`Self::past`] made of these effects.
    fn taken_apart<'a>(&self, mut past: &'a [u8]) -> Option<Vec<Part<'a>>> {
        let mut parts = Vec::new();
        for (effect, (words, buffers)) in self.pasts() {
            let bytes = take(&mut past, 4)?;
            let of_words = bytes.chunks_exact(4).map(bytemuck::pod_read_unaligned).collect::<Vec<u32>>();
            let mut places = Vec::new();
            for id in buffers {
                let place = self.parts.buffer(EffectBuffer { effect, id: *id });
                let bytes = take(&mut past, 1)?;
                (bytes.len() as u64 == place.2).then_some(())?;
                places.push((place, bytes));
            }
            (of_words.len() == words.len()).then_some(())?;
            parts.push(Part { effect, words: of_words, buffers: places });
        }
        past.is_empty().then_some(parts)
    }
}

/// What an effect goes on from: words, and buffers.
pub(crate) type Past = (Vec<u32>, &'static [BufferId]);

/// A buffer's handle, offset and size.
type Range = (vk::Buffer, u64, u64);

/// What one effect goes on from.
struct Part<'a> {
    effect: &'static str,
    words: Vec<u32>,
    /// Each, and what belongs there.
    buffers: Vec<(Range, &'a [u8])>,
}

/// As many elements of `size` bytes as the number before them says.
fn take<'a>(from: &mut &'a [u8], size: usize) -> Option<&'a [u8]> {
    let (count, rest) = from.split_first_chunk::<8>()?;
    let bytes = usize::try_from(u64::from_le_bytes(*count)).ok()?.checked_mul(size)?;
    let (taken, rest) = rest.split_at_checked(bytes)?;
    *from = rest;
    Some(taken)
}
