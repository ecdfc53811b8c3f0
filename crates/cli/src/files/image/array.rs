//! Pictures that an embedding program gives as arrays.

use super::{CHANNELS, ChannelChoice, ChannelImage, LUMINANCE, negative_texels, unknown_channel};
use crate::files::file_error::FileError;

/// The texels of a picture, row by row from the top: one number each, or red, green and blue. Grey
/// texels have equal red, green and blue.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PictureArray {
    width: usize,
    height: usize,
    /// The numbers of a texel, 1 or 3.
    channels: usize,
    texels: Vec<f64>,
}

impl PictureArray {
    /// Returns the picture, or the reason why the number of texels does not fit the size.
    pub(crate) fn new(width: usize, height: usize, texels: Vec<f64>) -> Result<Self, String> {
        let count = width.saturating_mul(height);
        let channels = [1, 3].into_iter().find(|n| count.saturating_mul(*n) == texels.len());
        match channels {
            Some(channels) if count > 0 => Ok(Self { width, height, channels, texels }),
            _ => Err(format!(
                "expected one number, or red, green and blue, for each of {height} x {width} texels, got {} numbers",
                texels.len()
            )),
        }
    }

    /// Returns the size and the texels as bytes.
    pub(crate) fn bytes(&self) -> Vec<u8> {
        let size = [self.width, self.height].map(|n| (n as u64).to_le_bytes());
        let texels = self.texels.iter().flat_map(|texel| texel.to_le_bytes());
        size.concat().into_iter().chain(texels).collect()
    }

    /// Returns one channel; `name` is for messages.
    ///
    /// # Errors
    ///
    /// If the picture does not have the channel.
    pub(crate) fn channel(
        &self,
        name: &str,
        choice: &ChannelChoice,
    ) -> Result<ChannelImage, FileError> {
        let wanted = choice.layer.as_deref().unwrap_or(choice.channel());
        let single = match wanted {
            _ if choice.layer.is_some() => None,
            "luminance" => Some(None),
            "r" => Some(Some(0)),
            "g" => Some(Some(1)),
            "b" => Some(Some(2)),
            _ => None,
        };
        let single: Option<usize> =
            single.ok_or_else(|| unknown_channel(name, wanted, CHANNELS.to_owned()))?;
        let value = |texel: &[f64]| match (texel, single) {
            ([grey], _) => *grey,
            // Weights of 0 would make NaN of infinite texels of other channels.
            (colours, Some(channel)) => colours[channel],
            (colours, None) => colours.iter().zip(LUMINANCE).map(|(x, w)| w * x).sum(),
        };
        let values = self.texels.chunks_exact(self.channels).map(value).collect();
        let (width, height) = (self.width, self.height);
        let mut image = ChannelImage { width, height, values, remarks: Vec::new() };
        image.remarks =
            negative_texels(&image).into_iter().map(|remark| format!("{name}: {remark}")).collect();
        Ok(image)
    }
}

#[cfg(test)]
mod tests {
    use super::{ChannelChoice, PictureArray};

    fn values(picture: &PictureArray, channel: &str) -> Result<Vec<f64>, String> {
        let choice = ChannelChoice { channel: Some(channel.to_owned()), layer: None };
        let image = picture.channel("P", &choice);
        image.map(|image| image.values).map_err(|error| error.to_string())
    }

    #[test]
    fn channels_are_those_of_files() {
        let colours = PictureArray::new(2, 1, vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0]).unwrap();
        assert_eq!(values(&colours, "g"), Ok(vec![2.0, 5.0]));
        let luminance =
            [0.2126 + 0.7152 * 2.0 + 0.0722 * 3.0, 0.2126 * 4.0 + 0.7152 * 5.0 + 0.0722 * 6.0];
        assert_eq!(values(&colours, "luminance"), Ok(luminance.to_vec()));
        let message = values(&colours, "x").unwrap_err();
        assert_eq!(message, "P: unknown channel \"x\"; valid: luminance, r, g, b");
        let grey = PictureArray::new(1, 2, vec![0.1, -0.2]).unwrap();
        assert_eq!(values(&grey, "luminance"), values(&grey, "b"));
        let remarks = grey.channel("P", &ChannelChoice::default()).unwrap().remarks;
        assert!(remarks[0].starts_with("P: 1 of 2 texels are negative"), "{remarks:?}");
        for (width, height, count) in [(2, 2, 3), (0, 0, 0), (usize::MAX, 3, 9)] {
            assert!(PictureArray::new(width, height, vec![0.0; count]).is_err());
        }
    }
}
