import numpy as np
import pytest
import yaml
from hypothesis import given

from cohelm.errors import ConfigError
from cohelm.geometry import distance_to_polygon, inside_polygon
from cohelm.robots import Robot, load_robot, robot_names
from cohelm.testing.strategies import polygons

PLAIN = {
    "name": "box",
    "footprint": [[0.5, 0.3], [-0.4, 0.3], [-0.4, -0.3], [0.5, -0.3]],
    "max_speed": 1.0,
    "max_turn_rate": 1.0,
    "max_acceleration": 0.8,
    "max_deceleration": 1.0,
    "emergency_deceleration": 1.5,
    "max_turn_acceleration": 2.0,
}


def robot(**changes):
    return Robot.model_validate({**PLAIN, **changes})


@pytest.mark.parametrize("name", robot_names())
def test_every_robot_that_comes_along_loads_and_says_what_is_assumed(name):
    loaded = load_robot(name)
    assert loaded.name == name
    assert loaded.source
    assert loaded.motion_model.inputs >= 1


def test_the_q6_is_as_the_maker_says(chair):
    width = np.ptp(chair.outline[:, 1])
    assert width == pytest.approx(0.61)
    # a base of 0.91 m and 0.20 m of footrests
    assert np.ptp(chair.outline[:, 0]) == pytest.approx(1.11)
    assert chair.inscribed_radius == pytest.approx(0.305)
    assert chair.circumscribed_radius == pytest.approx(np.hypot(0.65, 0.305))


@given(polygons())
def test_discs_cover_the_footprint(corners):
    """Also at points between them: every point of a fine lattice inside is inside a disc."""
    made = robot(footprint=corners.tolist())
    low, high = corners.min(axis=0), corners.max(axis=0)
    x, y = np.meshgrid(*(np.linspace(low[i], high[i], 25) for i in (0, 1)))
    lattice = np.stack([x.ravel(), y.ravel()], axis=-1)
    lattice = np.vstack([lattice[inside_polygon(made.outline, lattice)], made.outline])
    gap = np.linalg.norm(lattice[:, None] - made.discs[:, :2], axis=-1) - made.discs[:, 2]
    assert gap.min(axis=1).max() < 1e-9


@given(polygons())
def test_discs_overhang_the_bounding_box_by_at_most_three_centimetres_at_the_side(corners):
    made = robot(footprint=corners.tolist())
    narrow = np.ptp(made.outline, axis=0).min()
    assert made.discs[:, 2].max() <= narrow / 2.0 + 0.03 + 1e-9


@given(polygons())
def test_inscribed_and_circumscribed_discs_fit(corners):
    made = robot(footprint=corners.tolist())
    angle = np.linspace(0.0, 2.0 * np.pi, 90)
    circle = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    for p in 0.999 * made.inscribed_radius * circle:
        assert distance_to_polygon(made.outline, *p) < 0.0
    for p in 1.001 * made.circumscribed_radius * circle:
        assert distance_to_polygon(made.outline, *p) > 0.0


def test_a_clockwise_footprint_is_turned_round():
    there = robot()
    back = robot(footprint=PLAIN["footprint"][::-1])
    assert set(back.footprint) == set(there.footprint)
    assert back.footprint == tuple(tuple(corner) for corner in PLAIN["footprint"])


def test_limits_are_in_the_order_that_kinematics_wants():
    made = robot(max_reverse_speed=0.2)
    assert made.limits.tolist() == [1.0, 0.2, 1.0, 0.8, 1.0, 2.0]
    assert not made.limits.flags.writeable


def test_one_s_own_chair_is_one_file(tmp_path):
    file = tmp_path / "mine.yaml"
    file.write_text(yaml.safe_dump({**PLAIN, "name": "mine"}), encoding="utf-8")
    assert load_robot(file) == robot(name="mine")
    assert load_robot(str(file)) == robot(name="mine")


BAD = {
    "a footprint of two corners": ({"footprint": [[0, 0], [1, 1]]}, "footprint", "three corners"),
    "a footprint that is a line": (
        {"footprint": [[-1, 0], [0, 0], [1, 0]]},
        "footprint",
        "no area",
    ),
    "a footprint beside the axle": (
        {"footprint": [[1, 0], [2, 0], [2, 1]]},
        "footprint",
        "does not contain the drive axle",
    ),
    "a corner that is not a number": (
        {"footprint": [[0.5, 0.3], [-0.4, float("nan")], [-0.4, -0.3]]},
        "footprint",
        "",
    ),
    "an unknown motion model": (
        {"kinematics": "unicicle"},
        "kinematics",
        "did you mean 'unicycle'",
    ),
    "no speed": ({"max_speed": 0.0}, "max_speed", "greater than 0"),
    "a speed in words": ({"max_speed": "fast"}, "max_speed", "got 'fast'"),
    "brakes that disagree": (
        {"emergency_deceleration": 0.5},
        "",
        "emergency_deceleration must not be below max_deceleration",
    ),
    "a misspelt key": ({"max_sped": 1.0}, "max_sped", "did you mean 'max_speed'"),
    "a misspelt key of a laser": (
        {"lasers": [{"beems": 9}]},
        "lasers.0.beems",
        "unknown",
    ),
    "a laser of one beam": ({"lasers": [{"beams": 1}]}, "lasers.0.beams", "greater than or equal"),
}


@pytest.mark.parametrize("case", BAD)
def test_a_wrong_robot_file_is_one_line_with_file_key_and_what_to_do(tmp_path, case):
    changes, key, says = BAD[case]
    file = tmp_path / "mine.yaml"
    file.write_text(yaml.safe_dump({**PLAIN, **changes}), encoding="utf-8")
    with pytest.raises(ConfigError) as raised:
        load_robot(file)
    message = str(raised.value)
    assert raised.value.file == file
    assert raised.value.key.startswith(key)
    assert says in message
    assert "\n" not in message


def test_an_unknown_name_names_the_nearest():
    with pytest.raises(ConfigError, match="did you mean 'quantum_q6_edge'"):
        load_robot("quantum_q6")


def test_a_missing_file_says_so():
    with pytest.raises(ConfigError, match="no such file"):
        load_robot("nowhere/mine.yaml")
