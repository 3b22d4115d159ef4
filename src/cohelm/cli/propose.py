"""``cohelm propose``, ``choose`` and ``preferences``: routes, choices, learned preferences."""

from __future__ import annotations

import time
from datetime import datetime
from pathlib import Path
from typing import Any

from rich.table import Table
from rich.text import Text

from cohelm.cli import streams
from cohelm.cli.plan import planner_of, problem_of
from cohelm.cli.progress import Waiting
from cohelm.cli.report import OUTPUT, print_line, versions, write_json
from cohelm.cli.requests import ProposeRequest
from cohelm.cli.route_report import gap_along, notes
from cohelm.config import nearest
from cohelm.errors import ConfigError
from cohelm.planning import GlobalPlanner, RouteProblem
from cohelm.planning.alternatives.alternatives import AlternativeCriteria
from cohelm.planning.alternatives.features import FeatureParameters
from cohelm.planning.alternatives.learned_preference import (
    FEATURE_WORDS,
    UNITS,
    FeatureVector,
    RouteChoice,
    describe_preference,
    describe_weight,
    share_explained,
)
from cohelm.planning.alternatives.proposal import Proposal, ProposedRoute
from cohelm.planning.alternatives.proposal import propose as propose_routes
from cohelm.planning.alternatives.rider_file import (
    RiderChoices,
    ShownRoutes,
    forget_rider,
    known_rider,
    read_rider,
    read_shown_routes,
    rider_file,
    rider_names,
    write_rider,
    write_shown_routes,
)
from cohelm.planning.planners.route import parameters_of
from cohelm.planning.problem import prepare


def propose(request: ProposeRequest) -> int:
    """Rank routes, print and draw them, and record which one the rider takes, if given.

    Raises:
        CohelmError: if there is no such map, place, robot, planner or route, or the rider's file
            cannot be read.
    """
    if request.plot is not None:
        from cohelm.plotting import check_picture

        check_picture(request.plot)
    if request.take is not None and request.rider is None:
        raise ConfigError("add --rider: the rider who takes the route", key="--take")
    file = None if request.rider is None else rider_file(request.rider)
    rider = None if file is None else read_rider(file) or _new_rider(file)
    planner = planner_of(request)
    problem, places = problem_of(request)
    differing = AlternativeCriteria(measuring=FeatureParameters(speed=request.speed))
    with Waiting("planning"):
        began = time.thread_time()
        found = propose_routes(
            problem, planner, request.alternatives, rider=rider, differing=differing
        )
        seconds = time.thread_time() - began
        remarks = _notes(problem, planner, found)
    shown = _shown(request, found)
    if request.plot is not None:
        from cohelm.plotting import draw_routes

        paths = [each.alternative.path for each in found.routes]
        draw_routes(problem, paths, request.plot, places, title=found.why)
    if request.json:
        report = {**_summary(found, rider), "notes": remarks, "taken": request.take}
        write_json({**report, "timing": {"plan": seconds}})
    else:
        _print(found, rider, request)
        for remark in remarks:
            print_line(f"note: {remark}")
    if file is not None and rider is not None:
        if request.take is not None:
            _record(rider, file, shown, request.take, key="--take", quiet=request.json)
        else:
            write_shown_routes(shown, file)
    return 0


def choose(taken: int, rider_name: str) -> int:
    """Record that the rider took route ``taken`` of the last proposal.

    Raises:
        ConfigError: if no proposal is open, there is no such route, or a file cannot be read.
    """
    file = rider_file(rider_name)
    shown = read_shown_routes(file)
    if shown is None:
        known_rider(rider_name)
        raise ConfigError(
            f"nothing was proposed to {file.stem} since the last choice; "
            f"run cohelm propose … --rider first",
            key="--rider",
        )
    _record(read_rider(file) or _new_rider(file), file, shown, taken, key="N", quiet=False)
    return 0


def show(rider_name: str, *, json: bool) -> int:
    """Print the learned preferences.

    Raises:
        ConfigError: if there is no such rider, or the file cannot be read.
    """
    rider, file = known_rider(rider_name), rider_file(rider_name)
    right = None if rider.weights is None else share_explained(rider.choices, rider.weights)
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
                "habits": [] if rider.weights is None else describe_preference(rider.weights),
            }
        )
        return 0
    if rider.weights is not None:
        OUTPUT.print(_weights(rider, rider.weights))
    print_line(rider.sentence())
    if right is not None:
        print_line(f"they explain {right:.0%} of these choices")
    print_line(f"file: {file}")
    return 0


def reset(rider_name: str) -> int:
    """Forget a rider's choices and preferences.

    Raises:
        ConfigError: if there is no such rider.
    """
    kept = forget_rider(rider_name)
    print_line(f"forgotten; the old file is kept as {kept}: delete it to forget it finally")
    return 0


def _new_rider(file: Path) -> RiderChoices:
    """A rider without choices; warn if the name resembles a known one."""
    hint = nearest(file.stem, rider_names())
    if "did you mean" in hint:
        streams.say(f"note: no choices of {file.stem!r} so far{hint}")
    return RiderChoices(name=file.stem)


def _record(
    rider: RiderChoices, file: Path, shown: ShownRoutes, taken: int, *, key: str, quiet: bool
) -> None:
    """Store a choice and print it."""
    count = len(shown.routes)
    if count < 2:
        raise ConfigError("only one route was proposed, so there is no choice", key=key)
    if taken > count:
        raise ConfigError(f"{count} routes were proposed; take 1 to {count}", key=key)
    choice = RouteChoice(
        when=datetime.now().astimezone().isoformat(timespec="minutes"),
        where=shown.where,
        routes=shown.routes,
        taken=taken - 1,
    )
    rider = rider.with_choice(choice)
    write_rider(rider, file)
    write_shown_routes(None, file)
    if not quiet:
        print_line(f"recorded: route {taken} of {count} was taken; {rider.sentence()}")


def _notes(problem: RouteProblem, planner: GlobalPlanner, found: Proposal) -> list[str]:
    """Notes on the first route."""
    ground, path = prepare(problem, parameters_of(planner)), found.routes[0].alternative.path
    return notes(ground, path, gap_along(ground, path))


def _shown(request: ProposeRequest, found: Proposal) -> ShownRoutes:
    return ShownRoutes(
        where=f"{Path(request.map).name}: {request.start} to {request.goal}",
        routes=tuple(FeatureVector.of(each.alternative.features) for each in found.routes),
    )


def _summary(found: Proposal, rider: RiderChoices | None) -> dict[str, Any]:
    return {
        "routes": [_figures(each) for each in found.routes],
        "learned": found.learned,
        "why": found.why,
        "rider": None if rider is None else rider.name,
        "versions": versions(),
    }


def _figures(each: ProposedRoute) -> dict[str, Any]:
    path, features = each.alternative.path, each.alternative.features
    return {
        "words": each.words,
        "utility": each.utility,
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


def _print(found: Proposal, rider: RiderChoices | None, request: ProposeRequest) -> None:
    table = Table(title=Text("routes to choose from"), header_style="dim", title_justify="left")
    table.add_column("", justify="right")
    table.add_column("description")
    wishes = range(1, len(found.routes[0].alternative.path.wishes.closest) + 1)
    heads = ("length m", "time s", "clearance m", "people", "turns", "doors")
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
    print_line(found.why)
    if len(found.routes) == 1:
        print_line("no other route differs enough")
    elif rider is not None and request.take is None:
        print_line(f"record the choice: cohelm choose NUMBER --rider {_quoted(str(request.rider))}")


def _weights(rider: RiderChoices, weights: FeatureVector) -> Table:
    table = Table(title=Text(rider.name), header_style="dim", title_justify="left")
    table.add_column("weight", justify="right")
    table.add_column("for")
    table.add_column("the rider prefers")
    for name in sorted(FEATURE_WORDS, key=lambda name: -abs(getattr(weights, name))):
        weight, trait = float(getattr(weights, name)), FEATURE_WORDS[name]
        each = f"{trait.unit:g} {trait.counted}"
        table.add_row(f"{weight:+.2f}", each, describe_weight(name, weight))
    return table


def _quoted(text: str) -> str:
    return f"'{text}'" if " " in text else text
