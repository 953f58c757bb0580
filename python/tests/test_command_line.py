"""The package gives what the command line writes, byte for byte."""

import filecmp

import numpy
import pytest
from conftest import SIDE, decoded, pfm, small

import plenoscope

LENSES = [
    ({}, []),
    ({"f_number": 2, "focus": (120, 100)}, ["--f-number", "2", "--focus", "120,100"]),
    ({"f_number": 1.4, "focus_disparity": -0.1, "lens": "blades:6"},
     ["--f-number", "1.4", "--focus-disparity", "-0.1", "--lens", "blades:6"]),
    ({"keep_sharp": (-0.05, 0.1), "tilt": (0.1, -0.05), "at": (-1.5, 0.5)},
     ["--keep-sharp", "-0.05..0.1", "--tilt", "0.1,-0.05", "--at", "-1.5,0.5"]),
    ({"highlights": 0.5, "grain": 0.3, "size": (180, 120)}, ["--highlights", "0.5", "--grain", "0.3", "--size", "180x120"]),
    ({"size": "light-field"}, ["--size", "light-field"]),
]


@pytest.mark.parametrize(("asked", "args"), LENSES)
@pytest.mark.parametrize("name", ["photo.png", "field"])
def test_refocus(inputs, command, tmp_path, name, asked, args):
    if name == "field" and "size" in asked and asked["size"] != "light-field":
        asked, args = {**asked, "size": (60, 40)}, [*args[:-1], "60x40"]
    if name == "field" and "focus" in asked:
        asked, args = {**asked, "focus": (30, 25)}, [*args[:-1], "30,25"]
    ours, theirs = tmp_path / "ours.png", tmp_path / "theirs.png"
    command("refocus", inputs / name, "-o", theirs, *args, *small())
    picture = plenoscope.refocus(inputs / name, output=ours, long_side=SIDE, **asked)
    assert filecmp.cmp(ours, theirs, shallow=False)
    assert numpy.array_equal(picture, decoded(theirs))
    assert numpy.array_equal(picture, plenoscope.refocus(plenoscope.open(inputs / name), long_side=SIDE, **asked))


def test_16_bits_stay(inputs, command, tmp_path):
    ours, theirs = tmp_path / "ours.tif", tmp_path / "theirs.tif"
    command("refocus", inputs / "deep.tif", "-o", theirs, "--f-number", "2", *small())
    picture = plenoscope.refocus(inputs / "deep.tif", f_number=2, output=ours, long_side=SIDE)
    assert picture.dtype == numpy.uint16
    assert filecmp.cmp(ours, theirs, shallow=False)
    assert numpy.array_equal(picture, plenoscope.open(theirs).pixels)


def test_a_jpeg_and_its_settings(inputs, command, tmp_path):
    ours, theirs = tmp_path / "ours.jpg", tmp_path / "theirs.jpg"
    command("refocus", inputs / "photo.png", "-o", theirs, "--quality", "70", "--strip-metadata", *small())
    plenoscope.refocus(inputs / "photo.png", output=ours, quality=70, strip_metadata=True, long_side=SIDE)
    assert filecmp.cmp(ours, theirs, shallow=False)


@pytest.mark.parametrize("name", ["photo.png", "field"])
def test_view(inputs, command, tmp_path, name):
    command("view", inputs / name, "-o", tmp_path / "view.png", "--at", "-2.5,1", *small())
    seen = plenoscope.view(inputs / name, at=(-2.5, 1), long_side=SIDE)
    assert numpy.array_equal(seen, decoded(tmp_path / "view.png"))


@pytest.mark.parametrize("line", [{"row": 30}, {"column": 40, "scale": 3}])
def test_epi(inputs, command, tmp_path, line):
    args = [part for name, value in line.items() for part in (f"--{name}", str(value))]
    command("epi", inputs / "photo.png", "-o", tmp_path / "epi.png", *args, *small())
    assert numpy.array_equal(plenoscope.epi(inputs / "photo.png", long_side=SIDE, **line), decoded(tmp_path / "epi.png"))


@pytest.mark.parametrize("view", [None, (0, 7)])
@pytest.mark.parametrize("name", ["photo.png", "field"])
def test_depth(inputs, command, tmp_path, name, view):
    args = ["--view", "0,7"] if view else []
    command("depth", inputs / name, "-o", tmp_path / "depth.pfm", *args, *small())
    assert numpy.array_equal(plenoscope.depth(inputs / name, view=view, long_side=SIDE), pfm(tmp_path / "depth.pfm"))


def test_the_scale_of_a_camera(inputs, command, tmp_path):
    command("depth", inputs / "photo.png", "-o", tmp_path / "depth.pfm", "--depth-scale", "lytro", *small())
    ours = plenoscope.depth(inputs / "photo.png", depth_scale="lytro", long_side=SIDE)
    assert numpy.array_equal(ours, pfm(tmp_path / "depth.pfm"))


def test_a_map_of_ones_own(inputs, command, tmp_path):
    own = inputs / "sample.pfm"
    command("refocus", inputs / "sample.png", "-o", tmp_path / "theirs.png", "--disparity", own, "--size", "300x200")
    theirs = decoded(tmp_path / "theirs.png")
    for disparity in (own, pfm(own)):
        assert numpy.array_equal(plenoscope.refocus(inputs / "sample.png", disparity=disparity, size=(300, 200)), theirs)


@pytest.mark.parametrize("format", ["views", "hci", "stanford", "eslf", "quilt"])
def test_light_fields(inputs, command, tmp_path, format):
    command("synth", inputs / "photo.png", "-o", tmp_path / "theirs", "--format", format, *small())
    field = plenoscope.synthesize(inputs / "photo.png", long_side=SIDE)
    written = plenoscope.write_light_field(field, tmp_path / "ours", format=format)
    assert written.startswith(str(tmp_path / "ours"))
    compared = filecmp.dircmp(tmp_path / "ours", tmp_path / "theirs")
    assert compared.left_list and not compared.left_only and not compared.right_only
    same, *other = filecmp.cmpfiles(compared.left, compared.right, compared.common_files, shallow=False)
    # The scene's name is the folder's.
    assert set(sum(other, [])) <= {"parameters.cfg"} and same


@pytest.mark.parametrize(
    ("arguments", "call"),
    [
        (["refocus", "away.jpg", "-o", "out.png"], lambda: plenoscope.refocus("away.jpg")),
        (["refocus", "broken.png", "-o", "out.png"], lambda: plenoscope.refocus("broken.png")),
        (["refocus", "photo.png", "-o", "photo.png"], lambda: plenoscope.refocus("photo.png", output="photo.png")),
        (["refocus", "photo.png", "-o", "out.xyz"], lambda: plenoscope.refocus("photo.png", output="out.xyz")),
        (["refocus", "photo.png", "-o", "o.png", "--size", "999x999"], lambda: plenoscope.refocus("photo.png", size=(999, 999))),
        (["refocus", "photo.png", "-o", "o.png", "--focus", "999,1", *small()],
         lambda: plenoscope.refocus("photo.png", focus=(999, 1), long_side=SIDE)),
        (["refocus", "photo.png", "-o", "o.png", "--recipe", "broken.png"], lambda: plenoscope.refocus("photo.png", recipe="broken.png")),
        (["refocus", "photo.png", "-o", "o.png", "--models", "nowhere"], lambda: plenoscope.refocus("photo.png", models="nowhere")),
        (["epi", "field", "-o", "o.png", "--row", "99"], lambda: plenoscope.epi("field", row=99)),
        (["depth", "field", "-o", "o.pfm", "--view", "8,0"], lambda: plenoscope.depth("field", view=(8, 0))),
        (["synth", "field", "-o", "again"], lambda: plenoscope.synthesize("field")),
    ],
)
def test_errors_are_the_same_sentence(inputs, program, monkeypatch, arguments, call):
    monkeypatch.chdir(inputs)
    (inputs / "broken.png").write_bytes(b"\x89PNG\r\n\x1a\n no picture")
    theirs = program(*arguments)
    with pytest.raises(plenoscope.Error) as ours:
        call()
    assert theirs.stderr == f"error: {ours.value}\n"
    assert isinstance(ours.value, ValueError) == (theirs.returncode == 2)
