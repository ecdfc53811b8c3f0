use std::fmt;
use std::str::FromStr;

use crate::figures::{self, Recipe};
use crate::{Error, Figure, Job, Results, Setting};

/// A figure of the thesis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct FigureId(usize);

impl FigureId {
    /// Returns all available figures, in the order of the thesis.
    pub fn all() -> impl Iterator<Item = Self> {
        (0..figures::ALL.len()).map(Self)
    }

    /// Returns the number in the thesis: `4.10`, `C.1`.
    #[must_use]
    pub fn number(self) -> &'static str {
        figures::ALL[self.0].0
    }

    /// Returns a short title of the figure.
    #[must_use]
    pub fn title(self) -> &'static str {
        self.recipe().title()
    }

    /// Returns the jobs required to compose the figure.
    #[must_use]
    pub fn jobs(self, setting: Setting) -> Vec<Job> {
        self.recipe().jobs(setting)
    }

    /// Returns the figure composed from the results of its jobs in their setting; the results may
    /// contain others.
    ///
    /// # Errors
    ///
    /// [`Error::Missing`] if a job was not run; the errors of further computations.
    pub fn compose(self, results: &Results) -> Result<Figure, Error> {
        let mut figure =
            Figure { id: self, panels: Vec::new(), claims: Vec::new(), notes: Vec::new() };
        self.recipe().compose(results.setting(), results, &mut figure)?;
        Ok(figure)
    }

    fn recipe(self) -> &'static dyn Recipe {
        figures::ALL[self.0].1
    }
}

impl fmt::Display for FigureId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.number())
    }
}

impl FromStr for FigureId {
    type Err = Error;

    /// Parses `4.10`, `c.1`.
    fn from_str(text: &str) -> Result<Self, Error> {
        let same = |id: &Self| id.number().eq_ignore_ascii_case(text.trim());
        Self::all().find(same).ok_or_else(|| {
            let valid: Vec<&str> = Self::all().map(Self::number).collect();
            Error::UnknownFigure { name: text.to_owned(), valid: valid.join(", ") }
        })
    }
}
