use std::fmt;
use std::str::FromStr;

use sphvar_integrands::grammar::{self, Spec, quote, split_outside};
use sphvar_integrands::{Heuristic, WarpExpression};

use crate::Error;

/// The parts of the text of a [`WarpedPattern`](crate::WarpedPattern), which are not read yet:
/// `PATTERN:key=value,warp=WARP,heuristic=HEURISTIC`.
///
/// # Examples
///
/// ```
/// use sphvar_variance::WarpedText;
///
/// let text: WarpedText = "sobol:warp=cosine".parse()?;
/// assert_eq!((&*text.pattern, &*text.warp), ("sobol", "cosine"));
/// assert_eq!(text.to_string(), "sobol:warp=cosine");
/// # Ok::<(), sphvar_variance::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WarpedText {
    /// The name of the pattern of the square with its own keys.
    pub pattern: String,
    /// The densities.
    pub warp: String,
    /// The weights of several strategies, if the text has that key.
    pub heuristic: Option<Heuristic>,
}

/// The key of the densities.
const WARP: &str = "warp";
/// The key of the heuristic.
const HEURISTIC: &str = "heuristic";

impl WarpedText {
    /// Returns whether a text has the key `warp`.
    #[must_use]
    pub fn is_warped(text: &str) -> bool {
        items(text).1.iter().any(|item| key(item) == Some(WARP))
    }
}

impl WarpedText {
    /// Returns the parts if the items of `text` after `warp` were within its quotes, where they make
    /// a warp: for messages on unknown parameters.
    #[must_use]
    pub fn quoted(&self, text: &str) -> Option<Self> {
        let (name, items) = items(text);
        let at = items.iter().position(|item| key(item) == Some(WARP))?;
        let is_of_warp = |item: &&&str| key(item) != Some(HEURISTIC);
        let after: Vec<&str> = items[at + 1..].iter().filter(is_of_warp).copied().collect();
        let warp = format!("{},{}", self.warp, after.join(","));
        let is_warp = !after.is_empty() && warp.parse::<WarpExpression>().is_ok();
        let separator = if at == 0 { "" } else { ":" };
        let pattern = format!("{name}{separator}{}", items[..at].join(","));
        is_warp.then_some(Self { pattern, warp, heuristic: self.heuristic })
    }
}

impl FromStr for WarpedText {
    type Err = Error;

    /// # Errors
    ///
    /// [`Error::Integrand`] for a text that is no specification, has no `warp`, an empty one or an
    /// unknown heuristic.
    fn from_str(text: &str) -> Result<Self, Error> {
        let mut spec = Spec::parse(text).map_err(sphvar_integrands::Error::from)?;
        let missing = || {
            let (text, key) = (text.to_owned(), WARP.to_owned());
            sphvar_integrands::Error::from(grammar::Error::Missing { text, key })
        };
        let warp = spec.take(WARP).filter(|warp| !warp.trim().is_empty()).ok_or_else(missing)?;
        let heuristic = spec.take(HEURISTIC).map(|name| name.parse()).transpose()?;
        let (name, items) = items(text);
        let own = |item: &&str| !matches!(key(item), Some(WARP | HEURISTIC));
        let others: Vec<&str> = items.into_iter().filter(own).collect();
        let separator = if others.is_empty() { "" } else { ":" };
        let pattern = format!("{name}{separator}{}", others.join(","));
        Ok(Self { pattern, warp, heuristic })
    }
}

impl fmt::Display for WarpedText {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let separator = if self.pattern.contains(':') { ',' } else { ':' };
        write!(f, "{}{separator}{WARP}={}", self.pattern, quote(&self.warp))?;
        match self.heuristic {
            Some(heuristic) => write!(f, ",{HEURISTIC}={heuristic}"),
            None => Ok(()),
        }
    }
}

/// Returns the name and the items of a specification.
fn items(text: &str) -> (&str, Vec<&str>) {
    let mut pieces = split_outside(text, ",");
    let (name, first) = pieces[0].split_once(':').unwrap_or((pieces[0], ""));
    pieces[0] = first;
    pieces.retain(|piece| !piece.is_empty());
    (name, pieces)
}

fn key(item: &str) -> Option<&str> {
    item.split_once('=').map(|(key, _)| key)
}
