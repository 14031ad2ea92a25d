//! Descriptions of a picture's effects.

use std::any::Any;
use std::fmt;

use super::depth::FORMAT;
use super::player::{self, Depth, Describe, Feed, Player, Sharing};
use super::vectors;
use crate::effect::{Effort, Kind};
use crate::error::{Error, Result};
use crate::gpu::headless::Headless;

/// Descriptions of effects, in the order in which they are drawn: at least one, all of one picture size.
#[derive(Debug, Default)]
pub struct Effects {
    all: Vec<Box<dyn Described>>,
    /// Whether they write motion vectors.
    vectors: bool,
}

impl Clone for Effects {
    fn clone(&self) -> Effects {
        Effects { all: self.all.iter().map(|effect| effect.boxed()).collect(), vectors: self.vectors }
    }
}

impl<D: Describe> From<D> for Effects {
    fn from(desc: D) -> Effects {
        Effects::default().with(desc)
    }
}

impl Effects {
    /// One more, which is drawn last.
    #[must_use]
    pub fn with(mut self, desc: impl Describe) -> Effects {
        self.all.push(Box::new(desc));
        self
    }

    /// The same, with motion vectors of each frame's picture ([`crate::offline::Offline::vectors`]).
    #[must_use]
    pub fn with_vectors(self) -> Effects {
        Effects { vectors: true, ..self }
    }

    /// Whether they write motion vectors.
    pub(super) fn has_vectors(&self) -> bool {
        self.vectors
    }

    /// The description of an effect, if it is one of them.
    pub fn get<D: Describe>(&self) -> Option<&D> {
        self.all.iter().find_map(|effect| effect.as_any().downcast_ref())
    }

    /// The same, by the effect's name.
    pub(crate) fn named(&self, name: &str) -> Option<&dyn Any> {
        self.all.iter().find(|effect| effect.name() == name).map(|effect| effect.as_any())
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.all.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.all.is_empty()
    }

    /// The size of the picture that all of them make.
    pub(super) fn size(&self) -> Result<[u32; 2]> {
        let mut sizes = self.all.iter().map(|effect| (effect.name(), effect.size()));
        let refuse = |why: String| Err(Error::HostResource { name: "effects", why });
        let Some((first, size)) = sizes.next() else { return refuse("none; expected at least one".to_owned()) };
        match sizes.find(|(_, other)| *other != size) {
            Some((name, other)) => {
                refuse(format!("{first} of {size:?} pixels, {name} of {other:?}; expected one size"))
            }
            None => Ok(size),
        }
    }

    /// Makes effects hide each other: what is solid and what it hides by a depth image, others by the depth that one of
    /// them leaves, which costs less. Whether there is to be an image.
    pub(super) fn share_depth(&mut self) -> bool {
        let has = |depth: Depth| self.all.iter().any(|effect| effect.depth() == depth);
        let is_wanted = self.all.iter().any(|effect| effect.wants_depth());
        let is_shared = is_wanted || has(Depth::Solid) && (has(Depth::Hidden) || has(Depth::Leaves));
        let mut is_left = false;
        for effect in &mut self.all {
            let vectors = self.vectors.then_some(vectors::FORMAT);
            effect.share(Sharing { image: is_shared.then_some(FORMAT), buffer: is_left && !is_shared, vectors });
            is_left |= effect.depth() == Depth::Leaves;
        }
        is_shared
    }

    /// Makes them, one after the other, and hands each to `take`.
    pub(super) fn make(
        self,
        device: &mut Headless,
        effort: Effort,
        mut take: impl FnMut(&'static str, Box<dyn Player>),
    ) -> Result<()> {
        for effect in self.all {
            let name = effect.name();
            take(name, effect.make(device, effort)?);
        }
        Ok(())
    }
}

/// [`Describe`], whatever is described.
trait Described: fmt::Debug {
    fn name(&self) -> &'static str;
    fn size(&self) -> [u32; 2];
    fn depth(&self) -> Depth;
    fn wants_depth(&self) -> bool;
    fn share(&mut self, sharing: Sharing);
    fn boxed(&self) -> Box<dyn Described>;
    fn as_any(&self) -> &dyn Any;
    fn make(self: Box<Self>, device: &mut Headless, effort: Effort) -> Result<Box<dyn Player>>;
}

impl<D: Describe> Described for D {
    fn name(&self) -> &'static str {
        <D::Feed as Feed>::Kind::NAME
    }

    fn size(&self) -> [u32; 2] {
        Describe::size(self)
    }

    fn depth(&self) -> Depth {
        D::DEPTH
    }

    fn wants_depth(&self) -> bool {
        Describe::wants_depth(self)
    }

    fn share(&mut self, sharing: Sharing) {
        Describe::share(self, sharing);
    }

    fn boxed(&self) -> Box<dyn Described> {
        Box::new(self.clone())
    }

    fn as_any(&self) -> &dyn Any {
        self
    }

    fn make(self: Box<Self>, device: &mut Headless, effort: Effort) -> Result<Box<dyn Player>> {
        player::make(device, *self, effort)
    }
}
