"""The search for parameters: what is drawn, what a ride costs, and that it goes on where it was."""

import importlib.util
import json
from pathlib import Path

import numpy as np
import pytest

from cohelm import plugins
from cohelm.benchmarks.rides.cases import OWN_SETTINGS
from cohelm.benchmarks.tuning import (
    CYCLE,
    FIRST_SEED,
    PARTS,
    RUNGS,
    Axis,
    Training,
    check_known,
    cost_parts,
    draws,
    read_spaces,
    survivors,
)
from cohelm.errors import ConfigError
from cohelm.evaluation import Outcome
from cohelm.scenarios.presets import as_settings, nested, tuned_file, tuned_settings

PROJECT = Path(__file__).parent.parent.parent
SPACES = PROJECT / "benchmarks/tuned/spaces.yaml"


@pytest.fixture(scope="module")
def tune():
    spec = importlib.util.spec_from_file_location("tune", PROJECT / "benchmarks/tune.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


# ---------------------------------------------------------------------------- what is drawn


def test_an_axis_goes_from_bound_to_bound():
    assert [Axis(low=1.0, high=3.0).at(x) for x in (0.0, 0.5, 1.0)] == [1.0, 2.0, 3.0]
    assert [Axis(low=0.1, high=10.0, log=True).at(x) for x in (0.0, 0.5, 1.0)] == [0.1, 1.0, 10.0]
    whole = Axis(low=2, high=4, whole=True)
    assert [whole.at(x) for x in (0.0, 0.34, 0.99, 1.0)] == [2, 3, 4, 4]
    assert [Axis(choices=("a", "b")).at(x) for x in (0.0, 0.5, 1.0)] == ["a", "b", "b"]


@pytest.mark.parametrize(
    "given", [{}, {"low": 1.0}, {"low": 2.0, "high": 1.0}, {"low": 0.0, "high": 1.0, "log": True}]
)
def test_an_axis_without_sense_is_refused(given):
    with pytest.raises(ValueError, match=r"low|choices"):
        Axis(**given)


def test_draws_begin_with_what_a_planner_comes_with_and_fill_the_space():
    axes = {"a": Axis(low=0.0, high=1.0), "b": Axis(low=1.0, high=100.0, log=True)}
    drawn = draws(axes, 61)
    assert drawn[0] == {}
    assert drawn[:10] == draws(axes, 10)
    a = np.sort([each["a"] for each in drawn[1:]])
    # 60 of an even sequence leave no gap of more than a few sixtieths
    assert np.diff([0.0, *a, 1.0]).max() < 4.0 / 60.0


def test_the_declared_spaces_hold_and_every_rival_has_one():
    spaces = read_spaces(SPACES)
    rivals = set(plugins.names("local_planners")) - set(OWN_SETTINGS)
    assert set(spaces) == rivals
    for planner, axes in spaces.items():
        assert len(axes) >= 5, planner


def test_a_space_beyond_what_a_planner_allows_is_refused(tmp_path):
    file = tmp_path / "spaces.yaml"
    file.write_text("planners: {ss_mpc_dcbf: {terms.bodies.gamma: {low: 0.5, high: 1.5}}}")
    with pytest.raises(ConfigError, match=r"ss_mpc_dcbf.terms.bodies.gamma"):
        read_spaces(file)
    with pytest.raises(ConfigError, match="no space"):
        check_known({"dwa": {}}, ["dwb"])


def test_training_is_on_seeds_of_its_own():
    rides = [Training("dwa", (), index) for index in range(RUNGS[-1][1])]
    assert min(ride.seed for ride in rides) == FIRST_SEED >= 1000
    assert len({(ride.scene, ride.seed) for ride in rides}) == len(rides)
    assert {ride.scene for ride in rides} == set(CYCLE)


# ---------------------------------------------------------------------------- what it costs


def test_a_good_ride_costs_its_lateness(made_ride):
    # 10 m at 0.8 m/s, the preferred speed, are 12.5 s; 26 ticks of 0.5 s are 12.5 s
    pose = np.zeros((26, 3))
    pose[:, 0] = np.linspace(0.0, 10.0, 26)
    twist = np.tile([0.8, 0.0, 0.0], (26, 1))
    parts = cost_parts(made_ride(pose, twist=twist))
    assert tuple(parts) == PARTS
    assert sum(parts.values()) == pytest.approx(0.0)
    slow = cost_parts(made_ride(pose, step=1.0, twist=twist))
    assert slow["time"] == pytest.approx(1.0)


def test_a_collision_outweighs_all_and_a_fast_one_more(made_ride):
    def cost(outcome, speed=0.0, hit=False):
        ride = made_ride(
            np.zeros((3, 3)), people=np.full((3, 1, 4), 5.0), outcome=outcome,
            twist=np.tile([speed, 0.0, 0.0], (3, 1)), hit_moving=np.full((3, 1), hit),
        )  # fmt: skip
        return sum(cost_parts(ride).values())

    late = cost(Outcome.TIMEOUT)
    slow = cost(Outcome.COLLISION, 0.1, hit=True)
    fast = cost(Outcome.COLLISION, 1.0, hit=True)
    assert 5.0 < late < 10.0 < slow < fast < 25.0


def test_the_better_draws_are_ridden_on():
    costs = {0: [0.5, 0.5], 1: [1.0, 2.0], 2: [9.0, 0.0], 3: [1.0, 2.0]}
    assert survivors(costs, 1, 12) == [0, 1]  # one in six of twelve, ties by their number


def test_what_a_planner_comes_with_is_ridden_to_the_end():
    costs = {0: [3.0, 3.0], 1: [1.0, 2.0], 2: [9.0, 0.0], 3: [1.0, 2.0]}
    assert survivors(costs, 1, 18) == [1, 3, 0]
    assert survivors(costs, 2, 15) == [0]


# ---------------------------------------------------------------------------- presets


def test_parameters_become_settings_and_nest():
    dotted = {"bodies.gamma": 0.3, "bodies.margin": 0.1, "name": "x"}
    assert nested(dotted) == {"bodies": {"gamma": 0.3, "margin": 0.1}, "name": "x"}
    assert as_settings(nested(dotted)) == (
        "local_planner.bodies.gamma=0.3", "local_planner.bodies.margin=0.1",
        'local_planner.name="x"',
    )  # fmt: skip


@pytest.mark.parametrize("planner", plugins.names("local_planners"))
def test_what_is_kept_fits_its_planner(planner):
    found = {}
    for setting in tuned_settings(planner):
        key, _, text = setting.removeprefix("local_planner.").partition("=")
        found[key] = json.loads(text)
    assert plugins.build("local_planners", {"use": planner, **nested(found)}) is not None
    assert tuned_file(planner).parent.is_dir()


# ---------------------------------------------------------------------------- the script


class Rides:
    """A pool whose rides cost what they are told, and that breaks off after some."""

    def __init__(self, until=10_000):
        self.ridden, self.until = [], until

    def imap_unordered(self, _, tasks):
        for draw, training in tasks:
            if len(self.ridden) == self.until:
                raise KeyboardInterrupt
            self.ridden.append((draw, training.index))
            row = {"scene": "s", "seed": training.seed, "outcome": "reached", "error": ""}
            parts = dict.fromkeys(PARTS, 0.0) | {"time": abs(draw - 5.0) + 0.01}
            yield draw, training.index, {**row, "cost": parts["time"], **parts}


AXES = {"horizon": Axis(low=1.0, high=3.0)}


@pytest.mark.parametrize("planners", ["nonsense", "", ",", "dwa,nonsense"])
def test_a_planner_without_a_space_is_refused(tune, monkeypatch, capsys, tmp_path, planners):
    monkeypatch.setattr(
        "sys.argv", ["tune.py", "--planners", planners, "--out", str(tmp_path / "x")]
    )
    with pytest.raises(SystemExit) as end:
        tune.main()
    assert end.value.code == 2
    assert "no space is declared" in capsys.readouterr().err
    assert not (tmp_path / "x").exists()


def test_a_search_rides_its_budget_and_finds_the_best(tune, tmp_path, capsys):
    pool, search = Rides(), tune.Search("dwa", AXES, 16, tmp_path)
    assert search.go(pool, tune.Clock(tune.rides_of(16)))
    best = search.write(whole=True)
    assert best["draw"] == 5
    assert best["cost"] == pytest.approx(0.01)
    assert len(pool.ridden) == len(set(pool.ridden)) == tune.rides_of(16)
    # by hand: 16 draws × 2 rides, 3 draws × 4 more, 2 draws × 12 more
    assert tune.rides_of(16) == 32 + 12 + 24
    found = json.loads((tmp_path / "dwa.json").read_text())
    assert [each["rides"] for each in found["draws"]].count(18) == 2
    assert found["best"]["parameters"] == found["draws"][5]["parameters"]


def test_an_interrupted_search_goes_on_where_it_was(tune, tmp_path, capsys):
    broken, rest = Rides(until=36), Rides()
    search = tune.Search("dwa", AXES, 16, tmp_path)
    assert not search.go(broken, tune.Clock(1))
    search.write(whole=False)
    assert not json.loads((tmp_path / "dwa.json").read_text())["complete"]
    again = tune.Search("dwa", AXES, 16, tmp_path)
    assert again.go(rest, tune.Clock(1))
    assert len(broken.ridden) + len(rest.ridden) == tune.rides_of(16)
    assert not set(broken.ridden) & set(rest.ridden)
    assert again.write(whole=True)["draw"] == 5


def test_rides_of_another_space_are_not_taken_up(tune, tmp_path, capsys):
    tune.Search("dwa", AXES, 4, tmp_path).go(Rides(), tune.Clock(1))
    other, pool = {"horizon": Axis(low=1.0, high=2.0)}, Rides()
    tune.Search("dwa", other, 4, tmp_path).go(pool, tune.Clock(1))
    # all but those of draw 0, which are what the planner comes with
    assert {draw for draw, _ in pool.ridden} == {1, 2, 3}
