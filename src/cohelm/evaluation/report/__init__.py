"""Results of a sweep of rides: files for programs, an HTML report, and comparisons."""

from cohelm.evaluation.report.rides import Rides
from cohelm.evaluation.report.store import read_rides
from cohelm.evaluation.report.write import BenchReport, PaperTable, Sheet, write_results

__all__ = ["BenchReport", "PaperTable", "Rides", "Sheet", "read_rides", "write_results"]
