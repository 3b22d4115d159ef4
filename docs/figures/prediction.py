"""Draw predictions of pedestrians who stop and turn: the picture of docs/prediction.md.

python docs/figures/prediction.py [--plot FILE]
"""

import argparse
from pathlib import Path

import numpy as np

from cohelm.evaluation.perception.behaviour_changes import (
    CHANGES,
    SOON,
    BehaviourChange,
    simulated_changes,
)
from cohelm.evaluation.perception.prediction_scores import ALARM
from cohelm.perception import Hypotheses
from prediction_pictures import PredictedChange, draw_predictions


def predicted(change: BehaviourChange, predictor: Hypotheses) -> PredictedChange:
    """Predictions for one change, tick by tick."""
    memory, predictions = None, []
    tracked = [people for people in change.people if len(people) == 1]
    for people in tracked:
        found, memory = predictor.predict(people, 12, 0.1, memory)
        predictions.append(found)
    return PredictedChange(
        title=change.name.replace("_", " "),
        onset=change.onset,
        times=np.array([people.time for people in tracked]),
        positions=np.array([people.mean[0, :2] for people in tracked]),
        predictions=predictions,
    )


def main() -> None:
    """Draw one change of each kind."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--plot", type=Path, default=Path("docs/images/prediction.png"))
    chosen = options.parse_args()
    predictor = Hypotheses(Hypotheses.Parameters())
    draw_predictions(
        [predicted(each, predictor) for each in simulated_changes(5, counts=[1] * len(CHANGES))],
        chosen.plot,
        moments=(-0.2, 0.3, 0.6),
        alarm=ALARM,
        soon=SOON,
    )


if __name__ == "__main__":
    main()
