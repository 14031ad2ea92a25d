//! Cel-shaded smoke from a density volume (Hoshino, Dobashi, Yamamoto: Cartoon Rendering of Smoke).

#[doc(hidden)]
pub mod reference;
pub mod settings;
