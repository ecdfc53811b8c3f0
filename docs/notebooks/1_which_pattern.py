# %% [markdown]
# # Which pattern for my integrand?
#
# A renderer, a detector or a molecule is integrated over directions with N samples. Which N directions have the least error? It
# depends on the integrand. Here it is a function of our own, and `sphvar` predicts the error of each pattern from two spectra: the
# power of the pattern and the energy of the integrand at each degree.

# %%
import matplotlib.pyplot as plt
import numpy as np

import sphvar

# %% [markdown]
# The integrand is the radiance of a simple sky: a glow around the sun, a gradient towards the zenith, and a dark ground. It takes an
# array of directions, shape (n, 3), and returns n values. It is continuous, with a kink at the horizon.

# %%
SUN = np.array([0.6, 0.0, 0.8])


def radiance(d):
    glow = 3 * np.exp(25 * (d @ SUN - 1))
    sky = 0.2 + 0.8 * np.clip(d[:, 2], 0, None)
    return glow + sky


# %% [markdown]
# ## Rank the patterns for 500 directions

# %%
samplers = ["white-noise", "jittered", "poisson-disk", "healpix", "fibonacci", "spiral", "lebedev", "design"]
ranking = sphvar.choose(samplers, integrand=radiance, n=500)
ranking

# %% [markdown]
# Errors are standard errors over random orientations, relative to the integral. The first rows are a spherical design, a lattice
# and a quadrature rule; independent random directions (`white-noise`) are last. The package measures no errors here: it predicts them.
#
# ## Why
#
# The variance is a sum over degrees of the power of the pattern times the energy of the integrand. White noise has power 1 at every
# degree; the others have little power at low degrees, where most energy of the integrand is. The kink at the horizon, which is the
# equator, has energy at even degrees only beyond degree 20.

# %%
patterns = ["white-noise", "jittered", "poisson-disk", "fibonacci"]
figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.2))
for pattern in patterns:
    spectrum = sphvar.spectrum(pattern, n=432, realizations=20, lmax=60)
    left.plot(spectrum.l[1:], np.maximum(spectrum.power[1:], 1e-6), label=pattern)
left.set(xlabel="degree l", ylabel="power of the pattern", yscale="log", ylim=(1e-6, 10))
left.legend()
right.semilogy(np.arange(1, 61), sphvar.energies(radiance, 60)[1:], ".", color="black")
right.set(xlabel="degree l", ylabel="energy of the integrand", ylim=(1e-9, 10))
figure.tight_layout()

# %% [markdown]
# ## Do measured errors agree?
#
# `compare` predicts the variance and measures it on independent realizations. `z` is the difference in standard errors.

# %%
table = sphvar.compare(patterns, n=[48, 108, 192, 432, 768], integrand=radiance, realizations=200)
z = table.z
print(f"{len(z)} cells; largest |z| {np.nanmax(np.abs(z)):.1f}; {np.sum(np.abs(z) < 3)} below 3")

# %%
axes = table.plot()
axes.figure.set_size_inches(6, 4)

# %% [markdown]
# ## How many directions does an error of 1 % need?

# %%
sphvar.choose(["white-noise", "jittered", "fibonacci", "lebedev"], integrand=radiance, error="1%")
