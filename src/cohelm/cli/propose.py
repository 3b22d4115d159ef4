"""Routes to choose from, which one was taken, and what a rider's choices say."""

from __future__ import annotations

import time
from datetime import datetime
from pathlib import Path
from typing import Any

from rich.table import Table
from rich.text import Text

from cohelm.cli import streams
from cohelm.cli.notes import notes
from cohelm.cli.plan import Asked, planner_of, problem_of
from cohelm.cli.plan_report import gap_along
from cohelm.cli.progress import Waiting
from cohelm.cli.report import OUTPUT, versions, write_json
from cohelm.config import nearest
from cohelm.errors import ConfigError
from cohelm.planning import GlobalPlanner, RouteProblem
from cohelm.planning.alternatives import Differing
from cohelm.planning.choices import (
    Rider,
    Shown,
    forget_rider,
    known_rider,
    read_rider,
    read_shown,
    rider_file,
    rider_names,
    write_rider,
    write_shown,
)
from cohelm.planning.features import Measuring
from cohelm.planning.ground import ground_for
from cohelm.planning.learned import UNITS, Choice, Liking, explained, habits, meaning
from cohelm.planning.proposal import Proposal, Proposed
from cohelm.planning.proposal import propose as propose_routes
from cohelm.planning.route import parameters_of
from cohelm.planning.traits import TRAITS


def propose(
    asked: Asked, rider_name: str | None, take: int | None, *, json: bool, plot: Path | None
) -> int:
    """Rank routes, print them, draw where asked to, and note what the rider takes where said.

    Raises:
        CohelmError: if there is no such map, place, robot, planner or route, or the rider's file
            does not read.
    """
    if plot is not None:
        from cohelm.pictures import check_picture  # noqa: PLC0415 # lazy

        check_picture(plot)
    if take is not None and rider_name is None:
        raise ConfigError("say with --rider who takes it", key="--take")
    file = None if rider_name is None else rider_file(rider_name)
    rider = None if file is None else read_rider(file) or _newcomer(file)
    planner = planner_of(asked)
    problem, places = problem_of(asked)
    differing = Differing(measuring=Measuring(speed=asked.speed))
    with Waiting("planning"):
        began = time.thread_time()
        found = propose_routes(
            problem, planner, asked.alternatives, rider=rider, differing=differing
        )
        seconds = time.thread_time() - began
        noted = _notes(problem, planner, found)
    shown = _shown(asked, found)
    if plot is not None:
        from cohelm.pictures import draw_routes  # noqa: PLC0415 # lazy

        paths = [each.alternative.path for each in found.routes]
        draw_routes(problem, paths, plot, places, title=found.why)
    if json:
        report = {**_summary(found, rider), "notes": noted, "taken": take}
        write_json({**report, "timing": {"plan": seconds}})
    else:
        _say(found, rider, rider_name, take)
        for note in noted:
            OUTPUT.print(f"note: {note}", markup=False, soft_wrap=True)
    if file is not None and rider is not None:
        if take is not None:
            _note(rider, file, shown, take, key="--take", quiet=json)
        else:
            write_shown(shown, file)
    return 0


def choose(taken: int, rider_name: str) -> int:
    """Note that of the routes proposed last number ``taken`` was taken.

    Raises:
        ConfigError: if nothing is to be answered, there is no such route, or a file does not read.
    """
    file = rider_file(rider_name)
    shown = read_shown(file)
    if shown is None:
        known_rider(rider_name)
        raise ConfigError(
            f"nothing was proposed to {file.stem} since the last choice; "
            f"run cohelm propose … --rider first",
            key="--rider",
        )
    _note(read_rider(file) or _newcomer(file), file, shown, taken, key="N", quiet=False)
    return 0


def show(rider_name: str, *, json: bool) -> int:
    """Say what was learned.

    Raises:
        ConfigError: if there is no such rider, or the file does not read.
    """
    rider, file = known_rider(rider_name), rider_file(rider_name)
    right = None if rider.weights is None else explained(rider.choices, rider.weights)
    if json:
        weights = None if rider.weights is None else rider.weights.model_dump()
        write_json(
            {
                "rider": rider.name,
                "file": str(file),
                "choices": len(rider.choices),
                "weights": weights,
                "units": dict(UNITS),
                "explained": right,
                "habits": [] if rider.weights is None else habits(rider.weights),
            }
        )
        return 0
    if rider.weights is not None:
        OUTPUT.print(_weights(rider, rider.weights))
    OUTPUT.print(rider.sentence(), markup=False, soft_wrap=True)
    if right is not None:
        OUTPUT.print(f"they explain {right:.0%} of these choices", markup=False)
    OUTPUT.print(f"file: {file}", markup=False, soft_wrap=True)
    return 0


def reset(rider_name: str) -> int:
    """Forget a rider.

    Raises:
        ConfigError: if there is no such rider.
    """
    kept = forget_rider(rider_name)
    OUTPUT.print(
        f"forgotten; what it was is kept as {kept}: delete that to forget it for good",
        markup=False,
        soft_wrap=True,
    )
    return 0


def _newcomer(file: Path) -> Rider:
    """A rider without choices; a name near to a known one may be a slip, so it is said."""
    hint = nearest(file.stem, rider_names())
    if "did you mean" in hint:
        streams.say(f"note: no choices of {file.stem!r} so far{hint}")
    return Rider(name=file.stem)


def _note(rider: Rider, file: Path, shown: Shown, taken: int, *, key: str, quiet: bool) -> None:
    """Record a choice, and say so."""
    count = len(shown.routes)
    if count < 2:
        raise ConfigError("there was one route only, so nothing was chosen", key=key)
    if taken > count:
        raise ConfigError(f"{count} routes were proposed; take 1 to {count}", key=key)
    choice = Choice(
        when=datetime.now().astimezone().isoformat(timespec="minutes"),
        where=shown.where,
        routes=shown.routes,
        taken=taken - 1,
    )
    rider = rider.with_choice(choice)
    write_rider(rider, file)
    write_shown(None, file)
    if not quiet:
        OUTPUT.print(
            f"noted: route {taken} of {count} was taken; {rider.sentence()}",
            markup=False,
            soft_wrap=True,
        )


def _notes(problem: RouteProblem, planner: GlobalPlanner, found: Proposal) -> list[str]:
    """What is to be known of the route that is named first."""
    ground, path = ground_for(problem, parameters_of(planner)), found.routes[0].alternative.path
    return notes(ground, path, gap_along(ground, path))


def _shown(asked: Asked, found: Proposal) -> Shown:
    return Shown(
        where=f"{Path(asked.map).name}: {asked.start} to {asked.goal}",
        routes=tuple(Liking.of(each.alternative.features) for each in found.routes),
    )


def _summary(found: Proposal, rider: Rider | None) -> dict[str, Any]:
    return {
        "routes": [_figures(each) for each in found.routes],
        "learned": found.learned,
        "why": found.why,
        "rider": None if rider is None else rider.name,
        "versions": versions(),
    }


def _figures(each: Proposed) -> dict[str, Any]:
    path, features = each.alternative.path, each.alternative.features
    return {
        "words": each.words,
        "appeal": each.appeal,
        "length": features.length,
        "time": features.time,
        "minimum_clearance": features.clearance_min,
        "clearance": features.clearance,
        "crowding": features.crowding,
        "encounters": features.encounters,
        "turns": features.turns,
        "heading_change": features.heading_change,
        "doors": features.doors,
        "closest_to_each": path.wishes.closest.tolist(),
        "overlap": each.alternative.overlap,
        "points": path.points.tolist(),
        "method": path.method,
    }


def _say(found: Proposal, rider: Rider | None, rider_name: str | None, take: int | None) -> None:
    table = Table(title=Text("routes to choose from"), header_style="dim", title_justify="left")
    table.add_column("", justify="right")
    table.add_column("what it is like")
    wishes = range(1, len(found.routes[0].alternative.path.wishes.closest) + 1)
    heads = ("length m", "time s", "room m", "people", "turns", "narrow")
    for head in (*heads, *(f"to point {i} m" for i in wishes)):
        table.add_column(head, justify="right")
    for number, each in enumerate(found.routes, start=1):
        features = each.alternative.features
        table.add_row(
            str(number),
            Text(each.words),
            f"{features.length:.1f}",
            f"{features.time:.0f}",
            f"{features.clearance:.2f}",
            f"{features.encounters:.1f}",
            str(features.turns),
            str(features.doors),
            *(f"{distance:.2f}" for distance in each.alternative.path.wishes.closest),
        )
    OUTPUT.print(table)
    OUTPUT.print(found.why, markup=False, soft_wrap=True)
    if len(found.routes) == 1:
        OUTPUT.print("no other route differs enough to be a choice", markup=False)
    elif rider is not None and take is None:
        OUTPUT.print(
            f"say which was taken: cohelm choose NUMBER --rider {_quoted(str(rider_name))}",
            markup=False,
            soft_wrap=True,
        )


def _weights(rider: Rider, weights: Liking) -> Table:
    table = Table(title=Text(rider.name), header_style="dim", title_justify="left")
    table.add_column("weight", justify="right")
    table.add_column("for")
    table.add_column("so the rider likes")
    for name in sorted(TRAITS, key=lambda name: -abs(getattr(weights, name))):
        weight, trait = float(getattr(weights, name)), TRAITS[name]
        each = f"{trait.unit:g} {trait.counted}"
        table.add_row(f"{weight:+.2f}", each, meaning(name, weight))
    return table


def _quoted(text: str) -> str:
    return f"'{text}'" if " " in text else text
