"""People who do not see the chair find it standing."""

import dataclasses

import numpy as np
import pytest

from cohelm.control import SsMpcDcbf
from cohelm.control.unaware import times_on_course
from cohelm.messages import Status
from cohelm.testing.scenes import local_problem, walkers

PLANNER = SsMpcDcbf()


def scene(**given):
    return local_problem(steps=PLANNER.steps, step=PLANNER.step, **given)


def later(problem, plan, time):
    return dataclasses.replace(problem, time=time), plan


@pytest.mark.parametrize(
    ("person", "on_course"),
    [
        ([-1.5, 0.0, 1.2, 0.0], True),  # from behind, 0.6 m/s faster
        ([-1.5, 0.0, 0.6, 0.0], False),  # follows at the chair's speed
        ([-0.95, 0.0, 0.9, 0.0], False),  # follows closely, a little faster
        ([0.2, 1.4, 0.6, -0.8], True),  # from the side, into the chair's flank
        ([-1.0, 1.5, 0.0, -0.8], False),  # passes behind it
        ([2.0, 0.0, 0.0, 0.0], False),  # stands: the chair is the one who moves
    ],
)
def test_a_course_into_the_chair(person, on_course):
    problem = scene(people=walkers([person]), speed=0.6)
    plan = PLANNER.plan(problem, None)
    after = dataclasses.replace(problem, time=0.05)
    [time] = times_on_course(after, plan.memory)
    assert time == pytest.approx(0.05 if on_course else 0.0)


def test_a_course_that_is_left_is_forgotten_twice_as_fast():
    memory = PLANNER.plan(scene(people=walkers([[-1.5, 0.0, 1.2, 0.0]]), speed=0.6), None).memory
    memory = dataclasses.replace(memory, person_courses=np.array([0.3]))
    away = scene(people=walkers([[-1.5, 0.0, 0.2, 0.0]]), speed=0.6)
    left = [
        times_on_course(dataclasses.replace(away, time=time), memory)[0]
        for time in (0.05, 0.1, 0.2)
    ]
    assert left == pytest.approx([0.2, 0.1, 0.0])


def follow(planner, gap, *, seconds=1.5):
    """Speeds of a chair at 0.6 m/s, and the gap to a person at 1.2 m/s behind it, until it ends."""
    problem = scene(people=walkers([[-gap, 0.0, 1.2, 0.0]]), speed=0.6)
    x, speed, person, plan, out = 0.0, 0.6, -gap, None, []
    for k in range(round(seconds / 0.05)):
        now = dataclasses.replace(
            problem,
            time=0.05 * k,
            pose=np.array([x, 0.0, 0.0]),
            twist=np.array([speed, 0.0, 0.0]),
            people=walkers([[person, 0.0, 1.2, 0.0]]),
            predictions=problem_of(person).predictions,
            commanded=None if plan is None else plan.command,
        )
        plan = planner.plan(now, plan)
        hard = 0.0 if plan.urgent else max(plan.command[0], speed - 0.05)
        speed = max(hard, speed - 1.8 * 0.05)
        x, person = x + 0.05 * speed, person + 0.05 * 1.2
        out.append((speed, x - 0.46 - person - 0.25))
    return out


def problem_of(person):
    return scene(people=walkers([[person, 0.0, 1.2, 0.0]]), speed=0.6)


def test_somebody_who_walks_into_the_back_finds_the_chair_standing():
    """Two metres behind and 0.6 m/s faster; one who plans for nobody behind drives on."""
    rules = PLANNER.parameters.verification.model_copy(update={"unaware_after": np.inf})
    heedless = SsMpcDcbf(PLANNER.parameters.model_copy(update={"verification": rules}))
    # At first touch: what a planner does while somebody stands within the chair has no meaning.
    assert speeds_until_met(PLANNER)[-1] < 0.02
    assert min(speeds_until_met(heedless)) > 0.3


def speeds_until_met(planner):
    ticks = follow(planner, 2.0, seconds=3.0)
    met = next(k for k, (_, gap) in enumerate(ticks) if gap < 0.05)
    return [speed for speed, _ in ticks[: met + 1]]


def test_nobody_who_keeps_a_distance_stops_the_chair():
    problem = scene(people=walkers([[-1.2, 0.0, 0.6, 0.0]]), speed=0.6)
    plan = PLANNER.plan(problem, None)
    for k in range(1, 20):
        plan = PLANNER.plan(dataclasses.replace(problem, time=0.05 * k), plan)
    assert plan.status is not Status.STOP
