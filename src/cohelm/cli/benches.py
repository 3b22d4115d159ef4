"""``cohelm bench``: a command for every benchmark; one line in ``BENCHES`` adds one."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

import typer

from cohelm.cli import compiled_code, options

BENCHES = {
    "paper-global": (
        "cohelm.evaluation.benches.paper_global",
        "Global planners by how near they come to the rider's own way (Xu et al., Table 2).",
    ),
    "perception": (
        "cohelm.evaluation.benches.perception",
        "People in recordings and in crowds: found, followed, foreseen, and at what cost.",
    ),
    "planning": (
        "cohelm.evaluation.benches.planning",
        "Time and memory of global planning beside scikit-image and SciPy.",
    ),
}
"""Name → the module, which is a ``Bench``, and what it measures."""

app = typer.Typer(
    name="bench",
    help="Benchmarks: each writes its rows, a summary and its pictures to a folder.",
    no_args_is_help=True,
    rich_markup_mode="rich",
)


Seeds = Annotated[
    int | None,
    typer.Option(min=1, max=10_000, help="How many; unset, what is usual for it."),
]
First = Annotated[
    int, typer.Option(min=0, max=2**31, help="The first seed; others give other scenes.")
]
Out = Annotated[
    Path | None, typer.Option(metavar="DIR", help="What to write to; unset, benches/ and its name.")
]
Workers = Annotated[
    int | None, typer.Option(min=1, max=256, help="Processes; unset, what is usual for it.")
]
Map = Annotated[
    Path | None,
    typer.Option("--map", metavar="FILE.yaml", help="A map to stretch; unset, seeded floors."),
]

Size = Annotated[
    list[int] | None,
    typer.Option(
        "--size",
        metavar="CELLS",
        min=64,
        max=20_000,
        help="Side of the map in cells; may be given again. Unset, 384, 1000 and 4000.",
    ),
]


def _command(name: str, module: str) -> Callable[..., int]:
    def command(
        seeds: Seeds = None,
        first: First = 0,
        out: Out = None,
        workers: Workers = None,
        json: options.Json = False,
    ) -> int:
        compiled_code.place()
        from cohelm.cli import bench  # noqa: PLC0415 # lazy

        return bench.bench(name, module, bench.Asked(seeds, out, workers, json, first))

    return command


def _planning(
    seeds: Seeds = None,
    first: First = 0,
    out: Out = None,
    json: options.Json = False,
    map_file: Map = None,
    size: Size = None,
) -> int:
    compiled_code.place()
    from cohelm.cli import bench  # noqa: PLC0415 # lazy

    name, module = "planning", BENCHES["planning"][0]
    own = _given(map_file=map_file, sizes=tuple(size) if size else None)
    asked = bench.Asked(seeds, out, None, json, first, own)
    return bench.bench(name, module, asked)


def _given(**own: Any) -> dict[str, Any]:
    """Those that are set."""
    return {name: each for name, each in own.items() if each is not None}


SPECIAL: dict[str, Callable[..., int]] = {"planning": _planning}
"""Those that take options of their own, which go to the module's ``on``."""

for _name, (_module, _help) in BENCHES.items():
    app.command(_name, help=_help)(SPECIAL.get(_name) or _command(_name, _module))
