import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cohelm.shapes import CONTOUR, ELLIPSE, PRINTED, RadialShape, extent, outline, support

KINDS = pytest.mark.parametrize("kind", [PRINTED, CONTOUR, ELLIPSE])
EGG = (2.4, 1.6, 1.2)
"""(σ_h, σ_s, σ_r) of eq. (5) at 1.2 m/s."""
sigmas = st.floats(0.1, 3.0)


def length(kind, delta, sigma=EGG, scale=0.125, floor=0.0):
    return extent(RadialShape(kind, *sigma, scale, floor), delta)[0]


@KINDS
@given(front=sigmas, side=sigmas, rear=sigmas, delta=st.floats(-3.1, 3.1))
def test_the_slope_is_the_finite_difference(kind, front, side, rear, delta):
    # not across the side, where the second derivative jumps
    if abs(abs(delta) - np.pi / 2) < 1e-3:
        return
    sigma, e = (front, side, rear), 1e-6
    _, slope = extent(RadialShape(kind, *sigma, 0.2, 0.0), delta)
    difference = (length(kind, delta + e, sigma, 0.2) - length(kind, delta - e, sigma, 0.2)) / (
        2 * e
    )
    assert slope == pytest.approx(difference, rel=1e-4, abs=1e-5)


@KINDS
def test_extent_along_the_axes(kind):
    # q = 1/2σ², so l = 2cσ² as printed and σ√(2c) for the contour
    behind = 2.4 if kind == ELLIPSE else 1.2  # an ellipse is behind as ahead
    for delta, sigma in ((0.0, 2.4), (np.pi / 2, 1.6), (np.pi, behind)):
        expected = 0.25 * sigma**2 if kind == PRINTED else 0.5 * sigma
        assert length(kind, delta) == pytest.approx(expected)


@KINDS
@given(front=sigmas, side=sigmas, rear=sigmas)
def test_is_continuously_differentiable_at_the_side(kind, front, side, rear):
    shape = RadialShape(kind, front, side, rear, 0.125, 0.0)
    for aside in (-np.pi / 2, np.pi / 2):
        before, after = extent(shape, aside - 1e-9), extent(shape, aside + 1e-9)
        # the slope is 0 there and changes by 1e-9 of the curvature, at most (σ_s/σ)² of l
        assert before == pytest.approx(after, rel=1e-5, abs=1e-4)
        assert after[1] == pytest.approx(0.0, abs=1e-4)


@given(front=sigmas, side=sigmas, rear=sigmas)
def test_the_contour_is_convex(front, side, rear):
    turn = _turns(CONTOUR, (front, side, rear))
    assert (turn > -1e-9).all()


def test_the_printed_egg_is_not_convex_at_speed():
    assert (_turns(PRINTED, EGG) < 0.0).any()


@KINDS
@given(delta=st.floats(-3.1, 3.1), floor=st.floats(0.0, 3.0))
def test_never_less_than_the_floor_where_the_slope_is_zero(kind, delta, floor):
    free = length(kind, delta)
    got, slope = extent(RadialShape(kind, *EGG, 0.125, floor), delta)
    assert got == max(free, floor)
    if free < floor:
        assert slope == 0.0


@KINDS
def test_left_is_like_right_and_three_equal_sigmas_are_a_circle(kind):
    for delta in np.linspace(0.0, np.pi, 9):
        assert length(kind, delta) == pytest.approx(length(kind, -delta))
        assert length(kind, delta, (0.5, 0.5, 0.5)) == pytest.approx(length(kind, 0, (0.5,) * 3))


@KINDS
def test_the_outline_is_the_extent_about_a_pose(kind):
    pose = np.array([1.0, -2.0, 0.8])
    line = outline(RadialShape(kind, *EGG, 0.125, 0.45), 0.25, pose, 64)
    assert line[0] == pytest.approx(line[-1])
    for x, y in line:
        delta = np.arctan2(y + 2.0, x - 1.0) - 0.8
        away = np.hypot(x - 1.0, y + 2.0)
        assert away == pytest.approx(max(length(kind, delta), 0.45) + 0.25)


def _turns(kind, sigma):
    """Cross products of successive edges of the outline: all ≥ 0 if it is convex."""
    line = outline(RadialShape(kind, *sigma, 0.125, 0.0), 0.0, np.zeros(3), 180)
    edges = np.diff(line, axis=0)
    edges = edges / np.hypot(*edges.T)[:, None]
    after = np.roll(edges, -1, axis=0)
    return edges[:, 0] * after[:, 1] - edges[:, 1] * after[:, 0]


@given(front=sigmas, side=sigmas, direction=st.floats(-np.pi, np.pi))
def test_an_ellipse_is_the_ellipse_with_these_half_axes(front, side, direction):
    """(x/a)² + (y/b)² = 1 with c = ½, whose support is √(a² cos² + b² sin²)."""
    shape = RadialShape(ELLIPSE, front, side, 0.123, 0.5, 0.0)
    length, _ = extent(shape, direction)
    x, y = length * np.cos(direction), length * np.sin(direction)
    assert (x / front) ** 2 + (y / side) ** 2 == pytest.approx(1.0)
    far = support(shape, np.cos(direction), np.sin(direction))
    assert far == pytest.approx(np.hypot(front * np.cos(direction), side * np.sin(direction)))


@given(front=sigmas, side=sigmas, direction=st.floats(-np.pi, np.pi))
def test_the_ellipse_bounds_the_contour_of_who_reaches_less_far_behind(front, side, direction):
    ellipse = RadialShape(ELLIPSE, front, side, 0.5 * front, 0.125, 0.0)
    outer, _ = extent(ellipse, direction)
    inner, _ = extent(ellipse._replace(kind=CONTOUR), direction)
    assert outer >= inner - 1e-12
