"""Results of a sweep of rides: files for programs, a page for people, and two of them compared."""

from cohelm.evaluation.results.rides import Rides
from cohelm.evaluation.results.store import read_rides
from cohelm.evaluation.results.tables import PaperTable
from cohelm.evaluation.results.write import write_results

__all__ = ["PaperTable", "Rides", "read_rides", "write_results"]
