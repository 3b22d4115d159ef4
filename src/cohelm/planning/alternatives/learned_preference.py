"""Preference of a rider, learned from choices between routes.

A choice of route a over route b says that w · (x_a − x_b) > 0 for the rider's weights w over the
routes' features x: a linear classifier of differences, without intercept (Chang et al., 2017, used
a support vector machine). The features are divided by fixed units, not by statistics of the data,
so that a weight means the same for every rider and at any time.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np
from pydantic import Field, model_validator

from cohelm.arrays import Floats, value
from cohelm.config import Model
from cohelm.planning.alternatives.alternatives import Alternative, wish_distance
from cohelm.planning.alternatives.features import RouteFeatures


@value
class FeatureScale:
    """Scale of a figure of ``RouteFeatures`` that a rider may prefer high or low; assumed."""

    unit: float
    """Unit of the weight, about the typical difference between alternatives."""
    noticed: float
    """Smallest difference that is mentioned, in the figure's own unit."""


SCALES: Mapping[str, FeatureScale] = {
    "length": FeatureScale(unit=10.0, noticed=1.0),
    "clearance": FeatureScale(unit=0.2, noticed=0.1),
    "encounters": FeatureScale(unit=2.0, noticed=0.5),
    "turns": FeatureScale(unit=2.0, noticed=1.0),
    "doors": FeatureScale(unit=1.0, noticed=1.0),
}
"""Scales by the name of the figure."""


MIN_CHOICES = 5
"""Minimum number of choices: there are five weights to learn."""

_SOFTNESS = 10.0
"""C of the classifier, see :func:`learn_weights`."""
_WISH_UNIT = 2.0  # m
_MOST_DIFFERENCES = 4


class FeatureVector(Model):
    """Number for each feature that matters for choices: a route's figure, or a rider's weight."""

    length: float = 0.0
    """Length of the route, m; weight per 10 m."""
    clearance: float = 0.0
    """Mean clearance, m; weight per 0.2 m."""
    encounters: float = 0.0
    """People near the route; weight per 2 people."""
    turns: float = 0.0
    """Number of turns; weight per 2 turns."""
    doors: float = 0.0
    """Narrow passages; weight per passage."""

    @staticmethod
    def of(features: RouteFeatures) -> FeatureVector:
        """Select the features of a route that choices are learned from."""
        return FeatureVector(**{name: float(getattr(features, name)) for name in UNITS})

    def vector(self) -> Floats:
        """Numbers (f,) in the order of :data:`UNITS`."""
        return np.array([getattr(self, name) for name in UNITS])


UNITS: Mapping[str, float] = {name: each.unit for name, each in SCALES.items()}
"""Unit of the weight by the name of the feature."""


class RouteChoice(Model):
    """Choice of one of several routes."""

    when: str = ""
    """Date and time, if known."""
    where: str = ""
    """Map, start and goal, for the reader."""
    routes: tuple[FeatureVector, ...] = Field(min_length=2)
    """All routes that were shown."""
    taken: int = Field(ge=0)
    """Index of the route taken, from 0."""

    @model_validator(mode="after")
    def _is_among_them(self) -> RouteChoice:
        if self.taken >= len(self.routes):
            raise ValueError(f"route {self.taken} of {len(self.routes)} cannot be taken")
        return self


def learn_weights(choices: Iterable[RouteChoice]) -> FeatureVector | None:
    """Weights of length 1 that explain the choices; None if there are too few choices.

    Logistic regression of every (taken − left) difference without intercept, regularised by
    |w|² / 2C. With weights about 1 and differences about a unit, C = 10 is so weak that the
    choices determine the weights, while features that hardly differed keep a weight near 0. The
    certainty of a rider does not change the order of routes, so the length is normalised.
    """
    said = [choice for choice in choices if len(set(choice.routes)) > 1]
    if len(said) < MIN_CHOICES:
        return None
    from sklearn.linear_model import LogisticRegression  # noqa: PLC0415 # takes a second to import

    x = np.concatenate([_differences(choice) for choice in said])
    model = LogisticRegression(fit_intercept=False, C=_SOFTNESS / 2.0, max_iter=1000)
    model.fit(np.concatenate([x, -x]), np.repeat([1, 0], len(x)))  # each difference both ways
    weights = model.coef_[0]
    length = float(np.linalg.norm(weights))
    if length == 0.0:
        return None
    return FeatureVector(**dict(zip(UNITS, (weights / length).tolist(), strict=True)))


def utility(route: FeatureVector, weights: FeatureVector) -> float:
    """Sum w · x; higher for routes that suit the rider better."""
    return float(_scaled(route) @ weights.vector())


def preferred_order(
    routes: Sequence[Alternative], weights: FeatureVector | None
) -> tuple[int, ...]:
    """Return the indices of routes, the best first; without weights their own order.

    A present wish is more important than habits: two metres of distance from it count as much as
    all weights for one unit.
    """
    order = range(len(routes))
    if weights is None:
        return tuple(order)
    utilities = [
        utility(FeatureVector.of(each.features), weights) - wish_distance(each.path) / _WISH_UNIT
        for each in routes
    ]
    return tuple(sorted(order, key=lambda k: -utilities[k]))


def differences(
    route: RouteFeatures, other: RouteFeatures, weights: FeatureVector | None = None
) -> tuple[tuple[str, float], ...]:
    """Return (name, difference) of the figures in which two routes noticeably differ.

    The order is by the rider's weights, if they are known, else by the size of the difference.
    """
    found: list[tuple[float, str, float]] = []
    for name, scale in SCALES.items():
        more = float(getattr(route, name)) - float(getattr(other, name))
        if abs(more) >= scale.noticed:
            weight = 1.0 if weights is None else abs(getattr(weights, name))
            found.append((weight * abs(more) / scale.unit, name, more))
    found.sort(key=lambda each: -each[0])
    return tuple((name, more) for _, name, more in found[:_MOST_DIFFERENCES])


def _differences(choice: RouteChoice) -> Floats:
    """Differences (taken − other) in units, (routes − 1, f)."""
    x = np.stack([_scaled(route) for route in choice.routes])
    differences: Floats = x[choice.taken] - np.delete(x, choice.taken, axis=0)
    return differences


def _scaled(route: FeatureVector) -> Floats:
    scaled: Floats = route.vector() / np.array(list(UNITS.values()))
    return scaled
