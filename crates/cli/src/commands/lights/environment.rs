use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use glam::DVec3;
use sphvar_grammar::argument_text;
use sphvar_integrands::{EnvironmentMap, EnvironmentParameters, PictureParameters, Term, UpAxis};
use sphvar_scene::RgbEnvironment;

use crate::error::CliError;
use crate::integrands::environment::{Environment, PictureSource, to_map};
use crate::report::remark_on_channels;
use crate::session::Session;

/// The names of the channels in files.
const CHANNELS: [&str; 3] = ["r", "g", "b"];

/// An environment map of a file.
pub(super) struct LightProbe {
    /// The map as the integrand `env` with its parameters.
    pub(super) name: String,
    /// The direction of the pole of the map.
    pub(super) pole: DVec3,
    pub(super) environment: RgbEnvironment,
}

impl LightProbe {
    /// Reads a map from the path of a file or from `env:FILE,key=value`. Reports remarks.
    pub(super) fn read(argument: &OsStr, session: &Session) -> Result<Self, CliError> {
        let parameters = parse(argument)?;
        let name = Term::Environment(parameters.clone()).to_string();
        let EnvironmentParameters { file, picture } = parameters;
        if picture.channel.as_deref().is_some_and(|channel| channel != "rgb") {
            return Err(CliError::Usage(format!(
                "{name}: lights have red, green and blue; omit channel="
            )));
        }
        let source = PictureSource::open(&file, session)?;
        let mut remarks = Vec::new();
        let read = |channel: &'static str| -> Result<EnvironmentMap, CliError> {
            let picture =
                PictureParameters { channel: Some(channel.to_owned()), ..picture.clone() };
            let read = Environment::decode(&file, &source, &picture)?;
            remarks.push((channel, read.remarks));
            Ok(read.map)
        };
        let [r, g, b] = CHANNELS.map(read);
        remark_on_channels(session, &remarks);
        let pole = picture.up.map_or(DVec3::Z, UpAxis::direction);
        let environment = RgbEnvironment::new([r?, g?, b?], to_map(pole).inverse())
            .map_err(|error| CliError::File(format!("{}: {error}", file.display())))?;
        Ok(Self { name, pole, environment })
    }
}

fn parse(argument: &OsStr) -> Result<EnvironmentParameters, CliError> {
    let text = argument_text(argument);
    if text.starts_with("env:") && !Path::new(argument).is_file() {
        return match text.parse::<Term>().map_err(CliError::usage)? {
            Term::Environment(parameters) => Ok(parameters),
            other => Err(CliError::Usage(format!("expected env:FILE, got {other}"))),
        };
    }
    let file = PathBuf::from(argument);
    Ok(EnvironmentParameters { file, picture: PictureParameters::default() })
}
