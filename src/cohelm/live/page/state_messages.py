"""Messages about the chair for pages: the state of each step, and the route when it changes."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from cohelm.arrays import Floats
from cohelm.health.map_changes import CELL
from cohelm.live.control import driver_link
from cohelm.live.control.driver_state import DriverState
from cohelm.live.control.ipc import OfferRow, PersonRow, Points, Poses, RouteView, StepAnswer
from cohelm.live.control.mission import Mission
from cohelm.live.control.world_factory import LiveWorld
from cohelm.live.messages import (
    ActiveWish,
    ChairState,
    MapDifference,
    MapDifferences,
    Notice,
    OfferInfo,
    PersonInfo,
    ReasonText,
    RouteUpdate,
)
from cohelm.messages import Decision
from cohelm.reasons import Reason
from cohelm.simulation import GroundTruth

SLOW_NOTICE = Notice(
    code="slow", text="This computer is too slow for real time; the simulation runs slower."
)
"""Notice of overload."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PageView:
    """Values of the navigator's last answer; pages show them until a newer answer comes."""

    rider_authority: float = 0.0
    """See ``StepAnswer``, as the next ones."""
    remaining: float | None = None
    plan: Poses = ()
    people: tuple[PersonInfo, ...] = ()
    groups: tuple[Points, ...] = ()
    offers: tuple[OfferInfo, ...] = ()
    free: tuple[float, ...] = ()
    route: RouteView | None = None
    """None: no answer yet."""
    route_error: str = ""
    wishes: tuple[ActiveWish, ...] = ()
    """Wishes that the route takes into account."""
    differences: tuple[MapDifference, ...] = ()
    """Places where the building differs from the map."""
    route_version: int = 0
    """Grows with every change of route, route error or wishes."""

    def updated(self, answer: StepAnswer, mission: Mission) -> PageView:
        """Return the view of a new answer.

        Args:
            answer: Answer of the navigator.
            mission: Current mission; an answer to an older one does not change the wishes.
        """
        route = answer.route if answer.route is not None else self.route
        wishes = mission.wishes if answer.mission_version == mission.version else self.wishes
        differs = answer.differences
        same = (route, answer.route_error, wishes) == (self.route, self.route_error, self.wishes)
        return replace(
            self,
            rider_authority=answer.rider_authority,
            remaining=answer.remaining,
            plan=answer.plan,
            people=tuple(_person(row) for row in answer.people),
            groups=answer.groups,
            offers=tuple(_offer(row) for row in answer.offers),
            free=answer.free,
            route=route,
            route_error=answer.route_error,
            wishes=wishes,
            differences=self.differences if differs is None else differs,
            route_version=self.route_version if same else self.route_version + 1,
        )

    def route_update(self) -> RouteUpdate:
        """Return the message about the route."""
        route = self.route or RouteView(points=(), without_wishes=(), length=0.0, extra_length=0.0)
        return RouteUpdate(
            version=self.route_version,
            points=route.points,
            without_wishes=route.without_wishes,
            length=route.length,
            extra_length=route.extra_length,
            wishes=self.wishes,
            error=self.route_error,
            cause=route.cause,
        )

    def map_differences(self) -> MapDifferences:
        """Return the message about the differences from the map."""
        return MapDifferences(cell=CELL, found=self.differences)


class Sent:
    """Route and differences that pages have already."""

    def __init__(self) -> None:
        self._route = -1
        self._differences: tuple[MapDifference, ...] = ()

    def changes(self, view: PageView) -> list[RouteUpdate | MapDifferences]:
        """Return the messages about what has changed since the last call."""
        messages: list[RouteUpdate | MapDifferences] = []
        if view.route_version != self._route:
            messages.append(view.route_update())
        if view.differences is not self._differences:
            messages.append(view.map_differences())
        self._route, self._differences = view.route_version, view.differences
        return messages


@dataclass(frozen=True, slots=True, kw_only=True)
class StepStatus:
    """Values of one control step for the state message; names as in ``ChairState``."""

    seq: int
    """``ControlCycle.ticks``."""
    command: Decision
    """Decision at the wheels."""
    heartbeat_seq: int
    """``Heartbeat.seq`` that the command is based on; −1: none."""
    now: float
    """Time by the control loop's clock, just before the command was selected, s."""
    late: float
    """Delay of the step's start, s."""
    arrived: bool
    paused: bool
    ride: str
    starting_text: str
    """Additional text while the chair starts."""
    not_ready: Reason | None = None
    can_plan: bool = True
    rate: float = 1.0
    """See ``ChairState``, as the next one."""
    unstored: str = ""


def state_message(
    world: LiveWorld | None, driver: DriverState, view: PageView, step: StepStatus
) -> ChairState:
    """Return the state of the chair.

    Args:
        world: World of the ride; None: not built yet.
        driver: Link and mission.
        view: Values of the navigator's last answer.
        step: Values of the control step.
    """
    link, mission = driver.link, driver.mission
    status = driver_link.status(link, step.now)
    twist = step.command.twist
    return ChairState.model_construct(
        seq=step.seq,
        heartbeat=step.heartbeat_seq,
        lateness=round(1000.0 * step.late, 1),
        clock=round(step.now, 4),
        arrived=step.arrived,
        paused=step.paused,
        rate=round(step.rate, 2),
        unstored=step.unstored,
        ride=step.ride,
        command=(round(float(twist[0]), 4), round(float(twist[2]), 4)),
        driver=link.driver,
        device=driver_link.current_heartbeat(link, step.now).device,
        link=status,
        mode=mission.mode,
        pace=mission.pace,
        rider_authority=view.rider_authority,
        reason=reason_text(step.command, step.starting_text, driver_link.required_reason(status)),
        not_ready=None if step.not_ready is None else _text_of(step.not_ready),
        can_plan=step.can_plan,
        goal=mission.goal,
        remaining=view.remaining if mission.goal is not None else None,
        route_version=view.route_version,
        plan=view.plan,
        people=view.people,
        groups=view.groups,
        offers=view.offers if mission.goal is None else (),
        free=view.free,
        **_world_fields(world),
    )


def reason_text(
    decision: Decision, starting_text: str, required: Reason | None
) -> ReasonText | None:
    """Return the reason of a decision for the rider; None if nothing holds the chair.

    Args:
        decision: Decision at the wheels.
        starting_text: Additional text while the chair starts.
        required: Action that the driver must take first; None: nothing.
    """
    reason = decision.reason
    if reason is None or reason is Reason.ARRIVED:
        return None
    text = reason.sentence
    if reason is Reason.STARTING:
        text = f"{text} {starting_text}".strip()
    elif required is not None and required is not reason:
        text = f"{text} {required.sentence}"
    return ReasonText.model_construct(code=reason.value, text=text)


def true_people(truth: GroundTruth) -> tuple[tuple[float, float, float], ...]:
    """Return the ground truth of all people, (x, y, radius), m."""
    crowd = truth.crowd
    rows = zip(crowd.position.tolist(), crowd.radius.tolist(), crowd.there.tolist(), strict=True)
    return tuple((round(x, 3), round(y, 3), radius) for (x, y), radius, there in rows if there)


def rounded(pose: Floats) -> tuple[float, float, float]:
    """Round a pose to a millimetre and a milliradian."""
    x, y, heading = pose.tolist()
    return round(x, 3), round(y, 3), round(heading, 3)


def _world_fields(world: LiveWorld | None) -> dict[str, Any]:
    """Return the fields of ``ChairState`` that come from the platform."""
    if world is None:
        return {"time": 0.0, "pose": (0.0, 0.0, 0.0), "speed": 0.0, "turn_rate": 0.0}
    observation, truth = world.observation, world.truth
    twist = observation.twist
    return {
        "time": round(observation.time if truth is None else truth.time, 3),
        "pose": rounded(observation.pose),
        "speed": round(float(twist[0]), 3),
        "turn_rate": round(float(twist[2]), 3),
        "true_people": true_people(truth) if truth is not None else (),
        "closed_doors": tuple(sorted(world.shut)),
    }


def _text_of(reason: Reason) -> ReasonText:
    return ReasonText.model_construct(code=reason.value, text=reason.sentence)


def _offer(row: OfferRow) -> OfferInfo:
    return OfferInfo.model_construct(**row._asdict())


def _person(row: PersonRow) -> PersonInfo:
    fields = row._asdict() | {
        "id": int(row.id),
        "group": int(row.group),
        "seen": bool(row.seen),
    }
    return PersonInfo.model_construct(**fields)
