"""What the tests share: the command line, and inputs that both it and the package take."""

import os
import pathlib
import subprocess

import numpy
import pytest
from PIL import Image

import plenoscope

#: Long side of the views, small so that the nets take no time.
SIDE = 90


@pytest.fixture(scope="session")
def program(tmp_path_factory):
    """Runs `plenoscope` with a cache of its own, and says what came of it."""
    path = os.environ["PLENOSCOPE_PROGRAM"]
    env = {**os.environ, "XDG_CACHE_HOME": os.fspath(tmp_path_factory.mktemp("cache"))}

    def run(*args):
        return subprocess.run([path, *map(os.fspath, args)], capture_output=True, text=True, check=False, env=env)

    return run


@pytest.fixture(scope="session")
def command(program):
    """Runs `plenoscope`, which must succeed."""

    def run(*args):
        done = program(*args)
        assert done.returncode == 0, done.stderr

    return run


@pytest.fixture(scope="session")
def inputs(command, tmp_path_factory):
    """A photo of 8 bits, one of 16, and a recorded light field."""
    folder = tmp_path_factory.mktemp("inputs")
    command("sample", "-o", folder)
    photo = Image.open(folder / "sample.png").resize((360, 240))
    photo.save(folder / "photo.png")
    command("refocus", folder / "photo.png", "-o", folder / "deep.tif", "--bits", "16", "--f-number", "28", *small())
    command("synth", folder / "photo.png", "-o", folder / "field", *small())
    return folder


def small():
    return ["--long-side", str(SIDE)]


def decoded(path):
    """The pixels of a picture, decoded by other people's code."""
    return numpy.asarray(Image.open(path).convert("RGB"))


def pfm(path):
    """The numbers of a PFM file."""
    head, width_height, scale, values = pathlib.Path(path).read_bytes().split(b"\n", 3)
    assert head == b"Pf" and float(scale) < 0
    width, height = map(int, width_height.split())
    return numpy.frombuffer(values, "<f4").reshape(height, width)[::-1]


@pytest.fixture(scope="session")
def field():
    """A light field of the sample."""
    return plenoscope.synthesize(plenoscope.sample(), long_side=SIDE)
