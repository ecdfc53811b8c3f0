# %% [markdown]
# # A light probe: from a photograph to N lights
#
# A panorama with a high dynamic range lights a scene from all directions. A renderer for games has a few directional lights instead.
# `lights` replaces the panorama by N of them and states the error of the irradiance.

# %%
import matplotlib.pyplot as plt
import numpy as np

import sphvar

# %% [markdown]
# The panorama is read here from a file, at the directions of a grid of longitudes and colatitudes. An array (H, W, 3) from any
# reader of pictures is used the same way.

# %%
PROBE = "../../data/city.exr"
H, W = 128, 256
theta = (np.arange(H) + 0.5) * np.pi / H
phi = (np.arange(W) + 0.5) * 2 * np.pi / W
grid = np.stack(
    [np.outer(np.sin(theta), np.cos(phi)), np.outer(np.sin(theta), np.sin(phi)), np.outer(np.cos(theta), np.ones(W))], axis=-1
)
image = np.stack(
    [sphvar.evaluate(f"env:{PROBE},channel={c}", grid.reshape(-1, 3)).reshape(H, W) for c in "rgb"], axis=-1
)
print(image.shape, f"brightest texel {image.max() / np.median(image):.0f} times the median")

# %%
result = sphvar.lights(f"env:{PROBE}", n=32)
result

# %% [markdown]
# Each light stands for the same luminance, so that there are many where the panorama is bright.

# %%
directions, colours = result.directions, result.rgb
figure, axes = plt.subplots(figsize=(6, 3))
axes.imshow(np.clip(image / np.percentile(image, 95), 0, 1) ** (1 / 2.2), extent=(0, 360, 180, 0))
axes.scatter(
    np.degrees(np.arctan2(directions[:, 1], directions[:, 0])) % 360, np.degrees(np.arccos(directions[:, 2])),
    s=40,
    c=np.clip(colours / colours.max(), 0, 1) ** (1 / 2.2),
    edgecolors="red",
)
axes.set(xlabel="longitude (degrees)", ylabel="angle from the pole (degrees)");

# %% [markdown]
# ## The error of the irradiance
#
# A surface with normal n receives the sum of the lights times the cosine. Its error, the root mean square over all normals, falls with
# the number of lights.

# %%
table = sphvar.lights(f"env:{PROBE}", n=[8, 16, 32, 64, 128, 256], samplers="ccvt:density=luminance,median-cut,white-noise")
table

# %% [markdown]
# The package's numbers can be checked by hand: the irradiance of 500 normals, from the panorama and from the lights.

# %%
normals = sphvar.Sampler("fibonacci", 500).random()[0]
area = np.repeat(np.sin(theta) * np.pi / H * 2 * np.pi / W, W)
exact = np.clip(normals @ grid.reshape(-1, 3).T, 0, None) @ (area[:, None] * image.reshape(-1, 3))
approximate = np.clip(normals @ directions.T, 0, None) @ colours
error = np.sqrt(np.mean((approximate - exact) ** 2, axis=0) / np.mean(exact**2, axis=0))
print("relative error of red, green and blue:", *(f"{100 * e:.2f} %" for e in error))
