use glam::DVec3;

use crate::Directions;

/// From 30 degrees above the equator, so that pole and equator are both in sight.
pub(crate) const VIEWPOINT: DVec3 = DVec3::new(0.75, 0.433_012_701_892_219_3, 0.5);
/// From 60 degrees above the equator, where most of the upper half is in sight.
pub(crate) const VIEWPOINT_ABOVE: DVec3 =
    DVec3::new(0.433_012_701_892_219_3, 0.25, 0.866_025_403_784_438_6);

/// Directions of a sphere as a panel.
pub(crate) fn sphere_points(points: Vec<DVec3>) -> Directions {
    Directions { points, viewpoint: VIEWPOINT, lines: Vec::new() }
}

/// Directions of the upper half as a panel, with the equator.
pub(crate) fn hemisphere_points(points: Vec<DVec3>) -> Directions {
    const STEPS: u32 = 180;
    let equator = (0..=STEPS).map(|k| {
        let (sin, cos) = (std::f64::consts::TAU * f64::from(k) / f64::from(STEPS)).sin_cos();
        DVec3::new(cos, sin, 0.0)
    });
    Directions { points, viewpoint: VIEWPOINT_ABOVE, lines: vec![equator.collect()] }
}

/// Returns the axes of a picture of the sphere from a viewpoint off the z axis: right, up, towards
/// the viewer.
pub(crate) fn view_axes(viewpoint: DVec3) -> [DVec3; 3] {
    let towards = viewpoint.normalize();
    let right = DVec3::Z.cross(towards).normalize();
    [right, towards.cross(right), towards]
}
