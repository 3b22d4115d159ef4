"""Write your own part, check its contract, and print its prediction.

A part is a class with a nested ``Parameters`` model. Register it in one line of your project ::

    [project.entry-points."cohelm.predictors"]
    slowing = "my_package:SlowingDown"

and use it in any scenario with ``predictor: {use: slowing, time_constant: 1.5}``.
"""

import dataclasses

import numpy as np
from pydantic import Field

from cohelm.config import Model
from cohelm.messages import People, Predictions
from cohelm.testing import ConformanceError, check_predictor
from cohelm.testing.scenes import walkers


class SlowingDown:
    """All people slow down: v(t) = v₀ e^(−t/τ), p(t) = p₀ + τ (1 − e^(−t/τ)) v₀."""

    class Parameters(Model):
        """Parameters of the model."""

        time_constant: float = Field(2.0, gt=0.0, le=60.0)
        """τ, s."""

    def __init__(self, parameters: Parameters) -> None:
        self.parameters = parameters

    def predict(
        self, people: People, steps: int, step: float, memory: None
    ) -> tuple[Predictions, None]:
        """See :class:`~cohelm.perception.Predictor`; one hypothesis, no memory."""
        tau = self.parameters.time_constant
        ahead = step * np.arange(steps + 1)
        fading = np.exp(-ahead / tau)[:, None]
        position, velocity = people.mean[:, None, None, :2], people.mean[:, None, None, 2:]
        spread = np.sqrt(people.covariance[:, [0, 1], [0, 1]].max(axis=-1, initial=0.0))
        predictions = Predictions(
            step=step,
            names=("slowing_down",),
            weight=np.ones((len(people), 1)),
            mean=position + tau * (1.0 - fading) * velocity,
            velocity=fading * velocity,
            deviation=spread[:, None, None] + 0.3 * ahead,
        )
        return predictions, None


class OverSure(SlowingDown):
    """A prediction with decreasing uncertainty, which violates the contract."""

    def predict(
        self, people: People, steps: int, step: float, memory: None
    ) -> tuple[Predictions, None]:
        """Return decreasing deviations."""
        made, _ = super().predict(people, steps, step, memory)
        return dataclasses.replace(made, deviation=made.deviation[..., ::-1]), None


def main() -> None:
    predictor = SlowingDown(SlowingDown.Parameters())
    check_predictor(predictor)
    walker = walkers([[0.0, 0.0, 1.2, 0.0]])
    ahead = predictor.predict(walker, 4, 1.0, None)[0].mean[0, 0, :, 0]
    print("contract satisfied; a person at 1.2 m/s is after 0, 1 … 4 s at", np.round(ahead, 2), "m")
    try:
        check_predictor(OverSure(OverSure.Parameters()))
    except ConformanceError as fault:
        print("contract violated:", fault)


if __name__ == "__main__":
    main()
