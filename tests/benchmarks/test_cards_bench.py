"""Report of ``cohelm bench cards``, and refusal of invalid input."""

import numpy as np
import pytest
from tests.evaluation.sweep_rows import result

from cohelm.benchmarks.rides import cards


def rides(count, **changes):
    """A ride of one planner in the card ``accompanying`` with so many people."""
    given = {"people.count": str(count), "planner": "apf", "side_by_side_share": np.nan, **changes}
    made = result(seed=0, **given)
    row = {"card": "accompanying", "people.count": str(count), **made.row}
    del row["scene"]
    return type(made)(row, made.arrays)


@pytest.fixture
def bench():
    return cards.create(planners="apf", cards="accompanying", vary=["people.count=1,2"])


def test_cards_make_a_whole_report_and_name_what_is_varied(bench, tmp_path):
    told = bench.report(
        [rides(1, side_by_side_share=0.2), rides(2, side_by_side_share=0.6)], tmp_path
    )
    assert {file.name for file in told.files} >= {"summary.csv", "report.html"}
    assert set(told.summary["cards"]) == {
        "accompanying, people.count=1",
        "accompanying, people.count=2",
    }
    assert "accompanying, people.count=2" in (tmp_path / "report.html").read_text()
    assert told.sheets[0].rows == (
        ("accompanying", "1", "1 of 1"),
        ("accompanying", "2", "1 of 1"),
    )


def test_time_beside_a_companion_is_told_for_every_variant(bench, tmp_path):
    told = bench.report(
        [rides(1, side_by_side_share=0.2), rides(2, side_by_side_share=0.6)], tmp_path
    )
    beside = [note for note in told.notes if "side by side" in note]
    assert beside == [
        "accompanying, people.count=1, time side by side: apf 20 %",
        "accompanying, people.count=2, time side by side: apf 60 %",
    ]


def test_cards_that_all_broke_off_are_a_report_too(bench, tmp_path):
    told = bench.report([rides(1, outcome="error", error="x", time=np.nan)], tmp_path)
    assert any(
        note.endswith("ended by an error in 1 rides, first seed 0: x") for note in told.notes
    )
