"""Preferences learned from choices."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from cohelm.evaluation.report.statistics import bootstrap_mean
from cohelm.maps import read_map
from cohelm.planning.alternatives.learned_preference import (
    UNITS,
    FeatureVector,
    RouteChoice,
    differences,
    learn_weights,
    preferred_order,
    utility,
)

from .random_floors import route_sets, storey

AFTER, NEEDED = 20, 0.85


@pytest.fixture(autouse=True)
def at_home(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))


@pytest.fixture(scope="module")
def route_pool():
    """44 sets of two to four routes on twelve storeys by chance, with crowds."""
    rng = np.random.default_rng(20)
    return route_sets([storey(rng) for _ in range(12)], rng, 44, k=4)


@pytest.fixture(scope="module")
def some_routes():
    """Ten such sets on three storeys, where it matters little which they are."""
    rng = np.random.default_rng(22)
    return route_sets([storey(rng) for _ in range(3)], rng, 10, k=4)


def liked(**more):
    return FeatureVector(**{"length": 20.0, "clearance": 1.0, **more})


def choice(taken=0, **differences):
    """Of two routes that differ so, the one at ``taken`` was taken."""
    return RouteChoice(routes=(liked(), liked(**differences)), taken=taken)


# ------------------------------------------------------------------------------------- learning


def test_too_few_choices_teach_nothing():
    assert learn_weights([choice(length=40.0)] * 4) is None
    assert learn_weights([choice()] * 50) is None  # routes alike in everything


@pytest.mark.parametrize("name", UNITS)
@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_a_rider_who_minds_one_thing_gets_a_weight_on_that_alone(name, sign):
    more = {name: getattr(liked(), name) + 3.0 * UNITS[name]}
    weights = learn_weights([choice(taken=int(sign > 0.0), **more)] * 6)
    assert getattr(weights, name) == pytest.approx(sign)
    assert np.count_nonzero(np.abs(weights.vector()) > 0.15) == 1


def test_weights_have_length_one_and_do_not_hang_on_the_order_of_choices():
    made = [choice(length=30.0), choice(1, encounters=2.0), choice(turns=3.0), choice(1, doors=1.0)]
    made += [choice(1, clearance=1.3), choice(length=12.0, taken=1)]
    weights = learn_weights(made).vector()
    assert np.linalg.norm(weights) == pytest.approx(1.0)
    assert learn_weights(made[::-1]).vector() == pytest.approx(weights, abs=1e-4)


def test_exchanging_taken_and_left_turns_the_weights_round():
    made = [
        choice(length=30.0),
        choice(encounters=5.0),
        choice(1, clearance=1.3),
        choice(doors=2.0),
    ]
    made += [choice(1, turns=1.0)] * 2
    other = [each.model_copy(update={"taken": 1 - each.taken}) for each in made]
    assert learn_weights(other).vector() == pytest.approx(-learn_weights(made).vector(), abs=1e-6)


def hidden_rider(rng):
    """Weights of any sign and direction, as a person may have them."""
    return FeatureVector(**dict(zip(UNITS, rng.normal(size=len(UNITS)).tolist(), strict=True)))


def decides(routes, weights):
    """The choice of a rider who knows those weights and makes no mistake."""
    seen = tuple(FeatureVector.of(each.features) for each in routes)
    return RouteChoice(routes=seen, taken=int(np.argmax([utility(each, weights) for each in seen])))


def share_ranked_first(pool, seed):
    """Of the choices held out, the share that the learned weights rank first after 20 choices."""
    rng = np.random.default_rng(seed)
    weights = hidden_rider(rng)
    order = rng.permutation(len(pool))
    made = tuple(decides(pool[i], weights) for i in order[:AFTER])
    learned = learn_weights(made)
    held_out = [pool[i] for i in order[AFTER:]]
    first = [routes[preferred_order(routes, learned)[0]] for routes in held_out]
    return np.mean(
        [
            routes[decides(routes, weights).taken] is best
            for routes, best in zip(held_out, first, strict=True)
        ]
    )


@pytest.mark.slow
def test_a_hidden_rider_is_learned_from_twenty_choices(route_pool):
    shares = np.array([share_ranked_first(route_pool, seed) for seed in range(20)])
    sys.stdout.write(f"share ranked first: {report(shares)}\n")
    assert shares.mean() >= NEEDED, report(shares)


def report(shares):
    return f"{bootstrap_mean(shares):.3f}, least {shares.min():.3f}"


@pytest.mark.data
@pytest.mark.filterwarnings("ignore::cohelm.maps.nav2.MapWarning")
@pytest.mark.slow
def test_a_hidden_rider_is_learned_on_real_floors():
    data = os.environ.get("COHELM_DATA")
    files = sorted(Path(data).glob("ros_maps/*.yaml")) if data else []
    if not files:
        pytest.skip("COHELM_DATA names no folder with ros_maps")
    rng = np.random.default_rng(21)
    pool = route_sets([read_map(file) for file in files], rng, 60, k=4)
    shares = np.array([share_ranked_first(pool, seed) for seed in range(20)])
    sys.stdout.write(f"share ranked first on real floors: {report(shares)}\n")
    assert shares.mean() >= NEEDED, report(shares)


# -------------------------------------------------------------------------------------- ranking


def test_without_choices_the_planners_order_stays(some_routes):
    assert preferred_order(some_routes[0], None) == tuple(range(len(some_routes[0])))


def test_with_weights_the_best_comes_first(some_routes):
    routes = max(some_routes, key=lambda each: np.ptp([a.features.encounters for a in each]))
    quiet = FeatureVector(encounters=-1.0)
    order = preferred_order(routes, quiet)
    assert sorted(order) == list(range(len(routes)))
    met = [routes[k].features.encounters for k in order]
    assert met == sorted(met)
    own, best = routes[0], routes[order[0]]
    if best is not own:
        name, more = differences(best.features, own.features, quiet)[0]
        assert name == "encounters"
        assert more < 0.0


def test_differences_are_those_that_are_noticed(some_routes):
    for own, other, *_ in some_routes:
        more = other.features.length - own.features.length
        found = dict(differences(other.features, own.features, FeatureVector(length=-1.0)))
        assert found.get("length", 0.0) == (more if abs(more) >= 1.0 else 0.0)
        assert differences(own.features, own.features) == ()


def test_proposing_does_not_pay_for_learning():
    module = "cohelm.planning.alternatives.learned_preference"
    code = f"import {module}, sys; sys.exit('sklearn' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
