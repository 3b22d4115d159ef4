from .rides import Rides
from .store import read_rides
from .write import BenchReport, PaperTable, Sheet, write_results

__all__ = ["BenchReport", "PaperTable", "Rides", "Sheet", "read_rides", "write_results"]
