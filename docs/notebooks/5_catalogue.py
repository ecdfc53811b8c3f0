# %% [markdown]
# # The angular spectrum of a catalogue
#
# A survey lists objects with positions on the sky. How strongly do they cluster at each angular scale? The power spectrum of the
# points answers that without pixels. Here the catalogue is made up, so that the answer is known.

# %%
import matplotlib.pyplot as plt
import numpy as np

import sphvar

# %% [markdown]
# ## A mock catalogue
#
# A Gaussian random field with the spectrum `cl` modulates the density of the objects. `alm2points` evaluates the field at random
# candidates, and each is kept with a probability that is proportional to the density.

# %%
LMAX = 64
l = np.arange(LMAX + 1)
cl = np.where(l >= 2, 0.03 / np.maximum(l, 1) ** 1.5, 0)


def field(rng):
    """Return the coefficients of a Gaussian field, in the order of healpy."""
    alm = np.zeros((LMAX + 1) * (LMAX + 2) // 2, complex)
    start = 0
    for m in range(LMAX + 1):
        scale = np.sqrt(cl[m:])
        count = LMAX + 1 - m
        real, imaginary = rng.standard_normal((2, count))
        alm[start : start + count] = scale * (real if m == 0 else (real + 1j * imaginary) / np.sqrt(2))
        start += count
    return alm


def catalogue(seed, size=20000):
    rng = np.random.default_rng(seed)
    candidates = sphvar.Sampler("white-noise", 2 * size, seed=seed).random()[0]
    density = np.clip(1 + sphvar.alm2points(field(rng), candidates), 0, 3)
    return candidates[rng.random(len(candidates)) < density / 2]


points = catalogue(0)
print(points.shape)

# %%
figure, axes = plt.subplots(figsize=(5, 2.5), subplot_kw={"projection": "mollweide"})
shown = points[::5]
axes.scatter(np.arctan2(shown[:, 1], shown[:, 0]), np.arcsin(shown[:, 2]), s=0.3, color="black")
axes.grid(alpha=0.3)
axes.set_xticklabels([]);

# %% [markdown]
# ## Its spectrum
#
# Independent points have power 1 at every degree (shot noise), and clustering adds N/(4 pi) times the spectrum of the density. The
# error of a single catalogue follows from the 2l + 1 orders of a degree.

# %%
spectrum = sphvar.spectrum(points, lmax=LMAX)
scale = 4 * np.pi / spectrum.n
estimate = (spectrum.power - 1) * scale
error = spectrum.power * scale * np.sqrt(2 / (2 * l + 1))
pull = ((estimate - cl) / error)[2:]
print(f"N = {spectrum.n}; (estimate - truth)/error: mean {pull.mean():.2f}, standard deviation {pull.std():.2f}")

# %% [markdown]
# ## Error bars from mock catalogues
#
# Forty more mocks give the error without a formula, also where the density is not Gaussian.

# %%
powers = [sphvar.spectrum(catalogue(seed), lmax=LMAX).power for seed in range(1, 41)]
spread = np.std(powers, axis=0, ddof=1) * scale
print(f"spread of mocks over the formula, mean over degrees: {np.mean(spread[2:] / error[2:]):.2f}")

# %%
figure, axes = plt.subplots(figsize=(7, 4))
axes.errorbar(l[2:], (l * estimate)[2:], (l * spread)[2:], fmt=".", linewidth=0.8, label="catalogue, errors from mocks")
axes.plot(l[2:], (l * cl)[2:], color="black", label="truth")
axes.set(xlabel="degree l", ylabel="l C_l")
axes.legend();

# %% [markdown]
# ## A mask, and weights for completeness
#
# The survey misses objects near the galactic plane, and finds fewer and fewer to the south. Objects get the inverse of their completeness as
# weight; the effective number of points is smaller, and the shot noise larger.

# %%
def completeness(d):
    return 0.65 + 0.35 * d[:, 2]


rng = np.random.default_rng(99)
found = points[rng.random(len(points)) < completeness(points)]
raw = sphvar.spectrum(found, lmax=LMAX)
weighted = sphvar.spectrum(found, weights=1 / completeness(found), lmax=LMAX)
for label, s in [("raw", raw), ("weighted", weighted)]:
    print(f"{label:9} effective N {s.n_effective:9.1f}   power of the dipole {s.power[1]:8.2f}   of the whole catalogue {spectrum.power[1]:.2f}")

# %% [markdown]
# With a mask, the mean density has power of its own. Random points with the same mask, subtracted coefficient by coefficient, remove it;
# the result is divided by the share of the sky.

# %%
def visible(d):
    return np.abs(d[:, 2]) > np.sin(np.radians(15))


data = points[visible(points)]
randoms = sphvar.Sampler("white-noise", 200000, seed=7).random()[0]
randoms = randoms[visible(randoms)]
share = visible(sphvar.Sampler("fibonacci", 100000).random()[0]).mean()
density = len(data) / (4 * np.pi * share)
alm = (sphvar.points2alm(data, LMAX) - len(data) / len(randoms) * sphvar.points2alm(randoms, LMAX)) / density
power = np.zeros(LMAX + 1)
start = 0
for m in range(LMAX + 1):
    power[m:] += (1 if m == 0 else 2) * np.abs(alm[start : start + LMAX + 1 - m]) ** 2
    start += LMAX + 1 - m
noise = share / density * (1 + len(data) / len(randoms))
masked = (power / (2 * l + 1) - noise) / share
pull = ((masked - cl) / (spread / np.sqrt(share)))[2:]
print(f"share of the sky {share:.3f}; (masked - truth)/error: mean {pull.mean():.2f}, standard deviation {pull.std():.2f}")

# %%
figure, axes = plt.subplots(figsize=(7, 3.5))
axes.plot(l[2:], (l * masked)[2:], ".", label="15 degrees around the plane masked")
axes.plot(l[2:], (l * estimate)[2:], ".", markersize=3, label="whole sky")
axes.plot(l[2:], (l * cl)[2:], color="black", label="truth")
axes.set(xlabel="degree l", ylabel="l C_l")
axes.legend();
