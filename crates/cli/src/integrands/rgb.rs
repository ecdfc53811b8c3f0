//! Pictures with three channels, `env:FILE,channel=rgb`.

use sphvar_integrands::{Expression, Term};

use super::{IntegrandFiles, NamedIntegrand, parse_expression};
use crate::error::CliError;
use crate::report::say;

/// The value of `channel` for all channels of the next list.
const RGB: &str = "rgb";
/// Red, green, blue, and the luminance, which is the default channel.
const CHANNELS: [Option<&str>; 4] = [Some("r"), Some("g"), Some("b"), None];

/// Returns the integrands of an expression: one, or with `channel=rgb` those of red, green, blue
/// and, as the last one, luminance. Reads every file once and prints remarks, unless `quiet`.
///
/// Names are the expressions of single channels.
pub(crate) fn parse_integrands(
    text: &str,
    quiet: bool,
) -> Result<Vec<NamedIntegrand<'static>>, CliError> {
    let expression = parse_expression(text)?;
    let files = IntegrandFiles::default();
    if !expression.terms().any(is_rgb) {
        let integrand = files.build(&expression, text.to_owned())?;
        files.remarks.take().iter().for_each(|remark| say(quiet, remark));
        return Ok(vec![integrand]);
    }
    let of_channel = |channel: Option<&str>| {
        let expression = with_channel(expression.clone(), channel);
        let integrand = files.build(&expression, expression.to_string())?;
        let name = channel.unwrap_or("luminance");
        files.remarks.take().iter().for_each(|remark| say(quiet, &format!("{name} of {remark}")));
        Ok(integrand)
    };
    CHANNELS.into_iter().map(of_channel).collect()
}

/// Rejects several channels where a command takes one integrand.
pub(super) fn reject(expression: &Expression) -> Result<(), CliError> {
    if expression.terms().any(is_rgb) {
        return Err(CliError::Usage(
            "channel=rgb stands for three channels and luminance, which variance, compare and choose take; choose \
             r, g, b or luminance"
                .to_owned(),
        ));
    }
    Ok(())
}

fn is_rgb(term: &Term) -> bool {
    matches!(term, Term::Environment(p) if p.picture.channel.as_deref() == Some(RGB))
}

/// Replaces `channel=rgb` by one channel.
fn with_channel(mut expression: Expression, channel: Option<&str>) -> Expression {
    let factors = expression.summands.iter_mut().flat_map(|summand| &mut summand.factors);
    for factor in factors.filter(|factor| is_rgb(&factor.term)) {
        if let Term::Environment(parameters) = &mut factor.term {
            parameters.picture.channel = channel.map(str::to_owned);
        }
    }
    expression
}
