from .ride_task import SERIES, RideTask, check_rides, config_hash, ride_row

__all__ = ["SERIES", "RideTask", "check_rides", "config_hash", "ride_row"]
