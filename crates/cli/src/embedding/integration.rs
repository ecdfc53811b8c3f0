//! Integrals and values of integrands, which no document has.

use std::fmt;

use sphvar_integrands::{Domain, Energy, Integrand, VectorIntegrand};
use sphvar_samplers::PointSet;

use super::{Failure, Session};
use crate::args::Command;
use crate::commands::integrate::Integrated;
use crate::error::CliError;
use crate::integrands::parse_integrand;
use crate::memory::check_degree;
use crate::report::Document;

/// The result of `integrate`, also where the tolerance is not met.
pub struct Integration {
    /// The document of `--json`; that of the first component for several.
    pub document: String,
    /// The integral of each component.
    pub values: Vec<f64>,
    /// The half width of the 95 % interval of each component, or NaN if it is unknown.
    pub errors: Vec<f64>,
    /// Why the tolerance is not met, if it is not.
    pub failure: Option<String>,
    integrated: Integrated,
    session: Session,
}

impl fmt::Debug for Integration {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Integration")
            .field("values", &self.values)
            .field("errors", &self.errors)
            .finish_non_exhaustive()
    }
}

impl Integration {
    /// Returns the nodes with their weights: the sum of the weights times the values there is the
    /// integral.
    ///
    /// # Errors
    ///
    /// If the sets cannot be generated again.
    pub fn nodes(&self) -> Result<PointSet, Failure> {
        self.integrated.nodes().map_err(|error| Failure::of_run(error, &self.session))
    }
}

impl Session {
    /// Returns the integral of the words after the name of the command, which start with
    /// `integrate`; a function `vector` takes the place of the integrand that they name.
    ///
    /// # Errors
    ///
    /// Those of the command, except that a tolerance is not met.
    pub fn integrate(
        &self,
        words: &[String],
        vector: Option<&dyn VectorIntegrand>,
    ) -> Result<Integration, Failure> {
        let (command, global) = self.question(words)?;
        let Command::Integrate(args) = command else {
            return Err(Failure::usage("expected the command integrate"));
        };
        let run = global.session.clone();
        let result = Integrated::new(&args, &global, vector);
        run.check_stopped()?;
        let failed = |error: CliError| Failure::of_run(error, &run);
        let integrated = result.map_err(failed)?;
        let document = Document::new(&integrated.body, &integrated.provenance);
        document.print(&run).map_err(failed)?;
        let estimates = &integrated.integral.estimates;
        Ok(Integration {
            document: run.take_output(),
            values: estimates.iter().map(|estimate| estimate.value).collect(),
            errors: estimates.iter().map(|estimate| estimate.error).collect(),
            failure: integrated.failure.clone(),
            integrated,
            session: run,
        })
    }

    /// Returns the function of an expression.
    ///
    /// # Errors
    ///
    /// Those of the command's option `--integrand`.
    pub fn integrand(&self, text: &str) -> Result<Box<dyn Integrand>, Failure> {
        let integrand = parse_integrand(text, self);
        Ok(integrand.map_err(|error| Failure::of_run(error, self))?.function)
    }

    /// Returns the energies of an expression to degree `lmax`, which estimates may not reach.
    ///
    /// # Errors
    ///
    /// Those of [`integrand`](Self::integrand) and [`Integrand::energy`].
    pub fn energy(&self, text: &str, domain: Domain, lmax: usize) -> Result<Energy, Failure> {
        check_degree("lmax", lmax)?;
        let failed = |error| Failure::of_run(CliError::Failed(format!("{text}: {error}")), self);
        self.integrand(text)?.energy(domain, lmax).map_err(failed)
    }
}
