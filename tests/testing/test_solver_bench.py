"""``cohelm bench solver``: its parts, its states, and that both QP solvers agree."""

import itertools
import math

import numpy as np
import pytest

from cohelm.control import SsMpcDcbf
from cohelm.control.quadratic import Multipliers, minimise
from cohelm.errors import ConfigError
from cohelm.testing.benches import solver
from cohelm.testing.benches.solver_speed import PLAN, objective, piqp
from cohelm.testing.benches.solver_states import FUTURES, later, ride, with_futures
from cohelm.testing.comparison import along
from cohelm.testing.problems import random_problem


def test_its_parts_can_be_asked_for_alone():
    whole = solver.on().tasks(range(1))
    assert {task[0] for task in whole} == set(solver.PARTS)
    assert [t for t in whole if t[0] == "optima"] == solver.on(["optima"]).tasks(range(1))
    with pytest.raises(ConfigError, match="no part"):
        solver.on(["time"])


def test_the_whole_has_the_sizes_that_are_asked():
    whole = solver.on().tasks(range(1))
    assert sum(task[1] for task in whole if task[0] == "optima") == 500
    assert sum(task[2] for task in whole if task[0] == "failures") >= 20_000
    small = solver.on(share=0.01).tasks(range(1))
    assert sum(task[1] for task in small if task[0] == "optima") == 5
    assert sum(task[2] for task in small if task[0] == "failures") <= 300


def test_a_small_run_reports_itself(tmp_path):
    bench = solver.on(["failures"], 0.001)
    results = [row for task in bench.tasks(range(1)) for row in bench.work(task, tmp_path)]
    report = bench.report(results, tmp_path)
    assert [sheet.title for sheet in report.sheets] == ["States on which nothing may fail"]
    assert report.notes == ("0 failures in 36 solves and plans, 0 asked: met",)


def test_speed_is_drawn_and_judged(tmp_path):
    def row(what, people, ms):
        given = {"part": "speed", "people": people, "horizon": 25, "what": what, "solves": 9}
        times = {"median_ms": ms, "p99_ms": 2.0 * ms, "max_ms": 3.0 * ms, "failed": 0}
        return solver.Result({**dict.fromkeys(solver.COLUMNS, math.nan), **given, **times})

    ours = [row(PLAN, n, ms) for n, ms in ((1, 1.0), (20, 2.0), (50, 4.0))]
    theirs = [row("CasADi + IPOPT", n, ms) for n, ms in ((1, 9.0), (20, 100.0))]
    report = solver.on().report([*ours, *theirs], tmp_path)
    assert "a plan among 1 person: 9 times IPOPT, 10 asked: MISSED" in report.notes
    assert "a plan among 20 people: 50 times IPOPT, 30 asked: met" in report.notes
    # through 1 ms and 2 ms: 1 + 49/19 = 3.58 ms, 3.94 ms with a tenth more
    [said] = [note for note in report.notes if note.startswith("at most linear")]
    assert "3.58 ms among 50" in said
    assert said.endswith("it takes 4.00: MISSED")
    report = solver.on().report([*ours[:2], row(PLAN, 50, 3.9), *theirs], tmp_path)
    assert any(note.endswith("it takes 3.90: met") for note in report.notes)
    assert report.files[0].stat().st_size > 1000


def test_inputs_later_on_are_interpolated_and_the_last_one_lasts():
    inputs = np.array([[0.0, 1.0], [1.0, 1.0], [3.0, -1.0]])
    assert later(inputs, 0.2, 0.0) == pytest.approx(inputs)
    assert later(inputs, 0.2, 0.1) == pytest.approx(np.array([[0.5, 1.0], [2.0, 0.0], [3.0, -1.0]]))


def test_futures_go_on_stop_and_turn_back():
    problem = random_problem(np.random.default_rng(0), 3, steps=10).problem
    futures = with_futures(problem).predictions
    assert futures.names == tuple(FUTURES)
    walked = futures.mean[:, :, -1] - futures.mean[:, :, 0]
    assert walked[:, 0] == pytest.approx(problem.predictions.mean[:, 0, -1] - futures.mean[:, 0, 0])
    assert np.abs(walked[:, 1]).max() == 0.0
    assert walked[:, 2] == pytest.approx(-walked[:, 0])


def test_a_ride_starts_each_solve_from_the_last_plan():
    planner = SsMpcDcbf()
    drawn = random_problem(np.random.default_rng(3), 1, steps=planner.steps, step=planner.step)
    states = [state for state, _ in zip(ride(planner, drawn, 25), range(4), strict=False)]
    for before, after in itertools.pairwise(states):
        assert after.previous is not None
        assert after.problem.time == pytest.approx(before.problem.time + 0.05)
        assert after.seed.inputs.shape == (25, 2)
        assert after.took > 0.0


@pytest.mark.parametrize("people", [0, 4, 12])
def test_piqp_and_daqp_agree(people):
    pytest.importorskip("piqp", reason="needs PIQP: pip install cohelm[bench]")
    planner, rng = SsMpcDcbf(), np.random.default_rng(people)
    for _ in range(3):
        problem = random_problem(rng, people).problem.within(25)
        seed = along(problem, problem.twist[[0, 2]])
        program = planner.control.program(problem, seed, planner.control.value(problem, seed))
        ours, _ = minimise(program, Multipliers.none(program))
        _, theirs = piqp(program)
        assert objective(program, ours) == pytest.approx(objective(program, theirs), rel=1e-4)


def test_a_share_of_the_times_is_a_share_of_their_states():
    whole, tenth = (
        list(solver.SolverBench(("speed",), share).tasks(range(1))) for share in (1.0, 0.01)
    )
    assert len(tenth) == len(whole)
    assert sum(t[3] for t in tenth) == pytest.approx(0.01 * sum(t[3] for t in whole), rel=0.1)
