use glam::{DVec3, Vec3};
use pulp::Simd;

/// Up to `N` rays with a common origin, stored by component; `N` is a multiple of the SIMD lanes of
/// every instruction set.
pub(crate) struct Bundle<const N: usize> {
    dirs: [[f32; N]; 3],
    reaches: [f32; N],
}

/// One SIMD vector of rays of a bundle.
#[derive(Clone, Copy)]
pub(crate) struct Rays<S: Simd> {
    pub(crate) dirs: [S::f32s; 3],
    /// The reach of each ray; negative for rays that are already decided.
    pub(crate) reaches: S::f32s,
}

impl<const N: usize> Bundle<N> {
    pub(crate) fn new() -> Self {
        Self { dirs: [[0.0; N]; 3], reaches: [0.0; N] }
    }

    /// Replaces the rays by at most `N` directions with their reach.
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

    /// Marks the rays below the horizon of `normal` as decided.
    #[inline(always)]
    pub(crate) fn decide_below<S: Simd>(&mut self, simd: S, normal: Vec3) {
        for v in 0..N / S::F32_LANES {
            let rays = self.rays::<S>(v);
            let below =
                simd.less_than_f32s(dot(simd, &rays.dirs, normal, 0.0), simd.splat_f32s(0.0));
            self.set(v, rays.without(simd, below));
        }
    }

    /// Returns the rays of vector `v`.
    #[inline(always)]
    pub(crate) fn rays<S: Simd>(&self, v: usize) -> Rays<S> {
        let dirs = self.dirs.each_ref().map(|lane| S::as_simd_f32s(lane).0[v]);
        Rays { dirs, reaches: S::as_simd_f32s(&self.reaches).0[v] }
    }

    /// Stores which of the rays of vector `v` are decided.
    #[inline(always)]
    pub(crate) fn set<S: Simd>(&mut self, v: usize, rays: Rays<S>) {
        S::as_mut_simd_f32s(&mut self.reaches).0[v] = rays.reaches;
    }

    /// Returns the reach of a ray.
    #[inline(always)]
    pub(crate) fn reach(&self, ray: usize) -> f32 {
        self.reaches[ray]
    }

    /// Returns one bit per ray that is not decided.
    #[inline(always)]
    pub(crate) fn open<const WORDS: usize>(&self) -> [u64; WORDS] {
        let mut open = [0; WORDS];
        for (word, reaches) in open.iter_mut().zip(self.reaches.chunks(64)) {
            for (i, &reach) in reaches.iter().enumerate() {
                *word |= u64::from(reach >= 0.0) << i;
            }
        }
        open
    }

    /// Marks rays as decided, one bit for each from `first` on.
    #[inline(always)]
    pub(crate) fn decide(&mut self, first: usize, mut rays: u64) {
        while rays != 0 {
            self.reaches[first + rays.trailing_zeros() as usize] = -1.0;
            rays &= rays - 1;
        }
    }

    /// Sets `occluded[i]` if ray i is decided.
    #[inline(always)]
    pub(crate) fn report(&self, occluded: &mut [bool]) {
        for (occluded, &reach) in occluded.iter_mut().zip(&self.reaches) {
            *occluded |= reach < 0.0;
        }
    }
}

impl<S: Simd> Rays<S> {
    /// Returns the rays, with those in the mask marked as decided.
    #[inline(always)]
    pub(crate) fn without(self, simd: S, mask: S::m32s) -> Self {
        let reaches = simd.select_f32s(mask, simd.splat_f32s(-1.0), self.reaches);
        Self { reaches, ..self }
    }

    #[inline(always)]
    pub(crate) fn all_decided(&self, simd: S) -> bool {
        let open = simd.greater_than_or_equal_f32s(self.reaches, simd.splat_f32s(0.0));
        simd.first_true_m32s(open) == S::F32_LANES
    }
}

/// Returns the dot product of each direction with `v`, plus `offset`.
#[inline(always)]
pub(crate) fn dot<S: Simd>(simd: S, dirs: &[S::f32s; 3], v: Vec3, offset: f32) -> S::f32s {
    let xs = simd.mul_add_e_f32s(dirs[0], simd.splat_f32s(v.x), simd.splat_f32s(offset));
    let xys = simd.mul_add_e_f32s(dirs[1], simd.splat_f32s(v.y), xs);
    simd.mul_add_e_f32s(dirs[2], simd.splat_f32s(v.z), xys)
}
