import json

import numpy as np
import pytest
from scipy.stats import spearmanr

from cohelm.benchmarks.external import socnav1
from cohelm.errors import ConfigError


def person(number, x, y, degrees):
    return {"id": number, "xPos": 100.0 * x, "yPos": 100.0 * y, "orientation": degrees}


def scene(score, people, objects=(), links=()):
    return {"score": score, "humans": people, "objects": list(objects), "links": list(links)}


def read(tmp_path, *scenes):
    file = tmp_path / "scenes.json"
    file.write_text("\n".join(json.dumps(each) for each in scenes))
    return socnav1.read_scenes(file)


def test_before_a_person_is_deeper_in_their_space_than_behind(tmp_path):
    """An orientation of 0 faces −y: a person at +y looks at the robot at the origin."""
    looks, away = read(tmp_path, scene(20, [person(1, 0, 1, 0)]), scene(80, [person(1, 0, 1, 180)]))
    assert socnav1.distance(looks) == socnav1.distance(away) == pytest.approx(1.0)
    assert socnav1.depth(looks) == pytest.approx(np.exp(-1.0 / (2 * 0.5**2)))
    assert socnav1.depth(away) == pytest.approx(np.exp(-1.0 / (2 * 0.25**2)))
    assert socnav1.gap(looks) < socnav1.gap(away)


def test_between_a_person_and_a_screen_is_a_space_as_well(tmp_path):
    people, screen = [person(1, 0, 1.5, 0)], person(2, 0, -1.5, 0)
    alone, watching, empty = read(
        tmp_path,
        scene(90, people, [screen]),
        scene(10, people, [screen], [[1, 2, "interact"]]),
        scene(100, []),
    )
    assert socnav1.between(watching, 0.7, 0.25) == pytest.approx(0.7)
    assert socnav1.between(alone, 0.7, 0.25) == socnav1.depth(alone)
    assert socnav1.group(watching) == socnav1.depth(watching)  # a screen is no member
    assert socnav1.depth(empty) == 0.0
    assert socnav1.distance(empty) == np.inf


def test_the_rank_correlation_is_scipys_with_ties():
    rng = np.random.default_rng(3)
    x, y = rng.integers(0, 9, (2, 5, 40)).astype(float)
    expected = [spearmanr(*pair).statistic for pair in zip(x, y, strict=True)]
    assert socnav1.spearman(x, y, axis=1) == pytest.approx(expected)


@pytest.mark.parametrize("line", ["", "{}", "[]", '{"score": 5', "\x00\xff"])
def test_what_is_no_scene_is_refused_with_its_line(tmp_path, line):
    file = tmp_path / "other.json"
    file.write_text(f"{json.dumps(scene(5, []))}\n{line}" if line else "")
    with pytest.raises(ConfigError, match="line 2 is no scene" if line else "has no scenes"):
        socnav1.read_scenes(file)
    beyond = json.dumps(scene(101, []))
    file.write_text(beyond)
    with pytest.raises(ConfigError, match="0 to 100"):
        socnav1.read_scenes(file)
