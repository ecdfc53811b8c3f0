//! Environment maps in files, with how they are laid on the sphere.

use std::path::Path;

use glam::{DQuat, DVec3};
use sphvar_integrands::{EnvironmentMap, Integrand, PictureLayout, Projection, Rotated};

use crate::error::CliError;
use crate::files::{ChannelChoice, decode_image, read_image};
use crate::spec::{Spec, unknown_name};

/// The parameters of an environment map besides its file.
pub(crate) const KEYS: [&str; 6] = ["channel", "layer", "projection", "up", "mirror", "turn"];

/// The light probe of the examples, for users without a clone of the repository.
const CITY: &[u8] = include_bytes!("../../../../data/city.exr");
/// Where it lies in a clone.
const CITY_FILE: &str = "data/city.exr";

/// An environment map as a specification names it.
pub(crate) struct Environment {
    /// With its pole at +z.
    pub(crate) map: EnvironmentMap,
    /// Where the pole is to be, if that is said.
    pub(crate) pole: Option<DVec3>,
    /// All that the map depends on but the file.
    pub(crate) words: String,
    /// What a user should know of the file.
    pub(crate) remarks: Vec<String>,
}

impl Environment {
    /// Reads the map of a file with the parameters [`KEYS`] of a specification.
    pub(crate) fn take(spec: &mut Spec, file: &Path) -> Result<Self, CliError> {
        let choice = ChannelChoice { channel: spec.take("channel"), layer: spec.take("layer") };
        let mut layout = PictureLayout::default();
        let projections =
            [("latlong", Projection::LatLong), ("octahedral", Projection::Octahedral)];
        spec.replace_choice("projection", &projections, &mut layout.projection)?;
        spec.replace_choice("mirror", &[("no", false), ("yes", true)], &mut layout.mirror)?;
        let mut turn = 0.0;
        spec.replace_number("turn", &mut turn)?;
        if !f64::is_finite(turn) {
            let message =
                format!("{}: turn must be a finite number of degrees, got {turn}", spec.text);
            return Err(CliError::Usage(message));
        }
        layout.turn = turn.to_radians();
        let pole = spec.take("up").map(|name| axis(&name)).transpose()?;
        let image = if file == Path::new(CITY_FILE) && !file.exists() {
            decode_image(CITY_FILE.to_owned(), CITY, &choice)?
        } else {
            read_image(file, &choice)?
        };
        let map = EnvironmentMap::from_picture(image.width, image.height, image.values, layout);
        let map = map.map_err(|e| CliError::Failed(format!("{}: {e}", file.display())))?;
        Ok(Self {
            map,
            pole,
            words: format!("{choice:?} {layout:?} {pole:?}"),
            remarks: image.remarks,
        })
    }

    /// Returns the map as an integrand, with its pole at +z unless another place was given.
    pub(super) fn integrand(self) -> Result<Box<dyn Integrand>, CliError> {
        match self.pole {
            Some(pole) if pole != DVec3::Z => {
                let rotated = Rotated::new(self.map, to_map(pole).inverse());
                Ok(Box::new(rotated.map_err(CliError::usage)?))
            }
            _ => Ok(Box::new(self.map)),
        }
    }
}

/// Returns the rotation that carries a map's pole from a unit vector to +z, the shortest one.
pub(crate) fn to_map(pole: DVec3) -> DQuat {
    DQuat::from_rotation_arc(pole, DVec3::Z)
}

/// Returns the unit vector of an axis's name.
fn axis(name: &str) -> Result<DVec3, CliError> {
    const AXES: [(&str, DVec3); 6] = [
        ("z", DVec3::Z),
        ("y", DVec3::Y),
        ("x", DVec3::X),
        ("-z", DVec3::NEG_Z),
        ("-y", DVec3::NEG_Y),
        ("-x", DVec3::NEG_X),
    ];
    let found = AXES.iter().find(|(axis, _)| *axis == name);
    found.map(|(_, axis)| *axis).ok_or_else(|| unknown_name("up axis", name, &AXES.map(|a| a.0)))
}
