"""Arrays of every type and layout as points."""

from decimal import Decimal

import numpy as np
import pytest

from sphvar import Sampler

POINTS = Sampler("white-noise", 80, seed=9).random()[0]
# Points that are read are normalized, which changes the last bit of some.
POINTS = POINTS[(Sampler(POINTS).random()[0] == POINTS).all(axis=1)]


def read(points: object) -> np.ndarray:
    """Return the points as the native module reads them."""
    return Sampler(points, normalize=True).random()[0]  # type: ignore[no-any-return]


def test_layouts_are_read_alike() -> None:
    for array in [
        np.asfortranarray(POINTS),
        np.repeat(POINTS, 2, axis=0)[::2],
        POINTS[::-1][::-1],
        np.concatenate([POINTS, POINTS], axis=1)[:, :3],
        POINTS.astype(">f8"),
        POINTS.astype(np.longdouble),
        POINTS.tolist(),
        tuple(map(tuple, POINTS)),
        memoryview(POINTS),
    ]:
        assert read(array).tobytes() == POINTS.tobytes()
    assert read(POINTS[::-1]).tobytes() == POINTS[::-1].tobytes()
    np.testing.assert_allclose(read(POINTS[:, ::-1]), POINTS[:, ::-1], rtol=0, atol=4e-16)


def test_unaligned_arrays_are_read() -> None:
    buffer = bytearray(1 + POINTS.nbytes)
    unaligned = np.frombuffer(buffer, dtype=np.float64, offset=1, count=POINTS.size)
    unaligned = unaligned.reshape(POINTS.shape)
    unaligned[:] = POINTS
    assert not unaligned.flags.aligned
    assert read(unaligned).tobytes() == POINTS.tobytes()
    records = np.zeros(len(POINTS), dtype=[("a", "u1"), ("xyz", "f8", 3)])
    records["xyz"] = POINTS
    assert read(records["xyz"]).tobytes() == POINTS.tobytes()


def test_numbers_of_other_types() -> None:
    axes = np.concatenate([np.eye(3), -np.eye(3)])
    for dtype in [np.int8, np.int64, np.float16, np.float32]:
        assert (read(axes.astype(dtype)) == axes).all()
    assert (read(np.eye(3, dtype=np.uint8)) == np.eye(3)).all()
    single = POINTS.astype(np.float32)
    np.testing.assert_allclose(read(single), POINTS, rtol=0, atol=1e-7)


def test_read_only_arrays_stay_as_they_are() -> None:
    array = POINTS.copy()
    array.flags.writeable = False
    assert read(array).tobytes() == POINTS.tobytes()
    assert array.tobytes() == POINTS.tobytes()


@pytest.mark.parametrize(
    "array",
    [
        POINTS.astype(complex),
        POINTS.astype(object),
        [[Decimal(1), Decimal(0), Decimal(0)]],
        [["1", "0", "0"]],
        np.ones((3, 3), dtype=bool),
        np.zeros((3, 3), dtype="datetime64[s]"),
        None,
        {},
    ],
)
def test_other_types_are_errors(array: object) -> None:
    with pytest.raises((TypeError, ValueError)):
        Sampler(array)


@pytest.mark.parametrize(
    "array",
    [
        np.zeros((0, 3)),
        np.zeros((2, 0, 3)),
        np.zeros((0, 5, 3)),
        np.zeros((5, 0)),
        np.ones((5, 2)),
        np.ones((5, 4)),
        np.ones((1, 2, 5, 3)),
        np.float64(1.0),
        np.full((2, 3), np.nan),
        np.full((2, 3), np.inf),
        [[1.0, 0.0, 0.0], [1.0, 0.0]],
        np.ma.masked_array(POINTS, mask=np.eye(len(POINTS), 3, dtype=bool)),
    ],
)
def test_other_shapes_and_values_are_errors(array: object) -> None:
    with pytest.raises(ValueError):
        Sampler(array)


def test_points_of_extreme_lengths() -> None:
    for scale in [1e-300, 1e300]:
        np.testing.assert_allclose(read(scale * POINTS), POINTS, rtol=0, atol=4e-16)
    # The least number has one digit, so directions are those of whole numbers.
    assert read([[5e-324, 0, 0], [0, -5e-324, 0]]).tolist() == [[1, 0, 0], [0, -1, 0]]
