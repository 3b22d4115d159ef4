"""Options of benchmarks: each argument of a ``create`` is one, and carries its help."""

from __future__ import annotations

from typing import Annotated, Any

import typer


def names(text: str, *flags: str) -> Any:
    """Option of names, comma-separated."""
    return typer.Option(*flags, metavar="A,B", help=text)


def flag(name: str, text: str) -> Any:
    """Option without a value."""
    return typer.Option(name, help=text)


def repeatable(
    flags: str, metavar: str, text: str, least: float | None = None, most: float | None = None
) -> Any:
    """Option that may be given several times."""
    return typer.Option(flags, metavar=metavar, min=least, max=most, help=f"{text}; repeatable.")


Planners = Annotated[str | None, names("Local planners; default: all that are installed.")]
Scenes = Annotated[str | None, names("Scenarios by name or file; default: those of the benchmark.")]
Riders = Annotated[str | None, names("Riders; default: all with a destination.")]
Modes = Annotated[
    str | None, names("manual, stop_only, assisted, shared, autonomous; default: its own.")
]
TruePeople = Annotated[bool, flag("--true-people", "Give the chair the true positions of people.")]
Tuned = Annotated[bool, flag("--tuned", "Use the parameters of one search for all planners.")]
Settings = Annotated[tuple[str, ...], repeatable("--set", "KEY=VALUE", "Any scenario key, dotted")]
