"""What people call. Each hands its arguments to the library, which decides."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Optional, Union

from . import _native
from ._errors import UsageError
from ._how import how as _how
from ._native import LightField, Photo

if TYPE_CHECKING:
    import numpy
    from numpy.typing import NDArray
    from typing_extensions import Unpack

    from ._how import How, Input, Path, Progress

    Picture = NDArray[Union[numpy.uint8, numpy.uint16]]


def open(path: Path, *, progress: Optional[Progress] = None) -> Union[Photo, LightField]:
    """Opens a photo or a recorded light field. What a file is, is told by its content."""
    return _native.open(path, {"progress": progress})


def read_light_field(path: Path, *, progress: Optional[Progress] = None) -> LightField:
    """Opens a recorded light field: a folder of views, an HCI scene, a Stanford archive, an ESLF picture, a quilt."""
    opened = open(path, progress=progress)
    if isinstance(opened, Photo):
        raise UsageError(f"this is a photo — a light field is wanted — use plenoscope.synthesize: {path}")
    return opened


def sample() -> Photo:
    """The built-in sample photo, whose true disparity is known.

    >>> sample().size
    (1200, 800)
    """
    return _native.sample()


def photo(pixels: NDArray[numpy.uint8], name: str = "photo") -> Photo:
    """A photo of sRGB bytes, ``[y, x, c]``.

    >>> import numpy
    >>> photo(numpy.zeros((4, 6, 3), "uint8"))
    <plenoscope.Photo "photo", 6×4>
    """
    return _native.photo(pixels, name)


def light_field(
    views: NDArray[numpy.uint8],
    depths: Optional[NDArray[numpy.floating[Any]]] = None,
    name: str = "light field",
) -> LightField:
    """A light field of sRGB views, ``[v, u, y, x, c]``, with the disparity of every ray, ``[v, u, y, x]``, where it is known.

    >>> import numpy
    >>> light_field(numpy.zeros((3, 3, 4, 6, 3), "uint8"), numpy.zeros((3, 3, 4, 6)))
    <plenoscope.LightField "light field", 3×3 views of 6×4>
    """
    return _native.light_field(views, depths, name)


def synthesize(input: Input, /, **how: Unpack[How]) -> LightField:
    """Makes a light field of a photo. For the arguments see `plenoscope._how.how`."""
    return _native.synthesize(input, _how(**how))


def refocus(
    input: Input,
    /,
    *,
    output: Optional[Path] = None,
    f_number: Optional[float] = None,
    focus: Union[str, tuple[float, float], None] = None,
    focus_disparity: Optional[float] = None,
    lens: Optional[str] = None,
    keep_sharp: Optional[tuple[float, float]] = None,
    tilt: Optional[tuple[float, float]] = None,
    highlights: Optional[float] = None,
    grain: Optional[float] = None,
    at: Optional[tuple[float, float]] = None,
    size: Union[str, tuple[int, int], None] = None,
    bits: Optional[int] = None,
    quality: Optional[int] = None,
    strip_metadata: bool = False,
    force: bool = False,
    **how: Unpack[How],
) -> Picture:
    """The picture that another lens would have taken, ``[y, x, c]``, as it would stand in a file.

    A photo keeps its own colours and its own bits. With `output` the picture is written too, as PNG, JPEG, TIFF or WebP by
    the name's ending, with what the photo's file said about it.

    f_number: from 28 (the photo as it is) to 1; by default 3.5.
    focus: the pixel of the upright photo that is to be sharp, (x, y); or "subject", for what the photo most likely is about.
    focus_disparity: the disparity that is to be sharp; by default 0. Like `keep_sharp` and `tilt` in pixels of the map.
    lens: "disc", "square", "blades:5" to "blades:9", "ring", "cat-eye", or "picture:FILE", in which white is open.
    keep_sharp: disparities that stay sharp, (far, near).
    tilt: by how much the sharp disparity grows from left to right and from top to bottom.
    highlights: how much clipped lights are brightened before they are blurred, 0 to 1.
    grain: how much of the photo's grain is put back into blurred parts, 0 to 1.
    at: where the lens stands, (u, v) in steps from the reference view.
    size: "photo", "light-field", or (width, height).
    bits, quality, strip_metadata, force: as on the command line.
    how: see `plenoscope._how.how`; the recipe's edit is applied, other arguments go before it.

    >>> refocus(sample(), f_number=2, focus=(600, 500), size=(150, 100), long_side=60).shape
    (100, 150, 3)
    """
    given = {name: value for name, value in locals().items() if name not in ("input", "how")}
    return _native.refocus(input, {**given, **_how(**how)})


def view(input: Input, /, *, at: tuple[float, float], **how: Unpack[How]) -> NDArray[numpy.uint8]:
    """The view from a place of the lens, (u, v) in steps from the reference view, fractions allowed; ``[y, x, c]``.

    >>> view(sample(), at=(-3, 0.5), long_side=60).shape
    (40, 60, 3)
    """
    return _native.view(input, {"at": at, **_how(**how)})


def epi(
    input: Input,
    /,
    *,
    row: Optional[int] = None,
    column: Optional[int] = None,
    scale: Optional[int] = None,
    **how: Unpack[How],
) -> NDArray[numpy.uint8]:
    """An epipolar slice: a row or a column of the picture in all views beside each other, ``[y, x, c]``, the views downwards.

    Each view is `scale` rows thick, by default 8.

    >>> epi(sample(), row=20, scale=1, long_side=60).shape
    (8, 60, 3)
    """
    return _native.epi(input, {"row": row, "column": column, "scale": scale, **_how(**how)})


def depth(input: Input, /, *, view: Optional[tuple[int, int]] = None, **how: Unpack[How]) -> NDArray[numpy.float32]:
    """The disparity of a view, (v, u), by default that of the reference view; ``[y, x]``, in pixels per view step.

    >>> depth(sample(), long_side=60).shape
    (40, 60)
    """
    return _native.depth(input, {"view": view, **_how(**how)})


def write_light_field(
    input: Input, output: Path, /, *, format: Optional[str] = None, force: bool = False, **how: Unpack[How]
) -> str:
    """Writes a light field, and says where: as "views" (the default), "eslf", "hci", "stanford" or "quilt"."""
    import os

    return os.fspath(_native.write_light_field(input, output, {"format": format, "force": force, **_how(**how)}))
