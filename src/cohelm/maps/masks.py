"""Masks over a map, keepout zones and speed limits: Nav2's costmap filters.

A mask is described as for Nav2, by the parameters of its costmap_filter_info_server.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np
from numba import njit
from pydantic import Field

from cohelm import config
from cohelm.arrays import Booleans, Bytes, Floats, SignedBytes, value
from cohelm.errors import MapError
from cohelm.geometry import compose, inverse
from cohelm.kernels import CACHED
from cohelm.maps.grid import OCCUPIED, OccupancyGrid
from cohelm.maps.nav2 import read_map
from cohelm.maps.nav2_yaml import MapWarning, known_part, read_nav2_yaml
from cohelm.messages import Crowding

FilterType = Literal["keepout", "speed_percent", "speed_absolute"]
FILTER_TYPES: tuple[FilterType, ...] = get_args(FilterType)
"""Types by Nav2's number."""
_NODE = "costmap_filter_info_server"


class FilterInfo(config.Model):
    """Parameters of the server, with Nav2's keys and defaults."""

    type: int = Field(0, ge=0, le=4)
    """0 keepout, 1 speed limits in percent, 2 speed limits in m/s; others are not of use here."""
    base: float = 0.0
    multiplier: float = 1.0
    filter_info_topic: str = ""
    mask_topic: str = ""
    use_sim_time: bool = False

    @property
    def filter_type(self) -> FilterType | None:
        """The type by its name; None: not of use here."""
        return dict(enumerate(FILTER_TYPES)).get(self.type)


def read_filter_info(
    file: Path | str, *, types: tuple[FilterType, ...] = FILTER_TYPES
) -> FilterInfo | None:
    """Read the parameters of the one server in a file that has one of ``types``; None: none has.

    The file is Nav2's parameter file, with the node's name and ``ros__parameters``, or holds type,
    base and multiplier alone. Other nodes in it are left out.

    Raises:
        MapError: if the file is invalid, describes no mask at all, or several of these types.
    """
    file = Path(file)
    infos = [known_part(FilterInfo, each, file) for each in _servers(read_nav2_yaml(file))]
    if not infos:
        raise MapError(f"no parameters of a {_NODE}: type, base, multiplier", file=file)
    fitting = [each for each in infos if each.filter_type in types]
    if len(fitting) > 1:
        raise MapError(f"describes {len(fitting)} such masks; give each its own file", file=file)
    return fitting[0] if fitting else None


def _servers(data: dict[str, Any]) -> Iterator[dict[str, Any]]:
    """Parameters of all servers of filter information, at any depth of namespaces."""
    if "ros__parameters" not in data and {"base", "multiplier"} & data.keys():
        yield data
        return
    for node, below in data.items():
        if not isinstance(below, dict):
            continue
        parameters = below.get("ros__parameters")
        if parameters is None:
            yield from _servers(below)
        elif isinstance(parameters, dict) and (
            str(node).endswith(_NODE) or {"base", "multiplier"} & parameters.keys()
        ):
            yield parameters


NAV2_NUMBERS: dict[FilterType, tuple[float, float | None]] = {
    "keepout": (0.0, 1.0),
    "speed_percent": (100.0, -1.0),
    "speed_absolute": (0.0, None),
}
"""Base and multiplier of each type in Nav2's sample configurations; None: there is no sample."""
CLOSED = 100.0
"""Value from which a keepout mask closes a cell."""


@value
class CostmapFilter:
    """Mask and the meaning of its values, after nav2_msgs/CostmapFilterInfo.

    A cell's number is ``base + multiplier · mask``, with the mask's occupancy 0…100: for
    ``keepout`` 100 is closed, 0 is free and what lies between costs in proportion; for
    ``speed_percent`` it is a share of the robot's full speed in percent and for ``speed_absolute``
    a speed in m/s, and 0 is no limit. An unknown cell (−1) has no effect.
    """

    type: FilterType
    mask: OccupancyGrid
    """Grid of any resolution and pose; no effect beyond it."""
    base: float = 0.0
    multiplier: float = 1.0


def read_mask(
    file: Path | str,
    *,
    type: FilterType | None = None,  # noqa: A002  # Nav2's name
    base: float | None = None,
    multiplier: float | None = None,
    info: FilterInfo | None = None,
) -> CostmapFilter:
    """Read a mask from a map YAML and its image, like Nav2's map_server.

    ``mode: scale`` or ``raw`` keeps values between free and closed; in trinary they are unknown.
    A speed mask with values that are no limit gives a :class:`MapWarning`.

    Args:
        file: the map YAML of the mask.
        type: meaning of its numbers; None: that of ``info``.
        base, multiplier: from the mask's 0…100 to numbers; None: those of ``info``, else of
            ``NAV2_NUMBERS``.
        info: Nav2's description of the mask.

    Raises:
        MapError: if the file, type, base or multiplier is invalid or missing; names the file.
    """
    type = (info.filter_type if info else None) if type is None else type  # noqa: A001
    if type not in FILTER_TYPES:
        kinds = ", ".join(FILTER_TYPES)
        raise MapError(f"a mask cannot be of type {type!r}: use one of {kinds}", file=file)
    described = (info.base, info.multiplier) if info else NAV2_NUMBERS[type]
    base = described[0] if base is None else base
    multiplier = described[1] if multiplier is None else multiplier
    if multiplier is None:
        raise MapError(f"a mask of type {type} needs a multiplier, m/s per unit", file=file)
    if not (math.isfinite(base) and math.isfinite(multiplier)):
        raise MapError("base and multiplier of a mask must be finite", file=file)
    mask = CostmapFilter(type=type, mask=read_map(file), base=base, multiplier=multiplier)
    _warn_of_no_limits(mask, file)
    return mask


def closed_cells(filters: tuple[CostmapFilter, ...], grid: OccupancyGrid) -> Booleans:
    """The cells (rows, cols) of ``grid`` whose middles lie where a keepout mask is closed."""
    closed = np.zeros(grid.shape, dtype=np.uint8)
    for f in filters:
        if f.type == "keepout":
            project_mask(f, lambda numbers: (numbers >= CLOSED).astype(np.uint8), grid, closed)
    return closed.view(np.bool_)


def speed_limit_at(filters: tuple[CostmapFilter, ...], point: Floats, full_speed: float) -> float:
    """Lowest limit of the speed masks at a point, m/s; ``full_speed`` if there is none.

    After Nav2's SpeedFilter: 0, an unknown cell and a share outside 0…100 % set none.

    Args:
        filters: masks of any type.
        point: (x, y), map frame, m.
        full_speed: the robot's, m/s.
    """
    limit = full_speed
    for f in filters:
        if f.type == "keepout":
            continue
        number = _number_at(f, float(point[0]), float(point[1]))
        if f.type == "speed_percent":
            number = full_speed * number / 100.0 if number <= 100.0 else 0.0
        if 0.0 < number < limit:
            limit = number
    return limit


def read_crowding(file: Path | str, *, people_per_m2_at_full: float = 1.0) -> Crowding:
    """Read a heat map of the usual density of people: a map YAML and its image, like a mask.

    The image is read as map_server reads it, in ``mode: scale`` (black is crowded, white empty, or
    reversed with ``negate``) or ``raw`` (0…100); what is unknown counts as empty.

    Args:
        file: the YAML of the heat map.
        people_per_m2_at_full: density at the value 100, people per m².

    Raises:
        MapError: if a file cannot be read or keeps no shades; names the file.
    """
    if not (math.isfinite(people_per_m2_at_full) and people_per_m2_at_full > 0.0):
        raise MapError("people_per_m2_at_full must be a positive number", file=file)
    if Path(file).suffix.lower() not in {".yaml", ".yml"}:
        raise MapError("give the YAML file of a heat map, which contains its pose", file=file)
    grid = read_map(file)
    if str(read_nav2_yaml(Path(file)).get("mode", "trinary")).lower() == "trinary":
        raise MapError("mode: a heat map needs scale or raw; trinary keeps no shades", file=file)
    share = np.maximum(grid.data, 0).astype(np.float32) / np.float32(OCCUPIED)
    return Crowding(
        density=share * np.float32(people_per_m2_at_full),
        resolution=grid.resolution,
        X_MG=grid.X_MG,
    )


def project_mask(
    f: CostmapFilter, meaning: Callable[[Floats], Bytes], grid: OccupancyGrid, out: Bytes
) -> None:
    """Raise ``out`` (rows, cols) to the bytes of a mask in each cell of ``grid``.

    Args:
        f: the mask, sampled at the centres of the grid's cells.
        meaning: bytes (n,) of values (n,).
        grid: the grid of ``out``.
        out: changed in place.
    """
    table = np.zeros(256, dtype=np.uint8)  # by the mask's byte taken as unsigned
    table[: OCCUPIED + 1] = meaning(f.base + f.multiplier * np.arange(OCCUPIED + 1.0))
    X_FG = compose(inverse(f.mask.X_MG), grid.X_MG)
    _project(f.mask.data, f.mask.resolution, X_FG, grid.resolution, table, out)


def _warn_of_no_limits(f: CostmapFilter, file: Path | str) -> None:
    """Warn of values of a speed mask that Nav2 discards, because they are no limit."""
    if f.type == "keepout":
        return
    values = np.unique(f.mask.data[f.mask.data >= 0])
    numbers = f.base + f.multiplier * values
    upper = 100.0 if f.type == "speed_percent" else math.inf
    without = values[(numbers < 0.0) | (numbers > upper)]
    if len(without):
        unit = "%" if f.type == "speed_percent" else "m/s"
        warnings.warn(
            f"{file}: value {without[0]} gives {f.base + f.multiplier * without[0]:g} {unit} "
            f"(base {f.base:g}, multiplier {f.multiplier:g}), which is no limit; so do "
            f"{len(without) - 1} other values",
            MapWarning,
            stacklevel=3,
        )


def _number_at(f: CostmapFilter, x: float, y: float) -> float:
    """Value of the mask at a point of the map frame; 0 where it is unknown or ends."""
    mask = f.mask
    x0, y0, yaw = mask.X_MG.tolist()
    cos, sin = math.cos(yaw), math.sin(yaw)
    col = (cos * (x - x0) + sin * (y - y0)) / mask.resolution
    row = (cos * (y - y0) - sin * (x - x0)) / mask.resolution
    rows, cols = mask.data.shape
    if not (0.0 <= row < rows and 0.0 <= col < cols):
        return 0.0
    occupancy = int(mask.data[int(row), int(col)])
    return f.base + f.multiplier * occupancy if 0 <= occupancy <= OCCUPIED else 0.0


@njit(**CACHED)
def _project(
    mask: SignedBytes, side: float, X_FG: Floats, resolution: float, table: Bytes, out: Bytes
) -> None:
    cos, sin = math.cos(X_FG[2]), math.sin(X_FG[2])
    rows, cols = mask.shape
    for r in range(out.shape[0]):
        for c in range(out.shape[1]):
            x, y = (c + 0.5) * resolution, (r + 0.5) * resolution
            col = math.floor((X_FG[0] + cos * x - sin * y) / side)
            row = math.floor((X_FG[1] + sin * x + cos * y) / side)
            if 0 <= row < rows and 0 <= col < cols:
                out[r, c] = max(out[r, c], table[np.uint8(mask[row, col])])
