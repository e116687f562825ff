# SPDX-License-Identifier: Apache-2.0
"""Other Python threads run during a long call, and Ctrl-C ends the call."""

import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import espalier


class Clock:
    """A Python thread that records the time whenever it runs."""

    def __enter__(self):
        self.ticks, self.running = [], True
        self.thread = threading.Thread(target=self.run)
        self.thread.start()
        return self

    def run(self):
        while self.running:
            self.ticks.append(time.perf_counter())
            time.sleep(0.001)

    def __exit__(self, *_):
        self.running = False
        self.thread.join()

    def ran_during(self, call):
        """Returns whether the thread ran in the middle half of a call. It may always run near the ends."""
        begin = time.perf_counter()
        call()
        end = time.perf_counter()
        assert end - begin > 0.02, "too short to tell: make it longer"
        quarter = (end - begin) / 4
        return any(begin + quarter < tick < end - quarter for tick in list(self.ticks))


def large():
    rest = espalier.shapes.box(cells=(8, 8, 8))
    points = np.random.default_rng(1).uniform(0.01, 0.99, (200_000, 3))
    return rest, points


@pytest.fixture(scope="module")
def bound():
    rest, points = large()
    return rest, points, espalier.bind(rest, points)


CALLS = {
    "refine": lambda rest, points, binding: espalier.refine(rest, 3),
    "stencils": lambda rest, points, binding: espalier.Refiner(rest).stencils(3),
    "bind": lambda rest, points, binding: espalier.bind(rest, points),
    "deform": lambda rest, points, binding: binding.deform(np.stack([rest.positions] * 30)),
    "adjoint": lambda rest, points, binding: binding.adjoint(np.stack([points] * 30)),
    "fit": lambda rest, points, binding: espalier.fit(rest, binding, points[:30_000],
                                                   rows=np.arange(30_000)),
    "check": lambda rest, points, binding: espalier.check(rest, rest.positions**2),
    "mesh": lambda rest, points, binding: many_faces(),
}


FACES = np.tile(np.arange(4), (3_000_000, 1))  # 64-bit, so that NumPy need not convert them
FACES[-1] = 9


def many_faces():
    """Makes a mesh whose last face is invalid, so that the call ends there."""
    with pytest.raises(ValueError, match="face 2999999"):
        espalier.Lattice.mesh(np.zeros((4, 3)), FACES)


@pytest.mark.parametrize("name", CALLS)
def test_other_threads_run_during_a_long_call(bound, name):
    # On many threads, some of the calls would be too short. On a busy machine, the Python thread may have to wait for
    # a core.
    with espalier.ThreadLimit(1), Clock() as clock:
        assert any(clock.ran_during(lambda: CALLS[name](*bound)) for _ in range(10))


def test_a_call_that_holds_the_gil_would_be_noticed():
    numbers = np.random.default_rng(1).random(1_000_000)
    with Clock() as clock:
        # Sorting runs in C and does not release the GIL.
        assert not any(clock.ran_during(numbers.tolist().sort) for _ in range(3))


def run(code):
    """Runs code in a separate process, because it may hang. Returns its output."""
    setup = """
import signal, time, numpy as np, espalier
rest = espalier.shapes.box(cells=(6, 6, 6))
points = np.random.default_rng(1).uniform(0.01, 0.99, (500_000, 3))
"""
    done = subprocess.run([sys.executable, "-c", setup + code], capture_output=True, text=True,
                          timeout=60)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.parametrize("make, call", [
    ("espalier.bind(rest, points)", "made.deform(rest.positions.astype(np.float32))"),
    ("espalier.Refiner(rest)", "made.counts(4)"),
])
def test_a_signal_handler_asks_for_what_is_being_made(make, call):
    """A signal handler can call Espalier during a call of the same thread, without a deadlock."""
    run(f"""
def handle(*_):
    {call}
    calls.append(1)
signal.signal(signal.SIGALRM, handle)
made, calls = {make}, []
with espalier.ThreadLimit(1):  # the main thread, which handles signals, does the work
    signal.setitimer(signal.ITIMER_REAL, 0.001)
    {call}
while not calls:
    time.sleep(0.001)
""")


def test_an_interrupt_ends_a_long_call():
    # Times are of the processor, so that they do not depend on what else runs.
    code = """
import signal, time, numpy as np, espalier
rest = espalier.shapes.box(cells=(6, 6, 6))
points = np.random.default_rng(1).uniform(0.01, 0.99, (3_000_000, 3))
signal.signal(signal.SIGPROF, signal.default_int_handler)  # as Ctrl-C
with espalier.ThreadLimit(1):
    begin = time.process_time()
    signal.setitimer(signal.ITIMER_PROF, 0.1)
    try:
        espalier.bind(rest, points)
    except KeyboardInterrupt:
        print(time.process_time() - begin)
    espalier.bind(rest, points[:10])  # all is well
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True,
                          timeout=120)
    assert done.returncode == 0, done.stderr
    # Without the signal, the call would take 3 seconds or more; with it, it takes 0.15.
    assert done.stdout and float(done.stdout) < 0.5
