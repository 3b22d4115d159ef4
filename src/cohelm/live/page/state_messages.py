"""Messages about the chair for pages: the state of each step, and the route when it changes."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from cohelm.arrays import Floats
from cohelm.live.control import link
from cohelm.live.control.ipc import Points, RouteView, StepAnswer
from cohelm.live.control.mission import Mission
from cohelm.live.control.world_factory import LiveWorld
from cohelm.live.messages import ActiveWish, ChairState, PersonInfo, ReasonText, RouteUpdate
from cohelm.live.page.commands import Commands
from cohelm.messages import Decision
from cohelm.reasons import Reason
from cohelm.simulation import GroundTruth


@dataclass(frozen=True, slots=True, kw_only=True)
class PageView:
    """Values of the navigator's last answer; pages show them until a newer answer comes."""

    rider_authority: float = 0.0
    remaining: float | None = None
    plan: tuple[tuple[float, float, float], ...] = ()
    people: tuple[PersonInfo, ...] = ()
    groups: tuple[Points, ...] = ()
    route: RouteView | None = None
    route_error: str = ""
    wishes: tuple[ActiveWish, ...] = ()
    route_version: int = 0

    def updated(self, answer: StepAnswer, mission: Mission) -> PageView:
        """Return the view of a new answer; the route's version grows with every change of it."""
        route = answer.route if answer.route is not None else self.route
        wishes = mission.wishes if answer.mission == mission.version else self.wishes
        same = (route, answer.route_error, wishes) == (self.route, self.route_error, self.wishes)
        return replace(
            self,
            rider_authority=answer.rider_authority,
            remaining=answer.remaining,
            plan=answer.plan,
            people=tuple(_person(row) for row in answer.people),
            groups=answer.groups,
            route=route,
            route_error=answer.route_error,
            wishes=wishes,
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
        )


def state_message(
    world: LiveWorld | None,
    commands: Commands,
    view: PageView,
    order: Decision,
    *,
    starting_text: str,
    now: float,
    **fields: Any,
) -> ChairState:
    """Return the state of the chair.

    Args:
        world: Simulated world; None: not built yet.
        commands: Link and mission.
        view: Values of the navigator's last answer.
        order: Decision at the wheels.
        starting_text: Additional text while the chair starts.
        now: s of the control loop's clock.
        fields: Further fields of the message.
    """
    driver_link, mission = commands.link, commands.mission
    status = link.status(driver_link, now)
    if world is not None:
        simulation = world.simulation
        observation, truth = simulation.observe(), simulation.truth
        twist = observation.twist
        fields |= {
            "time": round(truth.time, 3),
            "pose": rounded(observation.pose),
            "speed": round(float(twist[0]), 3),
            "turn_rate": round(float(twist[2]), 3),
            "true_people": true_people(truth),
            "closed_doors": tuple(sorted(simulation.shut)),
        }
    else:
        fields |= {"time": 0.0, "pose": (0.0, 0.0, 0.0), "speed": 0.0, "turn_rate": 0.0}
    return ChairState.model_construct(
        command=(round(float(order.twist[0]), 4), round(float(order.twist[2]), 4)),
        driver=driver_link.driver,
        device=link.current_heartbeat(driver_link, now)[1],
        link=status,
        mode=mission.mode,
        pace=mission.pace,
        rider_authority=view.rider_authority,
        reason=reason_text(order, starting_text, link.required_reason(status)),
        goal=mission.goal,
        remaining=view.remaining if mission.goal is not None else None,
        route_version=view.route_version,
        plan=view.plan,
        people=view.people,
        groups=view.groups,
        **fields,
    )


def reason_text(
    decision: Decision, starting_text: str, required: Reason | None
) -> ReasonText | None:
    """Return the reason of a decision for the rider; None where nothing holds the chair.

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


def _person(row: tuple[float, ...]) -> PersonInfo:
    id_, x, y, vx, vy, radius, axis, front, side, rear, group = row
    return PersonInfo.model_construct(
        id=int(id_), x=x, y=y, vx=vx, vy=vy, radius=radius,
        axis=axis, front=front, side=side, rear=rear, group=int(group),
    )  # fmt: skip
