use std::path::PathBuf;

use glam::DVec3;
use sphvar_grammar::{Choice, Declaration, Parametric, Range};

use super::{PictureLayout, Projection};

/// Parameters of an environment map in a file.
#[derive(Clone, Debug, PartialEq)]
pub struct EnvironmentParameters {
    /// The file.
    pub file: PathBuf,
    /// The data to read from it, and its mapping to the sphere.
    pub picture: PictureParameters,
}

/// The data to read from a picture, and its mapping to the sphere.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PictureParameters {
    /// The channel; default: luminance.
    pub channel: Option<String>,
    /// The layer or part; default: channels without one.
    pub layer: Option<String>,
    /// The projection of the picture.
    pub projection: Projection,
    /// The direction of the pole of the picture; default: +z.
    pub up: Option<UpAxis>,
    /// Whether the picture is mirrored.
    pub mirror: bool,
    /// Added to all longitudes, in degrees.
    pub rotate: f64,
}

/// A direction along an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UpAxis {
    /// +z.
    PlusZ,
    /// +y.
    PlusY,
    /// +x.
    PlusX,
    /// -z.
    MinusZ,
    /// -y.
    MinusY,
    /// -x.
    MinusX,
}

impl UpAxis {
    /// Returns the unit vector.
    #[must_use]
    pub const fn direction(self) -> DVec3 {
        match self {
            Self::PlusZ => DVec3::Z,
            Self::PlusY => DVec3::Y,
            Self::PlusX => DVec3::X,
            Self::MinusZ => DVec3::NEG_Z,
            Self::MinusY => DVec3::NEG_Y,
            Self::MinusX => DVec3::NEG_X,
        }
    }
}

impl Choice for UpAxis {
    const CHOICES: &'static [(&'static str, Self)] = &[
        ("z", Self::PlusZ),
        ("y", Self::PlusY),
        ("x", Self::PlusX),
        ("-z", Self::MinusZ),
        ("-y", Self::MinusY),
        ("-x", Self::MinusX),
    ];
}

impl Choice for Projection {
    const CHOICES: &'static [(&'static str, Self)] =
        &[("latlong", Self::LatLong), ("octahedral", Self::Octahedral)];
}

impl PictureParameters {
    /// Returns the mapping of the picture to the sphere, with its pole at +z.
    #[must_use]
    pub fn layout(&self) -> PictureLayout {
        let &Self { projection, mirror, rotate, .. } = self;
        PictureLayout { projection, mirror, rotation: rotate.to_radians() }
    }
}

/// An example.
impl Default for EnvironmentParameters {
    fn default() -> Self {
        Self { file: "FILE".into(), picture: PictureParameters::default() }
    }
}

impl PictureParameters {
    /// Declares the parameters; `channels` describes the valid channels.
    pub(crate) fn declare_with(&mut self, channels: &'static str, d: &mut Declaration<'_>) {
        d.word("channel", channels, "luminance", &mut self.channel);
        d.word("layer", "layer or part of the file", "none", &mut self.layer);
        d.choice("projection", "how the picture covers the sphere", &mut self.projection);
        d.optional_choice("up", "axis of the picture's pole", "z", &mut self.up);
        d.choice("mirror", "whether y becomes -y, before the rotation", &mut self.mirror);
        d.number("rotate", Range::FINITE, "added to all longitudes, in degrees", &mut self.rotate);
    }
}

impl Parametric for PictureParameters {
    fn declare(&mut self, d: &mut Declaration<'_>) {
        let channels = "luminance, r, g, b, a channel's name in the file, or rgb, all three and luminance in variance, compare, choose";
        self.declare_with(channels, d);
    }
}

impl Parametric for EnvironmentParameters {
    fn declare(&mut self, d: &mut Declaration<'_>) {
        d.required_file("file", "OpenEXR or Radiance HDR picture", &mut self.file);
        self.picture.declare(d);
    }
}
