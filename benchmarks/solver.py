"""The local planner's solver: how fast, how sure, and beside CasADi + IPOPT on the same states.

    python benchmarks/solver.py [--quick] [--seed 0]

Four tables, all of thread CPU time, so that other work on the machine counts little:

1. plans along warm-started rides of 2 s among people who walk straight on and see nobody;
   IPOPT solves every tenth of the same states, from the same warm start;
2. plans from nothing for random problems, half of them hopeless: people inside the chair, walls
   through it, more speed than it can have; none may fail;
3. optima of both solvers to convergence, see ``cohelm.testing.comparison``;
4. whole ticks of the navigator in the hospital, from a 360-beam scan to the wheels.
"""

from __future__ import annotations

import argparse
import dataclasses
import os
import platform
import time
from collections import Counter
from collections.abc import Iterator
from importlib.metadata import version
from importlib.util import find_spec

import numpy as np
from rich import box
from rich.console import Console
from rich.table import Table

from cohelm.arrays import Floats
from cohelm.control import LocalProblem, SsMpcDcbf
from cohelm.control.warm_start import last_input, shifted
from cohelm.errors import ControlError
from cohelm.evaluation.scenario import load_scenario
from cohelm.evaluation.staging import set_stage
from cohelm.messages import LocalPlan, Reference, Status
from cohelm.navigation import Navigator, Tick
from cohelm.simulation import World
from cohelm.testing.comparison import Verdict, compare
from cohelm.testing.oracle import solve
from cohelm.testing.problems import RandomProblem, problem_of, random_problem

TICK = 0.05
FINE = 0.01
TICKS = 40
EVERY = 10
CROWDS = (0, 1, 5, 10, 20)


def main() -> None:
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("--quick", action="store_true", help="a tenth of everything")
    arguments.add_argument("--seed", type=int, default=0)
    given = arguments.parse_args()
    share = 10 if given.quick else 1
    console, planner = Console(width=100, color_system=None, highlight=False), SsMpcDcbf()
    console.print(
        f"{platform.machine()}, load {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores, "
        f"seed {given.seed}, Python {platform.python_version()}, "
        + ", ".join(f"{name} {version(name)}" for name in packages())
    )
    console.print(
        f"N = {planner.steps}, Δt = {planner.step} s, at most {planner.parameters.iterations} "
        "quadratic programs a plan; up to two walls; times in ms\n"
    )
    compile_all(planner)
    console.print(table_of_plans(planner, given.seed, rides=max(30 // share, 3)))
    console.print(table_of_failures(planner, given.seed, solves=5000 // share))
    if find_spec("casadi"):
        console.print(table_of_optima(planner, given.seed, problems=200 // share))
    console.print(table_of_ticks(given.seed, seconds=20.0 / (4 if given.quick else 1)))


def compile_all(planner: SsMpcDcbf) -> None:
    """Plan where every branch is taken, so that no compilation is counted."""
    rng = np.random.default_rng(1)
    for k in range(20):
        drawn = random_problem(rng, (0, 5)[k % 2], hopeless=k % 4 < 2)
        for _ in zip(range(3), ride(planner, drawn), strict=False):
            pass


def packages() -> tuple[str, ...]:
    """Those whose versions matter."""
    return ("cohelm", "numpy", "numba", "daqp", *(["casadi"] if find_spec("casadi") else []))


def table_of_plans(planner: SsMpcDcbf, seed: int, rides: int) -> Table:
    """Plan times by crowd, with IPOPT's where CasADi is installed."""
    table = Table(
        title="Plans along rides, and IPOPT on the same states",
        caption="as good: our plan, within its budget, costs at most 1 % more than IPOPT's",
        box=box.SIMPLE_HEAD,
    )
    for name in ("people", "plans", "median", "p99", "max", "stops"):
        table.add_column(name, justify="right")
    for name in ("IPOPT median", "p99", "gave up", "ratio", "as good"):
        table.add_column(name, justify="right")
    for people in CROWDS:
        rng = np.random.default_rng((seed, people))
        taken = [s for _ in range(rides) for s in ride(planner, random_problem(rng, people))]
        took = np.array([s.took for s in taken])
        stops = sum(s.plan.status is Status.STOP for s in taken)
        row = [str(people), str(len(took)), *spread(took), str(stops)]
        if find_spec("casadi"):
            row += beside_ipopt(planner, taken[::EVERY])
        table.add_row(*row)
    return table


@dataclasses.dataclass(frozen=True, slots=True)
class Solved:
    """A state along a ride, its plan and the time that it took, s."""

    problem: LocalProblem
    half_planes: Floats
    previous: LocalPlan | None
    plan: LocalPlan
    took: float


def ride(planner: SsMpcDcbf, drawn: RandomProblem) -> Iterator[Solved]:
    """The chair does what is planned, tick by tick; people keep their velocities."""
    problem, previous, way = drawn.problem, None, path(drawn.problem)
    for k in range(TICKS):
        begin = time.thread_time()
        plan = planner.plan(problem, previous)
        took = time.thread_time() - begin
        yield Solved(problem, drawn.half_planes, previous, plan, took)
        inputs = problem.robot.motion.input(plan.command)[None]
        pose = problem.robot.motion.rollout(problem.pose, inputs, TICK)[-1]
        mean = problem.people.mean.copy()
        mean[:, :2] += TICK * mean[:, 2:]
        problem = problem_of(
            robot=problem.robot,
            pose=pose,
            twist=plan.command,
            reference=along(way, pose, problem.reference),
            people=dataclasses.replace(problem.people, mean=mean),
            walls=problem.walls,
            time=(k + 1) * TICK,
        )
        previous = plan


def path(problem: LocalProblem) -> Floats:
    """The reference (k, 3) at steps of ``FINE`` s, as far on as a ride needs it."""
    reference = problem.reference
    bend = (reference.poses[1, 2] - reference.poses[0, 2]) / reference.step
    count = round((TICKS * TICK + len(reference.speeds) * reference.step) / FINE)
    inputs = np.tile([reference.speeds[0], bend], (count, 1))
    return problem.robot.motion.rollout(reference.poses[0], inputs, FINE)


def along(way: Floats, pose: Floats, like: Reference) -> Reference:
    """From the way's point nearest to ``pose`` on."""
    nearest = int(np.hypot(*(way[:, :2] - pose[:2]).T).argmin())
    ahead = nearest + np.arange(len(like.speeds)) * round(like.step / FINE)
    return dataclasses.replace(like, poses=way[np.minimum(ahead, len(way) - 1)])


def beside_ipopt(planner: SsMpcDcbf, states: list[Solved]) -> list[str]:
    """IPOPT's columns: times, times it gave up, ratio of medians, how often our plan is as good."""
    took, ours, good, gave_up = [], [], 0, 0
    for state in states:
        problem = state.problem
        now = last_input(problem, state.previous)
        warm = shifted(problem, state.previous, now)
        found = solve(
            problem,
            planner.parameters,
            state.half_planes,
            last_input=now,
            start=None if warm is None else warm.inputs,
        )
        took.append(found.time)
        ours.append(state.took)
        gave_up += not found.solved
        good += found.solved and sum(state.plan.costs.values()) <= 1.01 * found.cost + 1e-3
    ratio = np.median(took) / np.median(ours)
    median, p99, _ = spread(np.array(took))
    count = len(states)
    return [median, p99, f"{gave_up}/{count}", f"{ratio:.0f} ×", f"{good}/{count - gave_up}"]


def spread(seconds: Floats) -> list[str]:
    """(median, p99, max) in ms."""
    ms = 1e3 * seconds
    return [f"{x:.2f}" for x in (np.median(ms), np.percentile(ms, 99), ms.max())]


def table_of_failures(planner: SsMpcDcbf, seed: int, solves: int) -> Table:
    """Plans from nothing; a failure is an exception, or a command that is not finite."""
    table = Table(title="Plans from nothing, 0 to 20 people", box=box.SIMPLE_HEAD)
    for name in ("problems", "solves", "failures", "ok", "relaxed", "stop", "median", "p99", "max"):
        table.add_column(name, justify="right")
    for name, hopeless in (("random", False), ("hopeless", True)):
        rng = np.random.default_rng((seed, 100 + hopeless))
        count, took = Counter[str](), []
        for _ in range(solves // 2):
            problem = random_problem(rng, int(rng.integers(0, 21)), hopeless=hopeless).problem
            begin = time.thread_time()
            try:
                plan = planner.plan(problem, None)
                count[plan.status if np.isfinite(plan.command).all() else "failed"] += 1
            except ControlError:
                count["failed"] += 1
            took.append(time.thread_time() - begin)
        words = [str(count[word]) for word in ("failed", Status.OK, Status.RELAXED, Status.STOP)]
        table.add_row(name, str(solves // 2), *words, *spread(np.array(took)))
    return table


def table_of_optima(planner: SsMpcDcbf, seed: int, problems: int) -> Table:
    """Verdicts on random problems, 0 to 20 people."""
    rng = np.random.default_rng((seed, 200))
    found = [
        compare(random_problem(rng, people), planner)
        for people in np.resize((0, 1, 2, 5, 10, 20), problems).tolist()
    ]
    count = Counter(c.verdict for c in found)
    solved = [c for c in found if c.verdict is not Verdict.UNSOLVED]
    exact = [c for c in solved if c.exact]
    table = Table(title="Optima beside IPOPT's", box=box.SIMPLE_HEAD, show_header=False)
    table.add_column()
    table.add_column(justify="right")
    table.add_row("problems that IPOPT solves", f"{len(solved)} of {len(found)}")
    for verdict, words in (
        (Verdict.SAME, "from our seed: the same cost, to 1 %"),
        (Verdict.BETTER, "from our seed: a lower one"),
        (Verdict.OTHER, "from our seed: another local optimum, where IPOPT stays too"),
        (Verdict.DEARER, "from our seed: a dearer one, from where IPOPT ends lower"),
    ):
        table.add_row(words, f"{count[verdict]}")
    budget = np.array([c.budget <= 1.01 * c.ours + 1e-3 for c in solved])
    table.add_row("within the budget of iterations as good, to 1 %", f"{int(budget.sum())}")
    account = max(abs(c.there - c.oracle) / (c.oracle + 1e-3) for c in exact)
    kept = max((c.oracle - c.kept) / (c.oracle + 1e-3) for c in exact)
    table.add_row("IPOPT's cost by our account, largest difference", f"{account:.1e}")
    table.add_row("gained by our solver from IPOPT's optimum, most", f"{max(kept, 0.0):.1e}")
    return table


def table_of_ticks(seed: int, seconds: float) -> Table:
    """Whole ticks of a ride, and the planner's share of them."""
    table = Table(title=f"Whole ticks, hospital, {seconds:.0f} s", box=box.SIMPLE_HEAD)
    for name in ("people", "tracked, mean", "most", "ticks", "median", "p99", "max"):
        table.add_column(name, justify="right")
    table.add_column("control, median", justify="right")
    for people in (10, 40):
        scenario = load_scenario("hospital", settings=[f"people.count={people}"])
        stage = set_stage(scenario, seed)
        world, navigator = World(stage.world, seed), Navigator(stage.navigator)
        tick: Tick | None = None
        took, tracked, control = [], [], []
        for _ in range(round(seconds / TICK)):
            observation = world.observe()
            begin = time.thread_time()
            tick = navigator.step(observation, stage.request, tick)
            took.append(time.thread_time() - begin)
            tracked.append(len(tick.people))
            control.append(tick.durations.get("control", 0.0))
            world.advance(tick.decision)
        warm = np.array(took[20:])  # by then everything is compiled and the route is planned
        table.add_row(
            str(people),
            f"{np.mean(tracked[20:]):.1f}",
            str(max(tracked)),
            str(len(warm)),
            *spread(warm),
            f"{1e3 * np.median(control[20:]):.2f}",
        )
    return table


if __name__ == "__main__":
    main()
