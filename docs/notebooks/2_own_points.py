# %% [markdown]
# # Your own point set, ranked
#
# Any array of shape (N, 3) is a sampler wherever a name of a pattern is. Here is a set of our own: directions that repel each other
# as electrons do, found by gradient descent from random directions in a few lines of numpy.

# %%
import matplotlib.pyplot as plt
import numpy as np

import sphvar

# %%
N = 192


def repelled(seed, steps=300):
    points = sphvar.Sampler("white-noise", N, seed=seed).random()[0]
    for step in range(steps):
        difference = points[:, None] - points[None]
        distance = np.linalg.norm(difference, axis=2) + np.eye(N)
        force = np.sum(difference / distance[:, :, None] ** 3, axis=1)
        force -= np.sum(force * points, axis=1, keepdims=True) * points
        points = points + 0.3 / N * (1 - step / steps) * force
        points /= np.linalg.norm(points, axis=1, keepdims=True)
    return points


mine = repelled(0)

# %% [markdown]
# ## How evenly are the points distributed?
#
# `quality` measures distances, discrepancies and energies; a sampler and an array stand side by side.

# %%
quality = sphvar.quality({"mine": mine, "fibonacci": "fibonacci", "white-noise": "white-noise"}, n=N)
quality

# %% [markdown]
# ## What error does it have?
#
# The ranking for two integrands: a smooth lobe, and a cap, which has a jump at its edge.

# %%
samplers = {"mine": mine, "white-noise": "white-noise", "jittered": "jittered", "fibonacci": "fibonacci", "healpix": "healpix"}
for integrand in ("vmf:kappa=20", "cap:degrees=60"):
    table = sphvar.compare(samplers, n=N, integrand=integrand, realizations=1000)
    print(integrand)
    for row in sorted(table.rows, key=lambda row: row["predicted"]):
        print(f"  {row['sampler']:12} predicted {row['predicted']:.3g}, measured {row['measured']:.3g}")

# %% [markdown]
# ## Several sets, and the spectrum of the process that makes them
#
# An array of shape (M, N, 3) holds M realizations. Their mean spectrum has standard errors.

# %%
sets = np.stack([repelled(seed) for seed in range(6)])
figure, axes = plt.subplots(figsize=(6, 3.5))
for label, source in {"mine": sets, "fibonacci": "fibonacci", "jittered": "jittered"}.items():
    options = {} if label == "mine" else {"n": N}
    spectrum = sphvar.spectrum(source, lmax=40, **options)
    axes.semilogy(spectrum.l[1:], np.maximum(spectrum.power[1:], 1e-5), label=label)
axes.axhline(1, color="grey", linewidth=0.8)
axes.set(xlabel="degree l", ylabel="power", ylim=(1e-5, 10))
axes.legend();

# %% [markdown]
# ## May the set keep its orientation?
#
# The predictions above are for random rotations of the set. `audit` tests whether an ensemble needs them; jittered points as drawn do.

# %%
sphvar.audit("jittered", n=48, realizations=2000, lmax=4)
