"""Long work: other threads run, progress is told, what is raised stops it."""

import os
import signal
import subprocess
import sys
import threading
import time
import warnings

import numpy
import pytest
from conftest import SIDE

import plenoscope

#: Work that takes some seconds, so that what happens meanwhile happens.
LONG = {"long_side": 1200, "cache": False}


class Enough(Exception):
    pass


def test_other_threads_run_meanwhile():
    steps = 0
    is_over = threading.Event()

    def count():
        nonlocal steps
        while not is_over.is_set():
            steps += 1
            time.sleep(0.01)

    thread = threading.Thread(target=count)
    thread.start()
    plenoscope.synthesize(plenoscope.sample(), long_side=360, cache=False)
    is_over.set()
    thread.join()
    assert steps > 10


def test_progress_is_told_and_goes_on():
    told = []
    plenoscope.synthesize(
        plenoscope.sample(), long_side=360, cache=False, progress=lambda *all: told.append(all)
    )
    assert told and all(0 <= done <= total for _, done, total in told)
    stages = [stage for stage, *_ in told]
    order = list(dict.fromkeys(stages))
    assert stages == sorted(stages, key=order.index), "no stage comes back"


def test_what_progress_raises_stops_the_work():
    told = []

    def enough(stage, done, total):
        told.append((stage, done, total))
        raise Enough(stage)

    with pytest.raises(Enough):
        plenoscope.synthesize(plenoscope.sample(), progress=enough, **LONG)
    assert len(told) == 1 and told[0][1] < told[0][2], "it stopped at the first word, long before its end"


def test_ctrl_c_stops_the_work_and_the_next_goes_on():
    # Who runs the tests in the background has Ctrl+C ignored, and children inherit that.
    script = f"""
import signal
import plenoscope
signal.signal(signal.SIGINT, signal.default_int_handler)
try:
    plenoscope.synthesize(plenoscope.sample(), progress=lambda *_: print("works", flush=True), **{LONG!r})
    print("done")
except KeyboardInterrupt:
    print(plenoscope.depth(plenoscope.sample(), long_side=60).shape)
"""
    child = subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, text=True)
    assert child.stdout.readline() == "works\n"
    child.send_signal(signal.SIGINT)
    rest = child.communicate()[0].splitlines()
    assert child.returncode == 0 and rest[-1] == "(40, 60)", rest


def test_warnings_are_warnings():
    with pytest.warns(plenoscope.PlenoscopeWarning, match="the photo's shape is kept"):
        plenoscope.refocus(plenoscope.sample(), size=(300, 100), long_side=SIDE)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(plenoscope.PlenoscopeWarning):
            plenoscope.refocus(plenoscope.sample(), size=(300, 100), long_side=SIDE)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="there is no fork on this system")
def test_a_fork_says_why_it_cannot_work():
    plenoscope.sample()
    reader, writer = os.pipe()
    child = os.fork()
    if child == 0:
        try:
            plenoscope.sample()
            os.write(writer, b"it worked")
        except plenoscope.Error as error:
            os.write(writer, str(error).encode())
        finally:
            os._exit(0)
    os.close(writer)
    os.waitpid(child, 0)
    assert "spawn" in os.read(reader, 1000).decode()


def test_several_threads_work_at_once():
    results = {}

    def work(n):
        results[n] = plenoscope.refocus(plenoscope.sample(), f_number=2, size=(150, 100), long_side=SIDE)

    threads = [threading.Thread(target=work, args=(n,)) for n in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(results) == 4 and all(numpy.array_equal(results[0], other) for other in results.values())
