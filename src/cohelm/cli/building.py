"""``cohelm building``: maps, rooms and doors of a building, storey by storey."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cohelm.buildings import (
    BuildingStorey,
    Lift,
    door_sides,
    lifts_of,
    read_building,
    room_names,
    route_graph,
    storey_record,
    write_route_graph,
    write_storey,
)
from cohelm.cli.progress import Counting, waiting
from cohelm.cli.report import OUTPUT, plain_table, print_line, write_json
from cohelm.cli.requests import BuildingRequest
from cohelm.cli.run import make_folder
from cohelm.errors import ConfigError

if TYPE_CHECKING:
    from cohelm.buildings import AccessReport
    from cohelm.robots import Robot


def building(request: BuildingRequest) -> int:
    """Print the storeys of a building, and write and draw them if requested; returns 0.

    Raises:
        CohelmError: if the model or map cannot be read, or a file not be written.
    """
    asked = [(request.out, "--out"), (request.plot, "--plot")]
    folders = [(folder, key) for folder, key in asked if folder is not None]
    for folder, key in folders:
        if folder.suffix == ".png" or folder.is_file():
            raise ConfigError(f"{folder}: name a folder, for the files of all storeys", key=key)
    robot = _robot(request)
    storeys = read_building(
        request.model, storey=request.storey, resolution=request.resolution, watch=_counted
    )
    if request.out is not None:
        _check_free(request.out, storeys, overwrite=request.overwrite)
    for folder, key in folders:
        make_folder(folder, key)
    notes: list[str] = []
    written = [] if request.out is None else _write(storeys, request.out, notes)
    written += [] if request.plot is None else _draw(storeys, request.plot)
    access = _access(request, robot, storeys)
    written += [] if request.report is None else [request.report]
    lifts = lifts_of(storeys, notes)
    if request.json:
        record: dict[str, Any] = {
            "storeys": [storey_record(each) for each in storeys],
            "lifts": [_record(each) for each in lifts],
            "written": [str(each) for each in written],
        }
        if access is not None:
            from cohelm.evaluation.report.accessibility import access_record

            record["access"] = access_record(access)
        write_json(record)
        return 0
    for storey in storeys:
        _print(storey, _stops(lifts, storey, storeys))
    if access is not None:
        _print_access(access)
    for note in notes:
        print_line(f"note: {note}")
    for file in written:
        print_line(f"written: {file}")
    return 0


def _robot(request: BuildingRequest) -> Robot | None:
    """Chair of the report, once its file can be written; None without a report."""
    if request.report is None:
        if request.entrance is not None:
            raise ConfigError("is an option of --report", key="--entrance")
        return None
    from cohelm.plotting import check_folder
    from cohelm.robots import load_robot

    file, key = request.report, "--report"
    if file.suffix.lower() not in {".html", ".htm"}:
        raise ConfigError(f"{file}: a report ends in .html", key=key)
    if file.exists() and not request.overwrite:
        raise ConfigError(f"{file} exists; name another file, or --overwrite", key=key)
    check_folder(file, key)
    return load_robot(request.robot)


def _access(
    request: BuildingRequest, robot: Robot | None, storeys: tuple[BuildingStorey, ...]
) -> AccessReport | None:
    if robot is None or request.report is None:
        return None
    from cohelm.buildings import accessibility
    from cohelm.evaluation.report.accessibility import write_access

    with waiting("checking rooms and barriers"):
        access = accessibility(storeys, robot, request.entrance)
        write_access(access, storeys, request.report, title=request.model.stem)
    return access


def _write(storeys: tuple[BuildingStorey, ...], folder: Path, notes: list[str]) -> list[Path]:
    with waiting("building the route graph"):
        graph = route_graph(storeys)
        notes += graph.notes
        written = [
            file
            for storey in storeys
            for file in write_storey(storey, folder, graph.lift_places(storey.number))
        ]
        return [*written, *write_route_graph(graph, folder)]


def _check_free(folder: Path, storeys: tuple[BuildingStorey, ...], *, overwrite: bool) -> None:
    """Refuse to replace files, which somebody may have edited, and to mix buildings."""
    stems = {storey.stem for storey in storeys}
    for file in sorted(folder.glob("*.storey.json")):
        if (stem := file.name.removesuffix(".storey.json")) not in stems:
            problem = f"{folder} has another storey, {stem}, whose graph would not fit any more"
            raise ConfigError(f"{problem}; name another folder", key="--out")
    suffixes = (".yaml", ".pgm", ".speed.yaml", ".places.yaml", ".storey.json", ".route.geojson")
    for file in (folder / f"{storey.stem}{suffix}" for storey in storeys for suffix in suffixes):
        if file.exists() and not overwrite:
            raise ConfigError(f"{file} exists; name another folder, or --overwrite", key="--out")


def _counted(products: Iterable[Any], total: int) -> Iterator[Any]:
    with Counting("reading geometry", total) as counting:
        yield from counting(products)


def _draw(storeys: tuple[BuildingStorey, ...], folder: Path) -> list[Path]:
    from cohelm.plotting import draw_storey

    files = {folder / f"{storey.stem}.png": storey for storey in storeys}
    for file, storey in files.items():
        draw_storey(storey, file)
    return [*files]


def _stops(
    lifts: tuple[Lift, ...], storey: BuildingStorey, storeys: tuple[BuildingStorey, ...]
) -> list[str]:
    """Lifts of a storey with the other storeys that they serve."""
    names = {each.number: each.name for each in storeys if each is not storey}
    served = {lift.name: [landing.storey for landing in lift.landings] for lift in lifts}
    return [
        f"{lift} to {', '.join(names[number] for number in at if number in names)}"
        for lift, at in served.items()
        if storey.number in at
    ]


def _record(lift: Lift) -> dict[str, Any]:
    return {
        "name": lift.name,
        "landings": [
            {"storey": each.storey, "doors": list(each.doors), "polygon": each.polygon.tolist()}
            for each in lift.landings
        ],
    }


def _print(storey: BuildingStorey, lifts: list[str]) -> None:
    links = [str(link.kind) for link in storey.links if link.kind != "lift"]
    kinds = Counter([f"{door.kind}s" for door in storey.doors] + links)
    facts = [f"floor at {storey.elevation:.2f} m", f"rooms {len(storey.rooms)}"]
    facts += [f"{kind} {count}" for kind, count in kinds.items()] + lifts
    print_line(f"{storey.number}  {storey.name}: {', '.join(facts)}")
    names = room_names(storey.rooms)
    sides = [door_sides(door, names) for door in storey.doors]
    if storey.rooms:
        table = plain_table("room", "number", "area, m²", "leads to")
        for room in storey.rooms:
            name = names[room.id]
            near = sorted({each for pair in sides if name in pair for each in pair} - {name})
            table.add_row(name, room.number, f"{room.area:.1f}", ", ".join(near))
        OUTPUT.print(table)
    if storey.doors:
        table = plain_table("between", "is a", "clear width, m", "from", "x, m", "y, m")
        for door, pair in zip(storey.doors, sides, strict=True):
            place = (f"{value:.2f}" for value in door.point)
            table.add_row(" – ".join(pair), door.kind, f"{door.width:.2f}", door.width_from, *place)
        OUTPUT.print(table)
    for note in storey.notes:
        print_line(f"note: {note}")


def _print_access(report: AccessReport) -> None:
    print_line(f"{report.chair}: {report.summary}")
    for barrier in report.barriers:
        rooms = ", ".join(barrier.opens) or f"with others {', '.join(barrier.shares)}"
        print_line(f"barrier {barrier.number}, {barrier.place}: {barrier.text}. Opens {rooms}")
    for room in report.rooms:
        if room.remark:
            print_line(f"{room.name}: {room.remark}")
