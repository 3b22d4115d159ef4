"""Stick input of simulated riders."""

import numpy as np
import pytest

from cohelm.geometry import compose
from cohelm.plugins import build
from cohelm.robots import move
from cohelm.simulation.api import RiderView

ROUTE = np.array([[0.0, 0.0], [6.0, 0.0], [6.0, 5.0]])


def view(pose=(0.0, 0.0, 0.0), time=0.0, route=ROUTE, goal=(6.0, 5.0)):
    return RiderView(
        time=time,
        pose=np.array(pose, dtype=float),
        twist=np.zeros(3),
        goal=np.array(goal),
        route=np.asarray(route, dtype=float).reshape(-1, 2),
    )


def deflection(spec, seen):
    return build("riders", spec).act(seen, None, np.random.default_rng(0)).command.deflection


def test_no_rider_has_no_device():
    assert build("riders", "none").act(view(), None, np.random.default_rng(0)).command is None


def test_an_idle_rider_is_alive_and_centred():
    command = build("riders", "idle").act(view(time=3.0), None, np.random.default_rng(0)).command
    assert command.heartbeat == 3.0
    np.testing.assert_array_equal(command.deflection, 0.0)


def test_a_nudge_is_one_push_at_its_moment():
    spec = {"use": "nudge", "at": 2.0, "duration": 1.5, "side": "right"}
    times = np.arange(0, 100) * 0.05
    rider, rng = build("riders", spec), np.random.default_rng(0)
    pushed = np.array([rider.act(view(time=t), None, rng).command.deflection for t in times])
    during = (times > 2.0 - 1e-6) & (times < 3.5 - 1e-6)
    np.testing.assert_array_equal(pushed[during], [[0.8, -0.6]] * 30)  # 1.5 s at 20 Hz
    np.testing.assert_array_equal(pushed[~during], 0.0)


@pytest.mark.parametrize(
    ("x", "pushes"), [(0.0, False), (1.6, True), (2.9, True), (3.2, False), (5.0, False)]
)
def test_a_nudge_near_a_place_is_on_the_way_there(x, pushes):
    """The place is at 4 m: pushed within 2.5 m of it, until 1 m before it, not beyond it."""
    spec = {"use": "nudge", "near": (4.0, 0.0)}
    assert deflection(spec, view((x, 0.0, 0.0)))[1] == (0.6 if pushes else 0.0)


def test_the_ideal_rider_drives_the_route_to_the_goal():
    pose, deviation = np.array([0.0, 0.3, 0.2]), []
    rider, rng = build("riders", "ideal"), np.random.default_rng(0)
    for k in range(800):
        forward, left = rider.act(view(pose, time=0.05 * k), None, rng).command.deflection
        pose = move(pose, np.array([1.2 * forward, 0.0, 1.2 * left]), 0.05)
        x, y = pose[:2]
        deviation.append(min(abs(y) + max(x - 6.0, 0.0), abs(x - 6.0) + max(-y, 0.0)))
    assert np.hypot(pose[0] - 6.0, pose[1] - 5.0) <= 0.2
    assert max(deviation) < 0.5
    np.testing.assert_array_equal(deflection("ideal", view(pose)), 0.0)


def test_the_ideal_rider_turns_first_when_the_way_lies_behind():
    forward, left = deflection("ideal", view((0.0, 0.0, 3.0)))
    assert forward == 0.0
    assert left == -1.0


def test_without_a_route_the_ideal_rider_makes_for_the_goal():
    forward, left = deflection("ideal", view(route=[], goal=(5.0, 0.0)))
    assert forward > 0.5
    assert left == 0.0


def test_the_ideal_rider_does_the_same_in_a_rotated_world():
    X = np.array([2.0, 1.0, 0.7])
    pose = np.array([1.0, 0.2, 0.3])
    turned = view(
        compose(X, pose),
        route=compose(X, np.column_stack([ROUTE, np.zeros(3)]))[:, :2],
        goal=compose(X, np.array([6.0, 5.0, 0.0]))[:2],
    )
    np.testing.assert_allclose(deflection("ideal", turned), deflection("ideal", view(pose)))
