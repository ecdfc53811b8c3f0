"""Work in threads: interrupts, forks, several threads at once, panics, overhead."""

import os
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import sphvar
from sphvar import Sampler, _sphvar, healpix

SLOW = [("ccvt", 20_000, 1), ("design:t=64", 2114, 1), ("white-noise", 1_000_000, 400), ("step", 2500, 50)]


@pytest.mark.parametrize(("spec", "n", "m"), SLOW)
def test_interrupts_end_work_within_a_second(spec: str, n: int, m: int) -> None:
    code = f"""
import os, signal, sys, threading, time
import sphvar
sampler = sphvar.Sampler({spec!r}, {n})
sent = []
def interrupt():
    time.sleep(0.4)
    sent.append(time.monotonic())
    os.kill(os.getpid(), signal.SIGINT)
threading.Thread(target=interrupt).start()
try:
    sampler.random({m})
except KeyboardInterrupt:
    took = time.monotonic() - sent[0]
    assert sampler.position == 0
    # What was stopped can be done anew.
    assert sphvar.Sampler("white-noise", 10**5).random(2).shape == (2, 10**5, 3)
    print(took)
else:
    print("not interrupted")
"""
    run = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=False
    )
    assert run.returncode == 0 and run.stderr == "", run.stderr
    assert run.stdout.strip() != "not interrupted", "the work is too short for this test"
    assert float(run.stdout) < 1.0


class Endless(threading.Thread):
    """Work that takes minutes, until the end of a ``with`` block."""

    class Enough(Exception):
        """Ends the work."""

    def __init__(self) -> None:
        super().__init__()
        self._stop_now = threading.Event()
        self._started = threading.Event()
        self.is_stopped = False

    def run(self) -> None:
        def report(done: float, expected: float) -> None:
            self._started.set()
            if self._stop_now.is_set():
                raise self.Enough

        try:
            Sampler("ccvt", 20_000).random(1, progress=report)
        except self.Enough:
            self.is_stopped = True

    def __enter__(self) -> "Endless":
        self.start()
        assert self._started.wait(30)
        return self

    def __exit__(self, *_: object) -> None:
        self._stop_now.set()
        self.join()
        assert self.is_stopped


def test_python_threads_work_at_once() -> None:
    sampler = Sampler("white-noise", 100_000)
    try:
        # Even on one core, one call does not wait for the other.
        sphvar.set_num_threads(2)
        with Endless():
            assert sampler.random(2).shape == (2, 100_000, 3)
            assert (healpix.vec2pix(8, *np.ones((3, 100_000))) == 0).sum() == 0
    finally:
        sphvar.set_num_threads(0)


def test_python_runs_meanwhile() -> None:
    with Endless():
        count, start = 0, time.perf_counter()
        while time.perf_counter() - start < 0.2:
            count += 1
    # The lock of the interpreter would allow a step each 50 ms.
    assert count > 100


def test_numbers_of_threads_give_equal_bytes() -> None:
    vectors = np.random.default_rng(0).normal(size=(3, 100_000))
    sampler = Sampler("poisson-disk", 300)
    results = set()
    try:
        for threads in [1, 2, 5, 0]:
            sphvar.set_num_threads(threads)
            pixels = healpix.vec2pix(1024, *vectors)
            results.add((sampler.reset().random(20).tobytes(), pixels.tobytes()))
    finally:
        sphvar.set_num_threads(0)
    assert len(results) == 1
    for wrong in [-1, 1025, 10**30]:
        with pytest.raises((ValueError, OverflowError)):
            sphvar.set_num_threads(wrong)


@pytest.mark.parametrize("in_pool", [False, True])
def test_panics_are_exceptions(in_pool: bool, capfd: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(RuntimeError, match="internal error of sphvar.*a test"):
        _sphvar._panic(in_pool)
    assert Sampler("white-noise", 10**5).random(2).shape == (2, 10**5, 3)
    output = capfd.readouterr()
    assert output.out == "" and output.err == ""


@pytest.mark.filterwarnings("ignore:This process:DeprecationWarning")
def test_a_process_forked_during_work_can_work() -> None:
    if not hasattr(os, "fork"):
        pytest.skip("no fork")
    with Endless():
        child = os.fork()
        if child == 0:
            code = 1
            try:
                points = Sampler("white-noise", 10**5).random(2)
                code = 0 if points.shape == (2, 10**5, 3) else 2
            finally:
                os._exit(code)
        start, done = time.monotonic(), 0
        while not done and time.monotonic() - start < 30:
            done, status = os.waitpid(child, os.WNOHANG)
            time.sleep(0.01)
        if not done:
            os.kill(child, signal.SIGKILL)
            os.waitpid(child, 0)
    assert done and status == 0


def test_the_overhead_of_a_call_is_small() -> None:
    sampler = Sampler("white-noise", 1)
    calls = {
        "Sampler.random": lambda: sampler.random(1),
        "healpix.vec2pix": lambda: healpix.vec2pix(64, 1.0, 0.0, 0.0),
        "healpix.pix2ang": lambda: healpix.pix2ang(64, 17),
    }
    for name, call in calls.items():
        best = np.inf
        for _ in range(20):
            start = time.perf_counter()
            for _ in range(100):
                call()
            best = min(best, (time.perf_counter() - start) / 100)
        # 20 us in a build of the wheel; builds for development are slower.
        assert best < 60e-6, f"{name}: {1e6 * best:.1f} us"


def test_signals_are_those_of_python() -> None:
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_functions_of_work_that_was_given_up_are_not_called_again() -> None:
    calls = []

    def step(points: np.ndarray) -> np.ndarray:
        calls.append(len(points))
        if len(calls) == 6:
            os.kill(os.getpid(), signal.SIGINT)
        time.sleep(0.02)
        return (points[:, 2] > 0.1234).astype(float)

    for _ in range(3):
        calls.clear()
        with pytest.raises(KeyboardInterrupt):
            sphvar.predict("white-noise", n=16, integrand=step)
        time.sleep(0.3)
        known = len(calls)
        time.sleep(0.5)
        assert len(calls) == known
    assert sphvar.predict("white-noise", n=16, integrand="cosine").predicted[0] > 0


def test_functions_that_call_themselves_end_with_an_error() -> None:
    def endless(points: np.ndarray) -> np.ndarray:
        return sphvar.evaluate(endless, points)

    with pytest.raises(RecursionError):
        sphvar.integrate(endless)
