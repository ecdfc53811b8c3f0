//! The listed properties of a sampler, an integrand, a warp and a format.

use schemars::JsonSchema;
use serde::Serialize;
use sphvar_grammar::{DefaultValue, Parameter, ParameterKind, Value};
use sphvar_integrands::{SquareTerm, Term, WarpTerm};
use sphvar_samplers::{
    CostOrder, Domain, Pattern, PatternFacts, Rate, RotationPattern, SetDistribution,
    SquareDistribution, SquarePattern,
};

use super::page::{Page, UNBREAKABLE};
use crate::files::FileFormat;

/// A sampler.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct SamplerEntry {
    /// The name, as every command accepts it.
    pub(super) name: &'static str,
    /// One sentence.
    pub(super) summary: &'static str,
    /// The parameters, in the order in which they are printed.
    parameters: Vec<ParameterEntry>,
    /// The rules that numbers of points obey.
    counts: Counts,
    /// The growth of the time for a set with its number of points N.
    cost: CostEntry,
    /// The power as the degree or, on the square, the frequency goes to 0.
    low_degrees: &'static str,
    /// The rate of the variance in N for smooth integrands.
    smooth_rate: RateEntry,
    /// The rate of the variance in N for integrands with jumps.
    jump_rate: RateEntry,
    #[serde(skip)]
    rates: String,
    /// The known properties of the distribution.
    distribution: &'static str,
    /// Whether all sets are the same up to rotations or shifts.
    deterministic: bool,
    /// Whether the first points of a larger set are a set.
    extensible: bool,
    /// No set has power at any degree from 1 to `l`, for patterns that are made so.
    last_empty_degrees: Vec<LastEmptyDegree>,
    /// Authors and years.
    source: &'static str,
}

/// Valid numbers of points, in words.
#[derive(Debug, Serialize, JsonSchema)]
struct Counts {
    /// On the sphere.
    #[serde(skip_serializing_if = "Option::is_none")]
    sphere: Option<String>,
    /// On the hemisphere.
    #[serde(skip_serializing_if = "Option::is_none")]
    hemisphere: Option<String>,
    /// On the unit square.
    #[serde(skip_serializing_if = "Option::is_none")]
    square: Option<String>,
    /// Of rotations.
    #[serde(skip_serializing_if = "Option::is_none")]
    rotations: Option<String>,
}

/// The order of the time for a set: N^exponent (log N)^logarithm, times a factor.
#[derive(Debug, Serialize, JsonSchema)]
struct CostEntry {
    /// The order as a formula.
    text: String,
    /// The exponent of N.
    exponent: f64,
    /// The exponent of log N.
    logarithm: f64,
    /// A further factor of the time in words; may be empty.
    factor: &'static str,
}

/// A rate in words, and its exponents if it is a power.
#[derive(Debug, Serialize, JsonSchema)]
struct RateEntry {
    /// The rate in words.
    text: String,
    /// The exponent of N; null unless the rate is a power.
    exponent: Option<f64>,
    /// The exponent of log N; null unless the rate is a power.
    logarithm: Option<f64>,
}

/// The last degree without power of sets of n points.
#[derive(Debug, Serialize, JsonSchema)]
struct LastEmptyDegree {
    /// The number of points.
    n: usize,
    /// The last degree without power.
    l: usize,
}

/// A parameter of a sampler, integrand or warp.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct ParameterEntry {
    /// The key.
    name: &'static str,
    /// One sentence.
    summary: &'static str,
    /// The valid values in words.
    range: String,
    /// The names of the valid values, where they have names.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    values: Vec<&'static str>,
    /// A number or a text; null where the parameter must be given or follows from something else.
    default: serde_json::Value,
    /// Whether the parameter must be given.
    required: bool,
    /// `=DEFAULT` in the notation of the grammar.
    #[serde(skip)]
    shown_default: String,
    /// Whether any text or any file name is valid.
    #[serde(skip)]
    is_text: bool,
    /// The origin of the default, in words.
    #[serde(skip_serializing_if = "Option::is_none")]
    default_depends: Option<&'static str>,
}

/// An integrand or a warp.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct FunctionEntry {
    /// The name, as every command accepts it.
    pub(super) name: &'static str,
    /// One sentence.
    pub(super) summary: &'static str,
    /// An example, or the form where a file is required.
    example: String,
    /// The parameters, in the order in which they are printed.
    parameters: Vec<ParameterEntry>,
}

/// A format.
#[derive(Debug, Serialize, JsonSchema)]
#[serde(transparent)]
pub(crate) struct FormatEntry(pub(super) FileFormat);

impl SamplerEntry {
    pub(super) fn new(pattern: &Pattern, counts: &[usize], domain: Domain) -> Self {
        let last = |&n: &usize| {
            let n = pattern.nearest_count(n, domain);
            Some(LastEmptyDegree { n, l: pattern.last_empty_degree(n, domain)? })
        };
        let mut last_empty_degrees: Vec<_> = counts.iter().filter_map(last).collect();
        // Some patterns have empty degrees only with parameters other than the defaults.
        if last_empty_degrees.iter().all(|last| last.l == 0) {
            last_empty_degrees.clear();
        }
        let counts = |domain| Some(pattern.valid_counts(domain).to_string());
        let counts = Counts {
            sphere: counts(Domain::Sphere),
            hemisphere: counts(Domain::Hemisphere),
            square: None,
            rotations: None,
        };
        Self {
            deterministic: pattern.is_deterministic(),
            last_empty_degrees,
            ..Self::with(
                (pattern.name(), pattern.summary()),
                pattern.parameters(),
                &pattern.facts(),
                counts,
                distribution(pattern),
            )
        }
    }

    pub(super) fn of_square(pattern: &SquarePattern) -> Self {
        let counts = Counts {
            sphere: None,
            hemisphere: None,
            square: Some(pattern.valid_counts().to_string()),
            rotations: None,
        };
        let (distribution, deterministic) = square_distribution(pattern);
        let facts = pattern.facts();
        Self {
            deterministic,
            rates: facts.rates_on_torus(),
            ..Self::with(
                (pattern.name(), pattern.summary()),
                pattern.parameters(),
                &facts,
                counts,
                distribution,
            )
        }
    }

    pub(super) fn of_rotations(pattern: &RotationPattern) -> Self {
        let counts = Counts {
            sphere: None,
            hemisphere: None,
            square: None,
            rotations: Some(pattern.valid_counts().to_string()),
        };
        let sampler = pattern.build(pattern.nearest_count(1));
        let deterministic = sampler.is_ok_and(|sampler| !sampler.is_random());
        let distribution =
            if deterministic { "always the same" } else { "independent uniform rotations" };
        Self {
            deterministic,
            ..Self::with(
                (pattern.name(), pattern.summary()),
                pattern.parameters(),
                &pattern.facts(),
                counts,
                distribution,
            )
        }
    }

    /// Returns the entry of a random pattern that may have power at every degree.
    fn with(
        (name, summary): (&'static str, &'static str),
        parameters: Vec<Parameter>,
        facts: &PatternFacts,
        counts: Counts,
        distribution: &'static str,
    ) -> Self {
        let CostOrder { exponent, logarithm, factor, .. } = facts.cost;
        Self {
            name,
            summary,
            parameters: parameters.into_iter().map(ParameterEntry::new).collect(),
            counts,
            cost: CostEntry { text: facts.cost.to_string(), exponent, logarithm, factor },
            low_degrees: facts.low_degrees,
            smooth_rate: RateEntry::new(facts.smooth_rate),
            jump_rate: RateEntry::new(facts.jump_rate),
            rates: facts.rates(),
            distribution,
            deterministic: false,
            extensible: facts.is_extensible,
            last_empty_degrees: Vec::new(),
            source: facts.source,
        }
    }

    pub(super) fn show(&self, page: &mut Page) {
        let counts = match &self.counts {
            Counts { sphere: Some(sphere), hemisphere: Some(hemisphere), .. }
                if sphere != hemisphere =>
            {
                format!("{sphere}; on the hemisphere {hemisphere}")
            }
            Counts { sphere, square, rotations, .. } => {
                sphere.iter().chain(square).chain(rotations).cloned().collect()
            }
        };
        let power = match self.counts.square {
            None => "P(l) as l -> 0",
            Some(_) => "P(k) as k -> 0",
        };
        let extensible =
            if self.extensible { "; a sequence, the first points of a set are a set" } else { "" };
        let last = |last: &LastEmptyDegree| format!("{} for N = {}", last.l, last.n);
        let last: Vec<String> = self.last_empty_degrees.iter().map(last).collect();
        page.heading(&format!("{}: {}", self.name, self.summary));
        self.parameters.iter().for_each(|parameter| parameter.show(page));
        page.detail("N", &counts);
        page.detail("cost", &self.cost.text);
        page.detail(power, self.low_degrees);
        page.detail("last empty degree", &last.join(", "));
        page.detail("variance", &self.rates);
        page.detail("sets", &format!("{}{extensible}", self.distribution));
        page.detail("source", self.source);
    }
}

/// Returns the known properties of a pattern's distribution, in words.
fn distribution(pattern: &Pattern) -> &'static str {
    if let Pattern::PointFile(_) = pattern {
        return "one of the sets in the file, drawn uniformly";
    }
    let n = pattern.nearest_count(12, Domain::Sphere);
    let Ok(sampler) = pattern.build(n, Domain::Sphere) else { return "random" };
    match sampler.distribution() {
        SetDistribution::Independent => "independent uniform points",
        SetDistribution::Stratified(_) => "one uniform point in each of N cells of equal area",
        SetDistribution::SphericalEnsemble => "determinantal, invariant under rotations",
        SetDistribution::Fixed => "always the same, up to rotation",
        _ => "random",
    }
}

/// Returns the known properties of a pattern of the square in words, and whether all its sets are the
/// same up to shifts.
fn square_distribution(pattern: &SquarePattern) -> (&'static str, bool) {
    if let SquarePattern::PointFile(_) = pattern {
        return ("one of the sets in the file, drawn uniformly", false);
    }
    let Ok(sampler) = pattern.build(pattern.nearest_count(12)) else { return ("random", false) };
    let words = match sampler.distribution() {
        SquareDistribution::Independent => "independent uniform points",
        SquareDistribution::Jittered { .. } => "one uniform point in each cell of a grid",
        SquareDistribution::Fixed | SquareDistribution::Lattice(_) => {
            "always the same, up to a shift"
        }
        _ => "random",
    };
    (words, !sampler.is_random())
}

impl RateEntry {
    fn new(rate: Rate) -> Self {
        let (exponent, logarithm) = match rate {
            Rate::Power { exponent, logarithm } => (Some(exponent), Some(logarithm)),
            _ => (None, None),
        };
        Self { text: rate.to_string(), exponent, logarithm }
    }
}

impl ParameterEntry {
    fn new(parameter: Parameter) -> Self {
        let (default, default_depends) = match &parameter.default {
            DefaultValue::Value(Value::Integer(value)) => ((*value).into(), None),
            DefaultValue::Value(Value::Number(value)) => ((*value).into(), None),
            DefaultValue::Value(value) => (value.to_string().into(), None),
            DefaultValue::Depends(words) => (serde_json::Value::Null, Some(*words)),
            _ => (serde_json::Value::Null, None),
        };
        let values = match &parameter.kind {
            ParameterKind::Choice(names) => names.clone(),
            _ => Vec::new(),
        };
        Self {
            name: parameter.name,
            summary: parameter.summary,
            shown_default: match &parameter.default {
                DefaultValue::Value(value) => format!("={value}"),
                _ => String::new(),
            },
            is_text: matches!(
                parameter.kind,
                ParameterKind::Word | ParameterKind::Text(_) | ParameterKind::File
            ),
            range: parameter.kind.to_string(),
            values,
            required: parameter.default == DefaultValue::Required,
            default,
            default_depends,
        }
    }

    fn show(&self, page: &mut Page) {
        let absent = match self.default_depends {
            Some(words) => format!("; default {words}"),
            None if self.required => "; required".to_owned(),
            None => String::new(),
        };
        let range = if self.values.is_empty() {
            self.range.replace(' ', UNBREAKABLE)
        } else {
            self.values.join(", ")
        };
        let range = if self.is_text { String::new() } else { format!(": {range}") };
        let detail = format!("{}{range}{absent}", self.summary);
        page.detail(&format!("{}{}", self.name, self.shown_default), &detail);
    }
}

/// Returns an entry for every function of a registry.
macro_rules! entries {
    ($Term:ident) => {
        $Term::all()
            .iter()
            .map(|term| FunctionEntry {
                name: term.name(),
                summary: term.summary(),
                example: term.to_string(),
                parameters: term.parameters().into_iter().map(ParameterEntry::new).collect(),
            })
            .collect()
    };
}

impl FunctionEntry {
    pub(super) fn integrands() -> Vec<Self> {
        entries!(Term)
    }

    /// Returns the integrands on the unit square.
    pub(super) fn square_integrands() -> Vec<Self> {
        entries!(SquareTerm)
    }

    pub(super) fn warps() -> Vec<Self> {
        entries!(WarpTerm)
    }

    pub(super) fn show(&self, page: &mut Page) {
        page.heading(&format!("{}: {}", self.name, self.summary));
        page.detail("example", &self.example);
        self.parameters.iter().for_each(|parameter| parameter.show(page));
    }
}

impl FormatEntry {
    /// Returns content and extensions in a line.
    pub(super) fn line(&self) -> String {
        let extensions: Vec<String> = self.0.extensions.iter().map(|e| format!(".{e}")).collect();
        format!("{}, {}", self.0.content, extensions.join(" "))
    }

    pub(super) fn show(&self, page: &mut Page) {
        let FileFormat { name, summary, is_read, is_written, .. } = &self.0;
        let use_of = match (is_read, is_written) {
            (true, true) => "read and written",
            (true, false) => "read",
            _ => "written",
        };
        page.heading(&format!("{name}: {}", self.line()));
        page.detail(use_of, summary);
    }
}
