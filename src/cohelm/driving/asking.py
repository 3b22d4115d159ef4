"""What the chair asks of the navigator and what comes back: small values that cross a pipe."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from cohelm.driving.records import Outcome, RideLog
from cohelm.evaluation import Scenario
from cohelm.messages import Decision, Observation, Request
from cohelm.simulation import Truth

Points = tuple[tuple[float, float], ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Charge:
    """What a process for thinking is made with."""

    scenario: Scenario
    seed: int
    record: Path | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Ask:
    """One step: what is known, what is wanted."""

    number: int
    """Grows with every step; the answer's is the same."""
    errand: int
    """``Errand.version`` that the request is of."""
    observation: Observation
    request: Request
    truth: Truth
    """For log and recorder alone."""
    heard: int
    """The beat in the observation; −1: none."""
    distance: float = 0.0
    """By how much the therapist wants people kept farther away than the rider does, m."""
    afresh: bool = False
    """Nothing of before counts: the world began anew."""
    begin: tuple[str, Path] | None = None
    """A ride begins with this step: its id, and where its rows are kept."""
    end: Outcome | None = None
    """The ride has ended before this step."""
    surroundings: bool = False
    """Say also what a way is planned among, for a preview."""
    glance: bool = False
    """Time stands still: say that alone, and decide nothing."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Way:
    """The route, where it is another one than in the answer before."""

    points: Points
    without: Points
    length: float
    extra: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Answer:
    """One step: what goes to the wheels, and what the page shows."""

    number: int
    errand: int
    heard: int
    decision: Decision
    eta: float = 0.0
    arrived: bool = False
    remaining: float | None = None
    """Along the route, m."""
    trouble: str = ""
    """Why there is no route, where there should be one."""
    way: Way | None = None
    """None: as before."""
    plan: tuple[tuple[float, float, float], ...] = ()
    people: tuple[tuple[float, ...], ...] = ()
    """(id, x, y, v_x, v_y, radius, axis, front, side, rear, group) each."""
    groups: tuple[Points, ...] = ()
    log: RideLog | None = None
    """Of the ride that ended with the question."""
    glance: bool = False
    """Nothing was decided; see ``Ask.glance``."""
    surroundings: bytes | None = None
    """A pickled ``Surroundings``, empty where the chair goes nowhere; None: nobody asked. Whoever
    holds the chair does not open it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Ready:
    """The process is warm; before that it says how far it is."""

    done: bool
    what: str = ""
