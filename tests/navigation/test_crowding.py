"""Recent crowding and its decay."""

from dataclasses import replace

import numpy as np
import pytest

from cohelm.maps import OccupancyGrid
from cohelm.messages import Crowding
from cohelm.navigation.crowding import CrowdingParameters, update_crowding
from cohelm.testing.scenes import walkers

GRID = OccupancyGrid(data=np.zeros((160, 240)), resolution=0.05, X_MG=[-1.0, 2.0, 0.3])
AREA = 0.25
RULES = CrowdingParameters()
"""Cells of 0.5 m, a person over a disc of 1 m; rises by half in 3 s, fades by half in 30 s."""


def people(time, *positions):
    """On the grid's own axes, m."""
    from cohelm.geometry import transform

    there = [[*transform(GRID.X_MG, p), 0.0, 0.0] for p in positions]
    return replace(walkers(there), time=time)


def counted(spans, prior=None, rules=RULES):
    """The memory after (from, to, positions) each, counted twice a second."""
    state = update_crowding(None, people(0.0), GRID, prior, rules)
    for start, end, positions in spans:
        for k in range(round(start * 2) + 1, round(end * 2) + 1):
            state = update_crowding(state, people(0.5 * k, *positions), GRID, prior, rules)
    return state


@pytest.mark.parametrize("at", [(6.0, 4.0), (6.13, 4.31), (3.05, 5.99)])
def test_one_person_counts_as_one(at):
    state = counted([(0.0, 60.0, [at])])
    assert state.density.sum() * AREA == pytest.approx(1.0, rel=1e-4)
    rows, cols = np.nonzero(state.density)
    assert np.hypot((cols + 0.5) * 0.5 - at[0], (rows + 0.5) * 0.5 - at[1]).max() <= 1.0 + 1e-9


def test_who_is_unsure_to_be_a_person_counts_for_less():
    sure = people(0.5, (6.0, 4.0))
    unsure = replace(sure, confidence=[0.4])
    first = update_crowding(None, people(0.0), GRID, None, RULES)
    whole = update_crowding(first, sure, GRID, None, RULES).density
    np.testing.assert_allclose(
        update_crowding(first, unsure, GRID, None, RULES).density, 0.4 * whole, rtol=1e-6
    )


def test_it_rises_within_seconds_and_fades_within_half_a_minute():
    # after 3 s half of it, after 30 s more half of what was then
    risen = counted([(0.0, 3.0, [(6.0, 4.0)])])
    assert risen.density.sum() * AREA == pytest.approx(0.5, rel=1e-4)
    faded = counted([(0.0, 3.0, [(6.0, 4.0)]), (3.0, 33.0, [])])
    assert faded.density.sum() * AREA == pytest.approx(0.25, rel=1e-4)


def test_a_walker_leaves_little_and_a_flow_much():
    """One crosses at 1 m/s; then one every 2 s."""
    walk = [(k / 2, (k + 1) / 2, [(k / 2, 4.0)]) for k in range(24)]
    flow = [
        (k / 2, (k + 1) / 2, [((k / 2 + 2 * j) % 12.0, 4.0) for j in range(6)]) for k in range(120)
    ]
    one, many = counted(walk).density.max(), counted(flow).density.max()
    # a walker is 2 s over a spot: 1 − 0.5^(2/3) = 0.37 of who stands there
    assert one < 0.45 / np.pi
    assert many > 2.0 * one


def test_between_two_counts_nothing_changes():
    state = counted([(0.0, 3.0, [(6.0, 4.0)])])
    assert update_crowding(state, people(3.4, (1.0, 1.0)), GRID, None, RULES) is state


def test_routes_are_told_of_changes_that_matter_and_keep_the_object_till_then():
    state, told = update_crowding(None, people(0.0), GRID, None, RULES), []
    for k in range(1, 400):
        there = [(6.0, 4.0)] if k < 60 else []
        state = update_crowding(state, people(0.5 * k, *there), GRID, None, RULES)
        told.append(state.published)
        assert np.abs(state.density - state.published.density).max() < RULES.threshold
    versions = [each.version for each in told]
    assert versions == sorted(versions)
    # up to 1/π people/m² in steps of 0.1 and more, and down again, by halves at the end
    assert 5 <= versions[-1] <= 9
    assert len({id(each) for each in told}) == versions[-1] + (0 if versions[0] else 1)


def test_a_heat_map_is_a_floor_that_does_not_fade():
    heat = Crowding(density=[[0.0, 0.8], [0.0, 0.0]], resolution=2.0, X_MG=GRID.X_MG, version=0)
    state = counted([(0.0, 60.0, [])], prior=heat)
    expected = np.zeros((16, 24))
    expected[0:4, 4:8] = 0.8
    np.testing.assert_allclose(state.density, expected)
    assert state.published.version == 0
