import dataclasses

import numpy as np
import pytest

from cohelm.control.terms import InputLimits, PersonBarrier, SocialSpaceBarrier, WallBarrier
from cohelm.control.terms.constraints.person_barrier import person_barrier
from cohelm.control.terms.constraints.social_distance import (
    SpaceShapes,
    coefficients,
    social_gradient,
)
from cohelm.maps import DistanceField
from cohelm.shapes import CONTOUR, PRINTED
from cohelm.testing.scenes import local_problem, walkers

SHAPES = {"contour": (CONTOUR, 0.125), "printed": (PRINTED, 0.104)}


def smooth_field(problem):
    """sin + cos on cells of 5 cm: in each cell a bilinear function, whose gradient is known."""
    cells = np.arange(360) * 0.05
    hills = 0.6 + 0.4 * np.sin(cells[:, None]) + 0.3 * np.cos(1.3 * cells[None])
    corner = np.array([problem.pose[0] - 9.0, problem.pose[1] - 9.0, 0.0])
    return DistanceField(distance=hills.astype(np.float32), resolution=0.05, X_MG=corner)


def rows_at(constraint, problem, trajectory, motions):
    """The rows at a motion, from what is measured there."""
    there = constraint.values(problem, trajectory)
    return constraint.rows(problem, trajectory, motions.sensitivity(problem, trajectory), there)


def all_margins(constraint, problem, trajectory, motions):
    """(keys,), NaN where a row is left out."""
    rows = rows_at(constraint, problem, trajectory, motions)
    out = np.full(rows.num_row_ids, np.nan)
    out[rows.row_id] = rows.margin
    return out


def check_rows(constraint, problem, trajectory, motions, *, leave=()):
    """Every row's jacobian is the derivative of its margin; says how many there were."""
    rows = rows_at(constraint, problem, trajectory, motions)
    numeric = motions.slope(
        lambda m: all_margins(constraint, problem, m, motions), problem, trajectory
    )
    numeric = numeric[rows.row_id]
    sound = np.isfinite(numeric).all(axis=1) & ~np.isin(rows.row_id, leave)
    # the distance is √(e² + 1e-6), so directions turn by up to 1e-6/e² too little, e > 0.1 m
    assert np.abs(rows.jacobian[sound] - numeric[sound]).max(initial=0.0) < 1e-4
    return int(sound.sum())


def test_bodies_rows_are_derivatives(crowded, motions, rng):
    found = [check_rows(PersonBarrier(), p, motions.wandering(p, rng), motions) for p in crowded]
    assert sum(found) > 100


@pytest.mark.parametrize("shape", SHAPES)
def test_social_space_rows_are_derivatives(shape, crowded, motions, rng):
    constraint, kind = SocialSpaceBarrier(), SHAPES[shape]
    count = 0
    for plain in crowded:
        spaces = dataclasses.replace(
            plain.spaces, kind=kind[0], scale=kind[1], floor=0.1, robot=np.array([0.3, 0.2, 0.15])
        )
        problem = dataclasses.replace(plain, spaces=spaces)
        trajectory = motions.wandering(problem, rng)
        count += check_rows(
            constraint, problem, trajectory, motions, leave=steep_rows(problem, trajectory)
        )
    assert count > 100


def steep_rows(problem, trajectory):
    """Keys of the rows whose gradient is not the derivative: cut to 2, or on the spine itself."""
    s = problem.spaces
    axis, front, side, rear = (a[:, 0] for a in (s.axis, s.front, s.side, s.rear))
    gradient = social_gradient(
        problem.robot.capsule,
        trajectory.poses,
        problem.predictions.mean[:, 0],
        SpaceShapes(
            s.kind,
            np.stack([np.cos(axis), np.sin(axis)], axis=-1),
            coefficients(s.kind, s.scale, front, side, rear),
            s.floor,
            coefficients(s.kind, s.scale, *s.robot),
            s.robot_floor,
        ),
        np.ones(axis.shape, dtype=bool),
    )
    cut = np.hypot(gradient[..., 0], gradient[..., 1]) > 2.0 - 1e-9
    centres = person_barrier(
        problem.robot.capsule,
        trajectory.poses,
        problem.predictions.mean[:, 0],
        np.zeros(axis.shape),
    )
    cut |= centres + problem.robot.capsule[4] < 0.15
    return np.flatnonzero(cut[:, 1:] | cut[:, :-1])


def test_wall_rows_are_derivatives(crowded, motions, rng):
    count = 0
    for plain in crowded:
        problem = dataclasses.replace(plain, walls=smooth_field(plain))
        count += check_rows(WallBarrier(), problem, motions.wandering(problem, rng), motions)
    assert count > 100


def test_distances_by_hand(motions):
    """A person 2 m ahead of the axle, another 1 m aside, bodies of 0.25 m; a chair that stands."""
    who = walkers([[2.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0]])
    problem = local_problem(steps=4, step=0.5, people=who)
    trajectory = motions.standing(problem)
    # five discs in 1.11 m, each 0.222 m of it: the foremost centre is at 0.65 − 0.111 m
    gap = np.array([2.0 - 0.539, 1.0]) - np.hypot(0.222, 0.61) / 2.0 - 0.25
    # about who stands nothing grows
    growing = PersonBarrier(PersonBarrier.Parameters(margin=0.1, growth=0.08, max_margin=0.2))
    still = np.tile(gap[:, None] - 0.1, (1, 5))
    assert growing.values(problem, trajectory).h == pytest.approx(still, abs=1e-6)
    # σ is 0.05 m and grows by 0.1 m/s
    spread = PersonBarrier(
        PersonBarrier.Parameters(margin=0.1, growth=0.0, deviations=2.0, max_margin=0.45)
    )
    margin = np.array([0.2, 0.3, 0.4, 0.45, 0.45])
    assert spread.values(problem, trajectory).h == pytest.approx(gap[:, None] - margin, abs=1e-6)
    # a circle of 0.45 m about everyone, σ = 0.1 and c = ½ for the chair's own: √(½ · 2 · 0.01)
    h = SocialSpaceBarrier().values(problem, trajectory).h
    assert h == pytest.approx(np.tile(gap[:, None] - 0.55, (1, 5)), abs=1e-6)
    # as printed: between the centres, which are 2 m and 1 m apart
    h = (
        SocialSpaceBarrier(SocialSpaceBarrier.Parameters(distance="printed"))
        .values(problem, trajectory)
        .h
    )
    assert h == pytest.approx(np.tile([[2.0 - 0.55], [1.0 - 0.55]], (1, 5)), abs=1e-6)
    wider = SocialSpaceBarrier(
        SocialSpaceBarrier.Parameters(growth=0.1, deviations=1.0, max_growth=0.25)
    )
    h = wider.values(problem, trajectory).h
    margin = np.array([0.05, 0.1, 0.15, 0.2, 0.25])
    assert h == pytest.approx(gap[:, None] - 0.55 - margin, abs=1e-6)


@pytest.mark.parametrize(("speed", "share"), [(0.2, 0.4), (0.5, 1.0), (1.0, 1.0)])
def test_margins_grow_for_walking_people(motions, speed, share):
    """Ahead and walking away: the gap grows by v t, the margin by 0.08 m/s from 0.5 m/s on."""
    problem = local_problem(steps=4, step=0.5, people=walkers([[2.0, 0.0, speed, 0.0]]))
    growing = PersonBarrier(PersonBarrier.Parameters(margin=0.1, growth=0.08, max_margin=0.2))
    t = 0.5 * np.arange(5)
    gap = 2.0 + speed * t - 0.539 - np.hypot(0.222, 0.61) / 2.0 - 0.25
    margin = np.minimum(0.1 + 0.08 * share * t, 0.2)
    h = growing.values(problem, motions.standing(problem)).h
    assert h == pytest.approx((gap - margin)[None], abs=1e-6)


@pytest.mark.parametrize("others", [0, 1, 3])
def test_the_oncoming_margin_is_shared_by_all_oncoming_people(motions, others):
    """The margin grows by 0.08 m/s, and by 0.2 m/s shared among those who walk, and no others."""
    walking = [[2.0, 0.0, -0.5, 0.0]] * (1 + others)
    people = walkers([*walking, [0.0, 2.0, 0.0, 0.0], [0.0, -2.0, 0.0, 0.0]])
    problem = local_problem(steps=4, step=0.5, people=people)
    shared = PersonBarrier(
        PersonBarrier.Parameters(growth=0.08, oncoming_margin=0.2, max_margin=1.0)
    )
    alone = PersonBarrier(
        PersonBarrier.Parameters(growth=0.08 + 0.2 / (1 + others), max_margin=1.0)
    )
    trajectory = motions.standing(problem)
    h = shared.values(problem, trajectory).h
    assert h == pytest.approx(alone.values(problem, trajectory).h, abs=1e-12)
    off = PersonBarrier(PersonBarrier.Parameters(growth=0.08, oncoming_margin=0.0, max_margin=1.0))
    still = slice(1 + others, None)
    assert np.array_equal(h[still], off.values(problem, trajectory).h[still])  # about who stands


def test_a_slack_is_shared_by_the_hypotheses_of_a_person(motions):
    """A second hypothesis far off needs nothing; the same one twice needs the same slack once."""
    problem = local_problem(steps=6, step=0.2, people=walkers([[1.2, 0.1, -1.0, 0.0]]))
    trajectory = motions.standing(problem)
    twice, apart = doubled(problem, 0.0), doubled(problem, 50.0)
    for constraint in (PersonBarrier(), SocialSpaceBarrier()):
        once = constraint.values(problem, trajectory).slack
        assert once.shape == (1,)
        assert once[0] > 0.0
        for other in (twice, apart):
            assert constraint.values(other, trajectory).slack == pytest.approx(once, abs=1e-12)
            rows = rows_at(constraint, other, trajectory, motions)
            assert (rows.num_slacks, set(rows.slack_index.tolist())) == (1, {0})


def doubled(problem, away):
    """Everybody has a second hypothesis, ``away`` m off."""
    p, s = problem.predictions, problem.spaces
    predictions = dataclasses.replace(
        p,
        names=("one", "two"),
        weight=np.full((len(p.weight), 2), 0.5),
        mean=np.concatenate([p.mean, p.mean + away], axis=1),
        velocity=np.repeat(p.velocity, 2, axis=1),
        deviation=np.repeat(p.deviation, 2, axis=1),
    )
    shapes = {
        name: np.repeat(getattr(s, name), 2, axis=1) for name in ("axis", "front", "side", "rear")
    }
    return dataclasses.replace(
        problem, predictions=predictions, spaces=dataclasses.replace(s, **shapes)
    )


def test_values_are_the_slack_that_the_rows_need(crowded, motions, rng):
    for problem in crowded:
        trajectory = motions.wandering(problem, rng)
        for constraint in (PersonBarrier(), SocialSpaceBarrier(), WallBarrier()):
            rows = rows_at(constraint, problem, trajectory, motions)
            needed = np.zeros(rows.num_slacks)
            np.maximum.at(needed, rows.slack_index, -rows.margin)
            assert (
                np.abs(constraint.values(problem, trajectory).slack - needed).max(initial=0) < 1e-12
            )


def test_what_cannot_become_active_has_no_rows(motions):
    far = local_problem(steps=5, step=0.2, people=walkers([[9.0, 0.0, 0.0, 0.0]]))
    trajectory = motions.standing(far)
    for constraint in (PersonBarrier(), SocialSpaceBarrier(), WallBarrier()):
        rows = rows_at(constraint, far, trajectory, motions)
        assert rows.jacobian.shape == (0, 10)


def test_input_limits_by_hand(motions, chair):
    problem = local_problem(steps=3, step=0.2)
    limits = InputLimits(InputLimits.Parameters(tick=0.05))
    low, high, rise, fall = limits.bounds(problem, motions.standing(problem))
    assert high.tolist() == [[1.0, 1.2]] * 3  # the problem's 1 m/s is below the chair's 1.2
    assert low.tolist() == [[0.0, -1.2]] * 3
    back = dataclasses.replace(problem, reverses=True)
    assert limits.bounds(back, motions.standing(back))[0][0, 0] == -chair.max_reverse_speed
    assert rise == pytest.approx(np.array([[0.04, 0.125], [0.16, 0.5], [0.16, 0.5]]))
    assert fall == pytest.approx(np.array([[0.05, 0.125], [0.2, 0.5], [0.2, 0.5]]))
    rows = rows_at(limits, problem, motions.standing(problem), motions)
    assert (rows.slack_index == -1).all()
    assert rows.jacobian @ [1, 2, 4, 8, 16, 32] == pytest.approx([1, 2, 3, 6, 12, 24])


@pytest.mark.parametrize("speed", [-2.0, 0.5, 1.4, 3.0])
def test_a_robot_above_its_limits_may_return_to_them(speed, motions):
    """Braking as hard as allowed keeps every bound, whatever the wheels do now."""
    problem = local_problem(steps=20, step=0.2)
    limits = InputLimits()
    trajectory = dataclasses.replace(
        motions.standing(problem), current_input=np.array([speed, 2.5])
    )
    low, high, rise, fall = limits.bounds(problem, trajectory)
    now, inputs = trajectory.current_input, []
    for k in range(20):
        now = np.clip(0.0, now - fall[k], now + rise[k])
        inputs.append(now)
    braking = np.array(inputs)
    assert (braking >= low - 1e-9).all()
    assert (braking <= high + 1e-9).all()
    assert (low <= high).all()


@pytest.mark.parametrize("now", [[0.0, 0.0, 0.0], [0.6, -0.8, 0.3], [-1.6, 1.2, 0.0]])
def test_the_speed_of_a_holonomic_robot_is_bounded_by_its_norm(now, motions):
    """Rows hold for inputs exactly where a polygon of 16 sides has them, at 1 m/s."""
    problem = motions.any_way(local_problem(steps=8, step=0.2))
    limits, rng = InputLimits(), np.random.default_rng(0)
    trajectory = dataclasses.replace(motions.standing(problem), current_input=np.array(now))
    rows = rows_at(limits, problem, trajectory, motions)
    assert (rows.slack_index == -1).all()
    assert rows.num_row_ids == len(rows.margin) == 8 * 3 + 8 * 16
    assert len(set(rows.row_id.tolist())) == rows.num_row_ids
    most = limits.top_speeds(problem, trajectory)
    for _ in range(50):
        inputs = rng.uniform(-1.3, 1.3, (8, 3))
        left = rows.margin[24:] + rows.jacobian[24:] @ inputs.ravel()
        within = (inputs @ problem.robot.motion_model.facets.T <= most).ravel()
        assert ((left >= 0.0) == within).all()
        if np.hypot(*np.array(now)[:2]) <= 1.0:
            speed = np.hypot(inputs[:, 0], inputs[:, 1])
            kept = (left.reshape(8, 16) >= 0.0).all(axis=1)
            assert (speed[kept] <= 1.0 + 1e-9).all()
            assert kept[speed < np.cos(np.pi / 16.0)].all()


@pytest.mark.parametrize("now", [[2.0, 0.0, 0.0], [-1.5, -1.5, 2.0], [0.7, 0.7, 0.0]])
def test_a_holonomic_robot_that_is_too_fast_may_brake(now, motions):
    """Braking each input as hard as allowed keeps every row and every bound."""
    problem = motions.any_way(local_problem(steps=20, step=0.2))
    limits = InputLimits()
    trajectory = dataclasses.replace(motions.standing(problem), current_input=np.array(now))
    low, high, rise, fall = limits.bounds(problem, trajectory)
    inputs, before = [], np.array(now)
    for k in range(20):
        before = np.clip(0.0, before - fall[k], before + rise[k])
        inputs.append(before)
    change = np.ravel(inputs)
    rows = rows_at(limits, problem, trajectory, motions)
    left = rows.margin + rows.jacobian @ change
    assert left.min() > -1e-9
    assert (rows.upper - rows.jacobian @ change).min() > -1e-9
    assert (np.array(inputs) >= low - 1e-9).all()
    assert (np.array(inputs) <= high + 1e-9).all()
