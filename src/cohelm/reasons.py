"""Reasons for what the chair does or offers: stable codes, rider's sentences."""

from __future__ import annotations

from enum import StrEnum


class Reason(StrEnum):
    """Stable code of a reason; ``sentence`` is for the rider, ``report`` for others."""

    sentence: str
    report: str

    def __new__(cls, code: str, sentence: str, report: str = "") -> Reason:
        """Attach the sentences to the code; without a second one the first is for everybody."""
        reason = str.__new__(cls, code)
        reason._value_ = code
        reason.sentence = sentence
        reason.report = report or sentence
        return reason

    # Safety gate: invalid or old input.
    NOT_FINITE = "not_finite", "A sensor sent invalid data. Stopped."
    CLOCK = "clock", "The clock ran backwards. Stopped."
    STALE_SCAN = "stale_scan", "No data from a sensor. Stopped."
    STALE_POSE = "stale_pose", "The position is unknown. Stopped."
    STALE_TWIST = "stale_twist", "The speed is unknown. Stopped."
    POSE_JUMP = "pose_jump", "The position jumped. Stopped to check it."
    STALE_RIDER_COMMAND = "stale_rider_command", "The joystick is not connected. Stopped."
    RIDER_STOP = "rider_stop", "You stopped the chair.", "STOP was pressed."
    THERAPIST_STOP = "therapist_stop", "The therapist stopped the chair."
    STOP_PRESSED = "stop_pressed", "STOP was pressed on another screen."
    LATE = "late", "Navigation was too slow. Stopped."
    # Health monitor: redundant input that does not agree.
    SCAN_FROZEN = "scan_frozen", "The scanner repeats the same reading. Stopped."
    SCAN_IMPLAUSIBLE = "scan_implausible", "The scanner sends impossible distances. Stopped."
    SCAN_BLIND = "scan_blind", "The scanner cannot see ahead. Stopped."
    SCAN_PARTLY_BLIND = "scan_partly_blind", "The scanner sees little ahead. Slowed down."
    SCAN_MOTION = "scan_motion", "The scanner does not fit the chair's motion. Stopped."
    ODOMETRY_FAULT = "odometry_fault", "The wheel sensors do not fit the chair's motion. Stopped."
    POSE_FAULT = "pose_fault", "The position does not fit the chair's motion. Stopped."
    SENSORS_DISAGREE = "sensors_disagree", "The sensors contradict each other. Stopped."
    POSE_DOUBTFUL = "pose_doubtful", "The position is not certain. Slowed down."
    LOST = (
        "lost",
        "The position is lost. Stopped. Please steer by hand, or ask for help.",
        "The position is lost. Stopped. The rider must steer by hand, or needs help.",
    )
    DRIVE_FAULT = "drive_fault", "The wheels do not follow the command. Stopped."
    DRIVE_WEAK = "drive_weak", "The motors are weaker than they should be. Slowed down."
    STICK_STUCK = (
        "stick_stuck",
        "The joystick seems stuck. Please release it.",
        "The joystick seems stuck. It must be released.",
    )
    # Safety gate: the requested motion.
    OVER_LIMITS = "over_limits", "Slowed down to the chair's limits."
    TOO_CLOSE = "too_close", "Obstacle close ahead. Slowed down."
    BLOCKED = "blocked", "Obstacle in the way. Stopped."
    KEEPOUT = "keepout", "No entry here. Stopped."
    EDGE_AHEAD = "edge_ahead", "A step or an edge in the floor. Stopped."
    FLOOR_UNSEEN = "floor_unseen", "Floor that cannot be seen. Very slow, and not backwards."
    EDGES_ALLOWED = "edges_allowed", "Edges of the floor are not avoided now. Very slow."
    # Local planner.
    STICK_BACK = (
        "stick_back",
        "You hold the stick back. The chair moves on when you release it.",
        "The rider holds the stick back. The chair moves on when it is released.",
    )
    NO_SAFE_PLAN = "no_safe_plan", "No safe motion found. Braking."
    SOLVER_FAILED = "solver_failed", "Motion planning failed. Braking."
    # Global planner.
    START_BLOCKED = "start_blocked", "The chair is too close to an obstacle to plan a route."
    GOAL_BLOCKED = "goal_blocked", "The destination is too close to an obstacle."
    OUTSIDE_MAP = "outside_map", "This place is outside the map."
    NO_PATH = "no_path", "No route there is wide enough."
    TOO_MANY_WISHES = "too_many_wishes", "Too many route wishes at once."
    INVALID_PROBLEM = "invalid_problem", "The request is not valid."
    PLANNING_TIMEOUT = "planning_timeout", "No route found in time."
    PLANNING = "planning", "Route planning failed."
    # Progress and recovery.
    ARRIVED = "arrived", "You have arrived.", "The chair has arrived."
    WAITING = "waiting", "Waiting until the way is clear."
    GOAL_OCCUPIED = "goal_occupied", "A person is at the destination. Waiting."
    REPLANNING = "replanning", "No progress. Looking for another route."
    BACKING_UP = "backing_up", "Not enough space ahead. Backing up a little."
    REVERSING = "reversing", "No room to turn here. Backing out."
    CREEPING = "creeping", "Narrow passage. Driving very slowly."
    ASK_RIDER = (
        "ask_rider",
        "No way through. Please steer, or choose another destination.",
        "No way through. The rider must steer, or choose another destination.",
    )
    # Live rides.
    NO_DRIVER = "no_driver", 'Stopped. Tap "Drive from this screen".', "Stopped. No driver."
    CONNECTION_LOST = "connection_lost", "Connection to the driver's screen lost. Stopped."
    RELEASE_STICK = "release_stick", "Release the stick first.", "The stick must be released first."
    CONFIRM = "confirm", 'Tap "Go on".', 'The rider has not yet pressed "Go on".'
    NAVIGATOR_TIMEOUT = "navigator_timeout", "This computer is too slow for real time. Stopped."
    NAVIGATOR_RESTARTS = "navigator_restarts", "The navigator is starting again."
    NAVIGATOR_FAILED = "navigator_failed", "The navigator does not start. Stopped."
    PROGRAM_FAILED = "program_failed", "The program has failed. Stopped."
    COLLISION = "collision", "The chair touched something. Stopped."
    FELL = "fell", "A wheel went over an edge. Stopped."
    PAUSED = "paused", "The simulation is paused."
    STARTING = "starting", "Starting up. Please wait.", "Starting up."


class OfferReason(StrEnum):
    """Stable code of a reason to offer a destination; ``sentence`` has a field ``{metres}``."""

    sentence: str

    def __new__(cls, code: str, sentence: str) -> OfferReason:
        """Attach the sentence to the code."""
        reason = str.__new__(cls, code)
        reason._value_ = code
        reason.sentence = sentence
        return reason

    CLOSER_AND_STEERING = "closer_and_steering", "{metres} m closer, and you steer towards it"
    CLOSER = "closer", "You have come {metres} m closer"
    STEERING = "steering", "You steer towards it"
    HABIT = "habit", "You often go there"
    STILL_POSSIBLE = "still_possible", "Still possible"
