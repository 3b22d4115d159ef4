"""Nav2's description of a mask: parameters of its costmap_filter_info_server."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any, Literal, get_args

from pydantic import Field

from cohelm import config
from cohelm.errors import MapError
from cohelm.maps.nav2_yaml import known_part, read_nav2_yaml

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
