"""``report.html``: what the rides say, on one page that stands by itself."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field

from cohelm.evaluation.benches.bench import Sheet
from cohelm.evaluation.results.markup import Content, Markup, folded, table, tag, text
from cohelm.evaluation.results.measures import SHOWN
from cohelm.evaluation.results.page import page, section
from cohelm.evaluation.results.rides import Rides
from cohelm.evaluation.results.summary import case_name
from cohelm.evaluation.results.tables import PaperTable, case_tables, proxies, ratings

UNFOLDED = 12
"""Cases whose tables lie open; of more, each is behind its name."""
ALWAYS = (
    "These are simulated rides: no person was carried, and simulated people stand in for walking "
    "ones.",
    "Times, lengths and turning are of rides that reached the goal; where groups differ in how "
    "many do, differences are of the pairs in which both did.",
    "A p-value says how surprising a difference is if there were none; it does not say that the "
    "difference matters. Tables of different cases are corrected each by itself.",
)
"""Limitations that every comparison of simulated rides has."""
_VERDICT = re.compile(r"(?<=: )(met|MISSED|agrees|does not agree)(?=;|$)")
_GOOD = frozenset({"met", "agrees"})


@dataclass(frozen=True)
class Told:
    """What a benchmark says beyond its rides."""

    title: str
    notes: Sequence[str] = ()
    sheets: Sequence[Sheet] = ()
    limitations: Sequence[str] = ()
    paper: PaperTable = field(default_factory=lambda: PaperTable("", {}))
    measures: Sequence[str] = SHOWN
    part: str = ""
    """How much of what was asked for there is, ``14 of 36 rides``; empty: all of it."""


def report_page(rides: Rides, base: str, told: Told, pictures: Content = "") -> Markup:
    """The whole page."""
    parts = [
        section("says", "What came of it", _notes(told)),
        section("tables", "Side by side", _tables(rides, base, told)),
        text(pictures),
        section("ratings", "What riders said", _opinions(rides)),
        section("more", "Further tables", [_sheet(each) for each in told.sheets]),
        section("faults", "Rides that broke off", _faults(rides)),
        section("limits", "Limitations", _list([*told.limitations, *ALWAYS])),
    ]
    head = [tag("h1", told.title), _part(told.part), tag("p", _whole(rides), class_="soft")]
    return page(told.title, *head, *parts)


def _part(part: str) -> Markup:
    """That it is one, in sight of everybody; nothing where all rides are there."""
    if not part:
        return Markup("")
    says = "; the rest has not been ridden, and the groups may have different seeds."
    head, on = tag("strong", f"This is a part: {part}"), tag("code", "--resume")
    return tag("p", head, says, " ", on, " goes on with it.", class_="part", role="note")


def _whole(rides: Rides) -> str:
    seeds = sorted(set(rides.seeds))
    versions = sorted({str(row["version"]) for row in rides if row.get("version")})
    made = f"; cohelm {', '.join(versions)}" if versions else ""
    span = f"seeds {seeds[0]} to {seeds[-1]}" if len(seeds) > 1 else f"seed {seeds[0]}"
    return (
        f"{_count(len(rides), 'ride')}: {_count(len(rides.contenders), rides.by[-1])} in "
        f"{_count(len(rides.cases), 'case')}, {span}{made}"
    )


def _count(many: int, what: str) -> str:
    return f"{many} {what}" if many == 1 else f"{many} {what}s"


def _tables(rides: Rides, base: str, told: Told) -> list[Markup]:
    """All cases together, then each; folded where they are many."""
    split = rides.split()
    out = []
    if len(split) > 1:
        title = f"all {len(split)} cases together"
        out.append(case_tables(title, rides.together(), base, told.measures))
    for case, by_name in split.items():
        title = case_name(case, rides.by) or "all rides"
        theirs = {k[-1]: row for k, row in told.paper.rows.items() if k[:-1] == case}
        inside = case_tables(title, by_name, base, told.measures, theirs, told.paper.says)
        out.append(folded(title, inside) if len(split) > UNFOLDED else inside)
    return out


def _opinions(rides: Rides) -> list[Markup]:
    rated, stand_ins = ratings(rides), proxies(rides)
    out = [rated] if rated else [tag("p", "Nobody was asked: no ride has a rating by a person.")]
    if stand_ins:
        says = "Stand-ins, computed from stick and wheels. They are no opinion of anybody."
        out += [tag("p", says, class_="soft"), stand_ins]
    return out


def _notes(told: Told) -> Markup:
    """What is said, but for what stands under the limitations."""
    return _list([each for each in told.notes if each not in told.limitations])


def _list(sentences: Sequence[str]) -> Markup:
    items = [tag("li", _marked(each)) for each in sentences]
    return tag("ul", items) if items else Markup("")


def _marked(sentence: str) -> list[str]:
    """A sentence whose verdict, where it has one, is seen at a glance."""
    before, word, after = (*_VERDICT.split(sentence, maxsplit=1), "", "")[:3]
    if not word:
        return [sentence]
    return [before, tag("span", word, class_="good" if word in _GOOD else "bad"), after]


def _sheet(sheet: Sheet) -> Markup:
    return folded(sheet.title, table(sheet.columns, sheet.rows)) if sheet.rows else Markup("")


def _faults(rides: Rides) -> list[Markup]:
    """Every fault once, with its traceback and the command that shows it again."""
    found: dict[str, list[int]] = {}
    for i, row in enumerate(rides.rows):
        if row.get("outcome") == "error":
            found.setdefault(str(row.get("error") or "without a word"), []).append(i)
    out = []
    for error, at in found.items():
        row = rides.rows[at[0]]
        out.append(
            folded(
                f"{len(at)} × {error}",
                tag("p", tag("code", str(row.get("replay") or ""))),
                tag("pre", str(row.get("traceback") or "")),
            )
        )
    return out
