//! Environment maps in files, with their orientation on the sphere.

use std::borrow::Cow;
use std::path::Path;
use std::rc::Rc;
use std::sync::Arc;

use glam::{DQuat, DVec3};
use sphvar_integrands::{EnvironmentMap, PictureParameters, UpAxis};

use crate::error::CliError;
use crate::files::{
    ChannelChoice, ChannelImage, FileError, PictureArray, decode_image, decode_picture, input_name,
    read_whole,
};
use crate::session::Session;

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
    /// Returns the map of a picture; `file` is its name in messages.
    pub(crate) fn decode(
        file: &Path,
        source: &PictureSource,
        picture: &PictureParameters,
    ) -> Result<Self, CliError> {
        let choice =
            ChannelChoice { channel: picture.channel.clone(), layer: picture.layer.clone() };
        let image = source.decode(file, &choice)?;
        let layout = picture.layout();
        let map = EnvironmentMap::from_picture(image.width, image.height, image.values, layout);
        let map = map.map_err(|e| CliError::File(format!("{}: {e}", file.display())))?;
        let pole = picture.up.map(UpAxis::direction);
        Ok(Self { map, words: format!("{choice:?} {layout:?} {pole:?}"), remarks: image.remarks })
    }
}

/// The content of a picture: a file, or an array that is given in its place. Clones share it.
#[derive(Clone)]
pub(crate) enum PictureSource {
    File(Rc<[u8]>),
    Array(Arc<PictureArray>),
}

impl PictureSource {
    /// Reads the picture of a name, and the built-in probe where its file does not exist.
    pub(crate) fn open(file: &Path, session: &Session) -> Result<Self, CliError> {
        if let Some(array) = session.given.picture(file) {
            return Ok(Self::Array(array));
        }
        if file == Path::new(CITY_FILE) && !file.exists() {
            return Ok(Self::File(CITY.into()));
        }
        Ok(Self::File(read_whole(file)?.into()))
    }

    /// Returns the bytes by which pictures differ.
    pub(crate) fn bytes(&self) -> Cow<'_, [u8]> {
        match self {
            Self::File(bytes) => Cow::Borrowed(bytes),
            Self::Array(array) => Cow::Owned(array.bytes()),
        }
    }

    /// Returns one channel of radiances.
    fn decode(&self, file: &Path, choice: &ChannelChoice) -> Result<ChannelImage, CliError> {
        self.channel(file, choice, decode_image)
    }

    /// Returns one channel of a picture for a function on the unit square, also of PNG.
    pub(super) fn decode_any(
        &self,
        file: &Path,
        choice: &ChannelChoice,
    ) -> Result<ChannelImage, CliError> {
        self.channel(file, choice, decode_picture)
    }

    fn channel(
        &self,
        file: &Path,
        choice: &ChannelChoice,
        decode: impl Fn(String, &[u8], &ChannelChoice) -> Result<ChannelImage, FileError>,
    ) -> Result<ChannelImage, CliError> {
        match self {
            Self::File(bytes) => Ok(decode(input_name(file), bytes, choice)?),
            Self::Array(array) => {
                let channel = array.channel(&file.display().to_string(), choice);
                channel.map_err(CliError::of_array)
            }
        }
    }
}

/// Returns the shortest rotation that carries a map's pole from a unit vector to +z.
pub(crate) fn to_map(pole: DVec3) -> DQuat {
    DQuat::from_rotation_arc(pole, DVec3::Z)
}
