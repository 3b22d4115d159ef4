"""Sweeps: many rides, each a task of its own, and the store of their results."""

from cohelm.evaluation.sweeps.ride_task import SERIES, RideTask, check_rides, config_hash, ride_row

__all__ = ["SERIES", "RideTask", "check_rides", "config_hash", "ride_row"]
