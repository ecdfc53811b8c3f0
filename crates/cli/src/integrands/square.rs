//! The integrands on the unit square.

use std::fmt;

use sphvar_grammar::split_outside;
use sphvar_integrands::{
    Error, Expression, ImageParameters, SquareExpression, SquareImage, SquareIntegrand, SquareTerm,
};

use super::IntegrandFiles;
use crate::error::CliError;
use crate::files::ChannelChoice;
use crate::session::Session;

/// An integrand on the square with its name in tables.
pub(crate) struct NamedSquareIntegrand {
    /// The name as the user wrote it.
    pub(crate) name: String,
    /// The function.
    pub(crate) function: Box<dyn SquareIntegrand>,
}

impl NamedSquareIntegrand {
    /// Returns what is estimated, for titles.
    pub(crate) fn subject(&self) -> String {
        format!("integrating {}", self.name)
    }
}

/// Returns the integrand of one expression. Reads the files that it names and reports remarks on
/// them.
pub(crate) fn parse_square_integrand(
    text: &str,
    session: &Session,
) -> Result<NamedSquareIntegrand, CliError> {
    let expression: SquareExpression =
        text.parse().map_err(|error| match text.parse::<Expression>() {
            _ if split_outside(text, " @ ").len() > 1 => CliError::Usage(format!(
                "{text}: rotations (@) are of integrands on the sphere; those on the square have parameters for their \
                 place"
            )),
            Ok(_) => CliError::Usage(format!(
                "{text} is an integrand on the sphere; those on the square are {SquareForms}"
            )),
            Err(_) => CliError::usage(error),
        })?;
    let files = IntegrandFiles::new(session);
    let function = expression.build(&files).map_err(|error| match error {
        Error::File(source) => CliError::of_resolver(&source),
        other => CliError::usage(other),
    })?;
    files.report();
    Ok(NamedSquareIntegrand { name: text.to_owned(), function })
}

/// Returns the picture of a file as a function.
pub(super) fn read_image(
    files: &IntegrandFiles<'_>,
    wanted: &ImageParameters,
) -> Result<SquareImage, CliError> {
    let choice = ChannelChoice { channel: wanted.channel.clone(), layer: wanted.layer.clone() };
    let read = files.picture(&wanted.file)?.decode_any(&wanted.file, &choice)?;
    files.remarks.borrow_mut().extend(read.remarks);
    SquareImage::new(read.width, read.height, read.values, wanted.interpolation)
        .map_err(|e| CliError::File(format!("{}: {e}", wanted.file.display())))
}

/// The names of integrands on the square and their parameters; its `Display` text is for help.
pub(crate) struct SquareForms;

impl fmt::Display for SquareForms {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let forms: Vec<String> = SquareTerm::all().iter().map(SquareTerm::form).collect();
        f.write_str(&forms.join(" | "))
    }
}

#[cfg(test)]
mod tests {
    use super::{Session, parse_square_integrand};

    #[test]
    fn rotations_are_of_the_sphere() {
        for text in ["disk:radius=0.2 @ 30/10", "0.5 * half-plane:angle=3 @ 1/2/3 + wave:k1=1,k2=0"]
        {
            let Err(error) = parse_square_integrand(text, &Session::default().muted()) else {
                panic!("{text}")
            };
            assert!(error.to_string().contains("rotations (@)"), "{error}");
        }
    }
}
