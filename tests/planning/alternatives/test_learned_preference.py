"""Preferences learned from choices, and the file of a rider."""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from cohelm.errors import ConfigError
from cohelm.evaluation.report.statistics import bootstrap_mean
from cohelm.maps import read_map
from cohelm.planning.alternatives import rider_file as choices
from cohelm.planning.alternatives.learned_preference import (
    UNITS,
    FeatureVector,
    RouteChoice,
    describe_preference,
    learn_weights,
    share_explained,
    utility,
)
from cohelm.planning.alternatives.proposal import compare_routes, rank_routes
from cohelm.planning.alternatives.rider_file import (
    RiderChoices,
    ShownRoutes,
    read_rider,
    write_rider,
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
    assert len(describe_preference(weights)) == 1


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
    """Of the choices held out, the share that the rider file ranks first after 20 choices."""
    rng = np.random.default_rng(seed)
    weights = hidden_rider(rng)
    order = rng.permutation(len(pool))
    made = tuple(decides(pool[i], weights) for i in order[:AFTER])
    rider = RiderChoices(name="hidden", choices=made, weights=learn_weights(made))
    held_out = [pool[i] for i in order[AFTER:]]
    first = [rank_routes(routes, rider).routes[0].alternative for routes in held_out]
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
    for rider in (None, RiderChoices(name="new")):
        found = rank_routes(some_routes[0], rider)
        assert [each.alternative for each in found.routes] == list(some_routes[0])
        assert not found.learned
        assert "planner" in found.why
    assert "begins at 5 choices" in rank_routes(some_routes[0], RiderChoices(name="new")).why


def test_with_weights_the_best_comes_first_and_the_words_say_it(some_routes):
    routes = max(some_routes, key=lambda each: np.ptp([a.features.encounters for a in each]))
    found = rank_routes(routes, RiderChoices(name="quiet", weights=FeatureVector(encounters=-1.0)))
    met = [each.alternative.features.encounters for each in found.routes]
    assert met == sorted(met)
    assert found.learned
    assert "quiet routes" in found.why
    own, best = routes[0], found.routes[0].alternative
    if best is not own:
        assert compare_routes(best, own, FeatureVector(encounters=-1.0)).startswith("quieter")


def test_ranking_leaves_nothing_out_and_twice_the_same(some_routes):
    rider = RiderChoices(name="anyone", weights=FeatureVector(length=-0.6, doors=0.8))
    for routes in some_routes:
        found = rank_routes(routes, rider)
        assert {id(each.alternative) for each in found.routes} == {id(each) for each in routes}
        assert [e.words for e in rank_routes(routes, rider).routes] == [
            e.words for e in found.routes
        ]


def test_words_give_the_difference_in_metres(some_routes):
    for own, other, *_ in some_routes:
        more = other.features.length - own.features.length
        text = compare_routes(other, own, FeatureVector(length=-1.0))
        if abs(more) >= 1.0:
            assert text.startswith(f"{abs(more):.0f} m {'longer' if more > 0 else 'shorter'}")
        assert compare_routes(own, own) == "nearly equal"


# ------------------------------------------------------------------------------------- the file


def test_a_rider_comes_back_as_written():
    file = choices.rider_file("Ada L.-2")
    rider = RiderChoices(name="ada", choices=(choice(1, length=30.0),) * 6)
    rider = rider.with_choice(choice(turns=4.0))
    write_rider(rider, file)
    assert read_rider(file) == rider
    assert choices.rider_names() == ("Ada L.-2",)
    assert choices.known_rider("Ada L.-2") == rider
    assert json.loads(file.read_text())["version"] == 1  # readable


def test_the_one_before_is_kept():
    file = choices.rider_file("ada")
    first = RiderChoices(name="ada", choices=(choice(),))
    write_rider(first, file)
    write_rider(first.with_choice(choice(1, length=9.0)), file)
    assert read_rider(file.with_name("ada.json.bak")) == first
    assert sorted(each.name for each in file.parent.iterdir()) == ["ada.json", "ada.json.bak"]


def test_an_interruption_leaves_the_old_file(monkeypatch):
    file = choices.rider_file("ada")
    write_rider(RiderChoices(name="ada"), file)

    def stopped(_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(choices.os, "fsync", stopped)
    with pytest.raises(ConfigError, match=r"ada\.json.*No space left"):
        write_rider(RiderChoices(name="ada", choices=(choice(),)), file)
    assert read_rider(file) == RiderChoices(name="ada")
    assert [each.name for each in file.parent.iterdir()] == ["ada.json"]


WRONG = {
    "cut": '{"version": 1, "name": "ada", "cho',
    "other": "[1, 2]",
    "deep": "[" * 100_000,
    "newer": '{"version": 2, "name": "ada"}',
    "unknown key": '{"name": "ada", "choises": []}',
    "no such route": '{"name": "ada", "choices": [{"routes": [{}, {}], "taken": 2}]}',
    "not a number": '{"name": "ada", "weights": {"length": NaN}}',
    "empty": "",
}


@pytest.mark.parametrize("text", WRONG.values(), ids=WRONG)
def test_a_file_that_does_not_read_is_named_and_left_alone(text):
    file = choices.rider_file("ada")
    file.parent.mkdir(parents=True)
    file.write_text(text)
    with pytest.raises(ConfigError, match=r"ada\.json.*reset"):
        read_rider(file)
    with pytest.raises(ConfigError):
        write_rider(RiderChoices(name="ada"), file)
    assert file.read_text() == text
    kept = choices.forget_rider("ada")
    assert kept.read_text() == text
    assert read_rider(file) is None


def test_a_damaged_file_does_not_take_the_place_of_its_backup():
    file = choices.rider_file("ada")
    write_rider(RiderChoices(name="ada", choices=(choice(),)), file)
    write_rider(RiderChoices(name="ada", choices=(choice(), choice(1))), file)
    backup = file.with_name("ada.json.bak").read_bytes()
    file.write_text("{")
    assert choices.forget_rider("ada").name == "ada.json.damaged"
    assert file.with_name("ada.json.bak").read_bytes() == backup


def test_names_are_of_any_script():
    for name in ("हिन्दी", "กิ่ง", "jose\u0301", "O'Neill"):
        assert choices.rider_file(name).stem == name
    for name in ("a/b", "\u0301", "a\nb", "x" * 65):
        with pytest.raises(ConfigError, match="cannot be the name"):
            choices.rider_file(name)


def test_not_text_is_said():
    file = choices.rider_file("ada")
    file.parent.mkdir(parents=True)
    file.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(ConfigError, match="not what cohelm wrote"):
        read_rider(file)


@pytest.mark.parametrize("name", ["", "..", ".ada", "a/b", "../ada", "a" * 65, "ada\n", "ada "])
def test_names_that_no_file_should_have(name):
    with pytest.raises(ConfigError, match="name of a rider"):
        choices.rider_file(name)


def test_an_unknown_rider_is_said_with_the_nearest():
    write_rider(RiderChoices(name="ada"), choices.rider_file("ada"))
    with pytest.raises(ConfigError, match="did you mean 'ada'"):
        choices.known_rider("adda")
    with pytest.raises(ConfigError, match="did you mean 'ada'"):
        choices.forget_rider("adda")


def test_what_was_shown_is_kept_until_answered():
    file = choices.rider_file("ada")
    shown = ShownRoutes(where="a map", routes=(liked(), liked(length=3.0)))
    assert choices.read_shown_routes(file) is None
    choices.write_shown_routes(shown, file)
    assert choices.read_shown_routes(file) == shown
    assert choices.rider_names() == ()
    choices.write_shown_routes(None, file)
    assert choices.read_shown_routes(file) is None


def test_explained_is_the_share_ranked_first():
    made = [choice(length=30.0)] * 3 + [choice(1, length=30.0)]
    assert share_explained(made, FeatureVector(length=-1.0)) == 0.75
    assert share_explained([], FeatureVector()) == 0.0


def test_proposing_does_not_pay_for_learning():
    code = "import cohelm.planning.alternatives.proposal, sys; sys.exit('sklearn' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
