"""Ways round that are sampled: three-segment arcs over a horizon longer than the SQP's.

A gradient method stays in one way round. Some hundred arcs look at the others: a seeded table of
three segments each, of which many end by leading back to the path, then the best of them and the
last plan, pushed. One score judges sampled, polished and old ways alike: the time that a way loses
against the reference, in seconds, and in the same unit what it does to people, the rider and walls.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass

import numpy as np
from numba import njit
from pydantic import Field

from cohelm.arrays import Annotated, Floats, Integers, Shape
from cohelm.config import Model
from cohelm.control.api import LocalProblem, Motion
from cohelm.control.candidates.riding import Prices
from cohelm.control.candidates.scene import Scene, coarser, scene_of
from cohelm.control.candidates.searching import judged, searched
from cohelm.control.candidates.table import first_arcs, pushes
from cohelm.control.candidates.ways import Ways, signatures
from cohelm.control.room import share_of_room

_EXAMINED = 24
"""Arcs among which the different ones are looked for."""
_SIDES = {"right": 1, "left": -1, "none": 0}
"""How the bearing to somebody turns who is passed on that side."""


class Arcs:
    """Sampled ways round, and the score that judges any way."""

    class Parameters(Model):
        """Sampling, margins and prices, assumed but for what is named; found on rides."""

        horizon: float = Field(6.0, gt=0.0, le=20.0)
        """How far arcs look ahead, s; never less than the problem's own horizon."""
        stride: int = Field(2, ge=1, le=10)
        """Steps of the problem in one of the search; what it finds is judged in all of them."""
        count: int = Field(400, ge=50, le=20_000)
        """Arcs of the table."""
        pushes: int = Field(48, ge=0, le=1000)
        """Ways in which each of the best is changed, in each round."""
        rounds: int = Field(2, ge=0, le=10)
        """How often that is done."""
        elite: int = Field(4, ge=1, le=50)
        """How many are changed each time."""
        keep: int = Field(4, ge=1, le=_EXAMINED)
        """Different ways that are handed on, at most."""
        spread: float = Field(2.5, gt=0.0, le=100.0)
        """Ways dearer than the best one by more than this are dropped, s."""
        lag: float = Field(1.0, ge=0.0)
        """Price of a second lost at the end of the horizon."""
        late: float = Field(1.0, ge=0.0)
        """Price of a second lost on the mean over the horizon: sooner is better."""
        aside: float = Field(0.08, ge=0.0)
        """Price of the squared distance from the path, 1/m²: small, to go round is no fault."""
        bearing: float = Field(1.0, ge=0.0)
        """Price of 1 − cos of the angle at the end between the heading and the way ahead, s."""
        turning: float = Field(0.15, ge=0.0)
        """Price of ω², s²."""
        change: float = Field(0.016, ge=0.0)
        """Price of squared accelerations, s⁴/m² and s⁴/rad²."""
        hit: float = Field(60.0, ge=0.0)
        """Price of the squared depth to which the margin to a person is entered, 1/m²."""
        standing: float = Field(0.4, ge=0.0, le=1.0)
        """Share at which that counts where the robot stands: people walk into it all the same."""
        fading: float = Field(4.0, gt=0.0)
        """Time constant with which what is predicted counts less the later it is, s."""
        margin: float = Field(0.12, ge=0.0)
        """Gap to a person now below which it is a hit, m."""
        still: float | None = Field(None, ge=0.0)
        """The same to who stands, m, and never more; None: the same."""
        growth: float = Field(0.08, ge=0.0)
        """How that grows with prediction time for who walks, m/s."""
        berth: float = Field(0.0, ge=0.0)
        """By how much more it grows where somebody walks against the robot, m/s; see ``room``."""
        doubt: float = Field(0.0, ge=0.0)
        """What the predictor's own deviation adds to it, without unit."""
        greatest: float = Field(0.4, ge=0.0)
        """Its bound, m."""
        squeezing: float = Field(0.06, ge=0.0)
        """The margin where the ride is stalled, m; it does not grow then."""
        space: float = Field(0.8, ge=0.0)
        """Price of the squared share of a personal space that is entered, without unit."""
        hull: float = Field(25.0, ge=0.0)
        """Price of the squared depth in a group's space, 1/m²: so much that a way round is taken
        where there is one, and little enough that a robot among a group gets out."""
        wall: float = Field(0.5, ge=0.0)
        """Price of the squared share by which the clearance to walls is missed, without unit."""
        clearance: float = Field(0.1, ge=0.0)
        """Gap to walls that is wanted beyond the rider's clearance, m."""
        wall_margin: float = Field(0.02, ge=0.0)
        """Gap to a wall that counts as contact, m."""
        squeezing_wall_margin: float = Field(0.012, ge=0.0)
        """The same where the ride is stalled, m."""
        passing: float = Field(0.4, ge=0.0)
        """Price of passing somebody on the side that the rider does not like, s."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()

    def look(self, problem: LocalProblem, now: Floats) -> Outlook:
        """What can be said of ways through a problem; all that they share is worked out once.

        Args:
            problem: what is asked.
            now: what the wheels do, (m,).
        """
        p = self.parameters
        steps = max(round(p.horizon / problem.reference.step), len(problem.reference.speeds) - 1)
        margin = p.squeezing_wall_margin if problem.stalled else p.wall_margin
        scene = scene_of(problem, now, p.stride * -(-steps // p.stride), margin)
        return Outlook(
            parameters=p,
            problem=problem,
            scene=scene,
            prices=_prices(p, problem, scene),
            likeliest=_likeliest(problem, scene),
        )

    def ways(self, problem: LocalProblem, now: Floats, warm: Motion | None = None) -> Ways:
        """See :meth:`Outlook.ways`."""
        return self.look(problem, now).ways(warm)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Outlook:
    """A problem as ways through it are ridden and priced; lives as long as one plan is made."""

    parameters: Arcs.Parameters
    problem: LocalProblem
    scene: Scene
    prices: Prices
    likeliest: Annotated[Floats, Shape("n N+1 2")]
    """Where each person most likely is."""

    def ways(self, warm: Motion | None = None) -> Ways:
        """The best sampled ways, cheapest first, each passing people or the path in its own way.

        Args:
            warm: the last plan from now on, which is pushed too.
        """
        p, scene = self.parameters, self.scene
        coarse = coarser(scene, p.stride)
        m = len(scene.body.now)
        old = np.empty((0, m)) if warm is None else warm.inputs[: scene.steps]
        found = searched(
            coarse,
            _prices(p, self.problem, coarse),
            _means(old, p.stride),
            first_arcs(p.count),
            pushes(p.pushes),
            p.rounds,
            p.elite,
            p.spread,
            _EXAMINED,
        )
        ways = self._judged(np.repeat(found, p.stride, axis=1))
        if len(old):
            ways = _joined(self._judged(old[None].copy()), ways)
        order = np.argsort(ways.score, kind="stable")
        return _picked(ways, _different(ways.signature, order, p.keep))

    def score(self, inputs: Floats) -> Ways:
        """Any ways judged by the same score, in the order given.

        Args:
            inputs: (k, L, m) or (L, m); beyond L steps a way leads back to the path.
        """
        return self._judged(np.array(inputs, dtype=float, ndmin=3))

    def _judged(self, inputs: Floats) -> Ways:
        scene = self.scene
        count, m = len(inputs), inputs.shape[2]
        limited = np.empty((count, scene.steps, m))
        poses = np.empty((count, scene.steps + 1, 3))
        found = judged(scene, self.prices, inputs[:, : scene.steps], limited, poses)
        signature = signatures(poses, self.likeliest, scene.road)
        side = _SIDES[self.problem.profile.passing_side]
        wrong = (signature[:, 1:] == -side).sum(axis=1) if side else 0
        return Ways(
            step=scene.step,
            inputs=limited,
            poses=poses,
            score=found[:, 0] + self.parameters.passing * wrong,
            contact=found[:, 1],
            signature=signature,
        )


def _likeliest(problem: LocalProblem, scene: Scene) -> Floats:
    """Where each person most likely is, (n, N+1, 2)."""
    people, hypotheses = problem.predictions.weight.shape
    likely = problem.predictions.weight.argmax(axis=1) if people else np.empty(0, np.int64)
    rows = hypotheses * np.arange(people) + likely
    return np.ascontiguousarray(scene.crowd.states[rows, :, :2])


def _prices(p: Arcs.Parameters, problem: LocalProblem, scene: Scene) -> Prices:
    least, growth = (p.squeezing, 0.0) if problem.stalled else (p.margin, p.growth)
    if p.berth > 0.0 and not problem.stalled:
        growth += p.berth * share_of_room(problem.people, problem.pose)
    greatest = max(least, 0.0 if problem.stalled else p.greatest)
    fade, margin = _by_time(scene.step, scene.steps, p.fading, least, growth, greatest)
    return Prices(
        lag=p.lag,
        late=p.late,
        aside=p.aside,
        bearing=p.bearing,
        turning=p.turning,
        change=p.change,
        hit=p.hit,
        standing=p.standing,
        fade=fade,
        margin=margin,
        still=least if p.still is None else min(least, p.still),
        doubt=p.doubt,
        greatest=greatest,
        space=p.space,
        hull=p.hull,
        wall=p.wall,
        clearance=p.clearance + problem.profile.clearance,
    )


@functools.lru_cache(maxsize=64)
def _by_time(  # a key takes plain numbers
    step: float, steps: int, fading: float, least: float, growth: float, greatest: float
) -> tuple[Floats, Floats]:
    """(fade, margin) of ``Prices``, without a berth the same for every decision."""
    time = step * np.arange(steps + 1)
    return np.exp(-time / fading), np.minimum(least + growth * time, greatest)


@njit(cache=True)
def _different(signature: Integers, order: Integers, most: int) -> Integers:
    """The first ``most`` of ``order`` whose rows of ``signature`` (k, 1 + n) all differ."""
    chosen = np.empty(most, np.int64)
    count = 0
    for way in order:
        if count == most:
            break
        known = False
        for c in range(count):
            known |= np.array_equal(signature[way], signature[chosen[c]])
        if not known:
            chosen[count] = way
            count += 1
    return chosen[:count]


def _picked(ways: Ways, which: Integers) -> Ways:
    return Ways(
        step=ways.step,
        inputs=ways.inputs[which],
        poses=ways.poses[which],
        score=ways.score[which],
        contact=ways.contact[which],
        signature=ways.signature[which],
    )


def _means(inputs: Floats, stride: int) -> Floats:
    """Inputs (L, m) averaged over ``stride`` at a time; what does not fill the last is dropped."""
    whole = len(inputs) // stride
    return np.asarray(inputs[: whole * stride].reshape(whole, stride, inputs.shape[1]).mean(axis=1))


def _joined(one: Ways, other: Ways) -> Ways:
    return Ways(
        step=one.step,
        inputs=np.concatenate([one.inputs, other.inputs]),
        poses=np.concatenate([one.poses, other.poses]),
        score=np.concatenate([one.score, other.score]),
        contact=np.concatenate([one.contact, other.contact]),
        signature=np.concatenate([one.signature, other.signature]),
    )
