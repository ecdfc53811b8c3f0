//! The numbers of points of designs.

use super::DesignEquations;
use crate::{Domain, ValidCounts};

/// The numbers of points with which designs of degrees 2 to 12 are known: some small ones, and all
/// from a number on (Hardin and Sloane 1996). Others do not exist for the degrees 2 and 3 (Mimura
/// 1990; Boyvalenkov, Danev and Nikova 1999), nor, it is conjectured, for the others.
const KNOWN: [(usize, &[usize], usize); 11] = [
    (2, &[4], 6),
    (3, &[6, 8], 10),
    (4, &[12, 14], 16),
    (5, &[12, 16, 18, 20], 22),
    (6, &[24, 26], 28),
    (7, &[24, 30, 32, 34], 36),
    (8, &[36, 40, 42], 44),
    (9, &[48, 50, 52], 54),
    (10, &[60, 62], 64),
    (11, &[70, 72], 74),
    (12, &[84], 86),
];

/// The designs that have fewer degrees of freedom than equations, by their symmetry: degree,
/// whether the points stand for pairs, and their number. The tetrahedron, the octahedron, the
/// icosahedron, and in pairs the octahedron, the cube and the icosahedron.
const SYMMETRIC: [(usize, bool, usize); 6] =
    [(2, false, 4), (3, false, 6), (5, false, 12), (2, true, 3), (2, true, 4), (4, true, 6)];

/// Up to this degree any number of points with enough degrees of freedom has its largest degree:
/// the search takes milliseconds.
const SMALL_DEGREE: usize = 12;

/// The largest ratio of equations to the 2N coordinates where the number of points is not that of a
/// stored design.
const MAX_SHARE: f64 = 0.9;

/// Returns the smallest number of points, of pairs for symmetric sets, at which designs are made:
/// it has one or two degrees of freedom more than there are equations, apart from rotations, except
/// for the most symmetric sets.
pub(crate) fn default_count(equations: DesignEquations) -> usize {
    symmetric_counts(equations).next().unwrap_or_else(|| generic_count(equations))
}

/// Returns the numbers of points of the most symmetric sets.
fn symmetric_counts(equations: DesignEquations) -> impl Iterator<Item = usize> {
    let top = equations.degrees().last();
    let is_own =
        move |set: &&(usize, bool, usize)| set.1 == equations.is_symmetric && Some(set.0) == top;
    SYMMETRIC.iter().filter(is_own).map(|set| set.2)
}

/// Returns the smallest number of points with at least one degree of freedom, apart from
/// rotations, more than there are equations.
fn generic_count(equations: DesignEquations) -> usize {
    match equations {
        // Any number from 2 on, such as that of a regular polygon.
        DesignEquations { degree: 0 | 1, is_symmetric: false } => equations.degree + 1,
        DesignEquations { degree: 0 | 1, is_symmetric: true } => 1,
        _ => (equations.count() + 5) / 2,
    }
}

/// Returns whether a search may find a design: the default number of points, or one with enough
/// degrees of freedom that is not known to have none.
fn is_feasible(equations: DesignEquations, n_points: usize) -> bool {
    let is_known = |set: &(usize, &[usize], usize)| {
        set.0 != equations.degree || set.1.contains(&n_points) || n_points >= set.2
    };
    symmetric_counts(equations).any(|n| n == n_points)
        || n_points >= generic_count(equations)
            && (equations.is_symmetric || KNOWN.iter().all(is_known))
}

/// Returns the equations of the design of a degree with a number of points: on the sphere those of
/// pairs of antipodes if `is_symmetric`, or if only these have the degree. `None` if no design is
/// available.
pub(crate) fn equations_of(
    degree: usize,
    n_points: usize,
    domain: Domain,
    is_symmetric: bool,
) -> Option<DesignEquations> {
    let of = |is_symmetric| DesignEquations { degree, is_symmetric };
    if domain == Domain::Sphere && !is_symmetric && is_feasible(of(false), n_points) {
        return Some(of(false));
    }
    let n_pairs = pairs(n_points, domain)?;
    is_feasible(of(true), n_pairs).then_some(of(true))
}

/// Returns the equations of the design with a number of points, of the degree of [`degree_of`];
/// those of pairs of antipodes also where these have a larger degree that is found at once.
pub(crate) fn equations_by_count(
    n_points: usize,
    domain: Domain,
    is_symmetric: bool,
) -> Option<DesignEquations> {
    let in_pairs = pairs(n_points, domain).map(|n_pairs| {
        (DesignEquations { degree: degree_of(n_pairs, true), is_symmetric: true }, n_pairs)
    });
    if domain == Domain::Hemisphere || is_symmetric {
        return in_pairs.map(|(equations, _)| equations);
    }
    let degree = degree_of(n_points, false);
    let is_better = |&(equations, n_pairs): &(DesignEquations, usize)| {
        (equations.degree | 1) > degree
            && (equations.degree <= SMALL_DEGREE || super::stored::has(equations, n_pairs))
    };
    let plain = DesignEquations { degree, is_symmetric: false };
    Some(in_pairs.filter(is_better).map_or(plain, |(equations, _)| equations))
}

/// Returns the number of pairs of antipodes that points stand for or consist of, unless one has no
/// antipode.
fn pairs(n_points: usize, domain: Domain) -> Option<usize> {
    match domain {
        Domain::Hemisphere => Some(n_points),
        Domain::Sphere => n_points.is_multiple_of(2).then_some(n_points / 2),
    }
}

/// Returns the numbers of points with which designs of a degree are available.
pub(crate) fn valid_counts(degree: usize, domain: Domain, is_symmetric: bool) -> ValidCounts {
    let of = |is_symmetric| DesignEquations { degree, is_symmetric };
    let factor = if domain == Domain::Sphere { 2 } else { 1 };
    let is_plain = domain == Domain::Sphere && !is_symmetric;
    let step = if is_plain { 1 } else { factor };
    let symmetric = factor * default_count(of(true));
    let (first, generic) = if is_plain {
        (symmetric.min(default_count(of(false))), generic_count(of(false)))
    } else {
        (symmetric, factor * generic_count(of(true)))
    };
    // The last gaps are below the number from which there are enough degrees of freedom, apart from
    // those of small degrees just above it.
    let is_valid = |n: &usize| equations_of(degree, *n, domain, is_symmetric).is_some();
    let end = generic.max(first) + 8 * step;
    let last_gap = (first..end).step_by(step).rev().find(|n| !is_valid(n));
    let from = last_gap.map_or(first, |gap| gap + step);
    let listed: Vec<usize> = (first..from).step_by(step).filter(is_valid).collect();
    match (from, listed.is_empty()) {
        (1, true) => ValidCounts::Any,
        (first, true) => ValidCounts::AtLeast { first, step },
        (first, false) => ValidCounts::ListedOrAtLeast { listed: listed.into(), first, step },
    }
}

/// Returns the degree of the design of `n_points` points or pairs: the largest feasible one up to
/// degree 12 and where the number is that of a stored design, otherwise the largest for which at
/// most nine tenths of the coordinates are constrained. 0 if there is none.
pub(super) fn degree_of(n_points: usize, is_symmetric: bool) -> usize {
    let step = if is_symmetric { 2 } else { 1 };
    // The square of a degree is at most about 2N, with two pairs of points each a half of that.
    let mut degree = (2 * step * n_points).isqrt() / step * step + 2;
    let may_be = |degree| {
        let equations = DesignEquations { degree, is_symmetric };
        let is_quick = degree <= SMALL_DEGREE
            || super::stored::has(equations, n_points)
            || equations.count() as f64 <= MAX_SHARE * (2 * n_points) as f64;
        is_quick && is_feasible(equations, n_points)
    };
    while degree > 0 && !may_be(degree) {
        degree -= step;
    }
    degree
}

#[cfg(test)]
mod tests {
    use super::{
        DesignEquations, default_count, degree_of, equations_by_count, equations_of, is_feasible,
        valid_counts,
    };
    use crate::Domain;

    #[test]
    fn numbers_of_points_are_those_of_published_designs() {
        let count = |degree| default_count(DesignEquations { degree, is_symmetric: false });
        // The platonic solids; Womersley 2018 has 52, 482 and 2114 points.
        for (degree, n) in
            [(1, 2), (2, 4), (3, 6), (4, 14), (5, 12), (9, 52), (30, 482), (64, 2114)]
        {
            assert_eq!(count(degree), n, "{degree}");
        }
        for degree in 6..200 {
            assert!(count(degree) as f64 <= 0.5 * (degree + 1).pow(2) as f64 + 3.0, "{degree}");
        }
        // Symmetric sets in pairs: degrees 3, 5 and 65.
        for (degree, pairs) in [(2, 3), (4, 6), (64, 1074)] {
            let equations = DesignEquations { degree, is_symmetric: true };
            assert_eq!(default_count(equations), pairs, "{degree}");
            // An odd degree has no equations of its own.
            let odd = DesignEquations { degree: degree + 1, is_symmetric: true };
            assert_eq!(default_count(odd), pairs, "{degree}");
        }
    }

    #[test]
    fn counts_without_designs_are_infeasible() {
        let designs = |degree| DesignEquations { degree, is_symmetric: false };
        for (degree, n) in [(1, 1), (2, 5), (3, 9), (4, 15), (9, 53), (12, 85), (30, 481)] {
            assert!(!is_feasible(designs(degree), n), "{degree}, {n}");
        }
    }

    /// The cube and other pairs of antipodes, also stored ones, are designs too.
    #[test]
    fn pairs_of_antipodes_count_as_designs() {
        for (degree, n) in
            [(3, 8), (5, 18), (7, 32), (9, 48), (9, 50), (11, 70), (4, 12), (31, 500)]
        {
            let equations = equations_of(degree, n, Domain::Sphere, false);
            let symmetric = DesignEquations { degree, is_symmetric: true };
            assert_eq!(equations, Some(symmetric), "{degree}, {n}");
        }
        for (n, degree) in
            [(8, 3), (18, 5), (32, 7), (48, 9), (50, 9), (70, 11), (94, 13), (500, 31)]
        {
            let equations = equations_by_count(n, Domain::Sphere, false).unwrap();
            assert!(equations.is_symmetric && equations.degree | 1 == degree, "{n}: {equations:?}");
        }
        for n in [5, 9, 12, 23, 53, 482, 514, 1000, 50_000] {
            let equations = equations_by_count(n, Domain::Sphere, false).unwrap();
            assert!(!equations.is_symmetric || n == 12, "{n}: {equations:?}");
        }
    }

    /// The rule of numbers of points agrees with the search at every one of them.
    #[test]
    fn valid_counts_are_those_with_equations() {
        for domain in [Domain::Sphere, Domain::Hemisphere] {
            for is_symmetric in [false, true] {
                for degree in (1..=40).chain([65]) {
                    let counts = valid_counts(degree, domain, is_symmetric);
                    for n in 1..(degree + 2).pow(2) {
                        let is_made = equations_of(degree, n, domain, is_symmetric).is_some();
                        assert_eq!(counts.contains(n), is_made, "{degree}, {domain}, {n}");
                    }
                }
            }
        }
        let text =
            |degree, is_symmetric| valid_counts(degree, Domain::Sphere, is_symmetric).to_string();
        assert_eq!(text(2, false), "4 or at least 6");
        assert_eq!(text(3, false), "6, 8 or at least 10");
        assert_eq!(text(5, true), "12, or a multiple of 2, at least 18");
        assert_eq!(text(30, false), "at least 482");
    }

    #[test]
    fn degrees_follow_from_the_number_of_points() {
        let expected = [(1, 0), (2, 1), (3, 1), (4, 2), (5, 1), (6, 3), (9, 2), (12, 5), (482, 30)];
        for (n, degree) in expected {
            assert_eq!(degree_of(n, false), degree, "{n}");
        }
        assert_eq!(degree_of(1, true), 0);
        assert_eq!(degree_of(6, true), 4);
        for n in [600, 1000, 5000, 1_000_000] {
            let degree = degree_of(n, false);
            let share = ((degree + 1).pow(2) - 1) as f64 / (2 * n) as f64;
            assert!(share <= 0.9 && share > 0.84, "{n}: {degree}");
        }
    }
}
