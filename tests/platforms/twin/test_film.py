"""Films are drawn from any ride, and say what is missing."""

import numpy as np
import pytest
from PIL import Image

from cohelm.errors import ConfigError, PlatformError
from cohelm.evaluation import run
from cohelm.platforms.twin import VIEWS, check_film, film, film_ride
from cohelm.scenarios import load_scenario


@pytest.fixture(scope="module")
def ride():
    return run(load_scenario("empty", ["time_limit=1"]), 0)


@pytest.fixture
def drawn(mujoco):
    try:
        film._OffScreen.context(mujoco, 16, 16).free()
    except PlatformError as cause:
        pytest.skip(f"films need EGL or OSMesa: {cause}")


def test_a_film_has_the_frames_of_its_ride(ride, tmp_path, drawn):
    film_ride(ride, tmp_path / "ride.gif", "follow")
    with Image.open(tmp_path / "ride.gif") as image:
        assert image.n_frames == 5  # 1 s, four a second, and the first
        assert image.size == film.SIZE


@pytest.mark.parametrize("view", VIEWS)
def test_a_view_shows_more_than_one_colour(ride, view, drawn):
    image = next(film._frames(ride, view, [0]))
    assert image.std() > 5.0


def test_the_chair_is_in_the_middle_of_the_view_from_above(ride, drawn):
    image = next(film._frames(ride, "above", [0])).astype(float)
    width, height = film.SIZE
    middle = image[height // 2 - 8 : height // 2 + 8, width // 2 - 8 : width // 2 + 8]
    assert middle.mean() < np.median(image) - 40.0  # a dark chair on a light floor


def test_an_unknown_view_is_refused(tmp_path):
    with pytest.raises(ConfigError, match="no view is called"):
        check_film(tmp_path / "ride.gif", "side")


def test_without_a_renderer_the_libraries_are_named(mujoco, monkeypatch):
    monkeypatch.setattr(film, "_BACKENDS", ("none",))
    with pytest.raises(PlatformError, match="need EGL or OSMesa"):
        film._OffScreen.context(mujoco, 16, 16)
