"""The command that the package installs."""

import json
import os
import pathlib
import signal
import subprocess
import sys
import sysconfig
import time

import pytest

import sphvar

SCRIPT = pathlib.Path(sysconfig.get_path("scripts")) / "sphvar"
# Where the package is not installed, as in a source tree, its module is run.
SOURCES = pathlib.Path(sphvar.__file__).parents[1]
MODULE = f"import sys; sys.path.insert(0, {str(SOURCES)!r}); from sphvar._command import main; main()"
COMMAND = [str(SCRIPT)] if SCRIPT.exists() else [sys.executable, "-c", MODULE]

# Work of a minute.
LONG = ["sample", "ccvt:capacity=4096", "-n", "16384", "-o", "-"]


def run(*words: str, **options: object) -> "subprocess.CompletedProcess[bytes]":
    """Run the command and return what it printed."""
    return subprocess.run([*COMMAND, *words], capture_output=True, timeout=120, check=False, **options)  # type: ignore[call-overload]


def test_version_is_that_of_the_package() -> None:
    result = run("--version")
    assert (result.returncode, result.stderr) == (0, b"")
    assert result.stdout.decode() == f"sphvar {sphvar.__version__}\n"


def test_help_names_the_command_and_not_the_interpreter() -> None:
    result = run("choose", "--help")
    assert result.returncode == 0
    assert b"Usage: sphvar choose" in result.stdout
    assert b"python" not in result.stdout


def test_lists_are_json() -> None:
    result = run("list", "--json")
    assert (result.returncode, result.stderr) == (0, b"")
    document = json.loads(result.stdout)
    assert "fibonacci" in json.dumps(document)


def test_data_are_built_in(tmp_path: pathlib.Path) -> None:
    # The light probe of the documentation, the default integrand, is compiled in; no file is read.
    result = run("compare", "fibonacci", "-n", "48", "-m", "4", "-o", "results", cwd=tmp_path)
    assert result.returncode == 0, result.stderr.decode()
    assert b"fibonacci" in result.stdout


@pytest.mark.parametrize(
    ("words", "status", "text"),
    [
        (["sample", "fibonacci", "-n", "3", "-o", "no/such/folder/points.csv"], 1, "no/such/folder"),
        (["spectrum", "file:no-such-file.csv"], 1, "no-such-file.csv"),
        (["sample", "fibonacci"], 2, "-n"),
        (["sample", "no-such-pattern", "-n", "3"], 2, "no-such-pattern"),
        (["no-such-command"], 2, "no-such-command"),
        ([], 2, "Usage: sphvar"),
    ],
)
def test_failures_have_a_status_and_one_message(
    words: "list[str]", status: int, text: str, tmp_path: pathlib.Path
) -> None:
    result = run(*words, cwd=tmp_path)
    assert result.returncode == status, result.stderr.decode()
    assert text in result.stderr.decode()
    assert result.stdout == b""
    assert b"Traceback" not in result.stderr


def test_points_on_standard_output_are_complete() -> None:
    result = run("sample", "fibonacci", "-n", "20000")
    assert result.returncode == 0, result.stderr.decode()
    assert result.stdout.endswith(b"\n")
    assert len(result.stdout.splitlines()) == 20000 + 1


@pytest.mark.skipif(os.name != "posix", reason="names of files are bytes on POSIX only")
def test_names_that_are_not_utf8_are_kept(tmp_path: pathlib.Path) -> None:
    name = os.fsencode(tmp_path) + b"/p\xff.csv"
    if sys.platform == "darwin":
        pytest.skip("the file system accepts UTF-8 only")
    result = subprocess.run(
        [*map(os.fsencode, COMMAND), b"sample", b"fibonacci", b"-n", b"3", b"-o", name],
        capture_output=True, timeout=120, check=False,
    )
    assert result.returncode == 0, result.stderr.decode()
    assert os.path.exists(name)


@pytest.mark.skipif(os.name != "posix", reason="signals are those of POSIX")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_it_as_it_ends_the_binary(number: signal.Signals, tmp_path: pathlib.Path) -> None:
    words = [*COMMAND, *LONG[:-1], "points.csv"]
    with subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, cwd=tmp_path) as process:
        time.sleep(1.5)
        assert process.poll() is None, process.communicate()
        start = time.monotonic()
        process.send_signal(number)
        _, errors = process.communicate(timeout=60)
        assert time.monotonic() - start < 1
    assert process.returncode == 128 + number
    assert b"Traceback" not in errors
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(os.name != "posix", reason="signals are those of POSIX")
def test_an_ignored_interrupt_stays_ignored() -> None:
    # As in a shell that runs it in the background without job control.
    words = [*COMMAND, *LONG]
    with subprocess.Popen(
        words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_IGN) and None,
    ) as process:
        try:
            time.sleep(1.5)
            process.send_signal(signal.SIGINT)
            time.sleep(0.3)
            assert process.poll() is None
        finally:
            process.kill()


@pytest.mark.skipif(os.name != "posix", reason="pipes are those of POSIX")
def test_a_reader_may_close_its_pipe_early() -> None:
    words = [*COMMAND, "sample", "fibonacci", "-n", "200000", "-o", "-"]
    with subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout is not None and process.stderr is not None
        process.stdout.read(100)
        process.stdout.close()
        errors = process.stderr.read()
        assert process.wait(60) == 0
        assert errors == b""
