use sphvar_samplers::Domain;
use sphvar_spectrum::OrderPower;

use super::Recipe;
use super::order_grid::{OrderGrid, Style};
use super::patterns::ThesisPattern;
use super::significance::{at_most, largest_of_normal, verdict};
use crate::{
    Claim, Error, Figure, Job, Palette, Quantity, Results, Setting, Stated, ThesisEnsemble,
};

/// Figures 4.11, 4.12 and 4.16: how rotations spread the power of a lattice over the orders.
pub(crate) struct RotatedLattice {
    lattice: ThesisPattern,
    domain: Domain,
    title: &'static str,
}

impl RotatedLattice {
    /// Figure 4.11.
    pub(crate) const HEALPIX: Self = Self {
        lattice: ThesisPattern::Healpix,
        domain: Domain::Sphere,
        title: "Orders of HEALPix centres under rotations",
    };
    /// Figure 4.12.
    pub(crate) const FIBONACCI: Self = Self {
        lattice: ThesisPattern::Fibonacci,
        domain: Domain::Sphere,
        title: "Orders of the Fibonacci lattice under rotations",
    };
    /// Figure 4.16.
    pub(crate) const HEMISPHERICAL_FIBONACCI: Self = Self {
        lattice: ThesisPattern::Fibonacci,
        domain: Domain::Hemisphere,
        title: "Orders of the hemispherical Fibonacci lattice under rotations",
    };
}

/// The requested number of points, which the thesis does not state.
const N_POINTS: usize = 1024;
/// The last degree shown: the first peaks of the sphere lie at 1.76 sqrt(N), those of the
/// hemisphere at 2.49 sqrt(N).
const LMAX_SPHERE: usize = 64;
const LMAX_HEMISPHERE: usize = 96;
/// Numbers of rotations over which the power is averaged; 0 is the unrotated lattice.
const ROTATIONS: [u64; 4] = [0, 1, 10, 1000];
/// The power at which the left column saturates to white, four times that of white noise.
const WHITE: f64 = 4.0;
/// Degrees of less power are ignored: odd ones of antipodal sets have about 1e-28 from rounding.
const NOTHING: f64 = 1e-12;

impl RotatedLattice {
    fn lmax(&self) -> usize {
        match self.domain {
            Domain::Sphere => LMAX_SPHERE,
            Domain::Hemisphere => LMAX_HEMISPHERE,
        }
    }

    fn ensemble(&self) -> ThesisEnsemble {
        let pattern = self.lattice.pattern();
        match self.domain {
            Domain::Sphere => ThesisEnsemble::sphere(pattern, N_POINTS),
            Domain::Hemisphere => ThesisEnsemble::hemisphere(pattern, N_POINTS),
        }
    }

    fn job(&self, rotations: u64) -> Job {
        let ensemble = self.ensemble();
        let ensemble = if rotations == 0 { ensemble.unrotated() } else { ensemble };
        Job::Orders { ensemble, lmax: self.lmax(), sets: rotations.max(1) }
    }

    /// Returns the degrees that have power.
    fn degrees<'a>(&self, grid: &'a OrderGrid<'_>) -> impl Iterator<Item = usize> + use<'a, '_> {
        let domain = self.domain;
        let degrees = (1..=grid.lmax()).filter(move |&l| domain.has_degree(l));
        degrees.filter(|&l| grid.power(l) > NOTHING)
    }
}

impl Recipe for RotatedLattice {
    fn title(&self) -> &'static str {
        self.title
    }

    fn jobs(&self, _: Setting) -> Vec<Job> {
        ROTATIONS.iter().map(|&rotations| self.job(rotations)).collect()
    }

    fn compose(&self, _: Setting, results: &Results, figure: &mut Figure) -> Result<(), Error> {
        let step = self.domain.degree_step();
        for rotations in ROTATIONS {
            let grid = OrderGrid::new(results.orders(&self.job(rotations))?);
            let heading = match rotations {
                0 => "As made".to_owned(),
                1 => "1 rotation".to_owned(),
                _ => format!("Mean over {rotations} rotations"),
            };
            let mut panel = |name: &str, what: &str, style: Style, value: &dyn Fn(f64) -> f64| {
                let name = format!("{name}-{rotations}");
                figure.panel(&name, format!("{heading}: {what}"), grid.square(&style, step, value));
            };
            let grey = Style { label: "power, 4 for all above", palette: Palette::Grey };
            panel("square", "spectrum", grey, &|p| p.min(WHITE));
            panel("power", "power", Style { label: "power", palette: Palette::Heat }, &|p| p);
            let root = Style { label: "square root of power", palette: Palette::Heat };
            panel("root", "square root of power", root, &f64::sqrt);
        }
        self.claims(results, figure)?;
        figure.note(format!(
            "N = {}; the thesis states neither this nor the numbers of rotations. Power is (4 pi/N) |S_lm|^2 to degree {}; \
             degree 0, whose power is N, is left out.",
            self.ensemble().n_points,
            self.lmax()
        ));
        if self.domain == Domain::Hemisphere {
            figure.note("Antipodal sets have even degrees only; each is drawn twice as thick.");
        }
        Ok(())
    }
}

impl RotatedLattice {
    fn claims(&self, results: &Results, figure: &mut Figure) -> Result<(), Error> {
        let max_rotations = ROTATIONS[ROTATIONS.len() - 1];
        let before = OrderGrid::new(results.orders(&self.job(0))?);
        let some = OrderGrid::new(results.orders(&self.job(10))?);
        let after = OrderGrid::new(results.orders(&self.job(max_rotations))?);
        let change = self
            .degrees(&before)
            .map(|l| (after.power(l) / before.power(l) - 1.0).abs())
            .fold(0.0, f64::max);
        figure.claims.push(
            Claim::number(
                format!("largest relative change of the power of a degree by {max_rotations} rotations"),
                // Coefficients are accurate to 1e-12 of N, and a degree may have as little as 1e-12
                // of the largest power.
                Stated::About { value: 0.0, tolerance: 1e-6 },
                Quantity::exact(change),
            )
            .because(
                "\"the mean angular power spectrum do not change\": an identity, since rotations are unitary within a degree",
            )
            .by_construction(),
        );

        let peak =
            self.degrees(&before).max_by(|&a, &b| before.power(a).total_cmp(&before.power(b)));
        let Some(peak) = peak else { return Ok(()) };
        let power = before.power(peak);
        // Root mean square over the orders of a degree, in parts of its power.
        let rms = |grid: &OrderGrid<'_>, f: &dyn Fn(&OrderPower) -> f64| {
            grid.mean_over_orders(peak, |o| f(o).powi(2)).sqrt() / power
        };
        let spread = |grid: &OrderGrid<'_>| rms(grid, &|o| o.power - power);
        let mut z = 0.0_f64;
        let mut comparisons = 0;
        for l in self.degrees(&before) {
            for order in after.degree(l) {
                z = z.max(((order.power - before.power(l)) / order.stderr).abs());
                comparisons += 1;
            }
        }
        let p = largest_of_normal(z, comparisons);
        figure.claims.push(
            Claim::words(
                format!("power of the orders of a degree after {max_rotations} rotations"),
                "becomes equal",
                verdict(p),
            )
            .measured(Quantity::single(spread(&after)))
            .because(format!(
                "the spread over m at the peak l = {peak} in parts of its power {power:.2}; errors of sampling \
                 alone give {:.3}. It is {:.2} before and {:.2} after 10 rotations. The largest of {comparisons} \
                 differences has z = {z:.1}, {}",
                rms(&after, &|o| o.stderr),
                spread(&before),
                spread(&some),
                at_most(p),
            )),
        );
        Ok(())
    }
}
