//! Cel-shaded smoke from a density volume (Hoshino, Dobashi, Yamamoto: Cartoon Rendering of Smoke).

pub mod settings;
