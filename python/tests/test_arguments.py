"""Arguments that cannot be, recipes, and the book's page."""

import doctest
import json
import os
import pathlib
import pickle
import re

import numpy
import pytest
from conftest import SIDE, small

import plenoscope

SAMPLE = plenoscope.sample()


@pytest.mark.parametrize(
    ("wrong", "sentence"),
    [
        ({"f_number": 0.5}, "f_number: an f-number from 28"),
        ({"lens": "blades:4"}, "lens: 5 to 9 blades are wanted"),
        ({"grain": 2}, "grain: a number from 0 to 1 is wanted"),
        ({"bits": 12}, "bits: 8 or 16 is wanted"),
        ({"quality": 0}, "quality: 0 is not in 1..=100"),
        ({"depth_scale": "long"}, "depth_scale: \"long\" is no scale of depth"),
        ({"long_side": 8}, "long_side: 8 is not in 16..=4096"),
        ({"size": (0, 5)}, "size: photo or light-field"),
        ({"size": "large"}, "size: photo or light-field"),
        ({"focus": (1, 2), "focus_disparity": 0}, "leave one of them out"),
        ({"source": "network", "disparity": numpy.zeros((4, 4))}, "leave one of them out"),
        ({"disparity": numpy.full((4, 4), numpy.nan)}, "not numbers"),
        ({"focus_disparity": float("nan")}, "focus_disparity"),
    ],
)
def test_values_that_cannot_be_are_value_errors(wrong, sentence):
    with pytest.raises(plenoscope.UsageError, match=re.escape(sentence)) as error:
        plenoscope.refocus(SAMPLE, **wrong)
    assert isinstance(error.value, ValueError)


@pytest.mark.parametrize(
    "wrong", [{"f_number": "wide"}, {"focus": 3}, {"focus": "flower"}, {"long_side": 1.5}, {"size": 3}, {"recipe": 3}, {"progress": 3}, {"disparity": 3}]
)
def test_values_of_the_wrong_type_are_type_errors(wrong):
    (name,) = wrong
    with pytest.raises(TypeError, match=f"{name}: .* wanted, not"):
        plenoscope.refocus(SAMPLE, **wrong)


def test_an_unknown_argument_is_a_type_error():
    with pytest.raises(TypeError, match="fnumber"):
        plenoscope.refocus(SAMPLE, fnumber=2)


def test_a_light_field_has_one_line_at_a_time(field):
    for wrong in ({}, {"row": 1, "column": 1}):
        with pytest.raises(plenoscope.UsageError, match="a row"):
            plenoscope.epi(field, **wrong)
    with pytest.raises(plenoscope.UsageError, match="a photo"):
        plenoscope.read_light_field(os.environ["PLENOSCOPE_BOOK"].replace("python.md", "images/window.jpg"))


@pytest.fixture
def recipe():
    lens = {"f_number": 1.8, "focus": {"at": [0.4, 0.4]}}
    return plenoscope.Recipe({"version": 2, "lens": lens, "export": {"format": "png"}, "stars": 5})


def test_a_recipe_is_what_the_command_line_reads(recipe, inputs, command, tmp_path):
    recipe.save(tmp_path / "edit.json")
    for source, args in ((None, []), ("network", ["--source", "network"])):
        theirs = tmp_path / "theirs.png"
        command("refocus", inputs / "photo.png", "-o", theirs, "--recipe", tmp_path / "edit.json", *args, *small())
        picture = recipe.apply(inputs / "photo.png", output=tmp_path / "ours.png", long_side=SIDE, source=source)
        assert (tmp_path / "ours.png").read_bytes() == theirs.read_bytes()
        by_file = plenoscope.refocus(inputs / "photo.png", recipe=tmp_path / "edit.json", long_side=SIDE, source=source)
        assert numpy.array_equal(picture, by_file)


def test_the_source_of_a_recipe_is_heard(inputs):
    with_net = plenoscope.Recipe({"version": 2, "lens": {}, "depth": {"net": {"name": "paper-flowers"}}})
    own, theirs = (plenoscope.refocus(inputs / "photo.png", recipe=one, f_number=1.4, long_side=SIDE)
                   for one in (plenoscope.Recipe({"version": 2, "lens": {}}), with_net))
    assert not numpy.array_equal(own, theirs)
    named = plenoscope.refocus(inputs / "photo.png", recipe=with_net, source="network", f_number=1.4, long_side=SIDE)
    assert numpy.array_equal(named, own), "what is asked for goes before the recipe"


def test_recipes_come_back(recipe, tmp_path):
    recipe.save(tmp_path / "p.jpg.plenoscope.json")
    read = plenoscope.Recipe.of_photo(tmp_path / "p.jpg")
    assert plenoscope.Recipe.of_photo(tmp_path / "q.jpg") is None
    for other in (read, plenoscope.Recipe.load(tmp_path / "p.jpg.plenoscope.json"), pickle.loads(pickle.dumps(read))):
        assert other == read and other.as_dict()["stars"] == 5
    assert json.loads(read.to_json())["lens"]["f_number"] == pytest.approx(1.8)
    with pytest.raises(plenoscope.UsageError, match="f_number"):
        plenoscope.Recipe({"version": 2, "lens": {"f_number": -2}})


def test_the_books_page():
    page = pathlib.Path(os.environ["PLENOSCOPE_BOOK"]).read_text()
    blocks = re.findall(r"^```python\n(.*?)^```$", page, re.M | re.S)
    assert blocks
    test = doctest.DocTestParser().get_doctest("\n".join(blocks), {}, "python.md", "python.md", 0)
    said = []
    doctest.DocTestRunner().run(test, out=said.append)
    assert not said, "".join(said)
