"""Fair parameter search: equal rides, cost and budget for every planner.

A planner's space declares which of its parameters are searched between which bounds. Draw 0 is the
default; the others fill the space evenly (a scrambled Halton sequence, Owen 2017). All draws get a
few rides, the better ones more, the best most (successive halving, Jamieson & Talwalkar 2016), so
that no time is spent on draws that collide at once. ``benchmarks/tune.py`` runs the search.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

import numpy as np
from pydantic import Field, model_validator
from scipy.stats import qmc

from cohelm import plugins
from cohelm.benchmarks.rides.cases import contender_of, scene_of
from cohelm.benchmarks.study import Variant, scenario_of
from cohelm.config import Model, read_yaml, validate
from cohelm.errors import ConfigError
from cohelm.evaluation.episode.episode import run
from cohelm.evaluation.episode.ride import Outcome, Ride
from cohelm.evaluation.sweeps.ride_task import ride_figures
from cohelm.scenarios.presets import as_settings, nested

FIRST_SEED = 1009
"""First seed of the search, which uses seeds from 1000 on; results use those below. From 1009 on
the first rides of ``distracted`` are those with the turn beside the chair."""
DRAWS = 60
RUNGS = ((1, 2), (6, 6), (15, 18))
"""(one in so many draws is left; rides of each of them by then)."""
LONGEST = 30.0
"""Time limit of a training ride, s: about twice that on an empty floor."""
CYCLE = (
    scene_of("crossing", blind=True, true_people=True),
    scene_of("distracted", true_people=True),
    scene_of("aggressive", true_people=True),
    scene_of("distracted", true_people=True),
    scene_of("crossing", true_people=True),
    scene_of("corridor-2", true_people=True),
)
"""Scenes in turn, with increasing seeds; the corridor, which takes longest, is last."""
PARTS = ("collision", "failure", "standing", "time", "stalled", "intimate", "smoothness")
"""Parts of the cost of a ride."""

_DIGITS = 3
"""Significant digits of a drawn value."""


class Axis(Model):
    """Range of one parameter: two bounds, or a list of choices."""

    low: float | None = None
    high: float | None = None
    log: bool = False
    """Uniform in the logarithm."""
    whole: bool = False
    """Whole numbers only."""
    choices: tuple[Any, ...] = Field((), max_length=20)

    @model_validator(mode="after")
    def _bounds_or_choices(self) -> Self:
        bounded = self.low is not None and self.high is not None
        if bounded == bool(self.choices):
            raise ValueError("give either low and high, or choices")
        if self.low is not None and self.high is not None:
            if self.low >= self.high:
                raise ValueError("low must be less than high")
            if self.log and self.low <= 0.0:
                raise ValueError("with log, low must be positive")
        return self

    def at(self, share: float) -> Any:
        """Value at a share 0…1 of the range."""
        if self.low is None or self.high is None:
            return self.choices[min(int(share * len(self.choices)), len(self.choices) - 1)]
        if self.whole:
            count = math.floor(self.high) - math.ceil(self.low) + 1
            return math.ceil(self.low) + min(int(share * count), count - 1)
        if self.log:
            drawn = self.low * (self.high / self.low) ** share
        else:
            drawn = self.low + share * (self.high - self.low)
        return float(np.clip(float(f"{drawn:.{_DIGITS}g}"), self.low, self.high))


class _Spaces(Model):
    """File of spaces: planner → dotted parameter → range."""

    planners: dict[str, dict[str, Axis]]


def read_spaces(file: Path) -> dict[str, dict[str, Axis]]:
    """Read the spaces of a YAML file; each bound is validated by its planner.

    Raises:
        ConfigError: if a parameter does not exist or a bound is not allowed.
        PluginError: if a planner is not installed.
    """
    spaces = validate(_Spaces, read_yaml(file), file=file).planners
    for planner, axes in spaces.items():
        model = plugins.load("local_planners", planner).Parameters
        for share in (0.0, 1.0):
            ends = {key: axis.at(share) for key, axis in axes.items()}
            validate(model, nested(ends), file=file, prefix=planner)
    return spaces


def draws(axes: Mapping[str, Axis], count: int, seed: int = FIRST_SEED) -> list[dict[str, Any]]:
    """Draw parameters by dotted name; the first draw is empty, the planner's default.

    A longer list begins with the shorter one.
    """
    if not axes or count < 2:
        return [{}]
    shares = qmc.Halton(d=len(axes), scramble=True, seed=seed).random(count - 1)
    return [
        {},
        *(
            {key: axis.at(float(x)) for (key, axis), x in zip(axes.items(), row, strict=True)}
            for row in shares
        ),
    ]


@dataclass(frozen=True)
class Training:
    """One ride of the search."""

    planner: str
    parameters: tuple[tuple[str, Any], ...]
    """(dotted name, value)."""
    index: int
    """Number of the ride; scene and seed follow from it."""

    @property
    def scene(self) -> Variant:
        """Scene of the ride."""
        return CYCLE[self.index % len(CYCLE)]

    @property
    def seed(self) -> int:
        """Seed of the ride, equal for all draws and planners."""
        return FIRST_SEED + self.index

    def ride(self) -> dict[str, Any]:
        """Ride and return the row; a fault in the planner is a row, too."""
        settings = as_settings(nested(dict(self.parameters)))
        choices = (self.scene, contender_of(self.planner, settings=settings))
        row = {"scene": self.scene.label, "seed": self.seed}
        try:
            limit = (f"time_limit={LONGEST}",)
            ride = run(scenario_of(choices, self.seed, limit), self.seed)
        except Exception as failure:  # an error makes a draw a bad one
            parts = dict.fromkeys(PARTS, 0.0) | {"failure": 20.0}
            error = f"{type(failure).__name__}: {failure}".splitlines()[0][:120]
            return {**row, "outcome": "error", "error": error, "cost": 20.0, **parts}
        parts = cost_parts(ride)
        return {
            **row,
            "outcome": ride.outcome.value,
            "error": "",
            "cost": sum(parts.values()),
            **parts,
        }


def cost_parts(ride: Ride) -> dict[str, float]:
    """Cost of one ride by part; the search minimises the mean of their sum.

    - ``collision``: 10 for a touch while the chair moves, and up to 10 more by its speed
    - ``failure``: 5 where the goal is not reached without a collision
    - ``standing``: 0.5 where a person walks into the standing chair
    - ``time``: delay over the straight route at full speed, as a share of its time
    - ``stalled``: time of standing, as half that share
    - ``intimate``: twice the share of time nearer than 0.45 m to a person
    - ``smoothness``: 0.05 × RMS jerk (m/s³) + 0.5 × variance of the turn rate (rad²/s²)
    """
    row = ride_figures(ride)
    reached = ride.outcome is Outcome.REACHED
    touched = ride.outcome in {Outcome.COLLISION, Outcome.FELL}
    speed = np.nan_to_num(row["collision_speed"]) / ride.robot.max_speed
    ideal = _ideal_time(ride)
    return {
        "collision": 10.0 * (1.0 + min(float(speed), 1.0)) if touched else 0.0,
        "failure": 0.0 if reached or touched else 5.0,
        "standing": 0.5 if row["standing_contacts"] else 0.0,
        "time": float(row["time"]) / ideal - 1.0 if reached else 0.0,
        "stalled": 0.5 * float(row["stalled_time"]) / ideal,
        "intimate": 2.0 * float(row["proxemics_intimate"]),
        "smoothness": 0.05 * float(row["jerk_rms"]) + 0.5 * float(row["angular_velocity_variance"]),
    }


def _ideal_time(ride: Ride) -> float:
    """Time for the route at full speed, s; equal for every planner and draw."""
    speed = min(ride.robot.max_speed, ride.scenario.profile.preferred_speed)
    straight = float(np.hypot(*(ride.goal - ride.pose[0, :2])))
    return max(straight, ride.path.length if ride.path is not None else 0.0) / speed


def survivors(costs: Mapping[int, Sequence[float]], rung: int, count: int) -> list[int]:
    """Draws that continue in a rung, best first; ``costs`` are those of each draw's rides so far.

    Draw 0 is always among them: the default has to be beaten on all rides, not on the first two.

    Args:
        costs: draw → costs of the rides of the rung before.
        rung: index in ``RUNGS``.
        count: number of all draws.
    """
    left = math.ceil(count / RUNGS[rung][0])
    ranked = sorted(costs, key=lambda draw: (float(np.mean(costs[draw])), draw))
    return ranked[:left] if 0 in ranked[:left] or 0 not in costs else [*ranked[: left - 1], 0]


def check_known(spaces: Mapping[str, Any], planners: Sequence[str]) -> None:
    """Check that all planners have a space.

    Raises:
        ConfigError: naming those that have one.
    """
    for planner in planners:
        if planner not in spaces:
            raise ConfigError(
                f"no space is declared for {planner!r}; there is one for {', '.join(spaces)}"
            )
