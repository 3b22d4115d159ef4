"""Reading what is written on a command line: points and places."""

from __future__ import annotations

from cohelm.errors import ConfigError
from cohelm.maps import FARTHEST


def point(text: str, key: str) -> tuple[float, float]:
    """``x,y`` in metres.

    Raises:
        ConfigError: naming the option.
    """
    spot = place(text, key)
    if isinstance(spot, str) or len(spot) != 2:
        raise ConfigError(f"write a point as x,y in metres, as 3.5,-2, got {text!r}", key=key)
    return spot[0], spot[1]


ZONE_RADIUS = 0.5
"""Of a zone about a point or a line that gives none, m."""


def zone(text: str, key: str) -> tuple[list[tuple[float, float]], float]:
    """Points and radius of a zone: ``x,y[,radius]``, or ``x,y x,y x,y …[,radius]``, in metres.

    One point or a line of two without a radius has 0.5 m; an outline of three and more has none.

    Raises:
        ConfigError: naming the option.
    """
    try:
        groups = [[float(part) for part in group.split(",")] for group in text.split()]
    except ValueError:
        groups = []
    sizes = [len(group) for group in groups]
    numbers = [abs(number) <= FARTHEST for group in groups for number in group]
    fits = bool(sizes) and set(sizes[:-1]) <= {2} and sizes[-1] in {2, 3} and all(numbers)
    radius = groups[-1][2] if fits and sizes[-1] == 3 else None
    if not fits or (radius is not None and radius <= 0.0):
        form = "x,y,radius or an outline as 'x,y x,y x,y', in metres"
        raise ConfigError(f"write a zone as {form}, got {text[:80]!r}", key=key)
    if radius is None:
        radius = ZONE_RADIUS if len(groups) < 3 else 0.0
    corners = [(group[0], group[1]) for group in groups]
    if len(corners) == 3 and len(set(corners)) < 3:
        raise ConfigError(f"an outline needs three different corners, got {text[:80]!r}", key=key)
    return corners, radius


def place(text: str, key: str, *, heading: bool = False) -> str | tuple[float, ...]:
    """``x,y``, ``x,y,degrees`` where a heading makes sense, or a place's name.

    Raises:
        ConfigError: naming the option.
    """
    try:
        numbers = tuple(float(part) for part in text.split(","))
    except ValueError:
        if text.strip() and not text.strip()[0].isdigit():
            return text.strip()
        numbers = ()
    sizes = {2, 3} if heading else {2}
    if len(numbers) not in sizes or not all(abs(each) <= FARTHEST for each in numbers):
        form = "x,y or x,y,degrees" if heading else "x,y"
        raise ConfigError(f"write {form} in metres, or a place's name, got {text!r}", key=key)
    return numbers
