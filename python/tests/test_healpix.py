"""HEALPix functions: agreement with healpy, shapes, types, errors."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sphvar import healpix

healpy = pytest.importorskip("healpy")

NSIDES = [1, 2, 3, 7, 64, 100, 1024, 2**20, 2**29]


def random_vectors(n: int = 20_000) -> np.ndarray:
    return np.random.default_rng(5).normal(size=(3, n))


def is_power_of_two(nside: int) -> bool:
    return nside & (nside - 1) == 0


@pytest.mark.parametrize("nside", NSIDES)
@pytest.mark.parametrize("nest", [False, True])
def test_pixels_are_those_of_healpy(nside: int, nest: bool) -> None:
    if nest and not is_power_of_two(nside):
        with pytest.raises(ValueError, match="power of two"):
            healpix.vec2pix(nside, 0, 0, 1, nest=True)
        return
    x, y, z = random_vectors()
    pixels = healpix.vec2pix(nside, x, y, z, nest)
    assert pixels.dtype == np.int64
    expected = healpy.vec2pix(nside, x, y, z, nest)
    # At the largest resolutions both round directions to pixels of 1e-9 rad.
    assert (pixels != expected).mean() <= (0 if nside <= 1024 else 1e-3)
    assert (pixels >= 0).all() and (pixels < 12 * nside**2).all()

    theta, phi = healpy.vec2ang(np.stack([x, y, z], axis=1))
    found = healpix.ang2pix(nside, theta, phi, nest)
    expected = healpy.ang2pix(nside, theta, phi, nest)
    assert (found != expected).mean() <= (0 if nside <= 1024 else 1e-3)

    for ours, theirs in zip(healpix.pix2vec(nside, pixels, nest), healpy.pix2vec(nside, pixels, nest)):
        np.testing.assert_allclose(ours, theirs, rtol=0, atol=4e-15)
    for ours, theirs in zip(healpix.pix2ang(nside, pixels, nest), healpy.pix2ang(nside, pixels, nest)):
        # healpy takes the colatitude from its cosine, which costs half the digits near the poles.
        np.testing.assert_allclose(ours, theirs, rtol=0, atol=3e-8)
    for ours, theirs in zip(
        healpix.pix2ang(nside, pixels, nest, lonlat=True),
        healpy.pix2ang(nside, pixels, nest, lonlat=True),
    ):
        np.testing.assert_allclose(ours, theirs, rtol=0, atol=2e-6)
    # Centres lie in their pixels.
    assert (healpix.vec2pix(nside, *healpix.pix2vec(nside, pixels, nest), nest) == pixels).all()
    assert (healpix.ang2pix(nside, *healpix.pix2ang(nside, pixels, nest), nest) == pixels).all()


@pytest.mark.parametrize("nside", [n for n in NSIDES if is_power_of_two(n)])
def test_orders_are_those_of_healpy(nside: int) -> None:
    pixels = np.random.default_rng(1).integers(0, 12 * nside**2, 20_000)
    nested = healpix.ring2nest(nside, pixels)
    assert (nested == healpy.ring2nest(nside, pixels)).all()
    assert (healpix.nest2ring(nside, nested) == pixels).all()


def test_hostile_vectors_are_located_as_by_healpy() -> None:
    axes = np.array([-1.0, -0.0, 0.0, 1.0])
    grid = np.stack(np.meshgrid(axes, axes, axes), axis=-1).reshape(-1, 3)
    grid = grid[np.abs(grid).sum(axis=1) > 0]
    for scale in [1e-300, 1e-150, 1.0, 1e150, 1e300]:
        x, y, z = scale * grid.T
        found = healpix.vec2pix(64, x, y, z)
        # healpy overflows for extreme lengths; the pixel does not depend on the length.
        assert (found == healpix.vec2pix(64, *grid.T)).all()
    assert (healpix.vec2pix(64, *grid.T) == healpy.vec2pix(64, *grid.T)).all()
    thetas = np.array([0.0, 5e-324, 1e-160, 1e-9, 1.0, np.pi / 2, np.pi])
    phis = np.array([0.0, -0.0, 2 * np.pi, -7.0, 1e3])
    theta, phi = np.meshgrid(thetas, phis)
    assert (healpix.ang2pix(1024, theta, phi) == healpy.ang2pix(1024, theta, phi)).all()
    # A longitude just west of 0 is in the last pixel of its ring; healpy rounds it to 0.
    assert healpix.ang2pix(1024, 1e-9, -1e-20) == 3


def test_degrees() -> None:
    lon = np.linspace(-720, 720, 1001)
    lat = np.linspace(-90, 90, 1001)
    found = healpix.ang2pix(64, lon, lat, lonlat=True)
    assert (found != healpy.ang2pix(64, lon, lat, lonlat=True)).mean() < 5e-3
    assert healpix.ang2pix(64, np.float32(0), np.float32(np.pi)) == healpix.ang2pix(64, 0, np.pi)


def test_scalars_and_shapes() -> None:
    pixel = healpix.vec2pix(64, 1.0, 0.0, 0.0)
    assert isinstance(pixel, np.int64) and pixel.ndim == 0
    assert isinstance(healpix.pix2vec(64, 3)[0], np.float64)
    assert healpix.vec2pix(64, [1.0], 0.0, 0).shape == (1,)
    assert healpix.vec2pix(64, np.ones((3, 1)), np.ones((1, 4)), 0).shape == (3, 4)
    assert healpix.vec2pix(64, [], [], []).shape == (0,)
    assert healpix.pix2ang(64, [])[1].shape == (0,)
    assert healpix.pix2ang(64, np.zeros((2, 0, 3), int))[1].shape == (2, 0, 3)
    with pytest.raises(ValueError, match=r"\(2,\), \(3,\)"):
        healpix.vec2pix(64, [1, 2], [1, 2, 3], 0)


@pytest.mark.parametrize("n", [100, 40_000])
def test_types_strides_and_order(n: int) -> None:
    x, y, z = random_vectors(n)
    expected = healpix.vec2pix(64, x, y, z)
    table = np.stack([x, y, z], axis=1)
    assert (healpix.vec2pix(64, *table.T) == expected).all()
    assert (healpix.vec2pix(64, x[::-1], y[::-1], z[::-1]) == expected[::-1]).all()
    assert (healpix.vec2pix(64, x.astype(">f8"), y, z) == expected).all()
    single = table.astype(np.float32)
    assert (
        healpix.vec2pix(64, *single.T) == healpix.vec2pix(64, *single.T.astype(float))
    ).all()
    fortran = np.asfortranarray(x.reshape(10, -1))
    shape = fortran.shape
    assert (
        healpix.vec2pix(64, fortran, y.reshape(shape), z.reshape(shape)) == expected.reshape(shape)
    ).all()
    records = np.zeros(n, dtype=[("a", "i4"), ("x", "f8"), ("y", "f8"), ("z", "f8")])
    records["x"], records["y"], records["z"] = x, y, z
    assert (healpix.vec2pix(64, records["x"], records["y"], records["z"]) == expected).all()
    for array in (x, y, z):
        array.flags.writeable = False
    assert (healpix.vec2pix(64, x, y, z) == expected).all()
    assert (healpix.ring2nest(64, expected.astype(np.int32)) == healpix.ring2nest(64, expected)).all()
    assert (healpix.ring2nest(64, expected.astype(np.uint64)) == healpix.ring2nest(64, expected)).all()


def test_an_array_of_resolutions() -> None:
    nsides = np.array([[1, 2], [4, 64]])
    found = healpix.vec2pix(nsides, 0.3, 0.4, [0.5, -0.5])
    for (i, j), nside in np.ndenumerate(nsides):
        assert found[i, j] == healpix.vec2pix(int(nside), 0.3, 0.4, [0.5, -0.5][j])
    assert (healpix.nside2npix(nsides) == 12 * nsides**2).all()
    assert (healpix.npix2nside(12 * nsides**2) == nsides).all()
    assert healpix.vec2pix(np.array([], int), [], [], []).shape == (0,)


def test_errors_name_the_value_and_its_index() -> None:
    cases = [
        (lambda: healpix.vec2pix(64, [1, 0], [1, np.nan], 0), r"NaN.*\(index 1\)"),
        (lambda: healpix.vec2pix(64, 0.0, 0.0, 0.0), r"no direction"),
        (lambda: healpix.vec2pix(64, np.full((2, 3), np.inf), 0, 0), r"\(index \(0, 0\)\)"),
        (lambda: healpix.pix2vec(2, [0, 48]), r"pixel 48 is out of range.*48 pixels.*\(index 1\)"),
        (lambda: healpix.pix2vec(2, -1), r"pixel -1 is out of range"),
        (lambda: healpix.ang2pix(2, [0.0, 4.0], 0.0), r"theta = 4.*\(index 1\)"),
        (lambda: healpix.ang2pix(2, 1.0, np.inf), r"phi = inf"),
        (lambda: healpix.ang2pix(2, 0, 91, lonlat=True), r"lat = 91"),
        (lambda: healpix.ang2pix(2, np.nan, 1, lonlat=True), r"lon = NaN"),
        (lambda: healpix.vec2pix(0, 1, 0, 0), r"nside 0 is out of range"),
        (lambda: healpix.vec2pix(2**29 + 1, 1, 0, 0), r"from 1 to 536870912"),
        (lambda: healpix.ring2nest(3, 0), r"power of two"),
        (lambda: healpix.npix2nside(1024), r"nearest valid count is 972"),
        (lambda: healpix.npix2nside(-1), r"-1 is not"),
        (lambda: healpix.ring2nest(2, np.array([2**63], np.uint64)), r"above"),
    ]
    for call, message in cases:
        with pytest.raises(ValueError, match=message):
            call()
    large = np.ones(100_000)
    large[77_777] = np.nan
    large[99_999] = np.nan
    with pytest.raises(ValueError, match=r"index 77777"):
        healpix.vec2pix(64, large, 0, 0)
    for call in [
        lambda: healpix.vec2pix(2.5, 1, 0, 0),
        lambda: healpix.pix2vec(2, 1.0),
        lambda: healpix.pix2vec(2, "a"),
        lambda: healpix.vec2pix(2, "a", 0, 0),
        lambda: healpix.vec2pix(2, 1j, 0, 0),
        lambda: healpix.vec2pix(2, None, 0, 0),
    ]:
        with pytest.raises(TypeError):
            call()


@settings(max_examples=60, deadline=None)
@given(
    nside=st.integers(1, 2**29),
    vector=st.tuples(*[st.floats(allow_nan=False, allow_infinity=False)] * 3),
)
def test_any_vector_has_a_pixel_whose_centre_is_near(
    nside: int, vector: tuple[float, float, float]
) -> None:
    if not any(vector):
        return
    pixel = healpix.vec2pix(nside, *vector)
    centre = np.array(healpix.pix2vec(nside, pixel))
    unit = np.array(vector) / np.max(np.abs(vector))
    unit /= np.linalg.norm(unit)
    # A pixel is no longer than 1.6 radians over nside.
    assert np.linalg.norm(centre - unit) < 1.6 / nside + 1e-15


@settings(deadline=None, max_examples=30)
@given(st.lists(st.tuples(st.floats(0, np.pi), st.floats(-10, 10)), min_size=1, max_size=5))
def test_vectors_of_angles_are_those_of_healpy(pairs):
    healpy = pytest.importorskip("healpy")
    theta, phi = np.array(pairs).T
    vectors = healpix.ang2vec(theta, phi)
    np.testing.assert_allclose(vectors, healpy.ang2vec(theta, phi), atol=1e-15)
    degrees = np.degrees(phi), 90 - np.degrees(theta)
    np.testing.assert_allclose(healpix.ang2vec(*degrees, lonlat=True), vectors, atol=1e-13)
    for lonlat in (False, True):
        for ours, theirs in zip(healpix.vec2ang(vectors, lonlat), healpy.vec2ang(vectors, lonlat)):
            assert ours.shape == theirs.shape
            np.testing.assert_allclose(ours, theirs, atol=1e-7)


def test_angles_and_vectors_broadcast_and_are_checked():
    assert healpix.ang2vec(0, 0).shape == (3,)
    assert healpix.ang2vec(np.zeros((4, 1)), np.zeros(5)).shape == (4, 5, 3)
    for angles, lonlat, message in [
        (([0, 4], 0), False, r"theta\[1\]: expected theta from 0 to 3.14159 radians"),
        ((0, [[0, 91]]), True, r"latitude\[0\]\[1\]: expected latitude from -90 to 90 degrees"),
        ((0, np.nan), False, r"^theta: expected .* a finite phi, got 0.0 and nan$"),
    ]:
        with pytest.raises(ValueError, match=message):
            healpix.ang2vec(*angles, lonlat=lonlat)
    with pytest.raises(ValueError, match=r"vectors\[1\]: expected a direction"):
        healpix.vec2ang([[1, 0, 0], [0, 0, 0]])
    with pytest.raises(ValueError, match=r"expected shape \(3,\)"):
        healpix.vec2ang([1, 0])
