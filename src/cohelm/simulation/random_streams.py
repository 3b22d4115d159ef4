"""Random streams: one generator for each purpose, so that none changes the draws of another."""

from __future__ import annotations

import zlib

import numpy as np


def generator(seed: int, purpose: str) -> np.random.Generator:
    """Return the generator for one purpose, independent of all others.

    Args:
        seed: of the ride, ≥ 0.
        purpose: name of the stream; the same name and seed draw the same numbers.
    """
    return np.random.default_rng(
        np.random.SeedSequence(entropy=seed, spawn_key=(zlib.crc32(purpose.encode()),))
    )
