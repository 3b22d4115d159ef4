import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cohelm.geometry import (
    arc_length,
    between,
    compose,
    distance_to_polygon,
    inside_polygon,
    inverse,
    nearest_on_polyline,
    resample,
    transform,
    wrap_angle,
)
from cohelm.testing.strategies import points, polygons, poses


def near(a, b, tolerance=1e-9):
    """Poses or points that agree; headings up to whole turns."""
    difference = np.asarray(a) - np.asarray(b)
    if difference.shape[-1] == 3:
        difference[..., 2] = wrap_angle(difference[..., 2])
    return np.abs(difference).max() < tolerance


@given(st.floats(-1e3, 1e3))
def test_wrapping_keeps_the_direction_and_ends_within_half_a_turn(angle):
    wrapped = float(wrap_angle(angle))
    assert -np.pi < wrapped <= np.pi
    assert near(np.array([np.cos(angle), np.sin(angle)]), [np.cos(wrapped), np.sin(wrapped)])


def test_half_a_turn_is_plus_pi():
    assert wrap_angle(np.array([np.pi, -np.pi, 3.0 * np.pi])).tolist() == [np.pi] * 3


@given(poses())
def test_a_pose_and_its_inverse_cancel(X_AB):
    assert near(compose(X_AB, inverse(X_AB)), np.zeros(3))
    assert near(compose(inverse(X_AB), X_AB), np.zeros(3))


@given(poses(), poses())
def test_a_pose_seen_from_another_is_the_composition_to_the_bit(X_AB, X_AC):
    assert between(X_AB, X_AC).tobytes() == compose(inverse(X_AB), X_AC).tobytes()


@given(poses(), poses(), poses())
def test_composition_is_associative(X_AB, X_BC, X_CD):
    assert near(compose(compose(X_AB, X_BC), X_CD), compose(X_AB, compose(X_BC, X_CD)))


@given(poses(), poses(), points())
def test_frames_cancel(X_AB, X_BC, p_C):
    assert near(transform(compose(X_AB, X_BC), p_C), transform(X_AB, transform(X_BC, p_C)))


@given(poses(), points(), points())
def test_a_frame_keeps_distances(X_AB, p, q):
    there = np.linalg.norm(transform(X_AB, p) - transform(X_AB, q))
    assert there == pytest.approx(np.linalg.norm(p - q), abs=1e-9)


@given(st.lists(poses(), min_size=1, max_size=5))
def test_many_poses_at_once_are_each_by_itself(many):
    stacked = np.array(many)
    assert near(inverse(stacked), [inverse(X) for X in many])
    assert near(compose(stacked, stacked), [compose(X, X) for X in many])


@given(st.lists(points(), min_size=1, max_size=8), st.floats(0.05, 5.0))
def test_resampling_keeps_the_ends_and_the_spacing(corners, spacing):
    line = np.array(corners)
    got = resample(line, spacing)
    assert near(got[[0, -1]], line[[0, -1]])
    assert np.linalg.norm(np.diff(got, axis=0), axis=1).max(initial=0.0) <= spacing + 1e-9
    assert arc_length(got)[-1] <= arc_length(line)[-1] + 1e-9  # corners are cut, never added


@given(st.lists(points(10.0), min_size=1, max_size=6), points(10.0))
def test_the_nearest_point_of_a_line_is_the_nearest_of_many_samples(corners, p):
    line = np.array(corners)
    along, distance = nearest_on_polyline(line, *p)
    legs = [np.linspace(a, b, 400) for a, b in itertools.pairwise(line)]
    samples = np.concatenate([line, *legs])
    sampled = np.linalg.norm(samples - p, axis=1).min()
    assert distance <= sampled + 1e-9
    assert distance >= sampled - 0.04  # no leg is longer than 28.3 m: half a sample is 3.6 cm
    s = arc_length(line)
    at = np.array([np.interp(along, s, line[:, i]) for i in (0, 1)])
    assert np.linalg.norm(at - p) == pytest.approx(distance, abs=1e-6)


@given(polygons(), points(4.0))
def test_distance_to_a_polygon_is_that_of_its_edge(polygon, p):
    _, edge = nearest_on_polyline(np.vstack([polygon, polygon[:1]]), *p)
    assert abs(distance_to_polygon(polygon, *p)) == pytest.approx(edge, abs=1e-9)


@given(polygons())
def test_a_star_contains_its_centre_and_nothing_far_away(polygon):
    assert distance_to_polygon(polygon, 0.0, 0.0) < 0.0
    assert distance_to_polygon(polygon, 9.0, 0.0) > 0.0


@given(polygons(), poses(), points(4.0))
def test_moving_polygon_and_point_together_changes_nothing(polygon, X, p):
    moved = distance_to_polygon(transform(X, polygon), *transform(X, p))
    here = distance_to_polygon(polygon, *p)
    assert abs(moved) == pytest.approx(abs(here), abs=1e-9)
    if abs(here) > 1e-6:
        assert np.sign(moved) == np.sign(here)


def test_a_unit_square_by_hand():
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    assert distance_to_polygon(square, 0.5, 0.5) == -0.5
    assert distance_to_polygon(square, 2.0, 0.5) == 1.0
    assert distance_to_polygon(square, 4.0, 5.0) == 5.0  # 3-4-5 from the corner (1, 1)
    assert inside_polygon(square, np.array([[0.5, 0.1], [0.5, -0.1]])).tolist() == [True, False]


def test_orientation_does_not_matter():
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    assert distance_to_polygon(square[::-1].copy(), 0.5, 0.25) == -0.25
