//! Pictures with three channels, `env:FILE,channel=rgb`.

use sphvar_integrands::{Expression, Term};

use super::{IntegrandFiles, NamedIntegrand, parse_expression};
use crate::error::CliError;
use crate::report::remark_on_channels;
use crate::session::Session;

/// The value of `channel` for all channels of the next list.
const RGB: &str = "rgb";
/// The channels, the main one last.
const CHANNELS: [&str; 4] = ["r", "g", "b", "luminance"];

/// Returns the integrands of an expression: one, or with `channel=rgb` those of red, green, blue
/// and, as the last one, luminance. Reads every file once and reports remarks.
///
/// Names are the expressions of single channels.
pub(crate) fn parse_integrands(
    text: &str,
    session: &Session,
) -> Result<Vec<NamedIntegrand<'static>>, CliError> {
    let expression = parse_expression(text)?;
    let files = IntegrandFiles::new(session);
    if !expression.terms().any(is_rgb) {
        let integrand = files.build(&expression, text.to_owned())?;
        files.report();
        return Ok(vec![integrand]);
    }
    let of_channel = |channel: &'static str| {
        let mut expression = expression.clone();
        set_channel(&mut expression, channel);
        let integrand = files.build(&expression, expression.to_string())?;
        Ok((integrand, (channel, files.remarks.take())))
    };
    let read = CHANNELS.into_iter().map(of_channel).collect::<Result<Vec<_>, CliError>>()?;
    let (integrands, remarks): (Vec<_>, Vec<_>) = read.into_iter().unzip();
    remark_on_channels(session, &remarks);
    Ok(integrands)
}

/// Rejects several channels where a command takes one integrand.
pub(super) fn reject(expression: &Expression) -> Result<(), CliError> {
    if expression.terms().any(is_rgb) {
        return Err(CliError::Usage(
            "channel=rgb means r, g, b and luminance, and is supported by variance, compare and choose; name one \
             of the four"
                .to_owned(),
        ));
    }
    Ok(())
}

fn is_rgb(term: &Term) -> bool {
    matches!(term, Term::Environment(p) if p.picture.channel.as_deref() == Some(RGB))
}

/// Replaces `channel=rgb` by one channel, also within filters.
fn set_channel(expression: &mut Expression, channel: &str) {
    let mut pending = vec![expression];
    while let Some(expression) = pending.pop() {
        let factors = expression.summands.iter_mut().flat_map(|summand| &mut summand.factors);
        for factor in factors {
            let is_rgb = is_rgb(&factor.term);
            match &mut factor.term {
                Term::Environment(parameters) if is_rgb => {
                    parameters.picture.channel = Some(channel.to_owned());
                }
                Term::Filtered(parameters) => pending.push(&mut parameters.of),
                _ => {}
            }
        }
    }
}
