//! The flags for the prediction and measurement of variances, which `variance` and `compare` share.

use clap::Args;
use sphvar_variance::{Precision, PredictionBudget, SpectrumOptions, Trials};

use super::rows::{Effort, Parts, Plan};
use crate::counts::parse_realizations;
use crate::error::CliError;
use crate::flags::{
    DomainArgs, KmaxArgs, LmaxArgs, SquareArgs, spectra_kmax_help, spectra_lmax_help,
};
use crate::global::Global;
use crate::integrands::Integrals;
use crate::shards::ShardArgs;
use crate::share::parse_share;
use crate::transforms::TransformArgs;

/// Flags for the prediction and measurement of variances.
#[derive(Debug, Args)]
#[command(
    mut_arg("lmax", |lmax| lmax.help(spectra_lmax_help())),
    mut_arg("kmax", |kmax| kmax.help(spectra_kmax_help()))
)]
pub(crate) struct EffortArgs {
    #[arg(short = 'm', long, value_name = "M", value_parser = parse_trials, help = trials_help("; with --until-rel, the initial number"))]
    pub(crate) realizations: Option<u64>,
    /// Double the trials until the relative standard error of each variance is at most this, such as
    /// 2% or 0.02
    #[arg(long, value_name = "E", value_parser = parse_share, allow_negative_numbers = true)]
    pub(crate) until_rel: Option<f64>,
    /// Maximum number of trials with --until-rel
    #[arg(long, default_value = "1000000", value_name = "M", value_parser = parse_realizations,
        requires = "until_rel")]
    pub(crate) max_realizations: u64,
    #[arg(long, value_name = "R", value_parser = parse_realizations, help = spectrum_realizations_help())]
    pub(crate) spectrum_realizations: Option<u64>,
    #[command(flatten)]
    pub(crate) lmax: LmaxArgs,
    #[command(flatten)]
    pub(crate) transform: TransformArgs,
    #[command(flatten)]
    pub(crate) domain: DomainArgs,
    #[command(flatten)]
    pub(crate) square: SquareArgs,
    #[command(flatten)]
    pub(crate) kmax: KmaxArgs,
    #[command(flatten)]
    pub(crate) sharding: ShardArgs,
}

/// Parses a number of trials, which must suffice for the error of a variance.
pub(super) fn parse_trials(text: &str) -> Result<u64, String> {
    let trials = parse_realizations(text)?;
    let min_trials = Precision::MIN_TRIALS;
    if trials < min_trials {
        return Err(format!(
            "-m must be at least {min_trials} for the error of a measured variance, got {trials}"
        ));
    }
    Ok(trials)
}

/// Returns the help of the number of trials, with an addition.
pub(super) fn trials_help(more: &str) -> String {
    format!(
        "Trials per measured variance{more} [default: {}; fewer for samplers \
         whose sets are expensive, within a fixed amount of work, but at least {}]",
        Trials::DEFAULT,
        Trials::MIN_DEFAULT
    )
}

fn spectrum_realizations_help() -> String {
    format!(
        "Realizations per estimated spectrum [default: none where a closed form is available; otherwise until the \
         prediction is known to {} %, within a fixed amount of work]",
        100.0 * PredictionBudget::DEFAULT.relative
    )
}

impl EffortArgs {
    /// Returns the plan for integrals; set `whole_spectra` if the spectra are shown.
    pub(super) fn plan<'a>(
        &self,
        integrals: &'a Integrals<'a>,
        global: &'a Global,
        whole_spectra: bool,
    ) -> Result<Plan<'a>, CliError> {
        Ok(Plan {
            integrand: integrals.main(),
            integrals,
            domain: self.domain.domain(),
            effort: self.settings(self.lmax.lmax, global, whole_spectra)?,
        })
    }

    /// Returns the settings of predictions and measurements, with the largest degree or frequency of
    /// spectra.
    pub(super) fn settings<'a>(
        &self,
        lmax: Option<usize>,
        global: &'a Global,
        whole_spectra: bool,
    ) -> Result<Effort<'a>, CliError> {
        if self.until_rel.is_some() && self.sharding.save.is_some() {
            return Err(CliError::Usage(
                "--until-rel does not apply with --save or --shard: it stops by itself, when the results so far are \
                 precise enough, so its trials cannot be divided; give their number with -m"
                    .to_owned(),
            ));
        }
        let (method, epsilon) = self.transform.checked()?;
        let realizations = self.spectrum_realizations;
        let until = |relative| Precision { relative, max_trials: self.max_realizations };
        Ok(Effort {
            seed: global.seed,
            trials: self.realizations,
            until: self.until_rel.map(until),
            spectra: SpectrumOptions { lmax, realizations, method, epsilon },
            whole_spectra,
            parts: Parts::default(),
            session: &global.session,
        })
    }
}
