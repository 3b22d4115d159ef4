"""All exceptions of cohelm, as one tree.

    CohelmError                 .code is a stable word, also in ROS and web messages
    ├─ ConfigError              an invalid file or option; dotted key
    │  └─ ScenarioError         an invalid scenario
    ├─ PluginError              an unknown plugin, or one that does not import
    ├─ MapError                 a map that cannot be read or written, or is inconsistent
    ├─ BuildingError            a building model that cannot be read
    ├─ RecordingError           a bag or a cloud that cannot be read
    ├─ PlatformError            a chair that does not answer, or is lost while driving
    ├─ StoreError               stored data that cannot be read or written
    ├─ PlanningError            no path
    │  ├─ StartBlocked, GoalBlocked, OutsideMap      carry the point and the needed clearance
    │  ├─ NoPath
    │  ├─ NoRoute              no rooms, doors and lifts of a building lead there
    │  ├─ InvalidProblem       an invalid number in the request
    │  ├─ TooManyWishes
    │  └─ PlanningTimeout
    └─ ControlError             no command
       ├─ SolverFailed
       └─ Infeasible

Expected problems in the control loop are values (``LocalPlan.status``), not exceptions.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar


class CohelmError(Exception):
    """Base of all exceptions of cohelm."""

    code: ClassVar[str] = "cohelm"


class ConfigError(CohelmError):
    """An invalid configuration.

    Args:
        problem: problem and remedy, in one line.
        file: the invalid file, if any.
        key: the invalid dotted key, as ``local_planner.horizon``.
    """

    code = "config"

    def __init__(self, problem: str, *, file: Path | str | None = None, key: str = "") -> None:
        self.problem = problem
        self.file = file
        self.key = key
        super().__init__(": ".join(str(part) for part in (file, key, problem) if part))


class ScenarioError(ConfigError):
    """An invalid scenario."""

    code = "scenario"


class PluginError(CohelmError):
    """An unknown plugin, or one that does not import."""

    code = "plugin"


class MapError(CohelmError):
    """A map that cannot be read or written, or is inconsistent; always names the file.

    Args:
        problem: problem and remedy, in one line.
        file: the map file.
    """

    code = "map"

    def __init__(self, problem: str, *, file: Path | str) -> None:
        self.problem = problem
        self.file = file
        super().__init__(f"{file}: {problem}")


class BuildingError(CohelmError):
    """A building model that cannot be read, or lacks what it needs; always names the file.

    Args:
        problem: problem and remedy, in one line.
        file: the model.
        entity: class and GlobalId of the entity that is wrong, if it is one.
    """

    code = "building"

    def __init__(self, problem: str, *, file: Path | str, entity: str = "") -> None:
        self.problem = problem
        self.file = file
        self.entity = entity
        super().__init__(": ".join(str(part) for part in (file, entity, problem) if part))


class RecordingError(CohelmError):
    """A recording that cannot be read, or only in part; always names the file.

    Args:
        problem: problem and remedy, in one line.
        file: the file.
        offset: position in it, bytes from its start; None if unknown.
    """

    code = "recording"

    def __init__(self, problem: str, *, file: Path | str, offset: int | None = None) -> None:
        self.problem = problem
        self.file = file
        self.offset = offset
        where = "" if offset is None else f" at byte {offset}"
        super().__init__(f"{file}{where}: {problem}")


class PlatformError(CohelmError):
    """A chair that cannot be reached, or that is lost while driving."""

    code = "platform"


class StoreError(CohelmError):
    """Stored data that cannot be read or written, or is missing.

    Args:
        problem: problem and remedy, in one line.
        file: the file or folder, if any.
    """

    code = "store"

    def __init__(self, problem: str, *, file: Path | str | None = None) -> None:
        self.problem = problem
        self.file = file
        super().__init__(f"{file}: {problem}" if file is not None else problem)


class PlanningError(CohelmError):
    """No path; the subclass gives the cause."""

    code = "planning"


class _BlockedPoint(PlanningError):
    """A point where the robot cannot stand.

    Args:
        point: (x, y) in the map frame, m.
        clearance: distance to the nearest obstacle there, m.
        needed: the clearance that the robot needs, m.
        because: the rule that closes it, if it is not an obstacle, as "a zone to avoid".
    """

    what: ClassVar[str]

    def __init__(
        self, *, point: tuple[float, float], clearance: float, needed: float, because: str = ""
    ) -> None:
        self.point = point
        self.clearance = clearance
        self.needed = needed
        self.because = because
        where = f"the {self.what} ({point[0]:.2f}, {point[1]:.2f})"
        if clearance > 0.0:
            beside = f" from {because}" if because else ""
            text = f"has {clearance:.2f} m of clearance{beside}, the robot needs {needed:.2f} m"
        else:
            inside = because or "a wall, an obstacle or unknown space"
            text = f"lies in {inside}, the robot needs {needed:.2f} m of clearance"
        super().__init__(f"{where} {text}")


class StartBlocked(_BlockedPoint):
    """The robot cannot stand at its start."""

    code = "start_blocked"
    what = "start"


class GoalBlocked(_BlockedPoint):
    """The robot cannot stand at the goal."""

    code = "goal_blocked"
    what = "goal"


class OutsideMap(PlanningError):
    """A point outside the map.

    Args:
        what: name of the point, as ``start``.
        point: (x, y) in the map frame, m.
        bounds: (x_min, y_min, x_max, y_max) of the map, m.
    """

    code = "outside_map"

    def __init__(
        self,
        *,
        what: str,
        point: tuple[float, float],
        bounds: tuple[float, float, float, float],
    ) -> None:
        self.point = point
        self.bounds = bounds
        x0, y0, x1, y1 = bounds
        super().__init__(
            f"the {what} ({point[0]:.2f}, {point[1]:.2f}) is outside the map, "
            f"which reaches from ({x0:.2f}, {y0:.2f}) to ({x1:.2f}, {y1:.2f})"
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Passage:
    """A passage too narrow for the robot."""

    point: tuple[float, float]
    """(x, y) of its middle in the map frame, m."""
    width: float
    """Between the obstacles on either side, m."""
    needed: float
    """The width that the robot needs there, m."""
    resolution: float
    """Side of the map's cells, m, which limits the accuracy of the width."""
    turns: bool = False
    """The robot would have to turn there; ``needed`` is then a sufficient width."""
    clearance: float = 0.0
    """Part of ``needed`` that is clearance on either side, m."""

    def __str__(self) -> str:
        """Return one clause with position, width and missing width."""
        x, y = self.point
        cells = f"the map's cells are {self.resolution:.2f} m, the width is known no better"
        wide = f"at ({x:.2f}, {y:.2f})"
        if self.turns and self.width >= self.needed:
            return (
                f"no path was found through the passage {wide}, although it is wide enough: "
                f"{self.width:.2f} m, and {self.needed:.2f} m would do"
            )
        if self.turns:
            return (
                f"the robot cannot turn in the passage {wide}, {self.width:.2f} m wide; "
                f"{self.needed:.2f} m would do ({cells})"
            )
        needs = f"the robot needs {self.needed:.2f} m"
        if self.clearance > 0.0:
            body = self.needed - 2.0 * self.clearance
            needs += f" ({body:.2f} m and {self.clearance:.2f} m on either side)"
        missing = self.needed - self.width
        lacks = f"{missing:.2f} m are missing" if missing >= 0.005 else "too close to tell"
        return f"the passage {wide} is {self.width:.2f} m wide, {needs}: {lacks} ({cells})"


class NoPath(PlanningError):
    """No path connects start and goal, which are both free.

    Args:
        start, goal: (x, y) in the map frame, m.
        needed: the clearance that the robot needs along the path, m.
        passage: the narrowest place on the path that would be best if it were wide enough; None if
            walls close every path.
        because: another cause, as "the zones to avoid".
    """

    code = "no_path"

    def __init__(
        self,
        *,
        start: tuple[float, float],
        goal: tuple[float, float],
        needed: float,
        passage: Passage | None = None,
        because: str = "",
    ) -> None:
        self.start = start
        self.goal = goal
        self.needed = needed
        self.passage = passage
        self.because = because
        text = (
            f"no route with {needed:.2f} m of clearance from ({start[0]:.2f}, {start[1]:.2f}) "
            f"to ({goal[0]:.2f}, {goal[1]:.2f})"
        )
        if because:
            text += f": closed by {because}"
        super().__init__(text if passage is None else f"{text}: {passage}")


class NoRoute(PlanningError):
    """No rooms, doors and lifts of a building lead from start to goal.

    Args:
        start, goal: names of the places.
        needed: the width that the robot needs, m.
        narrowest: the narrowest door or room on the route that would be left without it, with its
            clear width, as "the door D1 (Office – Ward 3), 0.70 m wide"; empty if nothing joins
            the places at any width.
        because: another cause, as a clause.
    """

    code = "no_route"

    def __init__(
        self, *, start: str, goal: str, needed: float, narrowest: str = "", because: str = ""
    ) -> None:
        self.start = start
        self.goal = goal
        self.needed = needed
        self.narrowest = narrowest
        self.because = because
        text = because or "no door or lift joins them"
        if narrowest:
            text = f"the robot needs {needed:.2f} m, too narrow is {narrowest}"
        super().__init__(f"no route from {start} to {goal}: {text}")


class InvalidProblem(PlanningError):
    """The request contains an invalid number."""

    code = "invalid_problem"


class TooManyWishes(PlanningError):
    """The wishes can be passed in more orders than can be searched.

    Args:
        layers: layers of the search, one for each set of passed points.
        most: maximum number of layers on this map.
    """

    code = "too_many_wishes"

    def __init__(self, *, layers: int, most: int) -> None:
        self.layers = layers
        self.most = most
        super().__init__(
            f"the wishes can be passed in too many orders ({layers} layers to search, at most "
            f"{most}): give points that follow each other as one wish, or fewer wishes"
        )


class PlanningTimeout(PlanningError):
    """The budget was exhausted before a path was found."""

    code = "planning_timeout"


class ControlError(CohelmError):
    """No command.

    Args:
        problem: description.
        evidence: the problem that could not be solved, for debugging.
    """

    code = "control"

    def __init__(self, problem: str, *, evidence: object = None) -> None:
        self.evidence = evidence
        super().__init__(problem)


class SolverFailed(ControlError):
    """The quadratic program has no usable solution."""

    code = "solver_failed"


class Infeasible(ControlError):
    """The hard limits contradict each other, or the problem contains an invalid number."""

    code = "infeasible"
