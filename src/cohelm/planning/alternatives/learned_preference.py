"""Preference of a rider, learned from choices between routes, and its words.

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
from cohelm.planning.alternatives.features import RouteFeatures


@value
class FeatureWords:
    """Unit and words of a figure of ``RouteFeatures`` that a rider may prefer high or low."""

    unit: float
    """Unit of the weight, about the typical difference between alternatives; assumed."""
    noticed: float
    """Smallest difference that is mentioned, in the figure's own unit; assumed."""
    counted: str
    """Words after the number of a unit, for example "m longer"."""
    liked: str
    """Words for a positive weight."""
    disliked: str
    """Words for a negative weight."""
    more: str
    """Words for a route with more than another; {n} is the difference, {s} the plural."""
    less: str
    """Words for a route with less."""

    def compared(self, difference: float) -> str:
        """Difference of two routes' figures in words, for example "6 m longer"."""
        n = abs(difference)
        phrase = self.more if difference > 0.0 else self.less
        return phrase.format(n=f"{n:.0f}", s="s" if round(n) > 1 else "")


FEATURE_WORDS: Mapping[str, FeatureWords] = {
    "length": FeatureWords(
        unit=10.0,
        noticed=1.0,
        counted="m longer",
        liked="longer routes",
        disliked="shorter routes",
        more="{n} m longer",
        less="{n} m shorter",
    ),
    "clearance": FeatureWords(
        unit=0.2,
        noticed=0.1,
        counted="m more clearance",
        liked="more clearance",
        disliked="less clearance",
        more="more clearance",
        less="less clearance",
    ),
    "encounters": FeatureWords(
        unit=2.0,
        noticed=0.5,
        counted="more people",
        liked="busy routes",
        disliked="quiet routes",
        more="busier",
        less="quieter",
    ),
    "turns": FeatureWords(
        unit=2.0,
        noticed=1.0,
        counted="more turns",
        liked="routes with turns",
        disliked="straight routes",
        more="{n} more turn{s}",
        less="{n} fewer turn{s}",
    ),
    "doors": FeatureWords(
        unit=1.0,
        noticed=1.0,
        counted="more narrow passage",
        liked="routes through doors",
        disliked="routes without doors",
        more="{n} more narrow passage{s}",
        less="{n} fewer narrow passage{s}",
    ),
}
"""Words by the name of the figure."""


MIN_CHOICES = 5
"""Minimum number of choices: there are five weights to learn."""

_SOFTNESS = 10.0
"""C of the classifier, see :func:`learn_weights`."""


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


UNITS: Mapping[str, float] = {name: trait.unit for name, trait in FEATURE_WORDS.items()}
"""Unit of the weight by the name of the feature."""

_FAINT = 0.15  # weights below this are not mentioned


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


def describe_preference(weights: FeatureVector) -> list[str]:
    """Words for the weights, the strongest first; small ones are left out."""
    order = sorted(UNITS, key=lambda name: -abs(getattr(weights, name)))
    return [
        describe_weight(name, weight)
        for name in order
        if abs(weight := float(getattr(weights, name))) >= _FAINT
    ]


def describe_weight(name: str, weight: float) -> str:
    """Words for the weight of a feature; a dash if it is small."""
    if abs(weight) < _FAINT:
        return "–"
    return FEATURE_WORDS[name].liked if weight > 0.0 else FEATURE_WORDS[name].disliked


def share_explained(choices: Sequence[RouteChoice], weights: FeatureVector) -> float:
    """Share of the choices in which the weights rank the taken route first."""
    first = [
        int(np.argmax([utility(route, weights) for route in choice.routes])) == choice.taken
        for choice in choices
    ]
    return sum(first) / len(first) if first else 0.0


def _differences(choice: RouteChoice) -> Floats:
    """Differences (taken − other) in units, (routes − 1, f)."""
    x = np.stack([_scaled(route) for route in choice.routes])
    differences: Floats = x[choice.taken] - np.delete(x, choice.taken, axis=0)
    return differences


def _scaled(route: FeatureVector) -> Floats:
    scaled: Floats = route.vector() / np.array(list(UNITS.values()))
    return scaled
