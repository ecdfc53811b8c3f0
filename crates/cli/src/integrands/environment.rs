//! Environment maps in files, with their orientation on the sphere.

use std::path::Path;

use glam::{DQuat, DVec3};
use sphvar_integrands::{EnvironmentMap, PictureParameters, UpAxis};

use crate::error::CliError;
use crate::files::{ChannelChoice, decode_image, input_name, read_whole};

/// The light probe of the examples, for users without a clone of the repository.
const CITY: &[u8] = include_bytes!("../../data/city.exr");
/// Its path in a clone.
const CITY_FILE: &str = "data/city.exr";

/// An environment map of a file.
pub(crate) struct Environment {
    /// The map with its pole at +z.
    pub(crate) map: EnvironmentMap,
    /// A description of everything that the map depends on except the file.
    pub(crate) words: String,
    /// Remarks on the file for the user.
    pub(crate) remarks: Vec<String>,
}

impl Environment {
    /// Reads the map of a file.
    pub(crate) fn read(file: &Path, picture: &PictureParameters) -> Result<Self, CliError> {
        Self::decode(file, &bytes_of(file)?, picture)
    }

    /// Returns the map of a file with the given content.
    pub(crate) fn decode(
        file: &Path,
        bytes: &[u8],
        picture: &PictureParameters,
    ) -> Result<Self, CliError> {
        let choice =
            ChannelChoice { channel: picture.channel.clone(), layer: picture.layer.clone() };
        let image = decode_image(input_name(file), bytes, &choice)?;
        let layout = picture.layout();
        let map = EnvironmentMap::from_picture(image.width, image.height, image.values, layout);
        let map = map.map_err(|e| CliError::Failed(format!("{}: {e}", file.display())))?;
        let pole = picture.up.map(UpAxis::direction);
        Ok(Self { map, words: format!("{choice:?} {layout:?} {pole:?}"), remarks: image.remarks })
    }
}

/// Returns the content of a file, that of the built-in probe where its file does not exist.
pub(crate) fn bytes_of(file: &Path) -> Result<Vec<u8>, CliError> {
    if file == Path::new(CITY_FILE) && !file.exists() {
        return Ok(CITY.to_vec());
    }
    Ok(read_whole(file)?)
}

/// Returns the shortest rotation that carries a map's pole from a unit vector to +z.
pub(crate) fn to_map(pole: DVec3) -> DQuat {
    DQuat::from_rotation_arc(pole, DVec3::Z)
}
