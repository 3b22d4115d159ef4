"""The benchmark of edges: what it draws, its hands, and its report."""

import numpy as np
import pytest

from cohelm.benchmarks.rides import edges
from cohelm.benchmarks.rides.edges import EDGES, HANDS, SAFE, draw
from cohelm.errors import ConfigError
from cohelm.evaluation.sweeps import RideTask
from cohelm.geometry import transform
from cohelm.robots import load_robot
from cohelm.scenarios.floor import relief_of
from cohelm.scenarios.scenario import load_scenario

CHAIR = load_robot(edges.ROBOT)


def drawn(kind, hand, seed):
    return load_scenario("empty", [f"robot={edges.ROBOT}", *draw(kind, hand, CHAIR, seed)])


def heights(scenario, points):
    return relief_of(scenario.storey).heights(points)


@pytest.mark.parametrize("hand", HANDS)
@pytest.mark.parametrize("kind", EDGES)
def test_a_chair_starts_before_an_edge_that_it_cannot_take(kind, hand):
    for seed in range(20):
        scenario = drawn(kind, hand, seed)
        pose = np.array([*scenario.start[:2], np.radians(scenario.start[2])])
        here = heights(scenario, transform(pose, CHAIR.wheels))
        assert np.ptp(here) <= 0.06  # on level floor, or on a ramp of 1:20
        # somewhere on its way the floor falls by 5 cm or more
        way = scenario.start[:2] + np.linspace(0.0, 1.0, 400)[:, None] * (
            np.array(scenario.goal) - scenario.start[:2]
        )
        assert np.diff(heights(scenario, way)).min() <= -0.0499


@pytest.mark.parametrize("kind", SAFE)
def test_safe_floors_have_no_step_that_a_chair_cannot_take(kind):
    for seed in range(20):
        scenario = drawn(kind, "steers beyond", seed)
        way = scenario.start[:2] + np.linspace(0.0, 1.0, 400)[:, None] * (
            np.array(scenario.goal) - scenario.start[:2]
        )
        assert np.abs(np.diff(heights(scenario, way))).max() <= 0.0201


@pytest.mark.parametrize(
    "given", [{"kinds": "cliff"}, {"hands": "third"}, {"settings": ("start=[1, 1, 0]",)}]
)
def test_what_does_not_exist_or_is_drawn_cannot_be_set(given):
    with pytest.raises(ConfigError):
        edges.create(**given)


def test_the_report_counts_falls_and_false_stops(tmp_path):
    bench = edges.create(kinds="kerb,level", hands="pushes on", modes="stop_only")
    kerb, level = bench.tasks(range(1))
    # without protection, the stick alone drives over the edge
    manual = tuple(
        RideTask(each.columns, each.scenario, (*each.settings, "mode=manual"), each.seed)
        for each in kerb
    )
    rows = [
        *bench.work(kerb, tmp_path),
        *bench.work(manual, tmp_path),
        *bench.work(level, tmp_path),
    ]
    summary = bench.report(rows, tmp_path).summary
    assert (summary["approaches"], summary["fell"]) == (2, 1)
    assert summary["false_stops"] == 0
    assert summary["safe_hours"] == pytest.approx(30 / 3600, rel=0.7)
