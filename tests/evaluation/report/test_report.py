"""Results of a benchmark of rides: files, intervals, tests of differences, and the HTML page."""

from __future__ import annotations

import csv
import itertools
import re
from html.parser import HTMLParser

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy import stats
from tests.evaluation.sweep_rows import PLANNERS, result, sweep

from cohelm.benchmarks.bench import BenchReport, Sheet
from cohelm.errors import ConfigError
from cohelm.evaluation.metrics.measures import RideMeasure, measure_info
from cohelm.evaluation.report import PaperTable, Rides, read_rides, write_results
from cohelm.evaluation.report.html import Table, TableCell, render
from cohelm.evaluation.report.statistics import (
    bootstrap_mean,
    bootstrap_median,
    contrast,
    corrected,
    exact_mcnemar,
    holm_corrected,
    signed_ranks,
)
from cohelm.evaluation.report.store import _read_csv
from cohelm.evaluation.report.summary import case_name, contrasts
from cohelm.evaluation.report.write import curve_of, evenly, note_of, proxies, typical
from cohelm.evaluation.sweeps.ride_task import RideTask
from cohelm.evaluation.sweeps.store import (
    SweepHeader,
    SweepSize,
    SweepStore,
    is_begun,
    read_size,
)
from cohelm.evaluation.sweeps.sweep import write_rows
from cohelm.plotting import panels

BY = ("scene", "planner")
HOSTILE = "<script>alert('x')</script> & \"quotes\" $\\frac{1}{2}$"


class _Elements(HTMLParser):
    """Names of elements, those left open, and what attributes point to."""

    VOID = frozenset({"meta", "img", "br"})

    def __init__(self, page):
        super().__init__()
        self.names, self.open, self.sources, self.text = [], [], [], []
        self.feed(page)

    def handle_starttag(self, name, attributes):
        self.names.append(name)
        self.sources += [v for k, v in attributes if k in {"src", "href", "xlink:href"}]
        if name not in self.VOID:
            self.open.append(name)

    def handle_startendtag(self, name, attributes):
        self.sources += [v for k, v in attributes if k in {"src", "href", "xlink:href"}]

    def handle_endtag(self, name):
        assert self.open.pop() == name

    def handle_data(self, data):
        self.text.append(data)


def _rides(results):
    return Rides(
        [each.row for each in results], BY, [each.arrays.get("series") for each in results]
    )


def _html(table):
    return render("table.html", table=table)


def _page(folder):
    return (folder / "report.html").read_text(encoding="utf-8")


def test_parquet_gives_back_what_was_written_bit_for_bit(tmp_path):
    pq = pytest.importorskip("pyarrow.parquet")
    results = [*sweep(3), result(planner="apf", outcome="error", time=np.nan, error="it broke")]
    write_results(results, tmp_path, panels=False)

    back = read_rides(tmp_path)
    assert back.by == BY
    assert len(back) == len(results)
    for row, one in zip(back, results, strict=True):
        for key, cell in one.row.items():
            same = row[key] == cell or (np.isnan(row[key]) and np.isnan(cell))
            assert same, key
    types = {field.name: str(field.type) for field in pq.read_schema(tmp_path / "episodes.parquet")}
    assert types["seed"] == "int64"
    assert types["time"] == "double"
    assert types["outcome"] == "string"


def test_rows_csv_says_the_same_where_there_is_no_parquet(tmp_path):
    results = sweep(3)
    write_rows([each.row for each in results], tmp_path / "rows.csv")
    back = _read_csv(tmp_path / "rows.csv")
    assert back.by == list(BY) or back.by == BY
    assert np.allclose(back.column("time"), _rides(results).column("time"), rtol=1e-5)
    assert np.isnan(back.column("agreement")).all()
    assert [row["config"] for row in back] == ["c0ffee"] * len(results)


@pytest.mark.parametrize("content", ["", "scene,planner\na,b\n", "seed,outcome\n1,reached\n"])
def test_what_is_no_table_of_rides_is_refused(tmp_path, content):
    (tmp_path / "rows.csv").write_text(content)
    with pytest.raises(ConfigError):
        read_rides(tmp_path)


@pytest.mark.parametrize("name", ["rows.csv", "episodes.parquet"])
def test_damaged_files_are_refused(tmp_path, name):
    (tmp_path / name).write_bytes(b"PAR1\xff\xfe\x00garbage")
    with pytest.raises(ConfigError):
        read_rides(tmp_path)


def test_folders_without_rides_are_refused(tmp_path):
    with pytest.raises(ConfigError, match=r"neither episodes\.parquet nor rows\.csv"):
        read_rides(tmp_path)
    with pytest.raises(ConfigError, match="does not exist"):
        read_rides(tmp_path / "nowhere")


def test_intervals_agree_with_scipy():
    values = np.random.default_rng(3).exponential(size=60)
    for ours, of in ((bootstrap_mean, np.mean), (bootstrap_median, np.median)):
        found = ours(values)
        theirs = stats.bootstrap(
            (values,), of, n_resamples=4000, method="percentile", rng=np.random.default_rng(1)
        ).confidence_interval
        width = theirs.high - theirs.low
        assert found.mean == pytest.approx(of(values))
        # Two draws of some thousand resamples: bounds within a tenth of the width.
        assert found.low == pytest.approx(theirs.low, abs=0.1 * width)
        assert found.high == pytest.approx(theirs.high, abs=0.1 * width)


@given(arrays(float, st.integers(1, 12), elements=st.floats(-5, 5)))
@settings(max_examples=25, deadline=None)
def test_intervals_hold_their_value_and_no_order(values):
    for of in (bootstrap_mean, bootstrap_median):
        found, turned = of(values), of(values[::-1])
        assert found.low - 1e-12 <= found.mean <= found.high + 1e-12
        assert (found.low, found.high) == (turned.low, turned.high)


@pytest.mark.parametrize("n", [3, 8, 25, 50])
def test_signed_ranks_agree_with_scipy_where_it_is_exact(n):
    less = np.random.default_rng(n).normal(0.3, 1.0, n)
    theirs = stats.wilcoxon(less, method="exact").pvalue
    assert signed_ranks(less) == pytest.approx(theirs, abs=1e-12)


def test_signed_ranks_of_many_are_scipys():
    less = np.random.default_rng(0).normal(0.1, 1.0, 200)
    assert signed_ranks(less) == pytest.approx(stats.wilcoxon(less).pvalue)


@pytest.mark.parametrize("less", [[1, 1, -2, 3, 1], [2, 2, 2, 2, 2, 2], [1, -1, 2, -2, 3]])
def test_signed_ranks_with_ties_count_every_sign(less):
    """Under no difference each sign is a coin: 2^n rank sums, as extreme ones of them counted."""
    less = np.array(less, dtype=float)
    ranks = stats.rankdata(np.abs(less))
    sums = [ranks[np.array(s)].sum() for s in itertools.product([False, True], repeat=len(less))]
    middle, seen = ranks.sum() / 2.0, ranks[less > 0].sum()
    extreme = np.mean(np.abs(np.array(sums) - middle) >= abs(seen - middle) - 1e-9)
    assert signed_ranks(less) == pytest.approx(extreme)


def test_mcnemar_is_a_coin_thrown_for_each_discordant_pair():
    # 7 of 8: 2 × (1 + 8) / 2^8
    less = np.array([1.0] * 7 + [-1.0] + [0.0] * 20)
    assert exact_mcnemar(less) == pytest.approx(2 * 9 / 256)
    assert exact_mcnemar(np.zeros(5)) == 1.0
    assert np.isnan(exact_mcnemar(np.empty(0)))


def test_holm_is_what_holm_writes():
    # Sorted .01 .02 .04 times 3 2 1, never falling; NaN is no test.
    found = holm_corrected(np.array([0.04, np.nan, 0.01, 0.02]))
    assert np.allclose(found, [0.04, np.nan, 0.03, 0.04], equal_nan=True)


def test_differences_are_of_equal_seeds_and_cases_only():
    ours = _rides([result("a", seed=0, time=10.0), result("a", seed=1, time=20.0)])
    theirs = _rides([result("a", "dwa", 1, time=21.0), result("b", "dwa", 0, time=99.0)])
    i, j = theirs.pairs(ours)
    found = contrast(theirs.column("time")[i], ours.column("time")[j], measure_info("time"))
    assert (found.difference.count, found.difference.mean) == (1, 1.0)


def test_nothing_is_better_whose_mean_and_pairs_lie_on_different_sides():
    # 30 pairs a little below, three far above: ranks 1…30 against 31 + 32 + 33.
    theirs = np.zeros(33)
    ours = np.concatenate([np.linspace(-0.3, -0.2, 30), [40.0, 41.0, 42.0]])
    (found,) = corrected([contrast(ours, theirs, measure_info("time"))])
    assert found.p < 0.05
    assert (found.sign, found.difference.mean > 0.0, found.verdict) == (-1, True, "differs")
    (found,) = corrected([contrast(ours[:30], theirs[:30], measure_info("time"))])
    assert found.verdict == "better"
    (found,) = corrected([contrast(ours[:30], theirs[:30], measure_info("min_distance"))])
    assert found.verdict == "worse"


def _steered(riders, seeds=6):
    """Shared rides are 1 s slower or faster than autonomous ones, by the seed alone."""
    by = ("scene", "rider", "mode")
    rows = [
        {"scene": "a", "rider": f"r{k}", "mode": mode, "seed": s, "outcome": "reached",
         "time": 10.0 + (mode == "shared") * (1.0 if s else -0.5)}
        for k in range(riders) for s in range(seeds) for mode in ("shared", "autonomous")
    ]  # fmt: skip
    return Rides(rows, by)


def test_riders_of_one_scene_and_seed_are_no_more_proof_than_one_of_them():
    names = ["time", "reached"]
    one, ten = (contrasts(_steered(k).by_contender(), "shared", names) for k in (1, 10))
    for key, each in one.items():
        assert (ten[key].p, ten[key].difference.count) == (each.p, 6)
        assert ten[key].difference.mean == pytest.approx(each.difference.mean)
    assert not _steered(1).has_shared_draws
    assert _steered(2).has_shared_draws


def test_a_mean_of_shares_is_tested_by_its_ranks():
    # Three units of two: +1 and 0, +1 and +1, 0 and 0 make 0.5, 1, 0.
    ours, theirs = np.array([1.0, 0, 1, 1, 0, 0]), np.zeros(6)
    found = contrast(ours, theirs, measure_info("reached"), units=[0, 0, 1, 1, 2, 2])
    assert found.difference.mean == 0.5
    assert found.p == signed_ranks(np.array([0.5, 1.0, 0.0]))


def test_summary_says_what_is_worse(tmp_path):
    write_results(sweep(20), tmp_path, base="ours", panels=False)
    with (tmp_path / "summary.csv").open(newline="") as stream:
        rows = {(r["scene"], r["planner"], r["measure"]): r for r in csv.DictReader(stream)}
    slow = rows["crossing", "teb", "time"]
    assert slow["verdict"] == "worse"
    assert slow["pairs"] == "20"
    assert float(slow["difference"]) == pytest.approx(1.6, abs=0.1)
    assert rows["crossing", "teb", "path_length"]["verdict"] == ""
    assert rows["crossing", "ours", "time"]["base"] == ""
    assert float(rows["crossing", "ours", "reached"]["low"]) == pytest.approx(0.8389, abs=1e-3)


def test_the_page_stands_by_itself_and_is_well_formed(tmp_path):
    paper = PaperTable("A paper, Table 3", {("crossing", "ours"): {"time": 16.89}})
    report = BenchReport((Sheet("own", ("a",), (("b",),)),), ("it reached: met", "x: MISSED"), {})
    written = write_results(
        sweep(3), tmp_path, title="All", paper=paper, report=report, limitations=("One floor.",),
    )  # fmt: skip
    assert {file.name for file in written} >= {"summary.csv", "report.html"}
    page = _page(tmp_path)
    found = _Elements(page)
    assert not found.open
    assert not re.search(r"https?:|//[a-z]", page.replace("//www.w3.org", "//"))
    assert all(each.startswith(("#", "data:")) for each in found.sources)
    assert "script" not in found.names
    text = "".join(found.text)
    for words in ("16.89", "A paper, Table 3", "One floor.", "ours, paper", "Limitations", "teb"):
        assert words in text
    assert found.names.count("svg") > 6
    assert "prefers-color-scheme:dark" in page
    assert 'name="viewport"' in page


def test_hostile_text_stays_text(tmp_path):
    results = [
        result(HOSTILE, planner, seed, error=HOSTILE, traceback=HOSTILE, replay=HOSTILE,
               outcome="error" if seed else "reached")
        for seed in range(2) for planner in (HOSTILE, "dwa")
    ]  # fmt: skip
    report = BenchReport((Sheet(HOSTILE, (HOSTILE,), ((HOSTILE,),)),), (HOSTILE,), {})
    write_results(results, tmp_path, title=HOSTILE, report=report, limitations=(HOSTILE,))
    page = _page(tmp_path)
    assert "<script" not in page
    found = _Elements(page)
    assert not found.open
    assert HOSTILE in "".join(found.text)


@given(st.text(), st.text())
@settings(max_examples=60, deadline=None)
def test_tables_escape_any_text(words, value):
    table = Table([words], [[words], [TableCell(value, (words,), "good")]], words)
    found = _Elements(_html(table))
    assert not found.open
    assert found.names.count("td") == 0
    assert set(found.names) <= set(_Elements(_html(Table(["a"], [["b"]], "c"))).names) | {
        "span", "small", "caption",
    }  # fmt: skip


def test_the_length_of_half_a_way_is_none():
    rows = [result(seed=k, outcome=each).row for k, each in enumerate(("reached", "timeout"))]
    rides = Rides(rows, ("scene", "planner"))
    for name in ("time", "path_length"):
        assert np.isfinite(rides.column(name)).tolist() == [True, False]
    assert np.isfinite(rides.column("min_distance")).all()


def test_words_begin_at_the_left_and_figures_end_at_the_right():
    rows = [["ours", "1.2 m/s, crossing", "1.20 m"], ["dwa", "", "–"]]
    html = _html(Table(["planner", "case", "gap"], rows))
    assert html.count('<td class="words">') == 2
    assert "<td>1.20 m</td>" in html


def test_a_verdict_is_seen_and_a_limitation_told_once(tmp_path):
    notes = ("three asked: met; lost: none", "one asked: MISSED", "One floor.")
    report = BenchReport((), notes, {})
    write_results([result()], tmp_path, report=report, limitations=notes[2:])
    page = _page(tmp_path)
    assert 'asked: <span class="good">met</span>; lost' in page
    assert 'asked: <span class="bad">MISSED</span></li>' in page
    assert page.count("One floor.") == 1


@pytest.mark.parametrize(
    "results",
    [
        pytest.param([result()], id="one ride"),
        pytest.param(sweep(1), id="one seed"),
        pytest.param(sweep(5, planners=("ours",)), id="one planner"),
        pytest.param([result(outcome="error", time=np.nan, error="x")] * 3, id="all broke off"),
        pytest.param(
            [result(seed=s, outcome="collision", time=np.nan) for s in range(4)], id="no success"
        ),
        pytest.param(sweep(3)[:7], id="interrupted"),
        pytest.param([result(scene=str(c), seed=0) for c in range(15)], id="many cases"),
    ],
)
def test_whatever_rides_there_are_make_a_report(tmp_path, results):
    write_results(results, tmp_path, panels=len(results) < 6)
    assert not _Elements(_page(tmp_path)).open
    assert len(read_rides(tmp_path)) == len(results)


def test_a_case_is_named_by_its_words_and_its_numbers_with_their_key():
    by = ("pace", "card", "people.count", "speed", "planner")
    assert case_name(("1.2 m/s", "frontal", "2", "1.2"), by) == (
        "1.2 m/s, frontal, people.count=2, speed=1.2"
    )
    assert case_name(("true", ""), ("blind", "scene", "planner")) == "blind=true, no scene"


@pytest.mark.parametrize(
    ("rides", "says"),
    [
        ([result()], "1 ride: 1 planner in 1 case, seed 0"),
        (sweep(2), "12 rides: 3 planners in 2 cases, seeds 0 to 1"),
    ],
)
def test_the_page_counts_what_was_ridden(tmp_path, rides, says):
    write_results(rides, tmp_path, panels=False)
    assert says in _page(tmp_path)


def test_ticks_of_a_panel_are_told_apart():
    values = panels.Values(panels.look(0), np.array([0.9912, 0.9987]), np.zeros(2, dtype=bool))
    svg = panels.box_panel("box", "time ratio", {"ours": values})
    ticks = re.findall(r"<text[^>]*>\s*(\d\.\d+)\s*</text>", svg)
    assert len(set(ticks)) == len(ticks) > 2
    assert not re.search(r"<[^>]*\d\.\d{3}", svg)  # coordinates are short


@pytest.mark.parametrize(
    ("x", "says"), [(-0.004, "0.00"), (0.004, "0.00"), (-0.006, "-0.01"), (np.nan, "–")]
)
def test_nothing_has_no_sign(x, says):
    assert RideMeasure("time").text(x) == says


def test_no_rides_make_no_report(tmp_path):
    assert write_results([], tmp_path) == ()
    assert not list(tmp_path.iterdir())


def test_the_same_rides_make_the_same_files(tmp_path):
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        write_results(sweep(4, scenes=("a",)), tmp_path / name, title="x")
    for file in sorted((tmp_path / "a").iterdir()):
        assert file.read_bytes() == (tmp_path / "b" / file.name).read_bytes(), file.name


def test_a_ride_that_stands_for_all_is_of_one_seed():
    rides = _rides([r for r in sweep(5) if (r.row["planner"], r.row["seed"]) != ("teb", 4)])
    shown = typical(rides.split()["crossing",], "ours")
    assert set(shown) == set(PLANNERS)
    assert len({each.seeds[0] for each in shown.values()}) == 1


def test_cases_that_are_drawn_are_spread_evenly():
    assert evenly([(str(i),) for i in range(11)], 3) == [("0",), ("5",), ("10",)]


def test_a_row_stores_its_ride():
    settings = ("local_planner.use=dwa", "people.pedestrians=[{a: b c}]")
    task = RideTask((), "crossing", settings, 7)
    assert RideTask.from_row({"task": task.as_json()}) == task
    for no in ({}, {"task": ""}, {"task": None}, {"task": "cohelm run x"}, {"task": float("nan")}):
        assert RideTask.from_row(no) is None


def _sized(folder, size):
    with SweepStore(folder, SweepHeader("rides", {}, {}), resume=True) as store:
        store.set_size(size)


def test_a_page_of_a_part_says_at_its_top_how_much_of_what_it_is(tmp_path):
    _sized(tmp_path, SweepSize(tasks=4, rides=12))
    assert not is_begun(tmp_path)  # nothing is done yet
    rides = [result(seed=k) for k in range(9)]
    write_results(rides, tmp_path)
    page = (tmp_path / "report.html").read_text()
    at = page.index("This is a part: 9 of 12 rides")
    assert page.index("</h1>") < at < page.index("<h2>")
    write_results([*rides, *(result(seed=k) for k in (9, 10, 11))], tmp_path)
    assert "This is a part" not in (tmp_path / "report.html").read_text()


def test_the_last_size_of_a_sweep_counts(tmp_path):
    assert read_size(tmp_path) is None
    for size in (SweepSize(2, 4), SweepSize(3, 6)):
        _sized(tmp_path, size)
    assert read_size(tmp_path) == SweepSize(3, 6)
    (tmp_path / "sweep.sqlite").write_text("damaged")
    assert read_size(tmp_path) is None


def test_nobody_at_a_stick_has_no_stand_in_for_an_opinion():
    alone = Rides([result(seed=k, authority=0.0).row for k in range(3)], ("scene", "planner"))
    assert proxies(alone) is None
    steered = [result(seed=k, authority=0.9, agreement=0.8).row for k in range(3)]
    table = proxies(Rides(steered, ("scene", "planner")))
    assert any(each.startswith("agreement") for each in table.columns)


def test_what_overlaps_is_no_nearer_than_touching():
    """Curves hold gaps below 0, measures do not: panels show what the tables say."""
    one = result()
    curve = one.arrays["series"].copy()
    curve[:, 6] = np.linspace(1.0, -0.5, len(curve))
    shown = curve_of(Rides([one.row], ("scene", "planner"), [curve]))
    assert shown[:, 6].min() == 0.0
    assert shown[0, 6] == 1.0
    assert curve[:, 6].min() == -0.5


def test_verdicts_of_claims_are_marked():
    disagrees = note_of("the paper: it is so. Here: does not agree; time, s: 1 of a")
    assert (disagrees.verdict, disagrees.css) == ("does not agree", "bad")
    assert disagrees.after == "; time, s: 1 of a"
    assert note_of("Here: agrees; time, s").css == "good"
    assert note_of("a sentence").verdict == ""
