"""Wheels that meet steps of the floor."""

from dataclasses import replace

import numpy as np
import pytest

from cohelm.messages import Decision
from cohelm.robots import load_robot
from cohelm.simulation import FloorPiece, FloorRelief, World

CHAIR = load_robot("quantum_q6_edge")
AHEAD = np.array([0.5, 0.0, 0.0])
BACK = np.array([-0.2, 0.0, 0.0])


def floor_from(x, height):
    """The floor lies at another height from x on, m."""
    at, size = np.array([x + 3.0, 5.0]), np.array([6.0, 10.0])
    return FloorRelief(pieces=(FloorPiece(at=at, size=size, angle=0.0, height=height),))


def drive(setup, twist, ticks=120):
    """The ground truth after each tick until something happens."""
    world = World(setup, 0)
    for _ in range(ticks):
        world.advance(Decision(twist=twist))
        truth = world.truth
        if truth.fell or truth.hit_wall:
            break
    return truth


@pytest.fixture
def at_edge(make_setup):
    def make(height, heading=0.0, robot=CHAIR):
        start = np.array([4.5, 5.0, heading])
        return make_setup(robot=robot, start=start, relief=floor_from(6.0, height))

    return make


def test_the_first_wheel_over_an_edge_falls(at_edge):
    truth = drive(at_edge(-0.1), AHEAD)
    assert truth.fell
    assert not truth.hit_wall
    # the front casters lead
    front = CHAIR.wheels[:, 0].max()
    assert truth.pose[0] + front == pytest.approx(6.0, abs=0.06)


def test_a_chair_can_fall_backwards(at_edge):
    truth = drive(at_edge(-0.1, heading=np.pi), BACK, ticks=200)
    assert truth.fell


def test_a_chair_can_fall_while_it_turns(make_setup):
    x, y = np.abs(CHAIR.wheels).max(axis=0)
    away = 0.5 * (y + np.hypot(x, y))
    start = np.array([6.0 - away, 5.0, np.pi / 2])
    setup = make_setup(robot=CHAIR, start=start, relief=floor_from(6.0, -0.1))
    assert drive(setup, np.array([0.0, 0.0, -0.6])).fell


@pytest.mark.parametrize("height", [-0.05, 0.05, 0.02, -0.02])
def test_steps_that_a_chair_can_take_are_nothing(at_edge, height):
    truth = drive(at_edge(height), AHEAD)
    assert not truth.fell
    assert not truth.hit_wall
    assert truth.pose[0] > 6.5


def test_a_step_that_is_too_high_is_a_wall(at_edge):
    truth = drive(at_edge(0.08), AHEAD)
    assert truth.hit_wall
    assert not truth.fell


def test_what_a_chair_can_take_is_said_by_its_file(at_edge):
    weak = CHAIR.model_copy(update={"max_step_up": 0.01, "max_step_down": 0.01})
    assert drive(at_edge(-0.03, robot=weak), AHEAD).fell
    assert drive(at_edge(0.03, robot=weak), AHEAD).hit_wall


def test_a_floor_without_relief_changes_nothing(at_edge, make_setup):
    flat = make_setup(robot=CHAIR, start=np.array([4.5, 5.0, 0.0]))
    level = replace(at_edge(0.0), relief=floor_from(6.0, 0.0))
    assert drive(flat, AHEAD).pose.tolist() == drive(level, AHEAD).pose.tolist()
