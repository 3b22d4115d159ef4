"""``cohelm scenarios``, ``robots``, ``plugins`` and ``data``: what there is to choose from."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import typer

app = typer.Typer()


Plot = Annotated[
    Path | None, typer.Option(metavar="DIR", help="Draw each of them to a picture in this folder.")
]


@app.command()
def scenarios(plot: Plot = None) -> int:
    """The scenarios that come with cohelm."""
    from cohelm.cli import listings  # noqa: PLC0415 # lazy

    return listings.scenarios(plot)


@app.command()
def robots() -> int:
    """The chairs that come with cohelm, and the sensors they carry."""
    return _listing("robots")


@app.command()
def plugins() -> int:
    """The parts that a scenario can name, and where they come from."""
    return _listing("plugins")


@app.command()
def data() -> int:
    """The outside data sets that tests and benchmarks use: what is here, and where to get it."""
    return _listing("data")


def _listing(what: str) -> int:
    from cohelm.cli import listings  # noqa: PLC0415 # lazy

    command: Callable[[], int] = getattr(listings, what)
    return command()
