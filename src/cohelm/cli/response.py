"""``cohelm response``: show or reset what the chair has learned about its rider."""

from __future__ import annotations

from pathlib import Path

from cohelm.cli.report import print_line, write_json
from cohelm.live.sessions.records import default_folder
from cohelm.live.sessions.response import LEARNED, reset_response, stored_response

_SHOWN = {
    "tight_speed": ("speed within 0.3 m of walls", 1.0, "m/s"),
    "turn_share": ("sharpness of turns", 100.0, "%"),
    "steadiness": ("steadiness of the hand", 100.0, "%"),
}
"""Quantity → (label, factor, unit)."""


def response(folder: Path | None, *, reset: bool, json: bool) -> int:
    """Print the learned response, or reset it; returns 0.

    Args:
        folder: of the sessions; None: the usual one.
        reset: forget it first.
        json: print JSON.

    Raises:
        StoreError: if the folder cannot be read or written.
    """
    folder = folder or default_folder()
    if reset:
        reset_response(folder)
    found = stored_response(folder)
    if json:
        write_json(found.model_dump())
        return 0
    for name, (label, factor, unit) in _SHOWN.items():
        learned, number = LEARNED[name], factor * getattr(found, name)
        bounds = f"{factor * learned.lower:g} to {factor * learned.upper:g} {unit}"
        print_line(f"{label:28}{number:6.2f} {unit:4} from {found.rides[name]} rides ({bounds})")
    if found.since:
        print_line(f"rides since {found.since} count")
    return 0
