"""What is asked of steering together, met or missed; what the paper says of its corridors."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from cohelm.evaluation.benches.rides_verdicts import ENOUGH, as_percent, broken, few
from cohelm.evaluation.benches.steering_rows import differences, in_order, touch_speed
from cohelm.evaluation.bootstrap import Estimate, mean_of, median_of, share
from cohelm.evaluation.results.rides import Rides

SOFT = 0.2
"""A touch at no more than this is none, m/s."""
REACHED = 0.95
"""Least share of shared rides that is to arrive."""
SLOWEST = 1.4
"""Times the ride alone that the median shared ride may take."""
GUARDED = ("assisted", "shared")
"""Modes behind the whole gate with a rider."""


def limits(rides: Rides) -> Iterator[str]:
    """Whether any rider can ride: no fast touch, nearly all arrive, and in time."""
    yield from _little(rides)
    for mode in GUARDED:
        found = rides.only(mode=mode)
        if not len(found):
            continue
        fast = touch_speed(found) > SOFT
        text = f"{mode}: touches at more than {SOFT:g} m/s in {int(fast.sum())} of {len(found)}"
        met = not (fast | found.broke_off).any()
        yield f"{text} rides{broken(found)}, none asked: {_word(met)}"
        for rider in in_order(found.rows, "rider"):
            mine = found.only(rider=rider)
            speed = touch_speed(mine)
            if (speed > SOFT).any():
                worst = mine.rows[int(np.nanargmax(speed))]
                yield (
                    f"{mode}, {rider}: {int((speed > SOFT).sum())} of {len(mine)}, up to "
                    f"{np.nanmax(speed):.2f} m/s: {worst['replay']}"
                )
    yield from _shared(rides.only(mode="shared"))


def _shared(shared: Rides) -> Iterator[str]:
    if not len(shared):
        return
    reached = share(shared.reached)
    yield (
        f"shared: {as_percent(reached)} % reached, {100 * REACHED:g} % asked: "
        f"{_word(reached.mean >= REACHED)}"
    )
    for rider in in_order(shared.rows, "rider"):
        mine = shared.only(rider=rider).reached
        if mine.mean() < REACHED:
            yield f"shared, {rider}: {int(mine.sum())} of {len(mine)} reached"
    ratio = median_of(shared.column("time_ratio"))
    yield (
        f"shared: median time {ratio:.2f} × the same ride with nobody there, at most {SLOWEST:g} "
        f"asked: {_word(ratio.mean <= SLOWEST)}"
    )


def paper(rides: Rides) -> Iterator[str]:
    """The paper's conclusions on its corridors, each with whether it is so here."""
    yield from _little(rides)
    modes = {mode: rides.only(mode=mode) for mode in ("manual", "assisted", "shared", "autonomous")}
    yield from _less_touched(modes["shared"], modes["manual"], "shared", "manual")
    yield from _less_touched(modes["assisted"], modes["manual"], "assisted", "manual")
    if len(modes["shared"]) and len(modes["manual"]):
        yield _compared(modes["shared"], modes["manual"], "heading_change", "rad", "manual")
    for scene in in_order(rides.rows, "scene"):
        both = [modes[mode].only(scene=scene) for mode in ("shared", "autonomous")]
        if all(len(each) for each in both):
            yield _better(scene, *both)


def _less_touched(one: Rides, other: Rides, mine: str, theirs: str) -> Iterator[str]:
    if not (len(one) and len(other)):
        return
    less = mean_of(differences(one, other, "touched"))
    yield (
        f"{mine} collides less than {theirs}: {_is_less(less)}; {int(one.touched.sum())} of "
        f"{len(one)} rides against {int(other.touched.sum())} of {len(other)}, paired "
        f"{100 * less.mean:+.1f} [{100 * less.low:.1f}, {100 * less.high:.1f}] %"
    )


def _compared(one: Rides, other: Rides, key: str, unit: str, theirs: str) -> str:
    less = mean_of(differences(one, other, key))
    here = _is_less(less)
    return f"shared is smoother than {theirs}: {here}; turning {less:+.2f} {unit} less it, paired"


def _is_less(less: Estimate) -> str:
    """Whether a difference is clearly below 0, as the paper has it."""
    if less.high < 0.0:
        return "so here"
    return "not so here" if less.low > 0.0 else "not clear here"


def _better(scene: str, shared: Rides, alone: Rides) -> str:
    """Whether shared control is better than the chair alone: more arrive, or as many and sooner."""
    more, later = (mean_of(differences(shared, alone, key)) for key in ("reached", "time"))
    arrive = f"{int(shared.reached.sum())} of {len(shared)} arrive"
    beside = f"alone {int(alone.reached.sum())} of {len(alone)}"
    if more.low > 0.0 or (more.low >= 0.0 and later.count and later.high < 0.0):
        here = "so here"
    elif more.high < 0.0 or (later.count and later.low > 0.0):
        here = "not so here"
    else:
        here = "not clear here"
    why = "" if here == "so here" else _why(alone, later.mean)
    return (
        f"{scene}: shared is better than the chair alone: {here}; {arrive}, {beside}, time "
        f"{later:+.1f} s paired{why}"
    )


def _why(alone: Rides, later: float) -> str:
    """What stands in the way of being better."""
    if alone.reached.all() and not alone.touched.any():
        slow = ", and whoever steers along takes longer" if later > 0.0 else ""
        return f": the chair alone neither fails nor freezes here{slow}"
    return ""


def _little(rides: Rides) -> Iterator[str]:
    seeds = len(set(rides.seeds))
    counts = [
        len(rides.only(mode=mode, rider=rider))
        for mode in in_order(rides.rows, "mode")
        for rider in in_order(rides.rows, "rider")
    ]
    if min(counts, default=0) < ENOUGH:
        yield f"{few(min(counts, default=0))} a rider in a mode ({seeds} seeds)"


def _word(met: object) -> str:
    return "met" if met else "MISSED"
