"""``cohelm compare`` and ``rate``: what is done with results when the rides are over."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from cohelm.cli import options

app = typer.Typer()


@app.command()
def compare(
    before: Annotated[Path, typer.Argument(metavar="A", help="A result folder: how it was.")],
    after: Annotated[Path, typer.Argument(metavar="B", help="Another: how it is now.")],
    measures: Annotated[
        str | None,
        typer.Option(metavar="A,B", help="Measures to judge; unset, the usual ones."),
    ] = None,
    strict: Annotated[
        bool, typer.Option("--strict", help="One ride that ends worse is a regression.")
    ] = False,
    json: options.Json = False,
) -> int:
    """Contrast two result folders ride by ride; exit status 1 where B is worse."""
    from cohelm.cli import compare as command  # noqa: PLC0415 # lazy
    from cohelm.evaluation.benches.bench import parted  # noqa: PLC0415

    names = parted(measures, "--measures") or None
    return command.compare(before, after, names, strict=strict, json=json)


@app.command()
def rate(  # noqa: PLR0917 # an option is an argument
    folder: Annotated[Path, typer.Argument(help="Of a bench, or of cohelm run --out.")],
    rating: Annotated[
        int | None,
        typer.Option(min=1, max=5, help="1 (bad) to 5 (good); unset, list what was given."),
    ] = None,
    ride: Annotated[
        list[str] | None,
        typer.Option(metavar="KEY=VALUE", help="Which ride: scene=crossing; again for more."),
    ] = None,
    seed: Annotated[int | None, typer.Option(min=0, help="Which ride.")] = None,
    rater: Annotated[str, typer.Option(metavar="NAME", help="A pseudonym of who rode.")] = "",
    note: Annotated[str, typer.Option(help="What else was said.")] = "",
    json: options.Json = False,
) -> int:
    """Keep what a person who rode says of it, 1 to 5, beside the ride."""
    from cohelm.cli import rate as command  # noqa: PLC0415 # lazy

    return command.rate(
        folder, rating, ride=tuple(ride or ()), seed=seed, rater=rater, note=note, json=json
    )
