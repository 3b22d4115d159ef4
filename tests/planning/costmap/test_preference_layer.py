"""The user preference field against eqs. (1) and (2), and the corrections of the paper."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from cohelm.maps import OccupancyGrid
from cohelm.messages import Wish
from cohelm.planning.costmap.layers.preference import (
    Preference,
    Source,
    preference_costs,
    preference_field,
    sources_of,
    spread,
)

GRID = OccupancyGrid(data=np.zeros((60, 80)), resolution=0.1, X_MG=np.array([1.0, -2.0, 0.3]))
GAUSSIAN = Preference(c_min=10.0, c_max=200.0)
RAYLEIGH = Preference(c_min=10.0, c_max=200.0, density="rayleigh")


def costs(points, sigmas, preference):
    """The field of single points."""
    sources = tuple(
        Source(points=np.array([p]), sigma=s) for p, s in zip(points, sigmas, strict=True)
    )
    return preference_costs(GRID, sources, preference)


def centres():
    rows, cols = GRID.shape
    return GRID.centres(np.stack(np.mgrid[:rows, :cols], axis=-1))


def written_out(point, sigma, density):
    """Eq. (2), cell by cell."""
    d = np.hypot(*np.moveaxis(centres() - point, -1, 0))
    p = np.exp(-(d**2) / (2 * sigma**2))
    if density == "rayleigh":
        p = d / sigma**2 * p
    return 200.0 - (p.min() - p) * (200.0 - 10.0) / (p.min() - p.max())


@pytest.mark.parametrize("preference", [GAUSSIAN, RAYLEIGH])
@pytest.mark.parametrize("sigma", [0.5, 1.5, 4.0])
def test_is_equation_two(preference, sigma):
    point = GRID.centres([21, 33]) + 0.02
    layer = costs([point], [sigma], preference)
    assert np.abs(layer - written_out(point, sigma, preference.density)).max() <= 0.5 + 1e-3


def test_the_corrected_field_is_cheapest_at_the_point():
    layer = costs(GRID.centres([[21, 33]]), [1.0], GAUSSIAN)
    assert layer[21, 33] == layer.min() == 10
    assert layer.max() == 200


def test_the_printed_field_is_cheapest_on_a_ring_and_dearest_at_the_point():
    sigma = 1.5
    layer = costs(GRID.centres([[30, 40]]), [sigma], RAYLEIGH)
    assert layer[30, 40] == 200
    along = layer[30, 40:]  # d = 0, 0.1, 0.2, …
    assert 0.1 * np.argmin(along) == pytest.approx(sigma, abs=0.25)
    assert along[15] == 10


def test_spread_is_equation_one_with_a_floor():
    # P(d_r) = 1 − exp(−d_r²/2σ²) = 0.9
    d = np.array([2.0, 10.0])
    assert np.allclose(1.0 - np.exp(-(d**2) / (2 * spread(d, GAUSSIAN) ** 2)), 0.9)
    assert spread(np.array([0.0, 0.1]), GAUSSIAN).tolist() == [0.5, 0.5]


def test_no_point_of_two_is_lost():
    cells = [[10, 10], [50, 70]]
    layer = costs(GRID.centres(cells), [0.5, 3.0], GAUSSIAN)
    for row, col in cells:
        around = layer[row - 3 : row + 4, col - 3 : col + 4]
        assert layer[row, col] == around.min()
        assert layer[row, col] < 30


@settings(max_examples=60, deadline=None)
@given(
    point=st.tuples(st.floats(-1e4, 1e4), st.floats(-1e4, 1e4)),
    distance=st.floats(0.0, 1e4),
    preference=st.sampled_from([GAUSSIAN, RAYLEIGH]),
)
def test_is_a_cost_wherever_the_point_is(point, distance, preference):
    layer = costs([point], [float(spread(np.array(distance), preference))], preference)
    assert layer.dtype == np.uint8
    assert layer.min() >= 10
    assert layer.max() <= 200


def test_costs_must_be_in_order():
    with pytest.raises(ValidationError, match="c_min"):
        Preference(c_min=100.0, c_max=50.0)


def stroke(*points):
    return Wish(kind="stroke", points=np.array(points, dtype=float))


def test_a_stroke_is_a_valley_as_wide_as_a_points_and_as_deep_all_along():
    line = GRID.centres([[30, 20], [30, 60]])
    (source,) = sources_of((stroke(*line),), line[0], GAUSSIAN)
    assert source.sigma == GAUSSIAN.sigma_min  # it begins at the robot
    field = preference_field(GRID, (source,), GAUSSIAN)
    assert field.max() == 1.0
    # Well inside its ends the line is as if it had none: ∫ exp(−(x² + y²)/2σ²) dx ∝ exp(−y²/2σ²).
    across = field[:, 40] / field[30, 40]
    y = 0.1 * (np.arange(60) - 30)
    assert across == pytest.approx(np.exp(-(y**2) / (2 * 0.5**2)), abs=1e-3)
    assert np.ptp(field[30, 33:48]) < 1e-3


@pytest.mark.parametrize("preference", [GAUSSIAN, RAYLEIGH])
@pytest.mark.parametrize("far", [0.0, 1e4])
def test_a_stroke_is_a_cost_wherever_it_is(preference, far):
    wishes = (stroke([far, 0.0], [far + 3.0, 2.0], [far + 3.0, 300.0]), stroke([far, far]))
    sources = sources_of(wishes, np.zeros(2), preference)
    assert len(sources) == 2
    field = preference_field(GRID, sources, preference)
    assert np.isfinite(field).all()
    assert field.max() <= 2.0 + 1e-6
    layer = preference_costs(GRID, sources, preference)
    assert (layer.min(), layer.max()) == (10, 200)


def test_every_point_is_a_source_with_its_own_distance_and_zones_are_none():
    wishes = (
        Wish(points=np.array([[3.0, 4.0], [0.0, 10.0]])),
        Wish(kind="avoid", points=np.array([[1.0, 1.0]])),
        Wish(points=np.empty((0, 2))),
    )
    sources = sources_of(wishes, np.zeros(2), GAUSSIAN)
    assert [source.points.tolist() for source in sources] == [[[3.0, 4.0]], [[0.0, 10.0]]]
    assert [s.sigma for s in sources] == pytest.approx([5 * 0.466, 10 * 0.466], rel=1e-3)
