"""``cohelm bench``: a command for every benchmark; one line in ``BENCHES`` adds one."""

from __future__ import annotations

import inspect
import sys
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import typer
from typer.core import TyperGroup

from cohelm.cli.options import Options, command
from cohelm.cli.requests import BenchRequest
from cohelm.errors import ConfigError

BENCHES = {
    "ablation": (
        "cohelm.benchmarks.rides.ablation",
        "Ablation of ss_mpc_dcbf: leave out one component at a time.",
    ),
    "barn": (
        "cohelm.benchmarks.external.barn",
        "300 BARN worlds in this 2-D simulator: success, collisions, score.",
    ),
    "calm": (
        "cohelm.benchmarks.rides.calm",
        "Arrivals, collisions, stops and jerk on a hospital floor and on real floors.",
    ),
    "cards": (
        "cohelm.benchmarks.rides.cards",
        "All local planners on social navigation cards (Francis et al. 2023).",
    ),
    "crowdnav": (
        "cohelm.benchmarks.external.crowdnav",
        "CrowdNav's circle crossing: people do not see the robot.",
    ),
    "crowds": (
        "cohelm.benchmarks.rides.crowds",
        "All local planners across filmed crowds, which do not react.",
    ),
    "destinations": (
        "cohelm.benchmarks.destinations",
        "Inference of the destination of a rider who has named none, and the offers.",
    ),
    "doorways": (
        "cohelm.benchmarks.rides.doorways",
        "Narrow doorways among people with hands of all kinds: who gets through.",
    ),
    "edges": (
        "cohelm.benchmarks.rides.edges",
        "Edges of the floor: falls, and stops where there is none.",
    ),
    "faults": (
        "cohelm.benchmarks.rides.faults",
        "Faults of sensors, wheels and stick: detected, stopped, contacts; false alarms.",
    ),
    "lost": (
        "cohelm.benchmarks.lost",
        "Localisation health on real floors: chairs carried elsewhere, and false alarms.",
    ),
    "manoeuvres": (
        "cohelm.benchmarks.rides.manoeuvres",
        "Lifts, niches, toilets, dead ends and side doors: in, and out again.",
    ),
    "paper-dynamic": (
        "cohelm.benchmarks.paper.dynamic",
        "All local planners in the paper's dynamic scenes (Xu et al., Table 3).",
    ),
    "paper-global": (
        "cohelm.benchmarks.paper.global_planners",
        "Distance of all global planners from the rider's own path (Xu et al., Table 2).",
    ),
    "paper-static": (
        "cohelm.benchmarks.rides.modes:create_corridors",
        "All driving modes in the paper's corridors (Xu et al., Fig. 13).",
    ),
    "perception": (
        "cohelm.benchmarks.perception.bench",
        "Detection, tracking and prediction of people: scores and computing time.",
    ),
    "planning": (
        "cohelm.benchmarks.planning",
        "Time and memory of global planning, compared with scikit-image and SciPy.",
    ),
    "riders": (
        "cohelm.benchmarks.rides.modes:create_riders",
        "All driving modes with all simulated riders, in five scenes.",
    ),
    "rides": (
        "cohelm.benchmarks.rides.rides",
        "All local planners in the same scenes with people (Xu et al., Table 3).",
    ),
    "sharing": (
        "cohelm.benchmarks.rides.sharing",
        "All driving modes where rider and chair know different things.",
    ),
    "simulation": (
        "cohelm.benchmarks.simulation",
        "Simulated people compared with RVO2 and with real people; computing time.",
    ),
    "socnav1": (
        "cohelm.benchmarks.external.socnav1",
        "Measures of the distance to people beside ratings of people (SocNav1).",
    ),
    "socnavbench": (
        "cohelm.benchmarks.external.socnavbench",
        "SocNavBench's episodes: all local planners among recorded people.",
    ),
    "solver": (
        "cohelm.benchmarks.solver.bench",
        "Solver of ss_mpc_dcbf compared with IPOPT: time, optima and failures.",
    ),
    "speed": (
        "cohelm.benchmarks.ride_speed",
        "Real-time factor of simulation, perception and planning.",
    ),
    "swadapt": (
        "cohelm.benchmarks.rides.swadapt",
        "Circuits of the SWADAPT trials: collisions of simulated riders by mode.",
    ),
    "twin": (
        "cohelm.benchmarks.rides.twin",
        "Planar simulation beside the MuJoCo twin: arrivals, contacts, forces.",
    ),
}
"""Name → ``module`` or ``module:function`` (default ``create``) that returns a bench, and help."""


class _Benches(TyperGroup):
    """Commands that import their benchmark when they are called; a study's file is one as well."""

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Return (name, command, other arguments) for the arguments of ``cohelm bench``."""
        name = args[0]
        if name.endswith(".py"):
            return name, command_of(Path(name).stem, module_of(Path(name))), args[1:]
        if name in BENCHES:
            return name, command_of(name, *BENCHES[name]), args[1:]
        from cohelm.config import nearest  # pydantic takes its time to import

        if Path(f"{name}.py").is_file():
            raise ConfigError(f"no benchmark is called {name!r}; a study's file is named {name}.py")
        raise ConfigError(f"no benchmark is called {name!r}{nearest(name, BENCHES)}")


app = typer.Typer(
    name="bench",
    cls=_Benches,
    help="Benchmarks: each writes its rows, a summary and its pictures to a folder. "
    "`cohelm bench FILE.py` rides a study of your own (docs/results.md).",
    no_args_is_help=True,
    rich_markup_mode="rich",
)


def command_of(name: str, module: str, text: str = "") -> Any:
    """Command of one benchmark, with the common options and those of its ``create``."""
    from cohelm.cli.bench import bench, create_of

    create, shared = create_of(module), Options(BenchRequest, omit=("options",))
    own = Options(create)
    if both := {each.name for each in shared.parameters} & {each.name for each in own.parameters}:
        raise ConfigError(f"{', '.join(sorted(both))}: an option of every benchmark; rename it")
    text = text or inspect.getdoc(inspect.getmodule(create)) or ""

    def run(**given: Any) -> int:
        request = BenchRequest(**shared.values(given), options=own.values(given))
        return bench(name, module, request)

    single = typer.Typer(add_completion=False, rich_markup_mode="rich")
    single.command(name, help=text)(command(run, [*shared.parameters, *own.parameters]))
    return typer.main.get_command(single)


def module_of(file: Path) -> str:
    """Name by which this process and its workers import a study's file.

    Raises:
        ConfigError: if there is no such file, or a module of its name comes from elsewhere.
    """
    if not file.is_file():
        raise ConfigError("there is no such file", file=file)
    sys.path.append(str(file.resolve().parent))
    found = find_spec(file.stem) if file.stem.isidentifier() and file.stem not in BENCHES else None
    if found is None or found.origin is None or not Path(found.origin).samefile(file):
        raise ConfigError(f"{file.stem!r} is the name of something else; rename it", file=file)
    return file.stem


def _resolved_later() -> int:
    raise NotImplementedError("resolve_command makes the command")


for _name, (_module, _help) in BENCHES.items():
    app.command(_name, help=_help)(_resolved_later)
