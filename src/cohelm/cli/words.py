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
