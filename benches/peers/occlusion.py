"""Times occlusion rays on a height field of a million triangles beside Embree, on one thread.

Usage: python3 benches/peers/occlusion.py [--venv FOLDER]

Embree is that of the package embreex, in a virtual environment made for it outside the repository, which traces rays one by
one. The field, the camera and the kinds of hit points are those of crates/scene/benches/occlusion.rs; directions are
other ones of the same kind, uniform over the visible hemisphere, 256 at a hit point. The times of sphvar-scene are those
that its bench records, which is run first. Medians; all numbers are single precision on both sides.
"""

import argparse
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = ["embreex==4.4.*", "numpy"]
SQUARES = 708
N_DIRECTIONS = 256
N_RAYS = 1 << 16
REPEATS = 15
SIZE = 512
# Rays start this far above the surface, as the crate's do.
CLEARANCE = 2.0**-21


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--venv", type=Path, default=Path(tempfile.gettempdir()) / "sphvar-embree")
    parser.add_argument("--inside", action="store_true", help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.inside:
        time_embree()
        return
    python = arguments.venv / "bin" / "python"
    if not python.exists():
        subprocess.run([sys.executable, "-m", "venv", arguments.venv], check=True)
        subprocess.run([python, "-m", "pip", "install", "--quiet", *PACKAGES], check=True)
    bench = ["cargo", "bench", "-p", "sphvar-scene", "--bench", "occlusion", "--", f"field.*/{N_DIRECTIONS}"]
    subprocess.run(bench, cwd=ROOT, check=True, stdout=subprocess.DEVNULL)
    answer = subprocess.run([python, __file__, "--inside"], check=True, capture_output=True, text=True).stdout
    print(f"{'':12} {'Embree':>8} {'sphvar':>8} {'alone':>8}   Mray/s; alone: each ray by itself in sphvar's hierarchy")
    for group, rate in json.loads(answer).items():
        ours, alone = recorded(group, "endless"), recorded(group, "hierarchy")
        print(f"{group:12} {rate:8.2f} {ours:8.2f} {alone:8.2f}   sphvar/Embree {ours / rate:.2f}")


def recorded(group, what):
    """Million rays a second that the bench has found."""
    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    estimates = target / "criterion" / group / what / str(N_DIRECTIONS) / "new" / "estimates.json"
    return N_RAYS / json.loads(estimates.read_text())["median"]["point_estimate"] * 1e3


def time_embree():
    import numpy as np
    from embreex import rtcore_scene
    from embreex.mesh_construction import TriangleMesh

    rng = np.random.default_rng(1)
    place = np.arange(SQUARES + 1) / SQUARES
    y, x = np.meshgrid(place, place, indexing="ij")
    z = np.zeros_like(x)
    for octave in range(6):
        f = 7.0 * 2**octave
        z += 0.6 / f * np.sin(f * x + y) * np.cos(f * y - 2.0 * x)
    vertices = np.stack([x, y, z], axis=-1).reshape(-1, 3).astype(np.float32)
    k = (np.arange(SQUARES)[:, None] * (SQUARES + 1) + np.arange(SQUARES)).reshape(-1)
    above = k + SQUARES + 1
    faces = np.concatenate([np.stack([k, k + 1, above], -1), np.stack([k + 1, above + 1, above], -1)]).astype(np.int32)
    scene = rtcore_scene.EmbreeScene()
    TriangleMesh(scene, vertices, faces)

    position, target = np.array([0.5, -0.7, 1.0]), np.array([0.5, 0.45, 0.0])
    forward = (target - position) / np.linalg.norm(target - position)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right *= np.tan(0.4) / np.linalg.norm(right)
    up = np.cross(right, forward)

    def hits(px, py):
        """Points above the surface and normals there, of the pixels that show it."""
        a, b = 2.0 * px / SIZE - 1.0, 1.0 - 2.0 * py / SIZE
        dirs = forward + a[:, None] * right + b[:, None] * up
        dirs /= np.linalg.norm(dirs, axis=1)[:, None]
        origins = np.broadcast_to(position, dirs.shape).astype(np.float32)
        found = scene.run(origins, dirs.astype(np.float32), output=True)
        met = found["primID"] >= 0
        corners = vertices[faces[found["primID"][met]]].astype(float)
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        normals /= np.linalg.norm(normals, axis=1)[:, None]
        normals *= -np.sign(np.sum(normals * dirs[met], axis=1))[:, None]
        points = position + found["tfar"][met, None] * dirs[met]
        return points + CLEARANCE * normals, normals

    pixel = np.arange(4 * N_RAYS // N_DIRECTIONS)
    kinds = {
        "field": (rng.random(pixel.size) * SIZE, rng.random(pixel.size) * SIZE),
        "field-rows": (224.0 + pixel % 64, 256.0 + pixel // 64 % 256),
    }
    rates = {}
    for group, (px, py) in kinds.items():
        points, normals = (a[: N_RAYS // N_DIRECTIONS] for a in hits(px, py))
        dirs = rng.normal(size=(len(points), N_DIRECTIONS, 3))
        dirs /= np.linalg.norm(dirs, axis=2)[..., None]
        dirs *= np.where(np.sum(dirs * normals[:, None], axis=2) < 0.0, -1.0, 1.0)[..., None]
        origins = np.repeat(points, N_DIRECTIONS, axis=0).astype(np.float32)
        dirs = dirs.reshape(-1, 3).astype(np.float32)
        times = []
        for _ in range(REPEATS):
            start = time.perf_counter()
            scene.run(origins, dirs, query="OCCLUDED")
            times.append(time.perf_counter() - start)
        rates[group] = len(dirs) / statistics.median(times) * 1e-6
    print(json.dumps(rates))


if __name__ == "__main__":
    main()
