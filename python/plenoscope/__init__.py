"""Turns a photo into a 4-D RGBD light field, to look into and to refocus.

>>> import plenoscope
>>> field = plenoscope.synthesize(plenoscope.sample(), long_side=60)
>>> field.views.shape, field.depths.shape
((8, 8, 40, 60, 3), (8, 8, 40, 60))

Arrays are ``[v, u, y, x, c]`` and ``[v, u, y, x]``: ``v`` counts views downwards, ``u`` to the right. Disparities are in
pixels per view step of the array's own width; larger is nearer. Whatever takes an input takes a path, a `Photo`, a
`LightField`, or an array ``[y, x, c]`` of sRGB bytes. Names and numbers are those of the command line, and so are the
results, byte for byte.
"""

from ._errors import Error, FileError, PlenoscopeWarning, UsageError
from ._functions import (
    depth,
    epi,
    light_field,
    open,
    photo,
    read_light_field,
    refocus,
    sample,
    synthesize,
    view,
    write_light_field,
)
from ._native import LightField, Photo, Recipe

__all__ = [
    "Error",
    "FileError",
    "LightField",
    "Photo",
    "PlenoscopeWarning",
    "Recipe",
    "UsageError",
    "depth",
    "epi",
    "light_field",
    "open",
    "photo",
    "read_light_field",
    "refocus",
    "sample",
    "synthesize",
    "view",
    "write_light_field",
]
