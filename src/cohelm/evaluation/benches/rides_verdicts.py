"""What is asked of our planner in the scenes, and in words whether it is met."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence

import numpy as np

from cohelm.arrays import Booleans
from cohelm.evaluation.benches.rides_scenes import OWN_SETTINGS
from cohelm.evaluation.bootstrap import Estimate, middle_of
from cohelm.evaluation.results.rides import Rides

OURS = "ss_mpc_dcbf"
SLOWEST = 1.4
"""Times the ride alone that the median ride may take among people."""
FEW_HITS, SOFT_HIT = 0.02, 0.3
"""Of ``distracted``: share of rides with a moving collision, and its speed, m/s, at most."""
REACHED_BLIND = 0.95
"""Least share that is to arrive where people do not see the chair."""
BEHIND = 1.15
"""Times the fastest safe planner's time that ours may take there."""
BLIND = ", blind"
_FLAWLESS = ("crossing", "aggressive")
ENOUGH = 20
"""Rides of a planner in a scene from which on sentences are findings."""
WIDE = 0.6
"""Least median gap that ``social_mpc`` is to keep in ``crossing``, m."""

Groups = Mapping[str, Mapping[str, Rides]]


def verdicts(groups: Groups) -> list[str]:
    """Sentences on what can be said of the scenes there are, each ending in met or MISSED.

    Where there are fewer than ``ENOUGH`` rides in a scene, the first one says that they are few.
    """
    fewest = min((len(each) for scene in groups.values() for each in scene.values()), default=0)
    out = [] if fewest >= ENOUGH else [f"{few(fewest)}: what follows is no finding"]
    out += [line for scene in groups for line in _scene(scene, groups[scene])]
    out += _blind({scene: each for scene, each in groups.items() if _is_blind(scene)})
    return [*out, *_floors(groups)]


def few(rides: int) -> str:
    """That so many rides are too few to judge by."""
    return f"{rides} {'ride is' if rides == 1 else 'rides are'} too few to judge by"


def broken(*groups: Rides) -> str:
    """Of rides that broke off, behind a count of hits: ``, 3 broke off``; nothing of none."""
    count = sum(int(each.broke_off.sum()) for each in groups)
    return f", {count} broke off" if count else ""


def as_percent(each: Estimate) -> str:
    """``97 [92, 99]``."""
    if not each.count:
        return "–"
    return f"{100.0 * each.mean:.0f} [{100.0 * each.low:.0f}, {100.0 * each.high:.0f}]"


def _is_blind(scene: str) -> bool:
    """Scenes with people who do not see the chair; two of the paper's are so as they are."""
    return scene.endswith(BLIND) or scene in {"aggressive", "distracted"}


def _scene(scene: str, by_planner: Mapping[str, Rides]) -> Iterator[str]:
    ours = by_planner.get(OURS)
    if ours is None:
        return
    if scene in _FLAWLESS:
        yield _says(scene, f"{_count(ours.reached)} reached", ours.reached.all())
        hits = ours.touched
        text = f"collisions in {_count(hits)}{broken(ours)}, none asked"
        yield _says(scene, text, not (hits | ours.broke_off).any())
    if scene == "distracted":
        yield from _distracted(ours, by_planner)
    if scene in _FLAWLESS or scene == "distracted":
        ratio = middle_of(ours.column("time_ratio"))
        text = f"median time {ratio:.2f} × the ride alone, at most {SLOWEST:g} asked"
        yield _says(scene, text, ratio <= SLOWEST)
    if scene.startswith("corridor-") and not _is_blind(scene):
        touched = ours.touched | (ours.column("standing_contacts") > 0)
        text = f"{_count(ours.reached)} reached, touched in {_count(touched)}, all and none asked"
        yield _says(scene, text, bool(ours.reached.all() and not touched.any()))


def _distracted(ours: Rides, by_planner: Mapping[str, Rides]) -> Iterator[str]:
    scene, hits = "distracted", ours.hit_moving
    text = f"moving collisions in {_count(hits)}{broken(ours)}, at most {100 * FEW_HITS:g} % asked"
    yield _says(scene, text, (hits | ours.broke_off).mean() <= FEW_HITS)
    speed = np.nan_to_num(ours.column("collision_speed")).max()
    yield _says(scene, f"fastest at {speed:.2f} m/s, at most {SOFT_HIT:g} asked", speed <= SOFT_HIT)
    standing = ours.column("standing_contacts") > 0
    yield f"{scene}, {OURS}: walked into while it stood in {_count(standing)}"
    for name in _rivals(by_planner):
        theirs = by_planner[name].hit_moving.mean()
        if theirs <= hits.mean():
            level = "none either" if theirs == 0.0 == hits.mean() else "MISSED"
            yield f"{scene}: {name} collides in {100 * theirs:.1f} % of the rides: {level}"


def _blind(groups: Groups) -> Iterator[str]:
    """Over all scenes with people who do not see the chair."""
    groups = {scene: each for scene, each in groups.items() if OURS in each}
    if not groups:
        return
    where = "people blind"
    reached = np.concatenate([each[OURS].reached for each in groups.values()])
    text = f"{_count(reached)} reached, {100 * REACHED_BLIND:g} % asked"
    yield _says(where, text, reached.mean() >= REACHED_BLIND)
    names = [
        n for n in _rivals(next(iter(groups.values()))) if all(n in e for e in groups.values())
    ]
    if not names:
        return
    hits = {
        name: float(np.concatenate([each[name].touched for each in groups.values()]).mean())
        for name in (OURS, *names)
    }
    least = min(hits[name] for name in names)
    best = [name for name in names if hits[name] == least]
    text = (
        f"collisions in {100 * hits[OURS]:.1f} % of the rides, of the others {' and '.join(best)} "
        f"least with {100 * least:.1f} %"
    )
    yield _says(where, text, hits[OURS] <= least)
    slower = {name: _slower(groups, name) for name in best}
    fastest = max(slower, key=lambda name: np.nan_to_num(slower[name], nan=-np.inf))
    factor = slower[fastest]
    text = f"median time {factor:.2f} × that of {fastest}, at most {BEHIND:g} asked"
    yield _says(where, text, factor <= BEHIND)


def _slower(groups: Groups, name: str) -> float:
    """Median of our time over ``name``'s, on the seeds on which both arrive."""
    ratios = []
    for each in groups.values():
        i, j = each[OURS].pairs(each[name])
        ratios.append(each[OURS].column("time")[i] / each[name].column("time")[j])
    return middle_of(np.concatenate(ratios))


def _floors(groups: Groups) -> Iterator[str]:
    """Whether the baselines are what they can be."""
    for (name, scene), (wanted, judge) in _FLOORS.items():
        group = groups.get(scene, {}).get(name)
        if group is not None:
            found, met = judge(group)
            yield f"{scene}, {name}: {found}, {wanted} asked of it: {_word(met)}"


def _without_hit(group: Rides) -> tuple[str, bool]:
    hits = group.touched
    return f"hits in {_count(hits)}{broken(group)}", not (hits | group.broke_off).any()


def _wide_berths(group: Rides) -> tuple[str, bool]:
    gap = middle_of(group.column("min_distance"))
    return f"{gap:.2f} m", gap >= WIDE


_FLOORS: Mapping[tuple[str, str], tuple[str, Callable[[Rides], tuple[str, bool]]]] = {
    ("mpc_dcbf", "aggressive"): ("no hit", _without_hit),
    ("social_mpc", "crossing"): (f"median gap of {WIDE:g} m or more", _wide_berths),
}
"""(planner, scene) → what is asked of it there, or it is a straw man; and who judges."""


def _rivals(by_planner: Mapping[str, Rides]) -> Sequence[str]:
    return [name for name in by_planner if name != OURS and name not in OWN_SETTINGS]


def _count(met: Booleans) -> str:
    return f"{int(met.sum())} of {len(met)}"


def _says(where: str, text: str, met: object) -> str:
    return f"{where}, {OURS}: {text}: {_word(met)}"


def _word(met: object) -> str:
    return "met" if met else "MISSED"
