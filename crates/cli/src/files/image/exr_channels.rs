//! Selects the channels of an `OpenEXR` file that form the requested channel.

use exr::meta::header::Header;

use super::{CHANNELS, ChannelChoice, LUMINANCE, unknown_channel};
use crate::files::file_error::{FileError, Place};

/// The maximum number of channels that a message lists.
const LISTED: usize = 12;

/// Channels of a part with their weights.
#[derive(Debug, PartialEq)]
pub(super) struct Chosen {
    /// The part of the file, from 0.
    pub(super) part: usize,
    /// Indices in the part's list of channels, with their factors.
    pub(super) terms: Vec<(usize, f64)>,
}

/// The channels of one layer of one part: those whose names agree up to the last dot.
struct Layer {
    part: usize,
    /// The name of the part.
    part_name: String,
    /// The name of the layer within the part; empty for channels such as `R`.
    name: String,
    /// Names without that of the layer, with their indices in the part's list.
    channels: Vec<(String, usize)>,
}

/// Returns the channels of a selection.
///
/// # Errors
///
/// If they do not exist; the message lists the channels of the file.
pub(super) fn choose(
    path: &str,
    parts: &[Header],
    choice: &ChannelChoice,
) -> Result<Chosen, FileError> {
    let layers = layers(parts);
    let (mut layer, mut channel) = (choice.layer.as_deref(), choice.channel());
    // The full name of a channel includes its layer.
    if layer.is_none()
        && let Some((prefix, base)) = channel.rsplit_once('.')
    {
        (layer, channel) = (Some(prefix), base);
    }
    let candidates = layers.iter().filter(|candidate| match layer {
        None => candidate.name.is_empty(),
        Some(layer) => candidate.is_named(layer),
    });
    for candidate in candidates.clone() {
        if let Some(terms) = candidate.terms(channel) {
            return Ok(Chosen { part: candidate.part, terms });
        }
    }
    let list = list(&layers);
    if let (Some(layer), None) = (layer, candidates.clone().next()) {
        return Err(layout(path, &format!("a layer \"{layer}\""), &list));
    }
    if channel == "luminance" {
        let hint = if layer.is_none() { " (choose others by layer= or channel=)" } else { "" };
        return Err(layout(path, &format!("the channels R, G and B, or Y{hint}"), &list));
    }
    Err(unknown_channel(
        path,
        choice.channel(),
        format!("{CHANNELS} of colours; the file has {list}"),
    ))
}

/// Returns the layers in the order of the file.
fn layers(parts: &[Header]) -> Vec<Layer> {
    let mut layers: Vec<Layer> = Vec::new();
    for (part, header) in parts.iter().enumerate().filter(|(_, header)| !header.deep) {
        let part_name =
            header.own_attributes.layer_name.as_ref().map_or(String::new(), ToString::to_string);
        for (at, channel) in header.channels.list.iter().enumerate() {
            let whole = channel.name.to_string();
            let (name, base) = whole.rsplit_once('.').unwrap_or(("", &whole));
            let entry = (base.to_owned(), at);
            match layers.iter_mut().find(|layer| layer.part == part && layer.name == name) {
                Some(layer) => layer.channels.push(entry),
                None => layers.push(Layer {
                    part,
                    part_name: part_name.clone(),
                    name: name.to_owned(),
                    channels: vec![entry],
                }),
            }
        }
    }
    layers
}

impl Layer {
    /// Returns whether a name denotes this layer: its own, that of its part, or both joined by a
    /// dot.
    fn is_named(&self, name: &str) -> bool {
        let both = name.strip_prefix(&self.part_name).and_then(|rest| rest.strip_prefix('.'));
        (self.name == name && !name.is_empty())
            || (self.part_name == name && (self.name.is_empty() || self.name == name))
            || both == Some(&self.name)
    }

    /// Returns the indices and weights of a channel.
    fn terms(&self, channel: &str) -> Option<Vec<(usize, f64)>> {
        let at = |name: &str| {
            let exact = self.channels.iter().find(|(base, _)| base == name);
            let alike = || self.channels.iter().find(|(base, _)| base.eq_ignore_ascii_case(name));
            exact.or_else(alike).map(|(_, at)| *at)
        };
        if channel != "luminance" {
            return Some(vec![(at(channel)?, 1.0)]);
        }
        let colours: Option<Vec<usize>> = ["R", "G", "B"].into_iter().map(at).collect();
        match colours {
            Some(colours) => Some(colours.into_iter().zip(LUMINANCE).collect()),
            // Grey, or the luminance of luminance-chroma pictures.
            None => Some(vec![(at("Y")?, 1.0)]),
        }
    }
}

/// Returns the names of all channels.
fn list(layers: &[Layer]) -> String {
    let several_parts = layers.iter().any(|layer| layer.part != layers[0].part);
    let names = layers.iter().flat_map(|layer| {
        let part = if several_parts { layer.part_name.as_str() } else { "" };
        layer.channels.iter().map(move |(base, _)| {
            let pieces = [part, &layer.name, base];
            let pieces: Vec<&str> = pieces.into_iter().filter(|piece| !piece.is_empty()).collect();
            pieces.join(".").escape_debug().to_string()
        })
    });
    let names: Vec<String> = names.collect();
    let more = names.len().saturating_sub(LISTED);
    match (names.is_empty(), more) {
        (true, _) => "no channels but deep ones".to_owned(),
        (_, 0) => names.join(", "),
        _ => format!("{} and {more} more", names[..LISTED].join(", ")),
    }
}

fn layout(path: &str, expected: &str, got: &str) -> FileError {
    FileError::Layout {
        path: path.to_owned(),
        place: Place::Whole,
        expected: expected.to_owned(),
        got: got.to_owned(),
    }
}
