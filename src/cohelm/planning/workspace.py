"""Cells' costs so far, kept between plans: making them anew takes longer than many a search.

Memory that is fresh from the operating system has to be filled with zeros page by page when it is
first used. So one array is kept, and what a search has used of it is made zero again afterwards.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np
from numba import njit

from cohelm.arrays import Bytes, Floats

PAGE = 9
"""2⁹ cells are noted as used together."""

_KEPT: deque[Workspace] = deque(maxlen=1)


@dataclass(frozen=True)
class Workspace:
    """All zeros where nothing is noted as used."""

    reached: Floats
    """Cost so far of each cell, (n,)."""
    used: Bytes
    """Which pages of ``reached`` may not be zero, ((n >> PAGE) + 1,)."""


def take(cells: int) -> Workspace:
    """A workspace of that many cells that nobody else has; the kept one where it fits."""
    try:
        kept = _KEPT.pop()
    except IndexError:
        pass
    else:
        if kept.reached.size == cells:
            return kept
    return Workspace(reached=np.zeros(cells), used=np.zeros((cells >> PAGE) + 1, dtype=np.uint8))


def give_back(workspace: Workspace) -> None:
    """Clean a workspace and keep it for the next plan."""
    clean(workspace)
    _KEPT.append(workspace)


def forget() -> None:
    """Free what is kept, as for measuring how much a plan takes."""
    _KEPT.clear()


def clean(workspace: Workspace) -> None:
    """Make all zero again what was used."""
    _clean(workspace.reached, workspace.used)


@njit(cache=True)
def _clean(reached: Floats, used: Bytes) -> None:
    for page in range(used.shape[0]):
        if used[page]:
            reached[page << PAGE : (page + 1) << PAGE] = 0.0
            used[page] = 0
