use glam::{DVec3, Vec3};
use pulp::Simd;

/// Directions that are laid out together: a multiple of the lanes of every instruction set.
pub(crate) const BUNDLE: usize = 64;

/// Up to [`BUNDLE`] rays with a common origin, component by component.
pub(crate) struct Bundle {
    dirs: [[f32; BUNDLE]; 3],
    reaches: [f32; BUNDLE],
}

/// As many rays of a bundle as the processor treats at once.
#[derive(Clone, Copy)]
pub(crate) struct Rays<S: Simd> {
    pub(crate) dirs: [S::f32s; 3],
    /// How far they reach; negative for those that need no answer.
    pub(crate) reaches: S::f32s,
}

impl Bundle {
    pub(crate) fn new() -> Self {
        Self { dirs: [[0.0; BUNDLE]; 3], reaches: [0.0; BUNDLE] }
    }

    /// Replaces the rays, by at most [`BUNDLE`] directions with their reach.
    #[inline(always)]
    #[expect(clippy::cast_possible_truncation, reason = "f32 is accurate enough")]
    pub(crate) fn fill(&mut self, rays: impl ExactSizeIterator<Item = (DVec3, f64)>) {
        let len = rays.len();
        let [x, y, z] = &mut self.dirs;
        for (i, (dir, reach)) in rays.enumerate() {
            let dir = dir.as_vec3();
            (x[i], y[i], z[i]) = (dir.x, dir.y, dir.z);
            // NaN gives 0.
            self.reaches[i] = reach.max(0.0) as f32;
        }
        self.reaches[len..].fill(-1.0);
    }

    /// The rays of vector `v`; those below the horizon of `normal` need no answer.
    #[inline(always)]
    pub(crate) fn rays<S: Simd>(&self, simd: S, v: usize, normal: Vec3) -> Rays<S> {
        let dirs = self.dirs.each_ref().map(|lane| S::as_simd_f32s(lane).0[v]);
        let rays = Rays { dirs, reaches: S::as_simd_f32s(&self.reaches).0[v] };
        let below = simd.less_than_f32s(dot(simd, &dirs, normal), simd.splat_f32s(0.0));
        rays.without(simd, below)
    }
}

impl<S: Simd> Rays<S> {
    /// These rays, those of the mask marked as answered.
    #[inline(always)]
    pub(crate) fn without(self, simd: S, mask: S::m32s) -> Self {
        let reaches = simd.select_f32s(mask, simd.splat_f32s(-1.0), self.reaches);
        Self { reaches, ..self }
    }

    /// Sets `occluded[i]` if ray i has been answered.
    #[inline(always)]
    pub(crate) fn report(&self, occluded: &mut [bool]) {
        let reaches = pulp::bytemuck::cast_slice::<_, f32>(std::slice::from_ref(&self.reaches));
        for (occluded, &reach) in occluded.iter_mut().zip(reaches) {
            *occluded |= reach < 0.0;
        }
    }

    #[inline(always)]
    pub(crate) fn all_answered(&self, simd: S) -> bool {
        let open = simd.greater_than_or_equal_f32s(self.reaches, simd.splat_f32s(0.0));
        simd.first_true_m32s(open) == S::F32_LANES
    }
}

/// The dot product of each direction with `v`.
#[inline(always)]
pub(crate) fn dot<S: Simd>(simd: S, dirs: &[S::f32s; 3], v: Vec3) -> S::f32s {
    let xs = simd.mul_f32s(dirs[0], simd.splat_f32s(v.x));
    let xys = simd.mul_add_e_f32s(dirs[1], simd.splat_f32s(v.y), xs);
    simd.mul_add_e_f32s(dirs[2], simd.splat_f32s(v.z), xys)
}
