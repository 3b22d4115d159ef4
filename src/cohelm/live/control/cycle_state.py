"""State of the control cycle, and of what pages show: frozen values, replaced as a whole."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

from cohelm.health.map_changes import CELL
from cohelm.live.control.ipc import StepAnswer
from cohelm.live.control.mission import Mission
from cohelm.live.control.time_rate import TimeRate
from cohelm.live.control.watchdog import Watchdog
from cohelm.live.messages import EdgeCells, MapDifferences, NavigatorState, RouteUpdate
from cohelm.messages import Decision
from cohelm.reasons import Reason
from cohelm.safety import stop


@dataclass(frozen=True, slots=True, kw_only=True)
class PageView:
    """Parts of the navigator's last answer; pages show them until a newer answer comes."""

    navigator: NavigatorState = field(default_factory=lambda: NavigatorState(rider_authority=0.0))
    route: RouteUpdate = field(default_factory=lambda: RouteUpdate(version=0))
    """Its version grows with every change of route, error or wishes."""
    differences: MapDifferences = field(default_factory=lambda: MapDifferences(cell=CELL, found=()))
    edges: EdgeCells = field(default_factory=lambda: EdgeCells(runs=()))

    def updated(self, answer: StepAnswer, navigator: NavigatorState, mission: Mission) -> PageView:
        """Return the view of a new answer.

        Args:
            answer: Answer of the navigator.
            navigator: Its ``state``.
            mission: Current mission; an answer to an older one does not change the wishes.
        """
        version = self.route.version
        wishes = mission.wishes if answer.mission_version == mission.version else self.route.wishes
        route = answer.route or self.route
        route = route.model_copy(update={"version": version, "wishes": wishes})
        if route != self.route:
            route = route.model_copy(update={"version": version + 1})
        differences = answer.differences or self.differences
        edges = answer.edges or self.edges
        return PageView(navigator=navigator, route=route, differences=differences, edges=edges)


@dataclass(frozen=True, slots=True, kw_only=True)
class CycleState:
    """State of the control cycle between two steps."""

    ticks: int = 0
    """Number of steps so far, and the id of the current one."""
    starting: bool = True
    """True until the navigator has made a decision in this world."""
    paused: bool = False
    """True while the simulation is paused."""
    awaits_world: bool = False
    """True while another world is built; until then the chair stands."""
    first_step_id: int = 0
    """First step in this world; answers to older ones are not used."""
    loading_routes: int = -1
    """Step whose request makes the navigator load the code of routes; −1: none is unanswered."""
    restart: bool = False
    """True if the next request restarts the navigator."""
    requested_time: float = -math.inf
    """``LiveWorld.time`` of the last observation sent, s."""
    requested_epoch: int = 0
    """``LinkState.epoch`` at the last request."""
    answered_mission: int = -1
    """``Mission.version`` of the last answer; −1: none yet."""
    unstored_rows: str = ""
    """Reason why the navigator's process stores no rows; empty if it does."""
    watchdog: Watchdog = field(default_factory=Watchdog)
    time_rate: TimeRate = field(default_factory=TimeRate)
    view: PageView = field(default_factory=PageView)
    command: Decision = field(default_factory=lambda: stop(Reason.STARTING))
    """Decision at the wheels."""
    heartbeat_seq: int = -1
    """``Heartbeat.seq`` that the command is based on; −1: none."""
    commanded_at: float = -math.inf
    """Time of the last command for the wheels, s."""
    arrived: bool = False
    """True from an arrival to the next motion."""
    touching: bool = False
    """True while the chair is in contact with something."""
    stops: int = 0
    """Number of stops by the watchdog."""

    def entered(self, *, simulated: bool) -> CycleState:
        """Return the state in another world, where the chair stands and nothing is decided."""
        return replace(
            self,
            paused=False,
            awaits_world=False,
            first_step_id=self.ticks,
            restart=True,
            requested_time=-math.inf,
            watchdog=Watchdog(),
            time_rate=self.time_rate.resumed() if simulated else TimeRate(),
            view=PageView(route=RouteUpdate(version=self.view.route.version + 1)),
            command=stop(Reason.STARTING),
            arrived=False,
            touching=False,
        )
