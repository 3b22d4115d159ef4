from dataclasses import replace

import numpy as np
import pytest

from cohelm.arrays import identical
from cohelm.messages import People
from cohelm.perception import HYPOTHESES, Hypotheses
from cohelm.perception.prediction.interacting_models import transition_coefficients
from cohelm.testing import check_predictor
from cohelm.testing.scenes import walkers

TICK = 0.1


def crowd(ways, *, start=0.0, every=TICK, steps=10, step=0.12, predictor=None, memory=None):
    """Predictions after each tick of people on ``ways`` (ticks, n, 4), and the last memory."""
    predictor = predictor or Hypotheses()
    told = []
    for k, states in enumerate(ways):
        people = walkers(states, time=start + k * every)
        predictions, memory = predictor.predict(people, steps, step, memory)
        told.append(predictions)
    return told, memory


def way(velocity, every=TICK):
    """States (ticks, 1, 4) of one person with velocities (ticks, 2)."""
    velocity = np.asarray(velocity, dtype=float)
    position = np.cumsum(velocity * every, axis=0)
    return np.concatenate([position, velocity], axis=1)[:, None]


def changing(after, settle=4, before=30, ticks=12):
    """Straight on at 1.2 m/s, then within ``settle`` ticks to the velocity ``after``."""
    share = np.clip(np.arange(1 - before, ticks + 1) / settle, 0.0, 1.0)[:, None]
    return way((1.0 - share) * (1.2, 0.0) + share * np.asarray(after))


def beside(ways):
    """The same 5 m to the left."""
    return ways + np.array([0.0, 5.0, 0.0, 0.0])


def likely(told, name):
    return np.array([each.probability(name)[0] for each in told])


def test_fulfils_the_contract():
    check_predictor(Hypotheses())


def test_who_walks_straight_keeps_going():
    told, _ = crowd(way(np.tile([1.2, 0.3], (20, 1))))
    assert likely(told, "keeps_going")[-1] > 0.9
    ahead = told[-1].mean[0, 0, -1] - told[-1].mean[0, 0, 0]
    assert ahead == pytest.approx([1.2 * 1.2, 0.3 * 1.2], abs=0.02)


@pytest.mark.parametrize(
    ("after", "name", "settle"),
    [
        ((0.0, 0.0), "stops", 6),
        ((-1.2, 0.0), "turns_back", 4),
        ((0.0, 1.2), "turns_aside_left", 4),
        ((0.0, -1.2), "turns_aside_right", 4),
    ],
)
def test_what_somebody_does_is_known_soon(after, name, settle):
    told, _ = crowd(changing(after, settle))
    assert likely(told, "keeps_going")[15:29].min() > 0.9
    assert likely(told, name)[30:36].max() >= 0.5


def test_who_has_stopped_keeps_standing():
    told, _ = crowd(changing((0.0, 0.0), ticks=60))
    assert likely(told, "keeps_going")[-20:].min() > 0.5
    assert np.hypot(*(told[-1].mean[0, 0, -1] - told[-1].mean[0, 0, 0])) < 0.05


def test_who_stands_may_start_in_any_direction():
    told, _ = crowd(way(np.zeros((30, 2))))
    still, *others = told[-1].deviation[0, :, -1]
    assert max(others) > 2.0 * still
    assert np.abs(told[-1].mean[0, :, -1] - told[-1].mean[0, :, 0]).max() < 0.01


def test_weights_sum_to_one_and_deviations_do_not_shrink():
    told, _ = crowd(changing((-1.2, 0.0)))
    for each in told:
        assert each.names == HYPOTHESES
        assert each.weight.sum(axis=1) == pytest.approx(1.0)
        assert (np.diff(each.deviation, axis=-1) >= 0.0).all()


def test_nobody_is_taken_to_change_when_he_is_first_seen():
    told, _ = crowd(way(np.tile([1.2, 0.3], (1, 1))))
    assert likely(told, "keeps_going")[0] > 0.9


def test_one_odd_look_proves_the_less_the_heavier_the_tails():
    ways = way(np.tile([1.2, 0.0], (20, 1)))
    ways[-1, 0, 0] -= 0.3
    predictors = [
        Hypotheses(Hypotheses.Parameters(student_dof=tails)) for tails in (3.0, 10.0, 100.0)
    ]
    sure = [likely(crowd(ways, predictor=each)[0], "keeps_going")[-1] for each in predictors]
    assert sure == sorted(sure, reverse=True)
    assert sure[0] > sure[-1] + 0.05


def turned(ways, angle):
    c, s = np.cos(angle), np.sin(angle)
    R = np.array([[c, -s], [s, c]])
    return np.concatenate([ways[..., :2] @ R.T, ways[..., 2:] @ R.T], axis=-1), R


def test_turning_the_world_turns_the_predictions():
    ways = changing((0.0, 1.2))
    other, R = turned(ways, 2.1)
    here, there = crowd(ways)[0][-1], crowd(other)[0][-1]
    assert there.weight == pytest.approx(here.weight)
    assert there.mean == pytest.approx(here.mean @ R.T)
    assert there.velocity == pytest.approx(here.velocity @ R.T)
    assert there.deviation == pytest.approx(here.deviation)


def test_a_mirror_swaps_left_and_right():
    mirror = np.array([1.0, -1.0, 1.0, -1.0])
    ways = changing((0.0, 1.2))
    here, there = crowd(ways)[0][-1], crowd(ways * mirror)[0][-1]
    swap = [0, 1, 2, 4, 3]
    assert there.weight[:, swap] == pytest.approx(here.weight)
    assert there.mean[:, swap] == pytest.approx(here.mean * [1.0, -1.0])


def test_twin_runs_are_equal_and_memory_is_left_alone():
    ways = changing((0.0, 0.0))
    predictor = Hypotheses()
    _, memory = crowd(ways[:32], predictor=predictor)
    kept = replace(memory, mode_probability=memory.mode_probability.copy(), mean=memory.mean.copy())
    twins = [crowd(ways[32:], start=3.2, memory=memory, predictor=predictor) for _ in range(2)]
    assert identical(*twins)
    assert identical(memory, kept)


def test_asking_again_at_the_same_time_changes_nothing():
    ways = changing((0.0, 0.0))
    predictor = Hypotheses()
    told, memory = crowd(ways, predictor=predictor)
    people = walkers(ways[-1], time=TICK * (len(ways) - 1))
    again, after = predictor.predict(people, 10, 0.12, memory)
    assert identical(again, told[-1])
    assert identical(after, memory)


def test_ticks_between_scans_tell_nothing_new():
    # scans at 10 Hz; between them the tracker only goes on with what it knows
    ways = changing((0.0, 0.0))
    between = ways.copy()
    between[..., :2] += 0.5 * TICK * between[..., 2:]
    often = np.stack([ways, between], axis=1).reshape(-1, 1, 4)
    seldom, frequent = crowd(ways)[0], crowd(often, every=0.5 * TICK)[0]
    assert frequent[-2].weight == pytest.approx(seldom[-1].weight)


def test_everyone_is_known_by_id_in_any_order():
    ways = np.concatenate([changing((0.0, 0.0)), beside(changing((-1.2, 0.0)))], axis=1)
    predictor = Hypotheses()
    _, memory = crowd(ways[:33], predictor=predictor)
    people = walkers(ways[33], time=3.3)
    swapped = replace(
        people,
        id=people.id[::-1],
        mean=people.mean[::-1],
        covariance=people.covariance[::-1],
    )
    here, _ = predictor.predict(people, 4, 0.3, memory)
    there, _ = predictor.predict(swapped, 4, 0.3, memory)
    assert there.weight == pytest.approx(here.weight[::-1])
    assert there.mean == pytest.approx(here.mean[::-1])


def test_people_come_and_go():
    ways = np.concatenate([changing((0.0, 0.0)), beside(changing((-1.2, 0.0)))], axis=1)
    predictor = Hypotheses()
    _, both = crowd(ways[:33], predictor=predictor)
    _, one = crowd(ways[:33, :1], predictor=predictor)
    people = walkers(ways[33], time=3.3)
    alone = walkers(ways[33, :1], time=3.3)
    # whoever else is there does not matter
    assert predictor.predict(alone, 4, 0.3, both)[0].weight == pytest.approx(
        predictor.predict(people, 4, 0.3, one)[0].weight[:1]
    )
    # a newcomer is as everybody is
    new = predictor.predict(people, 4, 0.3, one)[0].weight[1]
    assert new == pytest.approx(predictor.predict(people, 4, 0.3, None)[0].weight[1])
    nobody, memory = predictor.predict(People.empty(3.3), 4, 0.3, both)
    assert nobody.weight.shape == (0, 5)
    assert len(memory.id) == 0


@pytest.mark.parametrize("back", [0.5, 100.0])
def test_a_clock_that_runs_back_does_no_harm(back):
    ways = changing((0.0, 0.0))
    predictor = Hypotheses()
    _, memory = crowd(ways, predictor=predictor)
    told, _ = predictor.predict(walkers(ways[-1], time=4.0 - back), 10, 0.1, memory)
    assert np.isfinite(told.mean).all()
    assert told.weight.sum() == pytest.approx(1.0)


def test_transition_is_that_of_the_sampled_motion():
    # dv = −v dt / τ + √q dw from v = 1 over 0.6 s, in 600 small steps
    tau, q, rng = 0.3, 0.4, np.random.default_rng(0)
    v, p = np.ones(40_000), np.zeros(40_000)
    for _ in range(600):
        kick = rng.normal(0.0, np.sqrt(q * 1e-3), 40_000)
        p += 1e-3 * v
        v += -1e-3 * v / tau + kick
    a, g, qpp, qpv, qvv = transition_coefficients(0.6, tau, q)
    assert v.mean() == pytest.approx(a, abs=0.005)
    assert p.mean() == pytest.approx(g, abs=0.005)
    # 40,000 samples know a variance to about 0.7 %
    assert np.cov(p, v)[[0, 0, 1], [0, 1, 1]] == pytest.approx([qpp, qpv, qvv], rel=0.03)
