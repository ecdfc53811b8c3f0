//! The figures, one file each.

mod cap_power;
mod patterns;
mod spectra;

use crate::{Error, Figure, Job, Results, Setting};

/// How a figure is made: what must be computed for it, and what is then shown and decided.
pub(crate) trait Recipe: Sync {
    /// What the figure shows, in a few words.
    fn title(&self) -> &'static str;

    /// What must be computed.
    fn jobs(&self, setting: Setting) -> Vec<Job>;

    /// Fills the figure.
    fn compose(
        &self,
        setting: Setting,
        results: &Results,
        figure: &mut Figure,
    ) -> Result<(), Error>;
}

/// Every figure by its number, in the thesis's order.
pub(crate) const ALL: [(&str, &dyn Recipe); 1] = [("C.1", &cap_power::CapPower)];
