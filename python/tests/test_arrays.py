"""Arrays: their axes, their memory, and what may be handed over in place of a file."""

import gc
import resource

import numpy
import pytest
from conftest import SIDE, decoded

import plenoscope


def test_views_are_windows_onto_the_light_fields_own_memory(field):
    views, depths = field.views, field.depths
    assert views.shape == (8, 8, 60, SIDE, 3) and views.dtype == numpy.uint8
    assert depths.shape == (8, 8, 60, SIDE) and depths.dtype == numpy.float32
    assert numpy.shares_memory(views, field.views) and numpy.shares_memory(depths, field.depths)
    assert not views.flags.writeable and not depths.flags.writeable
    with pytest.raises(ValueError, match="read-only"):
        views[0] = 0


def test_a_window_keeps_its_light_field_alive():
    field = plenoscope.synthesize(plenoscope.sample(), long_side=SIDE)
    views, kept = field.views, field.views.copy()
    del field
    gc.collect()
    assert numpy.array_equal(views, kept)


def test_looking_takes_no_memory():
    field = plenoscope.light_field(numpy.zeros((9, 9, 400, 400, 3), "uint8"), numpy.zeros((9, 9, 400, 400), "float32"))
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    windows = [(field.views, field.depths) for _ in range(100)]
    after = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    assert len(windows) == 100 and (after - before) * 1024 < field.views.size


def test_the_reference_view_is_the_photo(inputs):
    field = plenoscope.synthesize(inputs / "photo.png", long_side=360)
    assert field.grid == (8, 8) and field.reference == (4, 4) and field.size == (360, 240)
    assert numpy.array_equal(field.views[field.reference], decoded(inputs / "photo.png"))
    assert numpy.array_equal(field.depths[field.reference], plenoscope.depth(field))


def test_pixels_are_the_photos_own(inputs):
    photo = plenoscope.open(inputs / "photo.png")
    assert photo.size == (360, 240) and photo.name == "photo.png" and photo.path == inputs / "photo.png"
    assert numpy.array_equal(photo.pixels, decoded(inputs / "photo.png"))
    assert plenoscope.open(inputs / "deep.tif").pixels.dtype == numpy.uint16


def test_an_array_is_a_photo(inputs):
    pixels = decoded(inputs / "photo.png")
    by_file = plenoscope.refocus(inputs / "photo.png", f_number=2, long_side=SIDE)
    for given in (pixels, plenoscope.photo(pixels), numpy.asfortranarray(pixels)):
        assert numpy.array_equal(plenoscope.refocus(given, f_number=2, long_side=SIDE), by_file)


def test_arrays_are_a_light_field(field, tmp_path):
    copy = plenoscope.light_field(field.views, field.depths)
    assert numpy.array_equal(copy.views, field.views) and numpy.array_equal(copy.depths, field.depths)
    plenoscope.write_light_field(copy, tmp_path / "copy")
    read = plenoscope.read_light_field(tmp_path / "copy")
    assert numpy.array_equal(read.views, field.views) and numpy.array_equal(read.depths, field.depths)


def test_depths_of_views_alone_are_measured():
    rng = numpy.random.default_rng(5)
    wall = rng.integers(0, 255, (40, 80, 3)).astype("uint8")
    wall = wall.repeat(2, axis=0).repeat(2, axis=1)
    # Disparity 1: view u sees the wall one pixel further left for each step.
    views = numpy.stack([[numpy.roll(wall, (2 - v, 2 - u), axis=(0, 1)) for u in range(5)] for v in range(5)])
    depths = plenoscope.light_field(views).depths
    assert abs(numpy.median(depths) - 1) < 0.1


@pytest.mark.parametrize("wrong", [numpy.zeros((4, 6), "uint8"), numpy.zeros((4, 6, 2), "uint8"), 3, None])
def test_what_is_no_input_is_a_type_error(wrong):
    with pytest.raises(TypeError, match="wanted"):
        plenoscope.refocus(wrong)
