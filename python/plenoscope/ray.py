"""Many photos, many machines: a recipe over a Ray dataset (`pip install './python[ray]'`)."""

from __future__ import annotations

import os
import time
from typing import TYPE_CHECKING, Any, Union

import plenoscope

if TYPE_CHECKING:
    from ray.data import Dataset

    from ._how import Path


def refocus(
    dataset: Dataset,
    recipe: Union[plenoscope.Recipe, Path],
    *,
    photos: int = 4,
    cores: int = 1,
    force: bool = False,
    **options: Any,
) -> Dataset:
    """Puts the photos of a dataset through a recipe, and adds to each row what became of it.

    dataset: its column `path` names photos, its column `output` the picture of each, PNG, JPEG, TIFF or WebP by its ending.
        All machines must see both.
    photos: that a task takes.
    cores: of a task; its nets compute with as many threads.
    force: makes again what is there already.
    options: other arguments of `plenoscope.refocus`; they go before the recipe.

    The new columns are `state` ("made", "skipped" or "failed"), `secs` and `error`, a sentence. A picture gets its name when it
    is whole: where a worker dies, Ray runs its task again, and that makes what is not there.
    """
    edit = recipe if isinstance(recipe, plenoscope.Recipe) else plenoscope.Recipe.load(recipe)
    asked = {"threads": cores, "recipe": edit, **options}

    def one(path: str, output: str) -> tuple[str, float, str]:
        started = time.monotonic()
        state, error = "made", ""
        if not force and os.path.exists(output):
            state = "skipped"
        else:
            try:
                plenoscope.refocus(path, output=output, **asked)
            except plenoscope.Error as why:
                state, error = "failed", str(why)
        return state, round(time.monotonic() - started, 3), error

    def work(rows: dict[str, Any]) -> dict[str, Any]:
        done = [one(str(path), str(output)) for path, output in zip(rows["path"], rows["output"])]
        states, secs, errors = zip(*done)
        return {**rows, "state": list(states), "secs": list(secs), "error": list(errors)}

    return dataset.map_batches(work, batch_size=photos, num_cpus=cores, batch_format="numpy")
