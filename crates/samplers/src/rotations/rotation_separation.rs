use glam::{DQuat, DVec4};

use super::quaternion_tree::QuaternionTree;
use crate::{Progress, Stopped};

/// Returns the separation of rotations, the least angle between two of them in radians: 0 if two
/// coincide, at most pi; `None` for fewer than two. Weights have no part in it.
///
/// # Errors
///
/// [`Stopped`] if `progress` stops the work.
///
/// # Performance
///
/// Nearest neighbours in a k-d tree: O(N log N) on most sets.
///
/// # Examples
///
/// ```
/// use std::f64::consts::{FRAC_PI_2, PI};
/// use glam::DQuat;
/// use sphvar_samplers::rotation_separation;
///
/// let turns = [0.0, FRAC_PI_2, PI].map(DQuat::from_rotation_z);
/// let angle = rotation_separation(&turns, &())?.unwrap();
/// assert!((angle - FRAC_PI_2).abs() < 1e-15);
/// # Ok::<(), sphvar_samplers::Stopped>(())
/// ```
pub fn rotation_separation(
    rotations: &[DQuat],
    progress: &dyn Progress,
) -> Result<Option<f64>, Stopped> {
    if rotations.len() < 2 {
        return Ok(None);
    }
    let tree = QuaternionTree::new(rotations);
    // The nearer one of two antipodes is within the chord sqrt(2), to rounding.
    let mut smallest = 2.0 + 1e-9;
    for (i, &q) in rotations.iter().enumerate() {
        tree.visit(DVec4::from(q), &mut smallest, &mut |_, other, squared, bound| {
            if other as usize != i {
                *bound = squared;
            }
        });
        if i.is_multiple_of(1024) {
            progress.tick(0.0)?;
        }
        if smallest <= 0.0 {
            break;
        }
    }
    Ok(Some(angle_of_chord(smallest.sqrt())))
}

/// Returns the angle of the rotation between two whose quaternions are a chord apart, at most pi.
pub(super) fn angle_of_chord(chord: f64) -> f64 {
    (4.0 * (0.5 * chord).min(1.0).asin()).min(std::f64::consts::PI)
}

#[cfg(test)]
mod tests {
    use glam::DQuat;

    use super::rotation_separation;
    use crate::rotations::test_groups::{icosahedral, octahedral};
    use crate::{Purpose, RotationPattern, Streams};

    fn definition(rotations: &[DQuat]) -> f64 {
        let mut largest = 0.0_f64;
        for (i, p) in rotations.iter().enumerate() {
            largest = rotations[..i].iter().fold(largest, |max, q| max.max(p.dot(*q).abs()));
        }
        2.0 * largest.min(1.0).acos()
    }

    fn of(rotations: &[DQuat]) -> f64 {
        rotation_separation(rotations, &()).unwrap().unwrap()
    }

    #[test]
    fn it_matches_all_pairs() {
        let mut rng = Streams::new(5, Purpose::Pattern, 0).realization(0);
        for n in [2, 3, 10, 300] {
            let set = RotationPattern::Uniform.build(n).unwrap().sample(&mut rng).unwrap().points;
            let mut signs = set.clone();
            signs.iter_mut().step_by(2).for_each(|q| *q = -*q);
            let expected = definition(&set);
            for set in [&set, &signs] {
                // The definition loses half of the digits of small angles.
                assert!((of(set) - expected).abs() < 1e-7, "{n}: {} and {expected}", of(set));
            }
            let mut repeated = set;
            repeated.push(-repeated[1]);
            assert!(of(&repeated) <= 0.0);
        }
        assert_eq!(rotation_separation(&[DQuat::IDENTITY], &()), Ok(None));
        assert!(of(&vec![DQuat::IDENTITY; 3000]) <= 0.0);
        let tiny = [DQuat::IDENTITY, DQuat::from_rotation_x(1e-12)];
        assert!((of(&tiny) / 1e-12 - 1.0).abs() < 1e-12, "{}", of(&tiny));
    }

    /// The least turns of the groups: quarters about the axes of the cube, fifths about those of the
    /// icosahedron.
    #[test]
    fn groups() {
        assert!((of(&octahedral()).to_degrees() - 90.0).abs() < 1e-12);
        assert!((of(&icosahedral()).to_degrees() - 72.0).abs() < 1e-12);
    }
}
