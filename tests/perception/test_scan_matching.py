"""Fitting a reading to what was seen before."""

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given, settings

from cohelm.geometry import compose, inverse, wrap_angle
from cohelm.messages import Scan
from cohelm.perception.laser_odometry.ego_motion import (
    CAP,
    evaluate_pose,
    match_scan,
    search_pose,
)
from cohelm.perception.laser_odometry.local_map import feature_map, has_neighbour
from cohelm.perception.laser_odometry.scan_features import ScanFeatures, features_of_scan

from .driven import corridor, furnished

HERE = np.zeros(3)
NONE = ScanFeatures(points=np.empty((0, 2)), normals=np.empty((0, 2)))


def outline(laser, discs, pose=HERE):
    return features_of_scan(laser.scan(0.0, pose, discs)[0])


@settings(deadline=None, max_examples=15)
@given(
    st.tuples(*[st.floats(-0.25, 0.25)] * 2, st.floats(-0.08, 0.08)).map(np.array),
    st.integers(0, 5),
)
def test_a_pose_near_the_guess_is_found(pose, seed):
    laser, discs = furnished(seed=seed)
    fit = match_scan(feature_map(outline(laser, discs)), outline(laser, discs, pose), HERE, 0.02)
    assert np.hypot(*(fit.pose - pose)[:2]) < 0.01
    assert abs(fit.pose[2] - pose[2]) < 0.003
    assert fit.overlap > 0.85
    assert fit.constrained == 2


def test_moving_the_reference_moves_the_pose():
    laser, discs = furnished()
    first, second = outline(laser, discs), outline(laser, discs, (0.1, -0.05, 0.04))
    X = np.array([3.0, -7.0, 2.0])
    here = match_scan(feature_map(first), second, HERE, 0.02).pose
    there = match_scan(feature_map(first.transformed(X)), second, X, 0.02).pose
    # the cells lie otherwise about the points, nothing else
    assert compose(inverse(X), there) == pytest.approx(here, abs=1e-4)


def test_the_same_reading_fits_itself():
    laser, discs = furnished()
    seen = outline(laser, discs)
    fit = evaluate_pose(feature_map(seen), seen, HERE, 0.02)
    assert (fit.overlap, fit.misfit) == (1.0, 0.0)
    assert match_scan(feature_map(seen), seen, HERE, 0.02).pose == pytest.approx(HERE, abs=1e-9)


def test_along_a_smooth_corridor_the_guess_is_kept():
    laser = corridor(doors=False)
    reference = feature_map(outline(laser, np.empty((0, 3))))
    fit = match_scan(
        reference,
        outline(laser, np.empty((0, 3)), (0.4, 0.1, 0.03)),
        np.array([0.2, 0.0, 0.0]),
        0.02,
    )
    assert fit.constrained == 1
    assert fit.pose[0] == pytest.approx(0.2, abs=0.01)
    assert fit.pose[1:] == pytest.approx([0.1, 0.03], abs=0.01)


def test_a_search_finds_what_is_far_from_the_guess():
    laser, discs = furnished()
    reference, pose = feature_map(outline(laser, discs)), np.array([1.5, -1.3, 0.5])
    seen = outline(laser, discs, pose)
    assert match_scan(reference, seen, HERE, 0.02).overlap < 0.5
    guess = search_pose(reference, seen, HERE, 1.6, 0.5)
    assert match_scan(reference, seen, guess, 0.02).pose == pytest.approx(pose, abs=0.02)


def test_nothing_fits_nothing():
    laser, discs = furnished()
    some = outline(laser, discs)
    for reference, seen in ((NONE, some), (some, NONE), (NONE, NONE)):
        fit = match_scan(feature_map(reference), seen, HERE, 0.02)
        assert (fit.overlap, fit.misfit, fit.constrained) == (0.0, CAP, 0)
        assert (fit.pose == HERE).all()
        assert (search_pose(feature_map(reference), seen, HERE, 1.0, 0.5) == HERE).all()
        assert not has_neighbour(feature_map(reference), seen, 0.1).any()


def test_normals_are_those_of_the_walls_and_look_at_the_sensor():
    beams = np.linspace(-np.pi, np.pi, 720, endpoint=False)
    ranges = 3.0 / np.maximum(np.abs(np.cos(beams)), np.abs(np.sin(beams)))  # a square room
    scan = Scan(
        time=0.0, mount=HERE, angle_min=-np.pi, angle_increment=np.pi / 360, range_max=10.0,
        ranges=ranges,
    )  # fmt: skip
    seen = features_of_scan(scan)
    flat = seen.normals.any(axis=1)
    assert flat.mean() > 0.85  # all but what is near the corners
    upright = np.abs(seen.normals[flat]).max(axis=1) > np.cos(np.radians(1.0))
    assert upright.mean() > 0.9
    assert ((seen.normals * seen.points)[flat].sum(axis=1) < 0.0).all()


def test_a_post_is_its_middle():
    laser, _ = furnished(noise=0.0)
    laser.segments = laser.segments[:4]  # the walls alone
    seen = outline(laser, np.array([[1.0, 0.5, 0.06]]))
    near = seen.points[np.hypot(*(seen.points - [1.0, 0.5]).T) < 0.2]
    assert len(near) == 1  # the middle of the side that is seen
    assert np.hypot(*(near[0] - [1.0, 0.5])) == pytest.approx(0.06, abs=0.03)
    assert not seen.normals[np.hypot(*(seen.points - [1.0, 0.5]).T) < 0.2].any()


def test_the_angle_of_a_pose_is_wrapped():
    laser, discs = furnished()
    turned = np.array([0.0, 0.0, np.pi - 0.01])
    reference = feature_map(outline(laser, discs, turned).transformed(turned))
    after = np.array([0.0, 0.0, wrap_angle(np.pi + 0.03)])
    fit = match_scan(reference, outline(laser, discs, after), turned, 0.02)
    assert fit.pose[2] == pytest.approx(after[2], abs=0.003)
