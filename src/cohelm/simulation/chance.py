"""Chance: one generator for each purpose, so that none shifts another's draws."""

from __future__ import annotations

import zlib

import numpy as np


def generator(seed: int, purpose: str) -> np.random.Generator:
    """A generator for one purpose, independent of those for all others.

    Args:
        seed: of the ride, ≥ 0.
        purpose: its name; the same name and seed draw the same numbers.
    """
    return np.random.default_rng(
        np.random.SeedSequence(entropy=seed, spawn_key=(zlib.crc32(purpose.encode()),))
    )
