import dataclasses

import numpy as np
import pytest

from cohelm.arrays import identical
from cohelm.control import without_people
from cohelm.control.baselines import MpcDcbf
from cohelm.control.baselines.mpc_dcbf import EllipseParameters, bounded_by_ellipses
from cohelm.geometry import transform
from cohelm.messages import Status
from cohelm.shapes import extent
from cohelm.testing.problems import mirrored, random_problem, turned
from cohelm.testing.scenes import local_problem, walkers

STEPS, STEP = 25, 0.1
PLANNER = MpcDcbf()


def scene(**options):
    return local_problem(steps=STEPS, step=STEP, **options)


def drawn(seed, people):
    rng = np.random.default_rng(seed)
    return random_problem(rng, people, steps=STEPS, step=STEP).problem


def test_horizon_step_and_gamma_are_those_of_jian():
    p = PLANNER.parameters
    assert (p.steps, p.step, p.terms.social_space.gamma) == (25, 0.1, 0.3)


@pytest.mark.parametrize("seed", range(3))
def test_an_ellipse_contains_the_body(seed):
    """Its reach, measured from the person's centre, is nowhere less than the body's radius."""
    problem = drawn(seed, 6)
    spaces = bounded_by_ellipses(problem, EllipseParameters(margin=0.0)).spaces
    for i in range(6):
        for k in (0, 10, STEPS):
            for delta in np.linspace(-np.pi, np.pi, 37):
                far, _ = extent(spaces.shape(i, 0, k)._replace(floor=0.0), delta)
                assert far >= problem.people.radius[i] - 1e-12


def test_its_long_axis_lies_in_the_direction_of_motion_and_grows():
    problem = scene(people=walkers([[4.0, 0.0, 0.0, 1.0], [4.0, 3.0, 0.0, 0.0]]))
    spaces = bounded_by_ellipses(problem, EllipseParameters(margin=0.1, max_extension=0.2)).spaces
    assert spaces.axis[0] == pytest.approx(np.pi / 2)
    # radius 0.25, margin 0.1, deviation 0.05 now, 0.1 m/s more: 0.40 to begin with, 0.55 at most
    assert spaces.front[0, 0, 0] == spaces.side[0, 0, 0] == pytest.approx(0.40)
    assert spaces.front[0, 0, -1] == pytest.approx(0.55)
    assert (np.diff(spaces.front[0, 0]) >= 0.0).all()
    assert np.ptp(spaces.side) < 1e-12
    assert spaces.front[1] == pytest.approx(spaces.side[1])  # who stands has no direction


def test_half_axes_by_hand():
    problem = scene(people=walkers([[4.0, 0.0, 1.0, 0.0]]))
    s = bounded_by_ellipses(
        problem, EllipseParameters(margin=0.1, deviations=2.0, max_extension=1.0)
    ).spaces
    ends = [extent(s.shape(0, 0, -1)._replace(floor=0.0), d)[0] for d in (0.0, np.pi / 2, np.pi)]
    # 0.25 + 0.1 + 2 · (0.05 + 0.1 · 2.5) along, 0.25 + 0.1 + 2 · 0.05 across
    assert ends == pytest.approx([0.95, 0.45, 0.95])


def test_the_barrier_holds_along_a_plan_that_needs_no_slack():
    """Eq. (9) for every person: h_{k+1} ≥ (1 − γ) h_k, h by its definition."""
    gamma, checked = PLANNER.parameters.terms.social_space.gamma, 0
    for seed in range(30):
        problem = drawn(seed, 1 + seed % 3)
        plan = PLANNER.plan(problem, None)
        if plan.slack > 1e-9 or plan.status is Status.STOP:
            continue
        checked += 1
        h = heights(problem, plan.poses)
        assert (h[:, 1:] - (1.0 - gamma) * h[:, :-1]).min() > -2e-3
    assert checked >= 5


def heights(problem, poses):
    """h (n, N+1): from the spine's nearest of 801 points, less body and ellipse in between."""
    capsule, robot = problem.robot.capsule, problem.robot.capsule[4]
    share = np.linspace(0.0, 1.0, 801)[:, None]
    spine = transform(poses[:, None], (1.0 - share) * capsule[:2] + share * capsule[2:4])
    spaces = bounded_by_ellipses(problem, PLANNER.parameters.ellipses).spaces
    out = np.empty((len(problem.people), len(poses)))
    for i in range(len(out)):
        q = spine - problem.predictions.mean[i, 0][:, None]
        nearest = np.linalg.norm(q, axis=-1).argmin(axis=1)
        q = q[np.arange(len(poses)), nearest]
        delta = np.arctan2(q[:, 1], q[:, 0]) - spaces.axis[i, 0]
        a, b = spaces.front[i, 0], spaces.side[i, 0]
        ellipse = 1.0 / np.sqrt((np.cos(delta) / a) ** 2 + (np.sin(delta) / b) ** 2)
        out[i] = np.linalg.norm(q, axis=-1) - robot - ellipse
    return out


def test_it_gives_way_to_who_will_be_there():
    """Someone comes from the right and will be on the path: predicted, hence not driven into."""
    crossing = scene(people=walkers([[3.0, -2.4, 0.0, 1.2]]), speed=0.8)
    alone = PLANNER.plan(scene(speed=0.8), None)
    plan = PLANNER.plan(crossing, None)
    assert np.abs(plan.poses - alone.poses).max() > 0.1
    assert heights(crossing, plan.poses).min() > -0.05


def test_social_spaces_do_not_concern_it():
    problem = drawn(2, 4)
    spaces = dataclasses.replace(problem.spaces, floor=2.0)
    other = dataclasses.replace(problem, spaces=spaces)
    assert identical(PLANNER.plan(problem, None), PLANNER.plan(other, None))


@pytest.mark.parametrize("seed", range(3))
def test_nobody_there_changes_nothing(seed):
    problem = drawn(seed, 0)
    assert identical(PLANNER.plan(problem, None), PLANNER.plan(without_people(problem), None))


@pytest.mark.parametrize("seed", range(4))
def test_turned_and_mirrored_worlds_have_turned_and_mirrored_plans(seed):
    problem = drawn(seed, 3)
    plain = PLANNER.plan(problem, None)
    other = PLANNER.plan(turned(problem, np.array([2.0, -1.0, 0.7])), None)
    assert np.abs(plain.command - other.command).max() < 1e-5
    flipped = PLANNER.plan(mirrored(problem), None)
    assert np.abs(plain.command - flipped.command * [1.0, 1.0, -1.0]).max() < 1e-5
