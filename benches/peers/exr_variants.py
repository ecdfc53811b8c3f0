"""Writes the small EXR files of unusual layouts that the tests of `files/image` read.

Run with OpenEXR 3.3 or later; the argument is the folder `crates/cli/tests/data`.
"""

import sys
from pathlib import Path

import numpy as np
import OpenEXR

folder = Path(sys.argv[1])
WIDTH, HEIGHT = 8, 4
# 0, 1, 2, ... row by row.
ramp = np.arange(WIDTH * HEIGHT, dtype=np.float32).reshape(HEIGHT, WIDTH)


def header(compression=OpenEXR.ZIP_COMPRESSION):
    return {"compression": compression, "type": OpenEXR.scanlineimage}


def write(name, channels, **options):
    OpenEXR.File(header(**options), channels).write(str(folder / name))


write("grey_half.exr", {"Y": ramp.astype(np.float16)}, compression=OpenEXR.PIZ_COMPRESSION)
write("depth_uint.exr", {"Z": (ramp * 1000).astype(np.uint32)})
colours = {f"diffuse.{c}": ramp * k for k, c in enumerate("RGB", 1)}
write("layers.exr", {**colours, "specular.Y": ramp + 100, "mask": ramp * 0 + 1})
parts = [
    OpenEXR.Part({**header(), "name": "sky"}, {c: ramp for c in "RGB"}, "sky"),
    OpenEXR.Part({**header(), "name": "sun"}, {c: ramp + 50 for c in "RGB"}, "sun"),
]
OpenEXR.File(parts).write(str(folder / "parts.exr"))
