"""Control barriers: the law of eq. (9), its prices, its rows, and the hypotheses that bind."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cohelm.control.stack import Terms
from cohelm.control.terms import Barrier, WallBarrier
from cohelm.messages import Predictions
from cohelm.robots import Robot
from cohelm.robots.capsule import gap_to_disc
from cohelm.robots.clearance import Clearance
from cohelm.testing.problems import field_of, mirrored, random_problem, turned
from cohelm.testing.scenes import local_problem, round_spaces, walkers

STEPS = 6
NONE = Barrier(l1=0.0, l2=0.0)
UNPRICED = {"bodies": NONE, "social_space": NONE, "walls": WallBarrier(l1=0.0, l2=0.0)}
AT_ONCE = Clearance(now=0.3, growth=0.0, upper=1.0, standing=1.0)


def alone(name, barrier):
    """One barrier without the others."""
    return Terms(**UNPRICED | {name: barrier})


def distances(problem, poses, clearance):
    """h of a single body along poses (N+1, 3), saturated at 1 m."""
    mean, radius = problem.predictions.mean[0, 0], problem.people.radius[0]
    gaps = [
        gap_to_disc(problem.robot.capsule, pose, x, y, radius)
        for pose, (x, y) in zip(poses, mean, strict=False)
    ]
    return np.minimum(np.array(gaps) - clearance.now, 1.0)


@settings(max_examples=25)
@given(st.integers(0, 1000), st.floats(0.1, 1.0))
def test_the_price_is_that_of_the_largest_violation_of_eq_9(motions, seed, gamma):
    """s = max(0, (1 − γ) h_k − h_{k+1}), k = 0…N−1; without it h stays positive once it is."""
    rng = np.random.default_rng(seed)
    start = rng.uniform([0.8, -1.0, -1.4, -1.4], [2.5, 1.0, 1.4, 1.4])
    problem = local_problem(steps=STEPS, step=0.2, speed=0.5, people=walkers([start]))
    barrier = Barrier(gamma=gamma, l1=1.5, l2=0.8)
    tables = motions.prepared(problem, alone("bodies", barrier), clearance=AT_ONCE)
    inputs = np.column_stack([rng.uniform(0.0, 0.6, STEPS), rng.normal(0.0, 0.2, STEPS)])
    found = tables.evaluate(inputs)
    h = distances(problem, tables.trajectory(inputs).poses, AT_ONCE)
    slack = max(float(((1.0 - gamma) * h[:-1] - h[1:]).max()), 0.0)
    assert found.slack == pytest.approx(slack, abs=1e-9)
    assert found.costs["bodies"] == pytest.approx(1.5 * slack + 0.4 * slack**2, abs=1e-9)
    assert found.barrier == pytest.approx(h.min(), abs=1e-9)
    if slack == 0.0 and h[0] >= 0.0:
        assert (h >= -1e-12).all()


def test_gamma_1_is_a_plain_distance(motions, chair):
    """Only a person nearer than the clearance needs slack, by the missing distance."""
    for x in (1.2, 1.5, 1.8, 4.0):
        problem = local_problem(steps=STEPS, step=0.2, people=walkers([[x, 0.0, 0.0, 0.0]]))
        tables = motions.prepared(problem, alone("bodies", Barrier(gamma=1.0)), clearance=AT_ONCE)
        gap = x - chair.capsule[2] - chair.capsule[4] - 0.25
        found = tables.evaluate(np.zeros((STEPS, 2)))
        assert found.slack == pytest.approx(max(0.3 - gap, 0.0), abs=1e-5)


def test_social_spaces_add_the_extents_of_both(motions, chair):
    """A circle of 0.45 m about the person, and √(½ · 2 · 0.01) m of the robot's own: eq. (8)."""
    problem = local_problem(steps=STEPS, step=0.2, people=walkers([[0.1, 1.0, 0.0, 0.0]]))
    tables = motions.prepared(problem, alone("social_space", Barrier(gamma=1.0)))
    found = tables.evaluate(np.zeros((STEPS, 2)))
    h = 1.0 - chair.capsule[4] - 0.25 - 0.45 - 0.1
    assert found.barrier == pytest.approx(h, abs=1e-5)
    assert found.slack == pytest.approx(max(-h, 0.0), abs=1e-5)


def test_all_discs_share_the_slack_of_walls(motions, chair):
    """A wall beside the chair, parallel to it: as dear as the nearest disc alone."""
    side = float(chair.discs[:, 2].max())
    problem = local_problem(steps=STEPS, step=0.2)
    wall = field_of(np.array([[0.0, 1.0, -side]]), problem.pose)
    problem = dataclasses.replace(problem, walls=wall)
    found = motions.prepared(problem, alone("walls", WallBarrier())).evaluate(np.zeros((STEPS, 2)))
    wanted = problem.profile.clearance
    assert found.slack == pytest.approx(wanted, abs=1e-5)
    assert found.costs["walls"] == pytest.approx(2.0 * wanted + wanted**2, abs=1e-4)


def split(weights, *, aside=3.0, state=(2.0, 0.0, -0.5, 0.0)):
    """One person whose hypotheses (h,) differ by ``aside`` m to the left each."""
    problem = local_problem(steps=STEPS, step=0.2, people=walkers([state]))
    p, h = problem.predictions, len(weights)
    shift = aside * np.arange(h)[None, :, None, None] * np.array([0.0, 1.0])
    predictions = Predictions(
        step=p.step,
        names=tuple(f"future_{j}" for j in range(h)),
        weight=np.array([weights]),
        mean=np.repeat(p.mean, h, axis=1) + shift,
        velocity=np.repeat(p.velocity, h, axis=1),
        deviation=np.repeat(p.deviation, h, axis=1),
    )
    return dataclasses.replace(problem, predictions=predictions, spaces=round_spaces(predictions))


def binding(motions, weights, min_probability, **scene):
    tables = motions.prepared(split(weights, **scene))
    table = Barrier().table(tables.scene, min_probability=min_probability)
    return np.flatnonzero(table.binds).tolist()


@pytest.mark.parametrize(
    ("min_probability", "which"),
    [(0.0, [0, 1, 2]), (0.3, [0, 1]), (0.31, [1]), (0.6, [1]), (1.0, [1])],
)
def test_the_likeliest_hypothesis_binds_and_all_others_from_a_probability_on(
    motions, min_probability, which
):
    assert binding(motions, [0.3, 0.6, 0.1], min_probability) == which


def test_of_equally_likely_hypotheses_the_first_binds(motions):
    assert binding(motions, [0.4, 0.4, 0.2], 0.5) == [0]


@settings(max_examples=15)
@given(st.lists(st.floats(0.01, 1.0), min_size=1, max_size=5), st.floats(0.0, 1.0))
def test_each_person_binds_in_one_hypothesis_at_least(motions, weights, min_probability):
    share = np.array(weights) / np.sum(weights)
    expected = (share >= min_probability) | (np.arange(len(share)) == share.argmax())
    found = binding(motions, share, min_probability, aside=0.5)
    assert found == np.flatnonzero(expected).tolist()


def test_of_a_less_likely_hypothesis_the_space_binds_from_a_probability_on_and_the_body_never(
    motions,
):
    """The one in the way has a little less than 0.3, then a little more."""
    costs = {
        name: [
            motions.prepared(
                split([1.0 - p, p], aside=-3.0, state=(1.2, 3.0, 0.0, 0.0)),
                alone(name, Barrier()),
                clearance=AT_ONCE,
            )
            .evaluate(np.zeros((STEPS, 2)))
            .costs[name]
            for p in (0.29, 0.31, 0.6)
        ]
        for name in ("bodies", "social_space")
    }
    assert costs["bodies"][:2] == [0.0, 0.0]
    assert costs["bodies"][2] > 0.0
    assert costs["social_space"][0] == 0.0
    assert min(costs["social_space"][1:]) > 0.0


@pytest.mark.parametrize("name", ["bodies", "social_space"])
def test_a_slack_is_shared_by_the_hypotheses_of_a_person(name, motions):
    """The same hypothesis twice needs the same slack once."""
    near, barrier = (1.2, 0.1, -1.0, 0.0), Barrier()
    once, twice = (
        motions.prepared(split(weights, aside=0.0, state=near), alone(name, barrier))
        for weights in ([1.0], [0.5, 0.5])
    )
    costs = [tables.evaluate(np.zeros((STEPS, 2))).costs[name] for tables in (once, twice)]
    assert costs[1] == pytest.approx(costs[0])
    assert costs[0] > 0.0
    space, count = motions.linearised(twice, np.zeros((STEPS, 2)))
    slacks = space.rows.slack[:count]
    assert len(set(slacks[slacks >= 0].tolist())) == 1


def test_a_distant_person_changes_nothing(motions):
    near, far = [1.5, 0.4, -0.5, 0.0], [40.0, 9.0, -1.0, 0.0]
    one, two = (
        motions.prepared(local_problem(steps=STEPS, step=0.2, people=walkers(people)))
        for people in ([near], [near, far])
    )
    found, other = (tables.evaluate(np.full((STEPS, 2), 0.1)) for tables in (one, two))
    assert other == found
    counts = [motions.linearised(tables, np.full((STEPS, 2), 0.1))[1] for tables in (one, two)]
    assert counts[0] == counts[1]


def rows_by_key(motions, tables, inputs):
    """(margin, jacobian) of the soft rows by their key."""
    space, count = motions.linearised(tables, inputs)
    rows = space.rows
    return {
        int(rows.key[r]): (float(rows.margin[r]), rows.jacobian[r].copy())
        for r in range(count)
        if rows.slack[r] >= 0
    }


def check_rows(motions, tables, inputs):
    """The jacobian of each row is the derivative of its margin; returns the number of rows."""
    rows = rows_by_key(motions, tables, inputs)
    keys = sorted(rows)

    def margins(u):
        found = rows_by_key(motions, tables, u)
        return np.array([found.get(key, (np.nan,))[0] for key in keys])

    numeric = motions.slope(margins, inputs)
    checked = 0
    for key, slope in zip(keys, numeric, strict=True):
        if np.isfinite(slope).all():
            wrong = np.abs(rows[key][1] - slope).max()
            # directions are those of √(e² + 1e-6)
            checked += wrong < 2e-4
    return checked, len(keys)


@pytest.mark.parametrize("norm", [2, 1, "inf"])
@pytest.mark.parametrize("moves", ["as a chair", "any way"])
def test_rows_of_people_are_derivatives(norm, moves, motions):
    rng, right, count = np.random.default_rng(2), 0, 0
    for _ in range(3):
        problem = random_problem(rng, 6, steps=8).problem
        problem = problem if moves == "as a chair" else motions.any_way(problem)
        terms = Terms(**UNPRICED | {"bodies": Barrier()})
        tables = motions.prepared(problem, terms, norm=norm)
        found = check_rows(motions, tables, motions.wandering(problem, rng).inputs)
        right, count = right + found[0], count + found[1]
    assert count > 10
    # but for the kinks of the norms and of the saturation
    assert right >= 0.97 * count


def beside_a_wall(problem):
    """The problem with a wall to the left, which the robot approaches at an angle of 0.3 rad."""
    angle = problem.pose[2] - 1.3
    normal = np.array([np.cos(angle), np.sin(angle)])
    plane = np.array([[*normal, normal @ problem.pose[:2] - 0.6]])
    return dataclasses.replace(problem, walls=field_of(plane, problem.pose))


def test_rows_of_social_spaces_and_walls_are_derivatives(motions):
    """But where a gradient is cut at the steep flank of a narrow space."""
    for name, share in (("social_space", 0.8), ("walls", 0.97)):
        rng, right, count = np.random.default_rng(3), 0, 0
        for _ in range(6):
            problem = random_problem(rng, 6, steps=8).problem
            if name == "walls":
                problem = beside_a_wall(problem)
            barrier = WallBarrier() if name == "walls" else Barrier()
            tables = motions.prepared(problem, alone(name, barrier))
            found = check_rows(motions, tables, motions.wandering(problem, rng).inputs)
            right, count = right + found[0], count + found[1]
        assert count > 10
        assert right >= share * count


def test_a_turned_or_mirrored_world_costs_the_same(motions):
    rng = np.random.default_rng(5)
    for people in (1, 4, 9):
        problem = random_problem(rng, people, steps=STEPS).problem
        inputs = motions.wandering(problem, rng).inputs
        here = motions.prepared(problem).evaluate(inputs)
        for other, sign in (
            (turned(problem, np.array([3.0, -2.0, 1.1])), [1.0, 1.0]),
            (mirrored(problem), [1.0, -1.0]),
        ):
            there = motions.prepared(other).evaluate(np.array(sign) * inputs)
            assert there.cost == pytest.approx(here.cost, rel=1e-4, abs=1e-5)
            assert there.barrier == pytest.approx(here.barrier, abs=1e-4)


@pytest.mark.parametrize("speed", [-2.0, 0.5, 1.4, 3.0])
def test_a_robot_above_its_limits_may_return_to_them(speed, motions):
    """Braking as hard as allowed keeps every bound, whatever the wheels do now."""
    plain = local_problem(steps=20, step=0.2)
    jerky = Robot(**{**plain.robot.model_dump(), "max_jerk": 1000.0})
    problem = dataclasses.replace(plain, robot=jerky)
    tables = motions.prepared(problem, current_input=np.array([speed, 2.5]))
    robot = tables.scene.robot
    now, braking = robot.current_input, []
    for k in range(20):
        fall = robot.first_fall if k == 0 else robot.fall
        rise = robot.first_rise if k == 0 else robot.rise
        now = np.clip(0.0, now - fall, now + rise)
        braking.append(now)
    space, count = motions.linearised(tables, np.array(braking))
    p, hard = space.program, space.rows.slack[:count] < 0
    assert p.low.max() < 1e-9
    assert p.high.min() > -1e-9
    assert space.rows.margin[:count][hard].min() > -1e-9
    assert space.rows.upper[:count][hard].min() > -1e-9


def test_limits_by_hand(motions, chair):
    """0.8 m/s² up and 0.75 of 1 m/s² down, the first within a tick of 50 ms."""
    problem = local_problem(steps=3, step=0.2)
    robot = motions.prepared(problem, current_input=np.zeros(2)).scene.robot
    assert (robot.low[0], robot.high[0]) == (0.0, 1.0)  # below the chair's 1.2 m/s
    assert robot.rise == pytest.approx([0.16, 0.5])
    assert robot.fall == pytest.approx([0.15, 0.5])
    assert robot.first_rise == pytest.approx([0.04, 0.125])
    back = dataclasses.replace(problem, reverses=True)
    low = motions.prepared(back, current_input=np.zeros(2)).scene.robot.low
    assert low[0] == -chair.max_reverse_speed


@pytest.mark.parametrize("now", [[0.0, 0.0, 0.0], [0.6, -0.8, 0.3]])
def test_the_speed_of_a_holonomic_robot_is_bounded_by_its_norm(now, motions):
    """Rows hold for inputs within a polygon of 16 sides about 1 m/s."""
    problem, rng = motions.any_way(local_problem(steps=4, step=0.2)), np.random.default_rng(0)
    tables = motions.prepared(problem, current_input=np.array(now))
    space, _ = motions.linearised(tables, np.zeros((4, 3)))
    facets = np.s_[4 * 3 : 4 * 3 + 4 * 16]
    for _ in range(50):
        inputs = rng.uniform(-1.3, 1.3, (4, 3))
        left = space.rows.margin[facets] + space.rows.jacobian[facets] @ inputs.ravel()
        kept = (left.reshape(4, 16) >= 0.0).all(axis=1)
        speed = np.hypot(inputs[:, 0], inputs[:, 1])
        assert (speed[kept] <= 1.0 + 1e-9).all()
        assert kept[speed < np.cos(np.pi / 16.0)].all()
