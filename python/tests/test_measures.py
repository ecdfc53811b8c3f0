"""Bounds, audits, quality, lights and rotations: the answers are bit-identical to those of the command."""

import json
import pathlib
import subprocess
import sys

import numpy as np
import pytest

import sphvar


def command(*words):
    """Return the document of the command, and what it prints where it fails."""
    call = [sys.executable, "-m", "sphvar._command", *map(str, words), "--json", "--quiet"]
    run = subprocess.run(call, capture_output=True, text=True, check=False)
    return json.loads(run.stdout) if run.returncode == 0 else run.stderr


def same(result, *words):
    """Check that a result is the document of the command, apart from times and the words."""
    document = result.to_dict()
    expected = type(result)(command(*words))
    assert document["provenance"]["seed"] == expected.provenance["seed"]
    assert type(result)(document) == expected


def octahedron():
    return np.vstack([np.eye(3), -np.eye(3)])


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (
            lambda: sphvar.bounds("jittered", n=48, realizations=50, seed=3),
            ["bounds", "jittered", "-n", 48, "-m", 50, "-s", 3],
        ),
        (
            lambda: sphvar.bounds("fibonacci", n=100, integrand="cap:degrees=60", decay=2.5),
            ["bounds", "fibonacci", "-n", 100, "--integrand", "cap:degrees=60", "--decay", 2.5],
        ),
        (
            lambda: sphvar.bounds(profile="poly:b=2,alpha=0.5,gamma=1", n=1024, band=4),
            ["bounds", "--profile", "poly:b=2,alpha=0.5,gamma=1", "-n", 1024, "--band", 4],
        ),
        (
            lambda: sphvar.audit("jittered", n=12, realizations=60, lmax=4, alpha=0.05),
            ["audit", "jittered", "-n", 12, "-m", 60, "--lmax", 4, "--alpha", 0.05],
        ),
        (
            lambda: sphvar.audit("jittered", n=6, realizations=60, hemisphere=True),
            ["audit", "jittered", "-n", 6, "-m", 60, "--hemisphere"],
        ),
        (
            lambda: sphvar.quality(["fibonacci", "jittered"], n=48, realizations=2, lmax=[2, 5]),
            ["quality", "fibonacci,jittered", "-n", 48, "-m", 2, "--lmax", "2,5"],
        ),
        (
            lambda: sphvar.quality("r2", n=64, square=True),
            ["quality", "r2", "-n", 64, "--square"],
        ),
        (
            lambda: sphvar.rotation_quality(["super-fibonacci", "uniform"], n=[8, 16], kappa=5.0),
            ["rotations", "super-fibonacci,uniform", "-n", "8,16", "--kappa", 5],
        ),
    ],
)
def test_answers_are_those_of_the_command(call, words):
    same(call(), *words)


def test_a_spectrum_is_bounded_as_its_file(tmp_path):
    spectrum = sphvar.spectrum("jittered", n=48, realizations=50)
    file = tmp_path / "spectrum.csv"
    rows = zip(spectrum.l, spectrum.power, spectrum.stderr)
    lines = [f"{l},{float(p)!r},{float(e)!r},50" for l, p, e in rows]
    file.write_text("\n".join(["l,power,stderr,realizations", *lines]) + "\n")
    given = sphvar.bounds(spectrum=spectrum)
    assert given == sphvar.bounds(spectrum=file)
    assert given == sphvar.bounds(spectrum=str(file))
    same(given, "bounds", "--spectrum", file)


def test_points_are_measured_as_their_file(tmp_path):
    sets = sphvar.Sampler("jittered", 12).random(40)
    file = tmp_path / "sets.npy"
    np.save(file, sets)
    measured = sphvar.quality(sets)
    expected = command("quality", file)
    for key in ("n", "realizations", "separation", "worst_case_error", "exact_degree", "stderr"):
        assert measured.to_dict()[key] == expected[key], key

    audited = sphvar.audit(sets, lmax=3)
    expected = command("audit", "--points", file, "--lmax", 3)
    assert audited.rows == expected["audits"]
    assert sphvar.audit(file, lmax=3).rows == expected["audits"]
    assert sphvar.audit([file], lmax=3).rows == expected["audits"]


def test_known_measures():
    measures = sphvar.quality(octahedron())
    assert measures.n == 6
    assert measures.separation == pytest.approx(np.sqrt(2), rel=1e-14)
    # The centre of a face is the farthest direction.
    assert measures.covering_radius == pytest.approx(np.sqrt(2 - 2 / np.sqrt(3)), rel=1e-12)
    assert measures.exact_degree == 3
    # Twelve pairs of neighbours at sqrt 2 and three of antipodes.
    assert measures.riesz_energy[1] == pytest.approx(12 / np.sqrt(2) + 3 / 2, rel=1e-13)


def test_labels_name_rows():
    table = sphvar.quality({"mine": octahedron(), "theirs": "fibonacci"}, n=6)
    assert list(table.sampler) == ["mine", "theirs"]
    assert table.separation[0] > table.separation[1]


def test_lights_are_those_of_the_command(tmp_path):
    # A picture in Radiance's format, without compression: red, green, blue and an exponent.
    rng = np.random.default_rng(1)
    texels = rng.integers(128, 256, size=(8, 16, 4), dtype=np.uint8)
    texels[..., 3] = rng.integers(126, 131, size=(8, 16))
    file = tmp_path / "sky.hdr"
    header = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 8 +X 16\n"
    file.write_bytes(header + texels.tobytes())
    lights = sphvar.lights(file, n=5, realizations=2, seed=4)
    same(lights, "lights", file, "-n", 5, "-m", 2, "-s", 4)

    scale = np.exp2(texels[..., 3].astype(float) - 136)
    array = sphvar.lights(texels[..., :3] * scale[..., None], n=5, realizations=2, seed=4)
    assert np.array_equal(array.directions, lights.directions)
    assert np.array_equal(array.rgb, lights.rgb)
    assert array.irradiance_error == lights.irradiance_error


def test_lights_of_an_array():
    rng = np.random.default_rng(0)
    sky = np.exp(rng.normal(size=(8, 16, 3))).astype(np.float32)
    lights = sphvar.lights(sky, n=5, realizations=2, seed=4)
    assert lights.directions.shape == lights.rgb.shape == (5, 3)
    assert np.allclose(np.linalg.norm(lights.directions, axis=1), 1, atol=1e-14)
    # The lights are those of the first of the realizations, over which errors are averaged.
    assert abs(lights.irradiance_error - lights.error[0]) < 3 * lights.error_stderr[0]
    several = sphvar.lights(sky, n=[2, 5], realizations=2, seed=4)
    assert list(several.n) == [2, 5]
    assert several.error[1] == lights.error[0]
    with pytest.raises(ValueError, match="single sampler"):
        _ = several.directions


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: sphvar.bounds("jitered", n=48), ["bounds", "jitered", "-n", 48]),
        (lambda: sphvar.bounds("healpix", n=50), ["bounds", "healpix", "-n", 50]),
        (lambda: sphvar.bounds(profile="cubic"), ["bounds", "--profile", "cubic"]),
        (lambda: sphvar.quality("fibonacci"), ["quality", "fibonacci"]),
        (
            lambda: sphvar.audit("jittered", n=12, realizations=3),
            ["audit", "jittered", "-n", 12, "-m", 3],
        ),
        (lambda: sphvar.rotation_quality("cubes", n=4), ["rotations", "cubes", "-n", 4]),
    ],
)
def test_invalid_values_have_the_words_of_the_command(call, words):
    with pytest.raises(ValueError) as error:
        call()
    printed = " ".join(command(*words).split())
    # Options have the names of keywords.
    for option, keyword in {"--nearest": "nearest=True", "-n/--count": "n", "-m ": "realizations "}.items():
        printed = printed.replace(option, keyword)
    assert " ".join(str(error.value).split()) in printed


def test_missing_files_are_os_errors():
    with pytest.raises(OSError, match="missing"):
        sphvar.bounds(spectrum="/missing/spectrum.csv")
    with pytest.raises(OSError, match="missing"):
        sphvar.lights("/missing/map.exr")
    with pytest.raises(OSError, match="missing"):
        sphvar.audit(pathlib.Path("/missing/points.npy"))


def test_invalid_arrays_are_reported():
    with pytest.raises(ValueError, match=r"\(4, 2\)"):
        sphvar.quality(np.zeros((4, 2)))
    with pytest.raises(ValueError, match="length"):
        sphvar.quality(np.full((4, 3), 0.9))
    with pytest.raises(ValueError, match="finite|NaN"):
        sphvar.quality(np.full((4, 3), np.nan))
    with pytest.raises(TypeError):
        sphvar.quality(np.zeros((4, 3), dtype=complex))
    spectrum = sphvar.spectrum("healpix", n=12, lmax=4)

    class Broken:
        power = np.array([12.0, -1.0])
        stderr = np.zeros(2)
        realizations = 0

    with pytest.raises(ValueError, match="degree 1"):
        sphvar.bounds(spectrum=Broken())
    assert len(sphvar.bounds(spectrum=spectrum)) > 0


def test_unknown_keywords_name_the_close_ones():
    with pytest.raises(TypeError, match="realizations"):
        sphvar.audit("jittered", n=12, realisations=60)


def test_exponents_are_numbers_in_all_measures():
    single = sphvar.quality("fibonacci", n=32, realizations=1)
    assert set(single.scaled["worst_case_error"]) == set(single.worst_case_error)
    assert all(isinstance(key, (int, float)) for key in single.scaled["riesz_energy"])
    several = sphvar.quality(["fibonacci", "white-noise"], n=32)
    assert set(several.scaled[1]["worst_case_error"]) == set(several.worst_case_error)
