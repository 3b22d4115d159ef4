"""Keepout zones and speed limits from mask files, in real rides."""

from dataclasses import replace

import numpy as np
import pytest
import yaml

from cohelm.errors import GoalBlocked
from cohelm.evaluation import Episode, Outcome, run
from cohelm.geometry import distance_to_polygon
from cohelm.messages import Reason
from cohelm.scenarios import build_scenario, load_scenario

ZONE = np.array([[5.5, 5.0], [8.5, 5.0], [8.5, 8.6], [5.5, 8.6]])
"""Across the straight way of 10 m from (2, 7) to (12, 7) in the hall."""


@pytest.fixture
def masked(tmp_path):
    """A scenario in the hall with a mask whose zone holds ``value``."""

    def make(kind, value, settings=(), **keys):
        data = np.zeros((140, 140), dtype=np.uint8)
        data[50:86, 55:85] = value
        image = b"P5 140 140 255\n" + data[::-1].tobytes()  # its first row is the uppermost
        (tmp_path / "mask.pgm").write_bytes(image)
        header = {"image": "mask.pgm", "mode": "raw", "resolution": 0.1, "origin": [0, 0, 0]}
        header |= {"negate": 0, "occupied_thresh": 0.65, "free_thresh": 0.25}
        (tmp_path / "mask.yaml").write_text(yaml.safe_dump(header))
        mask = {"type": kind, "file": "mask.yaml", **keys}
        file = tmp_path / "mine.yaml"
        given = {"floor": "hall", "start": [2, 7, 0], "goal": [12, 7], "filters": [mask]}
        file.write_text(yaml.safe_dump(given))
        return load_scenario(file, ["mode=autonomous", "time_limit=60", *settings])

    return make


def depth(poses):
    """How far each pose's centre is inside the zone, m; negative outside."""
    return np.array([-distance_to_polygon(ZONE, x, y) for x, y, _ in poses])


def test_the_chair_goes_round_a_keepout_zone(masked):
    scenario = masked("keepout", 100)
    made = build_scenario(scenario, 0)
    ride = run(scenario, 0)
    assert ride.outcome is Outcome.REACHED
    assert depth(np.column_stack([made.route.points, made.route.points[:, 0]])).max() < 0.0
    # the zone is a wall to planner and gate: not the centre alone, the chair stays out
    assert depth(ride.pose).max() < -ride.robot.inscribed_radius + 0.05
    assert ride.replans == ()


def test_who_pushes_the_chair_to_a_keepout_zone_stands_before_it_and_reads_why(masked):
    settings = ["mode=assisted", "rider=ideal", "time_limit=20"]
    scenario = masked("keepout", 100, settings)
    made = build_scenario(scenario, 0)
    straight = np.linspace([2.0, 7.0], [12.0, 7.0], 100)
    pushed = replace(made, world=replace(made.world, rider_route=straight))
    told = []
    ride = Episode(pushed).run(lambda tick, _: told.append(tick.decision.reason))
    assert ride.outcome is not Outcome.REACHED
    front = ride.pose[:, 0] + 0.65
    assert front.max() < 5.5 + 0.02
    assert front.max() > 5.0
    stood = told[round(ride.stops[-1].time / 0.05) :]
    assert stood.count(Reason.KEEPOUT) > 0.5 * len(stood)


def test_a_goal_in_a_keepout_zone_is_refused_in_words(masked):
    with pytest.raises(GoalBlocked, match="a keepout zone"):
        build_scenario(masked("keepout", 100, ["goal=[7, 7]"]), 0)


@pytest.mark.parametrize(
    ("kind", "value", "limit"),
    [
        ("speed_percent", 75, 0.3),
        pytest.param("speed_absolute", 40, 0.4, marks=pytest.mark.slow),
    ],
)
@pytest.mark.parametrize("mode", ["autonomous", "assisted"])
def test_the_chair_is_slow_in_the_zone_from_the_moment_it_enters(masked, kind, value, limit, mode):
    """100 − 75 = 25 % of the robot's 1.2 m/s; 40 at 0.01 m/s each."""
    keys = {"multiplier": 0.01} if kind == "speed_absolute" else {}
    rider = "none" if mode == "autonomous" else "ideal"
    ride = run(masked(kind, value, [f"mode={mode}", f"rider={rider}"], **keys), 0)
    assert ride.outcome is Outcome.REACHED
    inside = depth(ride.pose) > 0.0
    assert inside.sum() > 3.0 / limit / 0.05 * 0.9
    assert ride.twist[inside, 0].max() <= limit + 0.01
    share = 0.9 if mode == "autonomous" else 0.6  # a stick's share is a share of the limit
    assert ride.twist[inside, 0].max() > share * limit
    assert ride.twist[~inside, 0].max() > 1.2 * limit
    assert ride.replans == ()


@pytest.mark.slow
def test_the_slower_of_mask_and_rider_holds(masked):
    settings = ["profile.preferred_speed=0.25", "time_limit=80"]
    ride = run(masked("speed_percent", 75, settings), 0)
    assert ride.twist[:, 0].max() <= 0.26
