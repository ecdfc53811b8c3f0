use std::f64::consts::PI;

use glam::{DQuat, DVec3, DVec4};

use super::quaternion_tree::QuaternionTree;
use super::rotation_separation::angle_of_chord;
use super::voronoi_cell::VoronoiCell;
use crate::{Progress, Stopped};

/// Rotations nearer than this, half their angle in radians, share a cell.
const COINCIDENT: f64 = 1e-9;

/// Returns the covering radius of rotations, or dispersion: the largest angle in radians, at most pi, from
/// a rotation to the nearest one of the set. It is pi for up to three rotations, since one with the
/// quaternion orthogonal to theirs differs from each by a half turn.
///
/// The result is exact to about 1e-9; it comes from the farthest vertex of all cells of the Voronoi
/// tessellation, convex polyhedra in the space of Rodrigues vectors. Weights have no part in it.
///
/// # Errors
///
/// [`Stopped`] if `progress` stops the work.
///
/// # Performance
///
/// About 40 us for each rotation of a set that is spread out.
///
/// # Examples
///
/// ```
/// use std::f64::consts::PI;
/// use glam::DQuat;
/// use sphvar_samplers::rotation_covering_radius;
///
/// // The half turns about the axes and the identity: a third of a turn about a diagonal is farthest.
/// let half_turns = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
/// let mut group: Vec<DQuat> = half_turns.map(DQuat::from_array).to_vec();
/// group.push(DQuat::IDENTITY);
/// let radius = rotation_covering_radius(&group, &())?;
/// assert!((radius - 2.0 * PI / 3.0).abs() < 1e-9);
/// # Ok::<(), sphvar_samplers::Stopped>(())
/// ```
///
/// # References
///
/// F. C. Frank, "Orientation mapping", Metallurgical Transactions A 19, 1988 (planes in the space of
/// Rodrigues vectors).
pub fn rotation_covering_radius(
    rotations: &[DQuat],
    progress: &dyn Progress,
) -> Result<f64, Stopped> {
    let tree = QuaternionTree::new(rotations);
    // About the distance of neighbours on the unit quaternions, whose volume is 2 pi^2.
    let spacing = (PI * PI / rotations.len().max(1) as f64).cbrt();
    let mut largest: f64 = if rotations.is_empty() { PI } else { 0.0 };
    for (i, &centre) in rotations.iter().enumerate() {
        if i.is_multiple_of(256) {
            progress.tick(0.0)?;
        }
        if largest >= PI {
            break;
        }
        largest = largest.max(cell(&tree, centre, spacing).radius());
    }
    Ok(largest)
}

/// Returns the Voronoi cell of a rotation of the tree.
fn cell(tree: &QuaternionTree, centre: DQuat, spacing: f64) -> VoronoiCell {
    let mut cell = VoronoiCell::whole();
    let (mut done, mut reach) = (0.0, 2.0 * spacing);
    let mut near: Vec<(f64, DVec4)> = Vec::new();
    loop {
        near.clear();
        tree.visit(DVec4::from(centre), &mut (reach * reach), &mut |q, _, squared, _| {
            if squared >= done {
                near.push((squared, q));
            }
        });
        near.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        for &(squared, q) in &near {
            // Another rotation cuts the cell only if it is nearer than twice the radius.
            if angle_of_chord(squared.sqrt()) <= 2.0 * cell.radius() {
                cut(&mut cell, centre.conjugate() * DQuat::from_vec4(q));
            }
        }
        let enough = 2.0 * (0.5 * cell.radius()).sin();
        if reach > enough || reach > 2.0 {
            return cell;
        }
        done = reach * reach;
        reach *= 1.5;
    }
}

/// Cuts off what is nearer to a rotation than to the centre of the cell.
fn cut(cell: &mut VoronoiCell, relative: DQuat) {
    let vector = DVec3::new(relative.x, relative.y, relative.z);
    let length = vector.length();
    if length < COINCIDENT {
        return;
    }
    // (1 - w)/|v|, the tangent of a fourth of the angle, without cancellation.
    let offset =
        if relative.w > 0.0 { length / (1.0 + relative.w) } else { (1.0 - relative.w) / length };
    cell.cut(vector / length, offset);
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use glam::DQuat;

    use super::rotation_covering_radius;
    use crate::ensemble::uniform_quaternion;
    use crate::rotations::test_groups::{icosahedral, octahedral, product, tetrahedral};
    use crate::{Purpose, RotationPattern, Streams};

    fn of(rotations: &[DQuat]) -> f64 {
        rotation_covering_radius(rotations, &()).unwrap()
    }

    fn nearest(rotations: &[DQuat], to: DQuat) -> f64 {
        2.0 * rotations.iter().fold(0.0, |max: f64, q| max.max(q.dot(to).abs())).min(1.0).acos()
    }

    /// The radii of Karney 2007 (the sets c48u1 and c600v): 62.80 and 44.48 degrees. The deep holes
    /// are `cos(radius/2) = (2 + sqrt 2)/4` and `(golden ratio)^2/sqrt 8`; of the 24-cell, 1/sqrt 2.
    #[test]
    fn groups() {
        let golden = 0.5 + 1.25f64.sqrt();
        for (group, cosine, published) in [
            (tetrahedral(), 0.5f64.sqrt(), 90.0),
            (octahedral(), (2.0 + 2f64.sqrt()) / 4.0, 62.80),
            (icosahedral(), golden * golden / 8f64.sqrt(), 44.48),
        ] {
            let expected = 2.0 * cosine.acos();
            assert!((expected.to_degrees() - published).abs() < 0.005);
            assert!((of(&group) - expected).abs() < 1e-9, "{}", of(&group).to_degrees());
            // Any signs, and a copy of an element, near or exact.
            let mut set: Vec<DQuat> = group.iter().map(|q| -*q).collect();
            set.push(group[3]);
            set.push((group[5] * DQuat::from_rotation_x(1e-10)).normalize());
            assert!((of(&set) - expected).abs() < 1e-8);
        }
    }

    /// Vertices of Voronoi cells are equidistant from four quaternions: the definition, among all
    /// solutions for q and -q.
    fn definition(rotations: &[DQuat]) -> f64 {
        use glam::{DMat3, DVec3};
        let mut largest = 0.0_f64;
        for (i, p) in rotations.iter().enumerate() {
            let relative = |q: &DQuat| {
                let r = p.conjugate() * *q;
                [r, -r]
            };
            let others: Vec<DQuat> = rotations
                .iter()
                .enumerate()
                .filter(|(j, _)| *j != i)
                .flat_map(|(_, q)| relative(q))
                .collect();
            for (a, x) in others.iter().enumerate() {
                for (b, y) in others.iter().enumerate().skip(a + 1) {
                    for z in &others[b + 1..] {
                        let rows = DMat3::from_cols(x.xyz(), y.xyz(), z.xyz()).transpose();
                        if rows.determinant().abs() < 1e-9 {
                            continue;
                        }
                        let t = rows.inverse() * DVec3::new(1.0 - x.w, 1.0 - y.w, 1.0 - z.w);
                        let q = *p * DQuat::from_xyzw(t.x, t.y, t.z, 1.0).normalize();
                        let to_p = 2.0 * p.dot(q).abs().min(1.0).acos();
                        if nearest(rotations, q) > to_p - 1e-9 {
                            largest = largest.max(to_p);
                        }
                    }
                }
            }
        }
        largest
    }

    #[test]
    fn it_matches_the_definition() {
        let mut rng = Streams::new(6, Purpose::Pattern, 0).realization(0);
        for n in [4, 5, 7, 12] {
            for _ in 0..4 {
                let set = RotationPattern::Uniform.build(n).unwrap().sample(&mut rng).unwrap();
                let (got, expected) = (of(&set.points), definition(&set.points));
                assert!((got - expected).abs() < 1e-6, "{n}: {got} and {expected}");
            }
        }
        for n in [0, 1, 2, 3] {
            let set: Vec<DQuat> = (0..n).map(|_| uniform_quaternion(&mut rng)).collect();
            assert!((of(&set) - PI).abs() < 1e-5, "{n}: {}", of(&set));
        }
        assert!((of(&vec![DQuat::IDENTITY; 100]) - PI).abs() <= 0.0);
    }

    /// No random rotation is farther from the set, the farthest of many is nearly as far, and neither
    /// a product from the left nor from the right changes the radius.
    #[test]
    fn it_bounds_the_distance_of_every_rotation() {
        let mut rng = Streams::new(7, Purpose::Pattern, 0).realization(0);
        let clustered: Vec<DQuat> = (0..40)
            .map(|k| DQuat::from_rotation_x(0.01 * f64::from(k)) * DQuat::from_rotation_y(0.3))
            .collect();
        let of_pattern = |text: &str, n| {
            let pattern: RotationPattern = text.parse().unwrap();
            let mut rng = Streams::new(8, Purpose::Pattern, 0).realization(0);
            pattern.build(n).unwrap().sample(&mut rng).unwrap().points
        };
        for set in [
            clustered,
            of_pattern("uniform", 100),
            of_pattern("super-fibonacci", 150),
            of_pattern("sukharev", 36),
            of_pattern("healpix-hopf", 72),
        ] {
            let radius = of(&set);
            let many = (0..3000).map(|_| nearest(&set, uniform_quaternion(&mut rng)));
            let farthest = many.fold(0.0, f64::max);
            assert!(farthest <= radius + 1e-9 && farthest > 0.75 * radius, "{farthest}, {radius}");
            let by = uniform_quaternion(&mut rng);
            for moved in [product(&[by], &set), product(&set, &[by])] {
                assert!((of(&moved) - radius).abs() < 1e-8, "{} and {radius}", of(&moved));
            }
        }
    }
}
