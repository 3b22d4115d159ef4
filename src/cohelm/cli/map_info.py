"""``cohelm map``: size and places of a map, and a check that the chair fits at a point."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

from cohelm.cli import parsing
from cohelm.cli.report import OUTPUT, plain_table, print_line, write_json
from cohelm.cli.requests import MapRequest
from cohelm.maps import OccupancyGrid, Places, distance_field, places_beside, read_map
from cohelm.messages import RiderProfile
from cohelm.planning.free_space import FreeSpaceCheck, check_free_space
from cohelm.robots import load_robot


def describe_map(request: MapRequest) -> int:
    """Print, and draw if requested; returns 0, or 1 where the chair does not fit at a point.

    Raises:
        CohelmError: if there is no such map, place or robot, or a point cannot be parsed.
    """
    if request.plot is not None:
        from cohelm.plotting import check_picture

        check_picture(request.plot)
    robot = load_robot(request.robot)
    grid, places = read_map(request.map), places_beside(request.map)
    field = distance_field(grid)
    checks = []
    for text in request.at:
        x, y, heading = _pose(text, places)
        checks.append(
            check_free_space(
                grid, robot, (x, y), heading, clearance=RiderProfile().clearance, field=field
            )
        )
    if request.plot is not None:
        from cohelm.plotting import draw_map

        draw_map(grid, places, request.plot, title=Path(request.map).stem, checks=checks)
    facts = _facts(grid, places)
    if request.json:
        shown = [{**check._asdict(), "robot": robot.name} for check in checks]
        write_json({**facts, "at": shown})
    else:
        _print(request, facts, checks)
    return 0 if all(check.fits for check in checks) else 1


def _pose(text: str, places: Places) -> tuple[float, float, float | None]:
    """Position, m, and heading, rad, if given."""
    spot = parsing.place(text, "--at", heading=True)
    if isinstance(spot, str):
        x, y = places.find(spot).point.tolist()
        return x, y, None
    return spot[0], spot[1], math.radians(spot[2]) if len(spot) == 3 else None


def _facts(grid: OccupancyGrid, places: Places) -> dict[str, Any]:
    width, height = grid.size
    cell = grid.resolution**2
    return {
        "bounds": list(grid.bounds),
        "size": [width, height],
        "resolution": grid.resolution,
        "cells": list(reversed(grid.shape)),
        "free_area": float(np.count_nonzero(~grid.blocked()) * cell),
        "unknown_area": float(np.count_nonzero(grid.data < 0) * cell),
        "places": {place.name: place.point.tolist() for place in places},
    }


def _print(request: MapRequest, facts: dict[str, Any], checks: list[FreeSpaceCheck]) -> None:
    x_min, y_min, x_max, y_max = facts["bounds"]
    columns, rows = facts["cells"]
    table = plain_table("", "")
    table.add_row("size", f"{facts['size'][0]:.2f} × {facts['size'][1]:.2f} m")
    table.add_row("x", f"{x_min:.2f} to {x_max:.2f} m")
    table.add_row("y", f"{y_min:.2f} to {y_max:.2f} m")
    table.add_row("resolution", f"{facts['resolution']:g} m, {columns} × {rows} cells")
    table.add_row("free area", f"{facts['free_area']:.1f} m²")
    table.add_row("unknown area", f"{facts['unknown_area']:.1f} m²")
    OUTPUT.print(table)
    if facts["places"]:
        listed = plain_table("place", "x, m", "y, m")
        for name, (x, y) in facts["places"].items():
            listed.add_row(name, f"{x:.2f}", f"{y:.2f}")
        OUTPUT.print(listed)
    for check in checks:
        print_line(describe_check(check))
    if request.plot is not None:
        print_line(f"written: {request.plot}")


def describe_check(check: FreeSpaceCheck) -> str:
    """One sentence about a point."""
    x, y = check.point
    at = f"({x:.2f}, {y:.2f})"
    if check.fits:
        turn = "can turn on the spot" if check.turns else "cannot turn on the spot"
        return f"{at}: the chair fits and {turn}; {check.clearance:.2f} m to the nearest obstacle"
    off = "" if math.isfinite(check.clearance) else " (off the map)"
    if check.nearest is None:
        return f"{at}{off}: the chair does not fit here, nor anywhere else on this map"
    nx, ny = check.nearest
    return f"{at}{off}: the chair does not fit; nearest free point ({nx:.2f}, {ny:.2f})"
