//! Pair correlation and Ripley's functions, for `spectrum --pairs`.

use clap::Args;
use glam::DVec3;
use schemars::JsonSchema;
use serde::Serialize;
use sphvar_samplers::Domain;
use sphvar_spectrum::{
    AngleBins, DifferentialAccumulator, Differentials, LocalDensity, PairCorrelation,
    PairCorrelationAccumulator,
};

use crate::counts::parse_one_count;
use crate::error::CliError;
use crate::integrands::parse_integrand;
use crate::memory::check_memory;
use crate::plots::{Chart, Ink, Panel, Scale, Series, Spread, Style};
use crate::progress::Progress;
use crate::report::{Column, number, table_of};
use crate::session::Session;

/// Flags of the pair correlation.
#[derive(Debug, Args)]
pub(crate) struct PairArgs {
    /// Estimate the pair correlation g and Ripley's K and L too; they replace the spectrum in tables, CSV files and plots
    #[arg(long, conflicts_with_all = ["exact", "save"])]
    pub(crate) pairs: bool,
    /// Largest angle between two points in degrees [default: five times the mean spacing]
    #[arg(long, value_name = "DEGREES", requires = "pairs", allow_negative_numbers = true)]
    max_angle: Option<f64>,
    /// Number of bins of the angle
    #[arg(long, default_value = "100", value_name = "B", requires = "pairs", value_parser = parse_one_count)]
    bins: usize,
    /// Local density of the points, by which the angles of differentials are scaled: an integrand, or weights for the inverse of the weights of the points
    #[arg(long, value_name = "DENSITY", requires = "pairs")]
    density: Option<String>,
}

/// The pair correlation to estimate.
pub(super) struct PairSettings {
    bins: AngleBins,
    density: Option<Density>,
    lmax: usize,
}

/// The local density by which differentials are scaled.
enum Density {
    InverseWeights,
    /// A function with mean 1.
    Function(Box<dyn Fn(DVec3) -> f64 + Sync>),
}

/// The accumulators of pairs.
pub(super) type PairAccumulators<'a> =
    (PairCorrelationAccumulator<'a>, Option<DifferentialAccumulator<'a>>);

/// Pair correlation and Ripley's functions; each list has an entry for each bin of the angle, and
/// each value is a mean over the realizations. A number that cannot be given is null.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub(crate) struct PairBody {
    /// The middle of each bin of the angle between two points, in radians; between two lines on the
    /// hemisphere.
    gamma: Vec<f64>,
    /// The pair correlation, `rho_2/rho^2`, averaged over each bin.
    #[schemars(with = "Vec<Option<f64>>")]
    g: Vec<f64>,
    /// The standard error of `g`.
    #[schemars(with = "Vec<Option<f64>>")]
    stderr: Vec<f64>,
    /// The standard deviation of `g` for as many independent uniform points and realizations.
    #[schemars(with = "Vec<Option<f64>>")]
    g_uniform_stderr: Vec<f64>,
    /// The pair correlation at `gamma` from the spectrum, smoothed by a heat kernel.
    #[schemars(with = "Vec<Option<f64>>")]
    g_smooth: Vec<f64>,
    /// The standard error of `g_smooth`.
    #[schemars(with = "Vec<Option<f64>>")]
    g_smooth_stderr: Vec<f64>,
    /// The standard deviation of the heat kernel along each axis, in radians.
    smoothing_width: f64,
    /// The upper edge of each bin, in radians.
    radius: Vec<f64>,
    /// Ripley's K: the area times the share of pairs within `radius`; `2 pi (1 - cos radius)` for
    /// independent uniform points.
    #[schemars(with = "Vec<Option<f64>>")]
    k: Vec<f64>,
    /// The standard error of `k`.
    #[schemars(with = "Vec<Option<f64>>")]
    k_stderr: Vec<f64>,
    /// The standard deviation of `k` for as many independent uniform points and realizations.
    #[schemars(with = "Vec<Option<f64>>")]
    k_uniform_stderr: Vec<f64>,
    /// The angular radius of the cap of area `k`, in radians; `radius` for independent uniform
    /// points.
    #[schemars(with = "Vec<Option<f64>>")]
    l: Vec<f64>,
    /// The standard error of `l`.
    #[schemars(with = "Vec<Option<f64>>")]
    l_stderr: Vec<f64>,
    /// `sum_l (2l+1) (1 - P(l)) e^(-l(l+1)t)/(N - 1)` with the heat kernel of `g_smooth`: 1 if no
    /// two points are within a few `smoothing_width`, 0 for white noise.
    #[schemars(with = "Option<f64>")]
    sum_rule: f64,
    /// The standard error of `sum_rule`.
    #[schemars(with = "Option<f64>")]
    sum_rule_stderr: f64,
    /// With `--density`: pairs by their angle scaled by the local density to that at the mean
    /// density, over those of independent points of the same density, in the bins of `gamma`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<Vec<Option<f64>>>")]
    scaled_g: Option<Vec<f64>>,
    /// The standard error of `scaled_g`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<Vec<Option<f64>>>")]
    scaled_stderr: Option<Vec<f64>>,
}

/// One bin of the angle, a row of CSV files; the columns are those of the lists of `pairs` in JSON.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct PairRecord {
    gamma: f64,
    g: f64,
    stderr: f64,
    g_uniform_stderr: f64,
    g_smooth: f64,
    g_smooth_stderr: f64,
    radius: f64,
    k: f64,
    k_stderr: f64,
    k_uniform_stderr: f64,
    l: f64,
    l_stderr: f64,
    scaled_g: Option<f64>,
    scaled_stderr: Option<f64>,
}

impl PairArgs {
    /// Returns the settings for sets of `n_points` with coefficients to degree `lmax`, if pairs are
    /// wanted.
    pub(super) fn settings(
        &self,
        domain: Domain,
        n_points: usize,
        lmax: usize,
        session: &Session,
    ) -> Result<Option<PairSettings>, CliError> {
        if !self.pairs {
            return Ok(None);
        }
        let max_angle = match self.max_angle {
            Some(degrees) => degrees.to_radians(),
            None => AngleBins::natural(domain, n_points).max_angle(),
        };
        let bins = AngleBins::new(domain, max_angle, self.bins)
            .map_err(|error| CliError::Usage(format!("--max-angle, --bins: {error}")))?;
        check_memory("--pairs", 8.0 * self.bins as f64 * (lmax as f64 + 1.0))?;
        let density = match self.density.as_deref() {
            None => None,
            Some("weights") => Some(Density::InverseWeights),
            Some(text) => Some(density(text, domain, session)?),
        };
        Ok(Some(PairSettings { bins, density, lmax }))
    }
}

/// Returns the density of an integrand.
fn density(text: &str, domain: Domain, session: &Session) -> Result<Density, CliError> {
    let function = parse_integrand(text, session)?.function;
    let wrong = |why: String| CliError::Usage(format!("--density {text}: {why}"));
    let integral = function.exact(domain).ok_or_else(|| wrong("its integral is unknown".into()))?;
    let mean = integral / domain.area();
    if !(mean > 0.0 && mean.is_finite()) {
        return Err(wrong(format!("a density has a positive mean, got {mean}")));
    }
    Ok(Density::Function(Box::new(move |dir| function.eval(dir) / mean)))
}

impl PairSettings {
    /// Returns the nominal work of the pairs of a set.
    pub(super) fn work(&self, n_points: usize) -> f64 {
        PairCorrelationAccumulator::work(&self.bins, n_points)
    }

    /// Returns empty accumulators, which `progress` can stop.
    pub(super) fn accumulators<'a>(
        &'a self,
        progress: &'a Progress,
    ) -> Result<PairAccumulators<'a>, CliError> {
        let pairs = PairCorrelationAccumulator::new(self.bins, self.lmax, progress)?;
        let density = self.density.as_ref().map(|density| match density {
            Density::InverseWeights => LocalDensity::InverseWeights,
            Density::Function(function) => LocalDensity::Function(&**function),
        });
        let differentials =
            density.map(|density| DifferentialAccumulator::new(self.bins, density, progress));
        Ok((pairs, differentials))
    }
}

impl PairBody {
    /// Returns the results; for sets without a distribution (`is_exact`) errors are 0, or absent for
    /// one that is not a sample (`has_no_error`).
    pub(super) fn new(
        sums: &PairAccumulators<'_>,
        is_exact: bool,
        has_no_error: bool,
    ) -> Result<Self, CliError> {
        let pairs = sums.0.finish()?;
        let pairs: PairCorrelation = if is_exact { pairs.into_exact() } else { pairs };
        let scaled = sums.1.as_ref().map(DifferentialAccumulator::finish).transpose()?;
        let (scaled_g, scaled_stderr) = match scaled {
            Some(Differentials { g, g_stderr, .. }) => {
                let errors = if is_exact { vec![0.0; g.len()] } else { g_stderr };
                (Some(g), Some(errors))
            }
            None => (None, None),
        };
        let body = Self {
            gamma: pairs.bins.centres(),
            g: pairs.g,
            stderr: pairs.g_stderr,
            g_uniform_stderr: pairs.g_uniform_stderr,
            g_smooth: pairs.g_smooth,
            g_smooth_stderr: pairs.g_smooth_stderr,
            smoothing_width: pairs.smoothing_width,
            radius: pairs.bins.upper_edges(),
            k: pairs.k,
            k_stderr: pairs.k_stderr,
            k_uniform_stderr: pairs.k_uniform_stderr,
            l: pairs.l,
            l_stderr: pairs.l_stderr,
            sum_rule: pairs.sum_rule,
            sum_rule_stderr: pairs.sum_rule_stderr,
            scaled_g,
            scaled_stderr,
        };
        Ok(if has_no_error { body.without_errors() } else { body })
    }

    /// Returns the same without standard errors, for a single set that is not a sample.
    fn without_errors(mut self) -> Self {
        let lists =
            [&mut self.stderr, &mut self.g_smooth_stderr, &mut self.k_stderr, &mut self.l_stderr];
        lists.into_iter().chain(&mut self.scaled_stderr).for_each(|list| list.fill(f64::NAN));
        self.sum_rule_stderr = f64::NAN;
        self
    }

    /// Returns a record for each bin.
    pub(super) fn rows(&self) -> Vec<PairRecord> {
        let row = |i: usize| PairRecord {
            gamma: self.gamma[i],
            g: self.g[i],
            stderr: self.stderr[i],
            g_uniform_stderr: self.g_uniform_stderr[i],
            g_smooth: self.g_smooth[i],
            g_smooth_stderr: self.g_smooth_stderr[i],
            radius: self.radius[i],
            k: self.k[i],
            k_stderr: self.k_stderr[i],
            k_uniform_stderr: self.k_uniform_stderr[i],
            l: self.l[i],
            l_stderr: self.l_stderr[i],
            scaled_g: self.scaled_g.as_ref().map(|g| g[i]),
            scaled_stderr: self.scaled_stderr.as_ref().map(|errors| errors[i]),
        };
        (0..self.gamma.len()).map(row).collect()
    }

    /// Returns the table of these rows, with the sum rule.
    pub(super) fn text<'r>(&self, rows: impl IntoIterator<Item = &'r PairRecord>) -> String {
        let degrees = |x: f64| number::value(x.to_degrees());
        let mut columns = vec![
            Column::number("angle (deg)", move |r: &PairRecord| degrees(r.gamma)),
            Column::number("g", |r: &PairRecord| number::value(r.g)),
            Column::number("+-", |r: &PairRecord| number::uncertainty(r.stderr)),
            Column::number("uniform +-", |r: &PairRecord| number::uncertainty(r.g_uniform_stderr)),
            Column::number("g smooth", |r: &PairRecord| number::value(r.g_smooth)),
            Column::number("+-", |r: &PairRecord| number::uncertainty(r.g_smooth_stderr)),
            Column::number("radius (deg)", move |r: &PairRecord| degrees(r.radius)),
            Column::number("K", |r: &PairRecord| number::value(r.k)),
            Column::number("L (deg)", move |r: &PairRecord| degrees(r.l)),
        ];
        if self.scaled_g.is_some() {
            let scaled = |r: &PairRecord| number::optional(r.scaled_g, number::value);
            columns.push(Column::number("g scaled", scaled));
        }
        let width = degrees(self.smoothing_width);
        let (value, error) = (self.sum_rule, self.sum_rule_stderr);
        let sum = if error.is_finite() && error > 0.0 {
            number::with_uncertainty(value, error)
        } else {
            number::value(value)
        };
        table_of(&columns, rows)
            + &format!(
                "sum rule = {sum} (1: no two points within a few times {width} degrees; white noise: 0)\n"
            )
    }

    /// Returns the chart of g and L for the sets of `name`.
    pub(super) fn chart(&self, name: &str, n_points: usize) -> Chart {
        let degrees = |x: &f64| x.to_degrees();
        let curve = |label: &str, x: &[f64], y: &[f64], errors: Vec<f64>, style, rank| Series {
            label: label.to_owned(),
            points: x.iter().map(degrees).zip(y.iter().copied()).collect(),
            spread: Spread::Errors(errors),
            style,
            ink: Ink::Rank(rank),
        };
        let mut of_g = vec![
            curve("pairs", &self.gamma, &self.g, self.stderr.clone(), Style::Line, 0),
            curve(
                "spectrum, smoothed",
                &self.gamma,
                &self.g_smooth,
                self.g_smooth_stderr.clone(),
                Style::Dashed,
                1,
            ),
        ];
        if let (Some(g), Some(errors)) = (&self.scaled_g, &self.scaled_stderr) {
            of_g.push(curve("scaled", &self.gamma, g, errors.clone(), Style::Line, 2));
        }
        let excess: Vec<f64> =
            self.l.iter().zip(&self.radius).map(|(l, r)| degrees(&(l - r))).collect();
        let errors = self.l_stderr.iter().map(degrees).collect();
        let panel = |y_label: &str, reference, series| Panel {
            y_label: y_label.to_owned(),
            y_scale: Scale::Linear,
            series,
            reference: Some(reference),
            side_by_side: false,
        };
        let of_l = vec![curve("", &self.radius, &excess, errors, Style::Line, 0)];
        let width = number::value(self.smoothing_width.to_degrees());
        Chart {
            title: format!("Pair correlation of {name}, N = {n_points}"),
            x_label: "angle \u{3b3} between two points (degrees)".to_owned(),
            x_scale: Scale::Linear,
            panels: vec![
                panel("pair correlation g(\u{3b3}), uniform points = 1", 1.0, of_g),
                panel("L(\u{3b3}) \u{2212} \u{3b3} (degrees)", 0.0, of_l),
            ],
            notes: vec![format!(
                "Bands: one standard error to either side. Smoothing: a heat kernel of standard \
                 deviation {width} degrees along each axis."
            )],
        }
    }
}
