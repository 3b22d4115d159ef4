"""Disturbed input of another rider: late, repeated, lost, noisy, trembling, biased, opposed."""

from __future__ import annotations

import math
from typing import Any, Self

import numpy as np
from pydantic import Field, model_validator

from cohelm.arrays import Annotated, Floats, Shape, replace, value
from cohelm.config import Model
from cohelm.messages import RiderCommand
from cohelm.simulation.api import RiderAct, RiderView
from cohelm.simulation.riders.rider_input import (
    IDEAL,
    BaseRider,
    RandomInterval,
    base_rider,
    deflected,
    next_interval,
    rotated,
    uniform,
)

_ROUNDING = 1e-9  # s; times are sums of float steps


class Disturbance(Model):
    """Rider whose input is disturbed."""

    base: BaseRider = Field(default_factory=lambda: dict(IDEAL))
    """Base rider."""


class IntervalDisturbance(Disturbance):
    """Base rider, and random intervals in which its input is disturbed."""

    mean_gap: float = Field(gt=0.0, le=600.0)
    """Mean time between two intervals, s."""
    duration: tuple[float, float]
    """Range of their durations, s."""

    @model_validator(mode="after")
    def _check_duration(self) -> Self:
        if not 0.0 < self.duration[0] <= self.duration[1] <= 60.0:
            raise ValueError("duration must be [shortest, longest] with 0 < both ≤ 60 s")
        return self


class Delayed:
    """Input with a constant delay; the stick is centred at first."""

    class Parameters(Disturbance):
        """Delay and base rider."""

        delay: float = Field(0.3, ge=0.0, le=3.0)
        """From perception to input, s (0.3, and 0.6 for slow riders: assumed)."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()
        self.base = base_rider(self.parameters.base)

    def act(self, view: RiderView, memory: Any | None, rng: np.random.Generator) -> RiderAct:
        """See :meth:`cohelm.simulation.api.Rider.act`; the heartbeat is not delayed."""
        last: _DelayMemory = memory or _DelayMemory(
            base=None, times=np.empty(0), inputs=np.empty((0, 2))
        )
        act = self.base.act(view, last.base, rng)
        if act.command is None:
            return act
        times = np.append(last.times, view.time)
        inputs = np.vstack([last.inputs, act.command.deflection])
        due = int(np.searchsorted(times, view.time - self.parameters.delay + _ROUNDING, "right"))
        deflection = inputs[due - 1] if due else np.zeros(2)
        kept = slice(max(due - 1, 0), None)
        queue = _DelayMemory(base=act.memory, times=times[kept], inputs=inputs[kept])
        return deflected(view, deflection, queue)


@value
class _DelayMemory:
    base: Any
    times: Annotated[Floats, Shape("k")]
    """Times of the inputs, s."""
    inputs: Annotated[Floats, Shape("k 2")]
    """The current input and those still to come."""


class Laggy:
    """Input that often repeats the last one; after the pilots of Reddy et al. (2018)."""

    class Parameters(Disturbance):
        """Probability and base rider."""

        repeat_probability: float = Field(0.8, ge=0.0, lt=1.0)
        """Probability that a command repeats the last one, for each of 20 a second (0.8 and 0.85 in
        programs after Reddy, Dragan and Levine, 2018)."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()
        self.base = base_rider(self.parameters.base)

    def act(self, view: RiderView, memory: Any | None, rng: np.random.Generator) -> RiderAct:
        """See :meth:`cohelm.simulation.api.Rider.act`."""
        last: _RepeatMemory | None = memory
        act = self.base.act(view, last.base if last else None, rng)
        repeats = rng.random() < self.parameters.repeat_probability
        if act.command is None:
            return act
        sent = last.sent if last is not None and repeats else act.command.deflection
        return deflected(view, sent, _RepeatMemory(base=act.memory, sent=sent))


@value
class _RepeatMemory:
    base: Any
    sent: Annotated[Floats, Shape("2")]


class Dropout:
    """A device that falls silent from time to time; its last message stays in effect."""

    class Parameters(IntervalDisturbance):
        """Frequency, duration and base rider; assumed."""

        mean_gap: float = Field(8.0, gt=0.0, le=600.0)
        duration: tuple[float, float] = (0.2, 2.0)

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()
        self.base = base_rider(self.parameters.base)

    def act(self, view: RiderView, memory: Any | None, rng: np.random.Generator) -> RiderAct:
        """See :meth:`cohelm.simulation.api.Rider.act`."""
        p = self.parameters
        last: _DropoutMemory | None = memory
        act = self.base.act(view, last.base if last else None, rng)
        interval = next_interval(
            view.time,
            last.interval if last else None,
            rng,
            mean_gap=p.mean_gap,
            duration=p.duration,
        )
        if act.command is None:
            return act
        received = act.command
        if last is not None and interval.contains(view.time):
            received = last.received
        kept = _DropoutMemory(base=act.memory, interval=interval, received=received)
        return RiderAct(command=received, memory=kept)


@value
class _DropoutMemory:
    base: Any
    interval: RandomInterval
    received: RiderCommand


class Noisy:
    """Input with one random axis from time to time; after the pilots of Reddy et al. (2018)."""

    class Parameters(Disturbance):
        """Probability and base rider."""

        noise_probability: float = Field(0.15, ge=0.0, le=1.0)
        """Probability that one axis of a command is random, for each of 20 a second (0.15 in
        programs after Reddy, Dragan and Levine, 2018)."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()
        self.base = base_rider(self.parameters.base)

    def act(self, view: RiderView, memory: Any | None, rng: np.random.Generator) -> RiderAct:
        """See :meth:`cohelm.simulation.api.Rider.act`; a released stick has no noise."""
        act = self.base.act(view, memory, rng)
        draw, axis, random_value = rng.random(), int(rng.integers(2)), rng.uniform(-1.0, 1.0)
        if act.command is None or not act.command.deflection.any():
            return act
        deflection = act.command.deflection.copy()
        if draw < self.parameters.noise_probability:
            deflection[axis] = random_value
        return deflected(view, deflection, act.memory)


class Tremor:
    """A sinusoid added to the input, along a line that is drawn once for a ride.

    The stick is read 20 times a second: a tremor above 10 Hz is aliased.
    """

    class Parameters(Disturbance):
        """Frequency, amplitude and base rider."""

        frequency: tuple[float, float] = (3.0, 12.0)
        """Range of the frequency, Hz: Parkinson's disease 3–8, essential tremor 4–12 (Luft et al.,
        Sensors 2019)."""
        amplitude: tuple[float, float] = (0.05, 0.4)
        """Range of the amplitude, share of full deflection (assumed)."""

        @model_validator(mode="after")
        def _check_ranges(self) -> Self:
            if not 0.0 < self.frequency[0] <= self.frequency[1] <= 20.0:
                raise ValueError("frequency must be [lowest, highest] with 0 < both ≤ 20 Hz")
            if not 0.0 <= self.amplitude[0] <= self.amplitude[1] <= 1.0:
                raise ValueError("amplitude must be [lowest, highest] with 0 ≤ both ≤ 1")
            return self

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()
        self.base = base_rider(self.parameters.base)

    def act(self, view: RiderView, memory: Any | None, rng: np.random.Generator) -> RiderAct:
        """See :meth:`cohelm.simulation.api.Rider.act`; a released stick does not tremble."""
        tremor: _TremorMemory = memory or self._draw(rng)
        act = self.base.act(view, tremor.base, rng)
        if act.command is None:
            return act
        deflection = act.command.deflection
        if deflection.any():
            offset = tremor.amplitude * math.sin(
                2.0 * math.pi * tremor.frequency * view.time + tremor.phase
            )
            axis = np.array([math.cos(tremor.direction), math.sin(tremor.direction)])
            deflection = deflection + offset * axis
        return deflected(view, deflection, replace(tremor, base=act.memory))

    def _draw(self, rng: np.random.Generator) -> _TremorMemory:
        p = self.parameters
        return _TremorMemory(
            base=None,
            frequency=uniform(p.frequency, rng),
            amplitude=uniform(p.amplitude, rng),
            phase=uniform((-math.pi, math.pi), rng),
            direction=uniform((0.0, math.pi), rng),
        )


@value
class _TremorMemory:
    base: Any
    frequency: float
    amplitude: float
    phase: float
    direction: float
    """Direction of the oscillation, from forward to the left, rad."""


class Biased:
    """A rider with a wrong sense of the heading, who therefore steers to one side."""

    class Parameters(Disturbance):
        """Offset and base rider."""

        offset: float = Field(0.26, ge=-1.0, le=1.0)
        """Angle to the left of the desired direction, rad (15°, assumed)."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()
        self.base = base_rider(self.parameters.base)

    def act(self, view: RiderView, memory: Any | None, rng: np.random.Generator) -> RiderAct:
        """See :meth:`cohelm.simulation.api.Rider.act`; obstacles and people are seen correctly."""
        offset = np.array([0.0, 0.0, self.parameters.offset])
        return self.base.act(replace(view, pose=view.pose - offset), memory, rng)


class Uncooperative:
    """A rider who from time to time steers to one side of the desired direction.

    For a rider with another destination, set the scenario's ``rider_goal``.
    """

    class Parameters(IntervalDisturbance):
        """Frequency, duration, angle and base rider; assumed."""

        mean_gap: float = Field(6.0, gt=0.0, le=600.0)
        duration: tuple[float, float] = (1.0, 3.0)
        angle: float = Field(1.2, ge=0.0, le=3.15)
        """Angle between the input and the correct one, rad."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()
        self.base = base_rider(self.parameters.base)

    def act(self, view: RiderView, memory: Any | None, rng: np.random.Generator) -> RiderAct:
        """See :meth:`cohelm.simulation.api.Rider.act`."""
        p = self.parameters
        last: _OppositionMemory | None = memory
        act = self.base.act(view, last.base if last else None, rng)
        interval = next_interval(
            view.time,
            last.interval if last else None,
            rng,
            mean_gap=p.mean_gap,
            duration=p.duration,
        )
        if act.command is None:
            return act
        deflection = act.command.deflection
        if interval.contains(view.time):
            deflection = rotated(deflection, interval.side * p.angle)
        return deflected(view, deflection, _OppositionMemory(base=act.memory, interval=interval))


@value
class _OppositionMemory:
    base: Any
    interval: RandomInterval
