//! The figures, one file each.

mod cap_power;
mod integrand_classes;
mod patterns;
mod spectra;
mod spectra_product;

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
pub(crate) const ALL: [(&str, &dyn Recipe); 3] = [
    ("5.1", &spectra_product::SpectraProduct),
    ("6.1", &integrand_classes::IntegrandClasses),
    ("C.1", &cap_power::CapPower),
];
