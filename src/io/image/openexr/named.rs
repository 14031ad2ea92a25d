//! Channels that are found by what renderers call them: those of a layer of some name, in whichever part of the file.

use std::path::Path;

use exr::meta::header::Header;

use super::{Fault, Fit, Pick, read};
use crate::io::ReadError;

/// What channels are called. Names are lower case, and those of a file are compared without regard to case.
#[derive(Clone, Copy, Debug)]
pub struct Wanted {
    /// What it is, for messages.
    pub what: &'static str,
    /// Names of layers, the best first; a layer of a file has one if that is the last part of its own name
    /// (`ViewLayer.Vector`, `FinalImageMovieRenderQueue_MotionVectors`). Channels of no layer come after.
    pub layers: &'static [&'static str],
    /// Channels of such a layer, the best first: the first of these lists is taken that is there as a whole.
    pub channels: &'static [&'static [&'static str]],
    /// The same of channels of no layer.
    pub plain: &'static [&'static [&'static str]],
}

impl Wanted {
    /// All that would be taken, in words.
    fn expected(&self) -> String {
        let list = |channels: &[&str]| channels.join(" ").to_uppercase();
        let of_layers: Vec<String> = self.channels.iter().map(|channels| list(channels)).collect();
        let plain: Vec<String> = self.plain.iter().map(|channels| list(channels)).collect();
        format!(
            "{}: channels {} of a layer called {}, or {} of none",
            self.what,
            of_layers.join(" or "),
            self.layers.join(" or "),
            plain.join(" or ")
        )
    }

    fn pick(&self, headers: &[Header]) -> Result<Pick, Fault> {
        let of_layers =
            self.layers.iter().flat_map(|layer| self.channels.iter().map(move |channels| (*layer, channels)));
        let mut names = of_layers.chain(self.plain.iter().map(|channels| ("", channels)));
        let found = names.find_map(|(layer, channels)| {
            headers.iter().enumerate().find_map(|(part, header)| {
                let numbers = channels.iter().map(|channel| number(header, layer, channel)).collect::<Option<Vec<_>>>();
                Some(Pick { part, channels: numbers? })
            })
        });
        found.ok_or_else(|| {
            const SHOWN: usize = 32;
            let names = headers.iter().flat_map(|header| {
                header.channels.list.iter().map(|channel| full_name(header, &channel.name.to_string()))
            });
            let names: Vec<String> = names.take(SHOWN).collect();
            (format!("has channels {}", names.join(", ")), self.expected())
        })
    }
}

/// A channel's name with that of its layer, which may be its part's.
fn full_name(header: &Header, name: &str) -> String {
    match &header.own_attributes.layer_name {
        Some(layer) if !name.contains('.') => format!("{layer}.{name}"),
        _ => name.to_owned(),
    }
}

/// The number of a layer's channel; of no layer, if that has no name.
fn number(header: &Header, layer: &str, channel: &str) -> Option<usize> {
    header.channels.list.iter().position(|own| {
        let name = own.name.to_string().to_ascii_lowercase();
        if layer.is_empty() {
            return name == channel;
        }
        let name = full_name(header, &name).to_ascii_lowercase();
        let Some((of, last)) = name.rsplit_once('.') else { return false };
        let own_layer = of.rsplit('.').next().unwrap_or(of);
        let is_layer = own_layer.strip_suffix(layer).is_some_and(|before| before.is_empty() || before.ends_with('_'));
        last == channel && is_layer
    })
}

/// Reads such channels of a file of that size, in the order of their list; 0 where the file has no data.
///
/// # Errors
/// A file that cannot be read, of another size, or without such channels: it says which it has.
pub fn read_named(path: &Path, size: [u32; 2], wanted: &Wanted) -> Result<Vec<Vec<f32>>, ReadError> {
    let found = read(path, Fit::Exactly(size), |headers| wanted.pick(headers))?;
    Ok(found.channels.into_iter().map(|(_, values)| values).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::image::write_exr_channels;
    use crate::io::tests::Folder;

    const MOTION: Wanted = Wanted {
        what: "motion",
        layers: &["vector", "motionvectors"],
        channels: &[&["x", "y", "z", "w"], &["r", "g"]],
        plain: &[&["x", "y"]],
    };

    #[test]
    fn channels_are_found_by_layer_and_name() {
        let folder = Folder::new();
        let path = folder.0.join("all.exr");
        let file = |names: &[&str]| {
            let channels: Vec<(String, Vec<f32>)> =
                names.iter().zip(1..).map(|(name, value)| ((*name).to_owned(), vec![value as f32; 2])).collect();
            write_exr_channels(&path, [2, 1], &channels).expect("written");
            read_named(&path, [2, 1], &MOTION).map(|found| found.iter().map(|values| values[0]).collect::<Vec<_>>())
        };
        let layers = ["L.Combined.R", "L.Depth.Z", "L.Vector.W", "L.Vector.X", "L.Vector.Y", "L.Vector.Z"];
        assert_eq!(file(&layers).expect("a layer"), [4.0, 5.0, 6.0, 3.0]);
        let unreal = ["B", "Final_MotionVectors.B", "Final_MotionVectors.G", "Final_MotionVectors.R", "G", "R"];
        assert_eq!(file(&unreal).expect("a layer"), [4.0, 3.0]);
        assert_eq!(file(&["X", "Y"]).expect("no layer"), [1.0, 2.0]);
        let none = file(&["L.Depth.X", "Vector.X", "Y"]).expect_err("no such").to_string();
        assert!(none.contains("Vector.X") && none.contains("X Y Z W or R G of a layer called vector"), "{none}");
        file(&["X", "Y"]).expect("no layer");
        assert!(read_named(&path, [3, 1], &MOTION).expect_err("size").to_string().contains("3 x 1"));
    }
}
