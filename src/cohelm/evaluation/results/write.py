"""What every bench of rides leaves behind, in the same form."""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from pathlib import Path

from cohelm.errors import ConfigError
from cohelm.evaluation.benches.bench import Report, Result
from cohelm.evaluation.results.chosen import shown
from cohelm.evaluation.results.figures import drawn
from cohelm.evaluation.results.measures import SHOWN
from cohelm.evaluation.results.ratings import read_ratings, with_ratings
from cohelm.evaluation.results.report import Told, report_page
from cohelm.evaluation.results.rides import Rides
from cohelm.evaluation.results.store import EPISODES, has_arrow, part_of, write_episodes
from cohelm.evaluation.results.summary import base_of, write_summary
from cohelm.evaluation.results.tables import PaperTable

_LOG = logging.getLogger("cohelm.results")
SUMMARY, PAGE = "summary.csv", "report.html"


def write_results(  # noqa: PLR0913  # what a bench may say of its rides
    results: Sequence[Result],
    folder: Path,
    *,
    by: Sequence[str] = ("scene", "planner"),
    title: str = "",
    base: str | None = None,
    measures: Sequence[str] = SHOWN,
    paper: PaperTable | None = None,
    report: Report | None = None,
    limitations: Sequence[str] = (),
    panels: bool = True,
    seconds: float = 40.0,
    say: Callable[[str], None] = _LOG.info,
) -> tuple[Path, ...]:
    """Write ``episodes.parquet``, ``summary.csv`` and ``report.html``; whatever rides there are.

    Args:
        results: a row each, as :func:`~cohelm.evaluation.sweeps.ride_task.ride_row` gives them, in
            their order, with the curve ``series`` where there is one. Not all need be there: any
            rides do, failed ones and those of one seed too.
        folder: is there, and can be written to.
        by: columns that say what was compared: the last is contrasted, on equal seeds, in every
            case that those before it make.
        title: of the page.
        base: the contender that the others are compared with; None: the first in the rows.
        measures: columns in the page's tables, see ``KNOWN``; the files have them all.
        paper: what a paper says of the same cases.
        report: the bench's own tables and sentences, for the page.
        limitations: of this bench, in sentences; those of all simulations are there anyway.
        panels: draw boxes, tracks and curves; the tables are there without them too.
        seconds: that may be spent on riding again for pictures; 0: none are.
        say: is told what is being done, where that takes time; else the log ``cohelm.results`` is.

    Returns:
        What was written. ``episodes.parquet`` is left out where pyarrow is not installed.

    Raises:
        ConfigError: if a file cannot be written.
    """
    rides, notes = _rated(results, by, folder)
    if not len(rides):
        return ()
    chosen = base_of(rides, base)
    table = [folder / EPISODES] if has_arrow() else []
    for file in table:
        write_episodes(rides, file)
    say(f"summing up {len(rides)} rides")
    write_summary(rides, chosen, folder / SUMMARY)
    told = Told(
        title=title or folder.name,
        notes=(*(report.notes if report else ()), *notes),
        sheets=report.sheets if report else (),
        limitations=limitations,
        paper=paper or PaperTable("", {}),
        measures=measures,
        part=part_of(len(rides), folder),
    )
    pictures = [drawn(rides, chosen, say) if panels else "", shown(rides, chosen, seconds, say)]
    (folder / PAGE).write_text(report_page(rides, chosen, told, pictures), encoding="utf-8")
    return (*table, folder / SUMMARY, folder / PAGE)


def _rated(
    results: Sequence[Result], by: Sequence[str], folder: Path
) -> tuple[Rides, Sequence[str]]:
    """The rides with what people said of them, and why, where nothing can be read of it."""
    rides = Rides(
        [result.row for result in results],
        by,
        [result.arrays.get("series") for result in results],
    )
    try:
        return with_ratings(rides, read_ratings(folder)), ()
    except ConfigError as cause:  # the rides stand without them
        return rides, (f"no ratings: {cause}",)
