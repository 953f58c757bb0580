"""napari opens our light fields through its own plugin engine."""

import os
import pathlib
import subprocess
import sys

import npe2
import numpy
import pytest
from npe2 import PluginManager, PluginManifest

import plenoscope

#: Libraries of Debian that Qt opens a window with.
QT_NEEDS = "libxcb-cursor0 libxcb-icccm4 libxcb-image0 libxcb-keysyms1 libxcb-render-util0 libxcb-xinerama0 libgl1 libegl1"


@pytest.fixture(scope="module")
def plugin():
    path = pathlib.Path(plenoscope.__file__).parent / "napari.yaml"
    manifest = PluginManifest.from_file(path)
    manifest.package_metadata = None
    manager = PluginManager.instance()
    manager.register(manifest)
    yield manifest
    manager.unregister(manifest.name)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    field = plenoscope.synthesize(plenoscope.sample(), long_side=90)
    where = tmp_path_factory.mktemp("napari") / "field"
    plenoscope.write_light_field(field, where)
    return where


def test_a_light_field_becomes_two_layers(plugin, folder):
    layers = npe2.read([os.fspath(folder)], stack=False, plugin_name=plugin.name)
    (views, how, kind), (depths, _, _) = layers
    assert kind == "image" and how["rgb"] and views.shape == (8, 8, 60, 90, 3) and depths.shape == (8, 8, 60, 90)
    read = plenoscope.read_light_field(folder)
    assert numpy.array_equal(views, read.views) and numpy.array_equal(depths, read.depths)


def test_a_photo_is_left_to_others(plugin, folder):
    with pytest.raises(ValueError, match="[Nn]o"):
        npe2.read([os.fspath(folder / "view_4_4.png")], stack=False, plugin_name=plugin.name)


def test_napari_shows_it(plugin, folder):
    opens = [sys.executable, "-c", "from qtpy.QtWidgets import QApplication; QApplication([])"]
    if not os.environ.get("DISPLAY") or subprocess.run(opens, capture_output=True, check=False).returncode != 0:
        pytest.skip(f"SKIPPED: Qt opens no window here — it needs a display, and on Debian: apt install {QT_NEEDS}")
    import napari
    from qtpy.QtWidgets import QApplication

    viewer = napari.Viewer()
    try:
        added = viewer.open(os.fspath(folder), plugin=plugin.name)
        assert [layer.name for layer in added] == ["field", "field depths"]
        assert viewer.dims.ndim == 4 and viewer.dims.nsteps[:2] == (8, 8)
        viewer.dims.set_current_step((0, 1), (4, 4))
        QApplication.processEvents()
        shown = viewer.screenshot(canvas_only=True, flash=False)
        assert shown[..., :3].std() > 5, "something is to be seen"
    finally:
        viewer.close()
