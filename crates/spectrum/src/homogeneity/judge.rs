use glam::DMat3;
use rayon::prelude::{IntoParallelIterator, ParallelIterator};
use sphvar_samplers::{Domain, Progress, Purpose, Stopped, Streams, uniform_rotation};

use super::audit::{
    AuditFamily, AuditSettings, AuditVerdict, Finding, HomogeneityAudit, MeanBias, OrderRatio,
};
use super::rotator::Rotator;
use super::statistics::{Layout, Sums};
use crate::Anisotropy;

/// The 90 % quantile of the standard normal distribution: the margin for a power of 0.9.
const POWER_MARGIN: f64 = 1.2815515655446004;

/// The scores of one family: first those of the ensemble, then those of its rotated copies.
type Scores = Vec<Vec<f64>>;

pub(super) fn judge(
    domain: Domain,
    lmax: usize,
    rows: &[Vec<f64>],
    anisotropy: &Anisotropy,
    settings: &AuditSettings,
    rotations: Option<&[DMat3]>,
    progress: &dyn Progress,
) -> Result<HomogeneityAudit, Stopped> {
    let layout = Layout::new(domain, lmax, rows);
    let mut observed = layout.zero();
    for row in rows {
        layout.add(row, &mut observed);
    }
    let used = rotations.filter(|r| !r.is_empty());
    let copies =
        rotated_copies(&layout, lmax, rows, settings, used.map_or(0, <[_]>::len), progress)?;
    let count = rows.len() as f64;
    let sums = || std::iter::once(&observed).chain(copies.iter().map(|copy| &copy.0));

    let mut findings = Vec::new();
    let orders: Scores = sums().map(|s| s.orders.clone()).collect();
    for family in AuditFamily::ALL {
        let scores: Scores = match family {
            AuditFamily::Means => standardised(sums().map(|s| s.means.clone()).collect()),
            AuditFamily::Phases => sums().map(|s| rayleigh(s, count)).collect(),
            AuditFamily::Orders => standardised(orders.clone()),
            AuditFamily::Covariances => standardised(sums().map(|s| s.pairs.clone()).collect()),
            AuditFamily::Rotations => {
                if let Some(used) = used {
                    let null = copies.iter().map(|copy| rotation_statistic(copy.1, used.len()));
                    findings.push(rotation_finding(used, null.collect()));
                }
                continue;
            }
        };
        findings.push(finding(family, &layout, &observed, count, &scores));
    }
    adjust(&mut findings, settings.alpha);

    let tested = findings.len();
    let (ratios, detectable) =
        order_ratios(&layout, anisotropy, &orders[1..], count, settings, tested);
    let verdict = if findings.iter().any(|f| f.rejected) {
        AuditVerdict::Inhomogeneous
    } else if detectable <= settings.tolerance {
        AuditVerdict::Homogeneous
    } else {
        AuditVerdict::Undecided
    };
    Ok(HomogeneityAudit {
        domain,
        lmax,
        realizations: rows.len(),
        bias: largest_bias(&layout, &observed, count),
        vanishing: layout.vanishing,
        findings,
        ratios,
        detectable,
        verdict,
    })
}

/// Returns, for each copy of the ensemble, the sums over independently rotated realizations and the
/// sum of `n_rotations` uniform rotations.
fn rotated_copies(
    layout: &Layout,
    lmax: usize,
    rows: &[Vec<f64>],
    settings: &AuditSettings,
    n_rotations: usize,
    progress: &dyn Progress,
) -> Result<Vec<(Sums, DMat3)>, Stopped> {
    let rotator = Rotator::new(lmax);
    let streams = Streams::new(settings.seed, Purpose::Resample, rows.len());
    let copy = |b: u64| {
        let mut rng = streams.realization(b);
        let (mut sums, mut rotated, mut spare) = (layout.zero(), Vec::new(), Vec::new());
        for row in rows {
            rotated.clone_from(row);
            rotator.rotate(&mut rng, &mut rotated, &mut spare);
            layout.add(&rotated, &mut sums);
        }
        let rotation = (0..n_rotations).map(|_| uniform_rotation(&mut rng)).sum();
        progress.tick(copy_work(rows.len() as u64, lmax))?;
        Ok((sums, rotation))
    };
    (0..settings.replicates()).into_par_iter().map(copy).collect()
}

/// Returns the nominal work of rotating `count` realizations: 2 microseconds and 0.6 ns lmax^3
/// each.
pub(super) fn copy_work(count: u64, lmax: usize) -> f64 {
    count as f64 * (33.0 + 0.01 * (lmax as f64).powi(3))
}

/// Returns sums in units of their root mean square over the ensemble and its copies, a scale that
/// is symmetric in them. All sums have mean 0 under invariance.
fn standardised(mut sums: Scores) -> Scores {
    let count = sums.len() as f64;
    for i in 0..sums[0].len() {
        let scale = (sums.iter().map(|s| s[i] * s[i]).sum::<f64>() / count).sqrt();
        for s in &mut sums {
            s[i] = if scale > 0.0 { s[i].abs() / scale } else { 0.0 };
        }
    }
    sums
}

/// Returns `2 |sum of unit vectors|^2/R` for every phase and doubled phase; its distribution tends
/// to chi-square with 2 degrees of freedom for large R.
fn rayleigh(sums: &Sums, count: f64) -> Vec<f64> {
    sums.phases.chunks_exact(2).map(|s| 2.0 * (s[0] * s[0] + s[1] * s[1]) / count).collect()
}

/// Returns the position and value of the maximum score; 0 for an empty list.
fn largest(scores: &[f64]) -> (usize, f64) {
    let by_score = |a: &(usize, f64), b: &(usize, f64)| a.1.total_cmp(&b.1);
    scores.iter().copied().enumerate().max_by(by_score).unwrap_or((0, 0.0))
}

/// Returns `(1 + #{T_b >= T})/(1 + copies)`; differences within rounding error count as ties.
fn p_value(statistic: f64, null: impl ExactSizeIterator<Item = f64>) -> f64 {
    const TIE: f64 = 1.0 - 1e-9;
    let copies = null.len() as f64;
    let as_large = null.filter(|&t| t >= TIE * statistic).count() as f64;
    (1.0 + as_large) / (1.0 + copies)
}

fn finding(
    family: AuditFamily,
    layout: &Layout,
    observed: &Sums,
    count: f64,
    scores: &Scores,
) -> Finding {
    let (at, statistic) = largest(&scores[0]);
    let comparisons = layout.comparisons(family);
    let (worst, value) = if comparisons > 0 {
        layout.describe(family, at, observed, count)
    } else {
        (String::new(), f64::NAN)
    };
    let p_value = p_value(statistic, scores[1..].iter().map(|s| largest(s).1));
    Finding {
        family,
        comparisons,
        statistic,
        p_value,
        adjusted: p_value,
        rejected: false,
        worst,
        value,
    }
}

/// Returns `3 |sum of R|^2/count`; for many uniform rotations, whose entries have variance 1/3 and
/// are uncorrelated, chi-square with 9 degrees of freedom.
fn rotation_statistic(sum: DMat3, count: usize) -> f64 {
    3.0 * sum.to_cols_array().iter().map(|x| x * x).sum::<f64>() / count as f64
}

fn rotation_finding(used: &[DMat3], null: Vec<f64>) -> Finding {
    let family = AuditFamily::Rotations;
    let sum: DMat3 = used.iter().copied().sum();
    let statistic = rotation_statistic(sum, used.len());
    let p_value = p_value(statistic, null.into_iter());
    let entries = sum.to_cols_array();
    let (at, _) = largest(&entries.map(f64::abs));
    let axis = |i: usize| ["x", "y", "z"][i];
    let worst = format!("E R_{}{}", axis(at % 3), axis(at / 3));
    let value = entries[at] / used.len() as f64;
    Finding {
        family,
        comparisons: 9,
        statistic,
        p_value,
        adjusted: p_value,
        rejected: false,
        worst,
        value,
    }
}

/// Sets Holm's adjusted p-values and the rejections.
fn adjust(findings: &mut [Finding], alpha: f64) {
    let mut order: Vec<usize> = (0..findings.len()).collect();
    order.sort_by(|&a, &b| findings[a].p_value.total_cmp(&findings[b].p_value));
    let mut adjusted: f64 = 0.0;
    for (rank, &i) in order.iter().enumerate() {
        let left = (order.len() - rank) as f64;
        adjusted = adjusted.max((left * findings[i].p_value).min(1.0));
        findings[i].adjusted = adjusted;
        findings[i].rejected = adjusted <= alpha;
    }
}

/// Returns the ratios with simultaneous confidence intervals, and the detectable error: the
/// critical score plus the margin for a power of 0.9, in units of the standard deviation over the
/// copies.
fn order_ratios(
    layout: &Layout,
    anisotropy: &Anisotropy,
    copies: &[Vec<f64>],
    count: f64,
    settings: &AuditSettings,
    tested: usize,
) -> (Vec<OrderRatio>, f64) {
    let n = copies.len() as f64;
    let scatter: Vec<f64> = (0..layout.orders(0).count())
        .map(|i| (copies.iter().map(|s| s[i] * s[i]).sum::<f64>() / n).sqrt())
        .collect();
    let mut extremes: Vec<f64> = copies
        .iter()
        .map(|s| s.iter().zip(&scatter).map(|(x, scale)| x.abs() / scale).fold(0.0, f64::max))
        .collect();
    extremes.sort_by(f64::total_cmp);
    let quantile = |alpha: f64| {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "below the number of copies"
        )]
        let from_top = (alpha * (n + 1.0)).floor().clamp(1.0, n) as usize;
        extremes[extremes.len() - from_top]
    };
    let critical = quantile(settings.alpha);
    let margin = quantile(settings.alpha / tested as f64) + POWER_MARGIN;
    let mut detectable: f64 = if count < 2.0 || scatter.is_empty() { f64::INFINITY } else { 0.0 };
    let mut ratios = Vec::new();
    for ((l, m), scatter) in layout.orders(0).zip(&scatter) {
        let (moments, power) = (anisotropy.order(l, m), layout.power[l]);
        let (ratio, stderr) = (1.0 + moments.mean() / power, moments.standard_error() / power);
        let (low, high) = ((ratio - critical * stderr).max(0.0), ratio + critical * stderr);
        ratios.push(OrderRatio { l, m, ratio, stderr, low, high });
        detectable = detectable.max(margin * scatter / (count * power));
    }
    (ratios, detectable)
}

fn largest_bias(layout: &Layout, observed: &Sums, count: f64) -> Option<MeanBias> {
    let mut first = 0;
    let mut worst: Option<MeanBias> = None;
    for &l in &layout.degrees {
        for m in 0..=l {
            let re = observed.means[first + m] / count;
            // For m >= 1 the two real components are sqrt(2) times the parts of one coefficient.
            let square = match m {
                0 => re * re,
                m => 0.5 * (re * re + (observed.means[first + l + m] / count).powi(2)),
            };
            let share = square / layout.power[l];
            if worst.is_none_or(|w| share > w.share) {
                worst = Some(MeanBias { l, m, share });
            }
        }
        first += 2 * l + 1;
    }
    worst
}
