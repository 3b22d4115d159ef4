"""Why the chair does not do what was wanted of it: codes for programs, sentences for riders."""

from __future__ import annotations

from enum import StrEnum


class Reason(StrEnum):
    """Why the wheels do not do what the planner wanted, or why the chair stands: stable codes."""

    sentence: str
    """The same for the rider."""

    def __new__(cls, code: str, sentence: str) -> Reason:
        """A code with its sentence."""
        reason = str.__new__(cls, code)
        reason._value_ = code
        reason.sentence = sentence
        return reason

    NOT_FINITE = "not_finite", "A sensor sent something that is not a number, so I stopped."
    CLOCK = "clock", "The clock ran backwards, so I stopped."
    STALE_SCAN = "stale_scan", "I cannot see: a sensor is silent, so I stopped."
    STALE_POSE = "stale_pose", "I do not know where we are: no position arrives, so I stopped."
    STALE_TWIST = (
        "stale_twist",
        "I cannot tell our speed: odometry is silent or wrong, so I stopped.",
    )
    POSE_JUMP = "pose_jump", "Our position jumped, so I stopped to be sure of it."
    RIDER_SILENT = "rider_silent", "Your joystick is not connected, so I stopped."
    RIDER_STOP = "rider_stop", "Somebody asked me to stop."
    LATE = "late", "I was too slow to think, so I stopped."
    OVER_LIMITS = "over_limits", "That was more than the chair allows, so I did less."
    TOO_CLOSE = "too_close", "Something is too close ahead, so I slowed down."
    BLOCKED = "blocked", "Something stands in the way, so I stopped."
    KEEPOUT = "keepout", "We are not to go in there, so I stopped."
    NO_SAFE_PLAN = "no_safe_plan", "I found no safe way to move, so I am braking."
    SOLVER_FAILED = "solver_failed", "I could not work out how to move, so I am braking."
    START_BLOCKED = "start_blocked", "We stand too close to something to plan a way."
    GOAL_BLOCKED = (
        "goal_blocked",
        "The goal is too close to something for the chair to stand there.",
    )
    OUTSIDE_MAP = "outside_map", "That place is outside the map."
    NO_PATH = "no_path", "I know no way to get there that is wide enough."
    TOO_MANY_WISHES = (
        "too_many_wishes",
        "Those are too many wishes at once for me to plan a way.",
    )
    INVALID_PROBLEM = "invalid_problem", "I could not make sense of what was asked of me."
    PLANNING_TIMEOUT = "planning_timeout", "I did not find a way in the time that I had."
    PLANNING = "planning", "I could not plan a way."
    ARRIVED = "arrived", "We have arrived."
    WAITING = "waiting", "I cannot go on just now, so I wait a moment."
    REPLANNING = "replanning", "We are not getting on, so I look for another way."
    BACKING_UP = "backing_up", "There is too little room ahead, so I back up a little."
    CREEPING = "creeping", "It is tight here, so I go very slowly."
    ASK_RIDER = "ask_rider", "I cannot get through here. Please steer, or choose another place."
    NOBODY_DRIVES = "nobody_drives", "Nobody is driving, so I stand."
    PAGE_SILENT = "page_silent", "I did not hear from the driver's page, so I stopped."
    LET_GO = "let_go", "Please let go of the stick first."
    CONFIRM = "confirm", "Please say when I may go."
    NAVIGATOR_SILENT = "navigator_silent", "I could not think in time, so I stopped."
    COLLISION = "collision", "We touched something, so I stopped."
    PAUSED = "paused", "Time stands still."
    GETTING_READY = "getting_ready", "I am getting ready."
