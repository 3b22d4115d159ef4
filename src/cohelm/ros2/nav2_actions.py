"""Nav2's actions FollowPath and ComputePathToPose, so that behaviour trees call cohelm.

    FollowPath           destination at the path's end, and the path as a drawn line to follow
    ComputePathToPose    a route of the scenario's global planner; nothing moves

A path gives a destination under the rule of RViz goals: it is accepted while no page drives, and
the chair moves while the rider holds the dead-man button.

Goals become jobs, one at a time, and a new goal ends the old one. Services of ROS 2 do not cross
the border between DDS vendors (rmw_cyclonedds#184), and an action is three services. So actions
need ``rclpy``, with the middleware that its clients use.
"""

from __future__ import annotations

import itertools
import logging
import math
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np

from cohelm.arrays import Floats
from cohelm.errors import CohelmError
from cohelm.geometry import resample
from cohelm.live import Drive
from cohelm.live.messages import (
    ChairState,
    Notice,
    Rejected,
    RouteUpdate,
    RouteWish,
    SetGoal,
    ToPage,
)
from cohelm.navigation import NavigatorSetup
from cohelm.planning import RouteProblem
from cohelm.recordings.rides import ros_messages as ros
from cohelm.recordings.transforms import name
from cohelm.ros2.parameters import Ros2Parameters
from cohelm.ros2.rclpy_node import RclpyNode, rclpy_class, to_rclpy
from cohelm.scenarios import Scenario, build_scenario

PERIOD = 0.1
"""Time between two feedback messages, s."""
_THREADS = 4
"""Two actions with their cancel and result services at the same time."""
_log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class ActionOutcome:
    """End of a job."""

    succeeded: bool
    result: dict[str, Any] = field(default_factory=dict)
    """Fields of the action's result; those that this version of the type lacks are left out."""


class ActionJob(Protocol):
    """Work for one goal."""

    def step(self) -> ActionOutcome | None:
        """Return the end of the work; None: it goes on."""
        ...

    def feedback(self) -> dict[str, Any]:
        """Return fields of the feedback; empty: there is none."""
        ...

    def cancel(self) -> None:
        """Give up: the client cancelled, or has another goal."""
        ...


class ActionServers:
    """Node with action servers.

    Args:
        name: Name of the node.
        domain: ROS domain; None: that of the environment.

    Raises:
        PlatformError: There is no ROS installation.
    """

    def __init__(self, name: str, domain: int | None = None) -> None:
        self._node = RclpyNode(name, domain, threads=_THREADS)
        self._ends = threading.Event()

    def add(self, action: Any, name: str, begin: Callable[[Any], ActionJob]) -> None:
        """Serve an action.

        Args:
            action: Class of the action, as ``nav2_msgs.action.FollowPath``.
            name: Its name, as ``follow_path``.
            begin: Starts the work for a goal.
        """
        server = _Server(action, begin, self._ends)
        self._node.serve_action(action, name, server.execute)

    def start(self) -> None:
        """Start to serve."""
        self._node.start()

    def close(self) -> None:
        """End all goals and the node; may be called twice."""
        self._ends.set()
        self._node.close()


class _Server:
    def __init__(
        self, action: Any, begin: Callable[[Any], ActionJob], ends: threading.Event
    ) -> None:
        self._action, self._begin, self._ends = action, begin, ends
        self._newest: Any = None

    def execute(self, handle: Any) -> Any:
        """Work on a goal until its end; runs in a thread of the executor."""
        self._newest = handle
        try:
            outcome = self._run(handle, self._begin(handle.request))
        except Exception:  # the client must get an answer
            _log.exception("an action has failed")
            outcome = ActionOutcome(False)
        if outcome is None:
            handle.canceled()
        elif outcome.succeeded:
            handle.succeed()
        else:
            handle.abort()
        return _filled(self._action.Result(), outcome.result if outcome is not None else {})

    def _run(self, handle: Any, job: ActionJob) -> ActionOutcome | None:
        """Return the end of the job; None: the client has cancelled it."""
        while not self._ends.is_set() and handle is self._newest:
            if handle.is_cancel_requested:
                job.cancel()
                return None
            outcome = job.step()
            if outcome is not None:
                return outcome
            told = job.feedback()
            if told:
                handle.publish_feedback(_filled(self._action.Feedback(), told))
            time.sleep(PERIOD)
        if handle is self._newest:
            job.cancel()
        return ActionOutcome(False)


def _filled(message: Any, fields: dict[str, Any]) -> Any:
    for key, each in fields.items():
        if hasattr(message, key):
            setattr(message, key, each)
    return message


NO_ROUTE_LIMIT = 5.0
"""Time without a route from which a path counts as impassable, s; people move on sooner."""
MAX_POINTS = 200
"""Maximum number of points of a drawn line."""
_SPACING = 0.25
"""m."""


class DriveClient:
    """Page without a screen: sends commands to the drive, and keeps what it answers.

    Args:
        drive: Live ride.
        client: Name of the page; connected by its owner.
    """

    def __init__(self, drive: Drive, client: str) -> None:
        self._drive, self._client = drive, client
        self._numbers = itertools.count(1)
        self._lock = threading.Lock()
        self.state: ChairState | None = None
        self.route_error = ""
        """Reason why there is no route; empty if there is one."""
        self.arrivals = 0
        self._rejected: dict[int, str] = {}
        drive.listen(self._take)

    def send(self, make: Callable[[int], SetGoal]) -> int:
        """Send the request that ``make`` makes of its number, and return the number."""
        number = next(self._numbers)
        self._drive.receive(self._client, make(number))
        return number

    def rejection(self, number: int) -> str:
        """Return the reason why this request was rejected; empty: it was not."""
        with self._lock:
            return self._rejected.get(number, "")

    def _take(self, message: ToPage, client: str | None) -> None:
        if isinstance(message, ChairState):
            self.state = message
        elif isinstance(message, RouteUpdate):
            self.route_error = message.error
        elif isinstance(message, Notice) and message.code == "arrived":
            self.arrivals += 1
        elif isinstance(message, Rejected) and client == self._client:
            with self._lock:
                self._rejected[message.id] = message.text


class FollowPath:
    """Work for one FollowPath goal.

    Args:
        goal: Goal of the action.
        client: Page that gives the destination.
        frame: Frame of the map.
        codes: Class of the result, with its error codes.
    """

    def __init__(self, goal: Any, client: DriveClient, frame: str, codes: Any) -> None:
        self._client, self._codes = client, codes
        self._arrivals, self._no_route_since = client.arrivals, math.nan
        self._number = 0
        self._error = self._begin(goal, frame)
        self._began = time.monotonic()
        self._seen = False  # the destination has been in a state message

    def step(self) -> ActionOutcome | None:
        """Return the end: arrived, rejected, no route, or another destination."""
        client, now = self._client, time.monotonic()
        state = client.state  # before the arrivals: an arrival ends the trip, in this order
        if self._error:
            return self._failed(*self._error)
        rejected = client.rejection(self._number)
        if rejected:
            return self._failed("NO_VALID_CONTROL", rejected)
        if client.arrivals > self._arrivals:
            return ActionOutcome(True, {"error_code": 0})
        ours = state is not None and state.goal is not None and self._is_end(state)
        if self._seen and not ours:
            return self._failed("UNKNOWN", "the rider has another destination, or none")
        self._seen |= ours
        if not client.route_error:
            self._no_route_since = math.nan
        elif math.isnan(self._no_route_since):
            self._no_route_since = now
        elif now - self._no_route_since > NO_ROUTE_LIMIT:
            return self._failed("INVALID_PATH", client.route_error)
        return None

    def feedback(self) -> dict[str, Any]:
        """Return the distance along the route, m, and the speed, m/s."""
        state = self._client.state
        if state is None or state.remaining is None:
            return {}
        return {"distance_to_goal": float(state.remaining), "speed": float(state.speed)}

    def cancel(self) -> None:
        """Cancel the trip."""
        self._client.send(lambda id_: SetGoal(id=id_))

    def _begin(self, goal: Any, frame: str) -> tuple[str, str] | None:
        """Send destination and line; returns (code, text) of what is wrong with the goal."""
        given = name(goal.path.header.frame_id)
        if given != frame:
            return "TF_ERROR", f"a path in frame {given!r}: paths are in {frame!r}"
        positions = [(each.pose.position.x, each.pose.position.y) for each in goal.path.poses]
        points = np.array(positions, dtype=float).reshape(-1, 2)
        if not len(points) or not np.isfinite(points).all():
            return "INVALID_PATH", "a path without points, or with one that is not a number"
        self._end = points[-1]
        end = float(points[-1, 0]), float(points[-1, 1])
        line = thinned(points)
        wishes = (RouteWish(kind="stroke", points=_pairs(line)),) if len(line) > 1 else ()
        self._number = self._client.send(lambda id_: SetGoal(id=id_, point=end, wishes=wishes))
        return None

    def _is_end(self, state: ChairState) -> bool:
        goal = state.goal
        return goal is not None and math.dist((goal.x, goal.y), self._end) < 0.1

    def _failed(self, code: str, text: str) -> ActionOutcome:
        number = int(getattr(self._codes, code, getattr(self._codes, "UNKNOWN", 1)))
        return ActionOutcome(False, {"error_code": number, "error_msg": text})


class ComputePath:
    """Work for one ComputePathToPose goal.

    Args:
        goal: Goal of the action.
        plan: Plans from (2,) to (2,), m; returns the points (k, 2).
        here: Position (2,) of the chair; None: not known yet.
        frame: Frame of the map.
        result: Class of the result, with its error codes.
        as_path: Converts a Path of ``rosbags`` to one of ``rclpy``.
    """

    def __init__(
        self,
        goal: Any,
        plan: Callable[[Floats, Floats], Floats],
        here: Floats | None,
        frame: str,
        result: Any,
        as_path: Callable[[Any], Any],
    ) -> None:
        self._goal, self._plan, self._here, self._frame = goal, plan, here, frame
        self._codes, self._as_path = result, as_path

    def step(self) -> ActionOutcome:
        """Plan, and return the path or the reason why there is none."""
        goal, frame = self._goal, self._frame
        poses = [goal.goal, *([goal.start] if goal.use_start else [])]
        wrong = [each for each in map(_frame_of, poses) if each != frame]
        start = _position(goal.start) if goal.use_start else self._here
        if wrong or start is None:
            text = f"a pose in frame {wrong[0]!r}: poses are in {frame!r}" if wrong else "no pose"
            return self._failed("TF_ERROR", text)
        end = _position(goal.goal)
        if not np.isfinite([start, end]).all():
            return self._failed("UNKNOWN", "a pose that is not a number")
        began = time.thread_time()
        try:
            points = self._plan(start, end)
        except CohelmError as error:
            return self._failed(_CODES.get(error.code, "NO_VALID_PATH"), str(error))
        path = ros.path(time.time(), frame, with_headings(points))
        spent = ros.duration(time.thread_time() - began)
        fields = {"path": self._as_path(path), "planning_time": self._as_path(spent)}
        return ActionOutcome(True, {**fields, "error_code": 0})

    def feedback(self) -> dict[str, Any]:
        """Return nothing: planning takes one step."""
        return {}

    def cancel(self) -> None:
        """Do nothing: planning takes one step."""

    def _failed(self, code: str, text: str) -> ActionOutcome:
        number = int(getattr(self._codes, code, getattr(self._codes, "UNKNOWN", 1)))
        return ActionOutcome(False, {"error_code": number, "error_msg": text})


_CODES = {
    "start_blocked": "START_OCCUPIED",
    "goal_blocked": "GOAL_OCCUPIED",
    "outside_map": "GOAL_OUTSIDE_MAP",
    "planning_timeout": "TIMEOUT",
}
"""Nav2's error code of each planning error; of others NO_VALID_PATH."""


def planner_of(scenario: Scenario) -> Callable[[Floats, Floats], Floats]:
    """Return a function that plans on a scenario's floor from (2,) to (2,), m, without wishes.

    Floor and planner are built with the first call.
    """
    lock = threading.Lock()
    built: list[NavigatorSetup] = []

    def plan(start: Floats, goal: Floats) -> Floats:
        with lock:
            if not built:
                built.append(build_scenario(scenario, scenario.seed).navigator)
            setup = built[0]
            problem = RouteProblem(
                grid=setup.grid,
                robot=setup.robot,
                start=start,
                goal=goal,
                filters=setup.filters,
                crowding=setup.heat,
                clearance=scenario.profile.clearance,
            )
            return setup.global_planner.plan(problem).points

    return plan


def thinned(points: Floats) -> Floats:
    """Return a line (k, 2) with about 0.25 m between its points, and at most 200."""
    length = float(np.hypot(*np.diff(points, axis=0).T).sum()) if len(points) > 1 else 0.0
    if length < _SPACING:
        return points[-1:]
    return resample(points, max(_SPACING, length / (MAX_POINTS - 2)))


def with_headings(points: Floats) -> Floats:
    """Return the poses (k, 3) along a line (k, 2); the last one has the heading before it."""
    steps = np.diff(points, axis=0)
    if not len(steps):
        return np.column_stack([points, np.zeros(len(points))])
    headings = np.arctan2(steps[:, 1], steps[:, 0])
    return np.column_stack([points, np.append(headings, headings[-1])])


def _pairs(points: Floats) -> tuple[tuple[float, float], ...]:
    return tuple((float(x), float(y)) for x, y in points)


def _frame_of(pose: Any) -> str:
    return name(pose.header.frame_id)


def _position(pose: Any) -> Floats:
    return np.array([pose.pose.position.x, pose.pose.position.y], dtype=float)


def serve_nav2(
    parameters: Ros2Parameters, drive: Drive, client: str, scenario: Scenario
) -> ActionServers:
    """Serve both actions; returns what ends them.

    Args:
        parameters: Frames and network.
        drive: Started ride.
        client: Connected page that gives destinations.
        scenario: Floor and global planner.

    Raises:
        PlatformError: There is no ROS installation, or no package nav2_msgs.
    """
    follow, compute = (
        rclpy_class(f"nav2_msgs/action/{name}") for name in ("FollowPath", "ComputePathToPose")
    )
    frame = parameters.frames.map or parameters.frames.odom
    page, plan = DriveClient(drive, client), planner_of(scenario)

    def here() -> Floats | None:
        return None if page.state is None else np.array(page.state.pose[:2])

    servers = ActionServers(f"{parameters.name}_actions", parameters.dds.domain)
    servers.add(follow, "/follow_path", lambda goal: FollowPath(goal, page, frame, follow.Result))
    servers.add(
        compute,
        "/compute_path_to_pose",
        lambda goal: ComputePath(goal, plan, here(), frame, compute.Result, to_rclpy),
    )
    servers.start()
    return servers
