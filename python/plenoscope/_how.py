"""How light fields are made of photos: the arguments that every function takes which may have to make one."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any, Callable, Optional, Union

if TYPE_CHECKING:
    from typing import TypedDict

    import numpy
    from numpy.typing import NDArray

    from ._native import LightField, Photo, Recipe

    Path = Union[str, "os.PathLike[str]"]
    #: What functions work on.
    Input = Union[Path, Photo, LightField, NDArray[numpy.uint8]]
    #: A map of one's own.
    Map = Union[Path, NDArray[numpy.floating[Any]]]
    #: Is told what is done, and how many units of how many.
    Progress = Callable[[str, int, int], object]

    class How(TypedDict, total=False):
        """See `how`."""

        long_side: Optional[int]
        disparity: Optional[Map]
        source: Optional[str]
        depth_scale: Optional[str]
        models: Optional[Path]
        threads: Optional[int]
        lambertian: bool
        recipe: Union[Recipe, Path, None]
        cache: bool
        progress: Optional[Progress]


def how(
    *,
    long_side: Optional[int] = None,
    disparity: Optional[Map] = None,
    source: Optional[str] = None,
    depth_scale: Optional[str] = None,
    models: Optional[Path] = None,
    threads: Optional[int] = None,
    lambertian: bool = False,
    recipe: Union[Recipe, Path, None] = None,
    cache: bool = True,
    progress: Optional[Progress] = None,
) -> dict[str, Any]:
    """Gathers the arguments.

    long_side: of a view, in pixels; by default 540. A smaller photo is not enlarged.
    disparity: the ray depth of the reference view, in place of a net's: a PFM file, or an array ``[y, x]`` in pixels per
        view step at its own width.
    source: where ray depth comes from: "auto" (the phone's depth, else the net that the person prefers, else our own),
        "network", "phone", "fused", or the name of a depth net.
    depth_scale: how far ray depths of a net reach, "deep" (the default) or "lytro".
    models: takes the nets from this folder.
    threads: that compute; 0 is one for each core.
    lambertian: leaves the occlusion net out.
    recipe: an edit, or its file: where depth comes from, and what was mended of it; for `refocus` all of it. Other
        arguments go before it.
    cache: looks for a light field of last time, and keeps this one.
    progress: is called ``progress(stage, done, total)``, at most twenty times a second. What it raises stops the work.
    """
    return locals()
