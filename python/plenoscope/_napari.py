"""A reader for napari: light fields as layers whose first two axes are the views (npe2; see napari.yaml)."""

from __future__ import annotations

from typing import Any, Callable, Optional, Union

import plenoscope

#: What napari adds: data, how it is shown, and the kind of layer.
Layer = tuple[Any, dict[str, Any], str]


def reader(path: Union[str, list[str]]) -> Optional[Callable[[Any], list[Layer]]]:
    """What reads a path; None where it holds no light field, so that napari asks others."""
    if isinstance(path, list):
        return None
    try:
        opened = plenoscope.open(path)
    except plenoscope.Error:
        return None
    if isinstance(opened, plenoscope.Photo):
        return None
    return lambda _path: layers(opened)


def layers(field: plenoscope.LightField) -> list[Layer]:
    """The views, and above them the depths where they are known; without a copy."""
    found: list[Layer] = [(field.views, {"name": field.name, "rgb": True, "metadata": {"reference": field.reference}}, "image")]
    if field.has_depths:
        depths = field.depths
        shown = {
            "name": f"{field.name} depths",
            "colormap": "turbo",
            "contrast_limits": (float(depths.min()), float(depths.max())),
            "visible": False,
        }
        found.append((depths, shown, "image"))
    return found
