"""What a rider likes, learned from which of several routes was taken, and said in words.

A choice of route a over route b says that w · (x_a − x_b) > 0 for the rider's weights w over the
routes' features x: a linear classifier of differences, without intercept (Chang et al., 2017, used
a support vector machine). The features are divided by fixed units, not by anything of the data, so
that a weight means the same for every rider and at any time.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np
from pydantic import Field, model_validator

from cohelm.arrays import Floats
from cohelm.config import Model
from cohelm.planning.features import RouteFeatures
from cohelm.planning.traits import TRAITS

LEAST_CHOICES = 5
"""Fewer say too little: five weights are to be learned."""

_SOFTNESS = 10.0
"""C of the classifier, see :func:`learn`."""


class Liking(Model):
    """A number for each feature that a choice may go by: what a route has of it, or its weight."""

    length: float = 0.0
    """Of the route, m; weight per 10 m."""
    clearance: float = 0.0
    """Mean clearance, m; weight per 0.2 m."""
    encounters: float = 0.0
    """People near the way; weight per 2 people."""
    turns: float = 0.0
    """Weight per 2 turns."""
    doors: float = 0.0
    """Narrow passages; weight per passage."""

    @staticmethod
    def of(features: RouteFeatures) -> Liking:
        """What of a route's features choices are learned from."""
        return Liking(**{name: float(getattr(features, name)) for name in UNITS})

    def vector(self) -> Floats:
        """The numbers (f,) in the order of :data:`UNITS`."""
        return np.array([getattr(self, name) for name in UNITS])


UNITS: Mapping[str, float] = {name: trait.unit for name, trait in TRAITS.items()}
"""What one unit of weight is per, by the name of the feature."""

_FAINT = 0.15  # weights below this are not spoken of


class Choice(Model):
    """Which of several routes was taken."""

    when: str = ""
    """Date and time, if noted."""
    where: str = ""
    """Map, start and goal, for the reader."""
    routes: tuple[Liking, ...] = Field(min_length=2)
    """All that were shown."""
    taken: int = Field(ge=0)
    """Index of the one taken, from 0."""

    @model_validator(mode="after")
    def _is_among_them(self) -> Choice:
        if self.taken >= len(self.routes):
            raise ValueError(f"route {self.taken} of {len(self.routes)} cannot be taken")
        return self


def learn(choices: Iterable[Choice]) -> Liking | None:
    """The weights that explain the choices, of length 1; None where too few say anything.

    Logistic regression of every (taken − left) difference without intercept, regularised by
    |w|² / 2C. With weights about 1 and differences about a unit, C = 10 leaves it to the choices
    how surely they were made, while features that hardly ever differed keep a weight near 0. How
    sure a rider is does not change the order of routes, so the length is normalised away.
    """
    said = [choice for choice in choices if len(set(choice.routes)) > 1]
    if len(said) < LEAST_CHOICES:
        return None
    from sklearn.linear_model import LogisticRegression  # noqa: PLC0415 # takes a second to import

    x = np.concatenate([_differences(choice) for choice in said])
    model = LogisticRegression(fit_intercept=False, C=_SOFTNESS / 2.0, max_iter=1000)
    model.fit(np.concatenate([x, -x]), np.repeat([1, 0], len(x)))  # each difference both ways
    weights = model.coef_[0]
    length = float(np.linalg.norm(weights))
    if length == 0.0:
        return None
    return Liking(**dict(zip(UNITS, (weights / length).tolist(), strict=True)))


def appeal(route: Liking, weights: Liking) -> float:
    """The sum w · x: the more, the better the route suits."""
    return float(_scaled(route) @ weights.vector())


def habits(weights: Liking) -> list[str]:
    """What the weights say of the rider, the strongest first; those that hardly count left out."""
    order = sorted(UNITS, key=lambda name: -abs(getattr(weights, name)))
    return [
        meaning(name, weight)
        for name in order
        if abs(weight := float(getattr(weights, name))) >= _FAINT
    ]


def meaning(name: str, weight: float) -> str:
    """What the weight of a feature says of the rider; a dash where it says too little."""
    if abs(weight) < _FAINT:
        return "–"
    return TRAITS[name].liked if weight > 0.0 else TRAITS[name].disliked


def explained(choices: Sequence[Choice], weights: Liking) -> float:
    """The share of the choices whose taken route the weights rank first."""
    first = [
        int(np.argmax([appeal(route, weights) for route in choice.routes])) == choice.taken
        for choice in choices
    ]
    return sum(first) / len(first) if first else 0.0


def _differences(choice: Choice) -> Floats:
    """(taken − left) in units, (routes − 1, f)."""
    x = np.stack([_scaled(route) for route in choice.routes])
    differences: Floats = x[choice.taken] - np.delete(x, choice.taken, axis=0)
    return differences


def _scaled(route: Liking) -> Floats:
    scaled: Floats = route.vector() / np.array(list(UNITS.values()))
    return scaled
