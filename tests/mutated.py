"""Damaged copies of a file, and a count of what a reader makes of them."""

import contextlib
import re
import resource
import signal
import time
import warnings
from collections import Counter
from dataclasses import dataclass, field

import numpy as np
import pytest

from cohelm.errors import CohelmError

LONGEST = 10.0
"""Time after which reading one file counts as a hang, s."""
MOST_MEMORY = 600.0
"""Growth of the process over all files, MB."""
PARTS = [
    pytest.param(range(60), id="first"),
    *(
        pytest.param(range(n, n + 1000), id=f"{n}", marks=pytest.mark.slow)
        for n in range(0, 5000, 1000)
    ),
]
"""Numbers of the copies that one test reads: 5,000 in slow tests, none of which takes minutes."""
ABSURD = (b"1e-300", b"1e300", b"-1", b"0", b"nan", b"inf", b"99999999999999999999", b"''", b"[]")
_NUMBER = re.compile(rb"-?\d+\.?\d*(?:e[-+]?\d+)?")


class Hang(BaseException):
    """A reader took too long; no reader catches it."""


@dataclass
class Tally:
    """What became of the files: ``refused``, ``said``, ``same`` as undamaged, or ``silent``."""

    counts: Counter = field(default_factory=Counter)
    silent: list = field(default_factory=list)
    """(number of the file, description of the difference) of what was read without a word."""
    slowest: float = 0.0
    memory: float = 0.0

    def __str__(self):
        counts = ", ".join(f"{n} {kind}" for kind, n in sorted(self.counts.items()))
        return f"{counts}; slowest {self.slowest:.2f} s, memory +{self.memory:.0f} MB"


def damaged(data, rng):
    """One damaged copy of a file's bytes: cut, bytes or bits changed, moved, or numbers absurd."""
    out = bytearray(data)
    at = int(rng.integers(len(out)))
    length = int(rng.integers(1, 65))
    match rng.integers(8):
        case 0:
            return bytes(out[:at])
        case 1:
            for k in rng.integers(0, len(out), rng.integers(1, 12)):
                out[k] = rng.choice([0, 1, 127, 255, rng.integers(256)])
        case 2:
            out[at] ^= 1 << int(rng.integers(8))
        case 3:
            del out[at : at + length]
        case 4:
            out[at:at] = rng.bytes(length)
        case 5:
            end = int(rng.integers(len(out)))
            out[at:at] = out[end : end + length]
        case 6:
            out[at : at + 4] = rng.choice([b"\xff\xff\xff\xff", b"\xff\xff\xff\x7f", b"\0\0\0\0"])
        case 7:
            numbers = list(_NUMBER.finditer(data[:4096]))
            if numbers:
                found = numbers[int(rng.integers(len(numbers)))]
                out[found.start() : found.end()] = rng.choice(list(map(bytes, ABSURD)))
    return bytes(out)


@contextlib.contextmanager
def within(seconds):
    """Raise :class:`Hang` if the block takes longer."""

    def _hang(*_):
        raise Hang(f"more than {seconds:g} s")

    before = signal.signal(signal.SIGALRM, _hang)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


def fuzzed(file, data, read, *, copies, seed, difference):
    """Read damaged copies of a file.

    Args:
        file: Path that gets each copy.
        data: Bytes of the sound file.
        read: Function of the path → (content, warnings); a ``CohelmError`` is a refusal.
        copies: Numbers of the copies, a range.
        seed: Of the damage.
        difference: Function (sound, content) → description; empty: they are equal.
    """
    file.write_bytes(data)
    sound, said = read(file)
    assert not said, said
    tally, begin = Tally(), _memory()
    for number in copies:
        copy = damaged(data, np.random.default_rng([seed, number]))
        file.write_bytes(copy)
        began = time.perf_counter()
        try:
            with within(LONGEST), warnings.catch_warnings(record=True) as caught:
                warnings.simplefilter("always")
                content, said = read(file)
        except CohelmError as error:
            kind = "refused" if len(str(error).splitlines()) == 1 else "not one line"
        except Exception as error:
            raise AssertionError(f"file {number} of seed {seed}: {error!r}") from error
        else:
            what = difference(sound, content)
            kind = "said" if said or caught else "silent" if what else "same"
            if kind == "silent":
                tally.silent.append((number, what))
        tally.counts[kind] += 1
        tally.slowest = max(tally.slowest, time.perf_counter() - began)
    tally.memory = _memory() - begin
    return tally


def _memory():
    """Highest memory of this process so far, MB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
