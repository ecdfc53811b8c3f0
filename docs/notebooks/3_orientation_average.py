# %% [markdown]
# # Orientation averages to a tolerance
#
# The intensity that a suspension of particles scatters is the mean over all orientations of the intensity of one. How many
# orientations does a relative error of 1e-4 take, and how is the error known? The particle here is a box of 4 x 8 x 16 nm.

# %%
import time

import matplotlib.pyplot as plt
import numpy as np
from scipy.integrate import lebedev_rule

import sphvar

# %% [markdown]
# The intensity depends on the direction of the scattering vector in the frame of the particle: the squared form factor of a box. The
# larger the wavenumber q, the more it oscillates over the sphere.

# %%
SIDES = np.array([4.0, 8.0, 16.0])


def intensity(q):
    def of_direction(d):
        return np.prod(np.sinc(q / (2 * np.pi) * d * SIDES), axis=1) ** 2

    return of_direction


# %% [markdown]
# `integrate` doubles the number of directions of 16 rotated copies until a 95 % interval is within the tolerance: about one result in
# twenty has a slightly larger error. The result is an integral over the sphere, 4 pi times the mean.

# %%
result = sphvar.integrate(intensity(0.5), rtol=1e-4)
result

# %%
wavenumbers = np.geomspace(0.05, 3, 20)
start = time.perf_counter()
results = [sphvar.integrate(intensity(q), rtol=1e-4) for q in wavenumbers]
seconds = time.perf_counter() - start
means = np.array([r.value for r in results]) / (4 * np.pi)
errors = np.array([r.error for r in results]) / (4 * np.pi)
print(f"20 wavenumbers in {seconds:.2f} s")
print("largest relative error bound", f"{np.max(errors / means):.1e}")

# %% [markdown]
# The default points are a Fibonacci lattice, which exists for every N. For a smooth function, points that are exact up to a degree need
# fewer evaluations:

# %%
rules = [sphvar.integrate(intensity(q), rtol=1e-4, sampler="lebedev") for q in wavenumbers]
print("evaluations in all:", sum(r.evaluations for r in results), "fibonacci,", sum(r.evaluations for r in rules), "lebedev")

# %% [markdown]
# ## Beside a loop over Lebedev rules
#
# The customary loop takes the next Lebedev rule until two agree to the tolerance. Two rules can agree by chance, and the loop ends
# with the largest rule that scipy has, of 5810 points. The reference is a product rule on an octant, which the symmetry of the box
# allows.

# %%
ORDERS = [3, 5, 7, 9, 11, 13, 15, 17, 19, 21, 23, 25, 27, 29, 31, 35, 41, 47, 53, 59, 65, 71, 77, 83, 89, 95, 101, 107, 113, 119, 125, 131]


def lebedev_loop(f, tolerance):
    previous, used = None, 0
    for order in ORDERS:
        x, w = lebedev_rule(order)
        value, used = w @ f(x.T), used + len(w)
        if previous is not None and abs(value - previous) <= tolerance * abs(value):
            return value, used
        previous = value
    return value, used


loops = [lebedev_loop(intensity(q), 1e-4) for q in wavenumbers]
x, w = np.polynomial.legendre.leggauss(80)
z, phi = np.meshgrid((x + 1) / 2, (x + 1) * np.pi / 4, indexing="ij")
octant = np.stack([np.sqrt(1 - z**2) * np.cos(phi), np.sqrt(1 - z**2) * np.sin(phi), z], axis=-1).reshape(-1, 3)
reference = np.array([np.pi * np.outer(w, w).ravel() @ intensity(q)(octant) for q in wavenumbers])
series = {
    "integrate, fibonacci": ([r.value for r in results], [r.evaluations for r in results]),
    "integrate, lebedev": ([r.value for r in rules], [r.evaluations for r in rules]),
    "loop over Lebedev rules": tuple(zip(*loops)),
}
deviations = {label: np.abs(np.array(values) / reference - 1) for label, (values, _) in series.items()}
for label, error in deviations.items():
    print(f"{label:24} largest error {error.max():.0e}; {np.sum(error > 1e-4)} of 20 above the tolerance")

# %%
figure, (left, middle, right) = plt.subplots(1, 3, figsize=(11, 3.2))
left.loglog(wavenumbers, means, color="black")
left.set(xlabel="q (1/nm)", ylabel="mean intensity")
for label, (_, counts) in series.items():
    middle.loglog(wavenumbers, np.maximum(deviations[label], 1e-12), "o-", markersize=3, label=label)
    right.loglog(wavenumbers, counts, "o-", markersize=3, label=label)
middle.axhline(1e-4, color="grey", linewidth=0.8)
middle.set(xlabel="q (1/nm)", ylabel="relative error")
right.legend(fontsize=8)
right.set(xlabel="q (1/nm)", ylabel="evaluations")
figure.tight_layout()

# %% [markdown]
# The loop has the fewest evaluations, but no error: nothing marks the result that is beyond the tolerance. `integrate` pays for the copies
# from which its interval follows.
#
# ## One fixed set of orientations for all wavenumbers
#
# A simulation needs the directions beforehand. Which set, and how large, for the wavenumbers up to q = 1?

# %%
sphvar.choose(["lebedev", "design", "fibonacci", "healpix", "white-noise"], integrand=intensity(1.0), error="0.01%")
