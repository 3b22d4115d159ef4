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
from prediction_pictures import Foretold, draw_futures


def predicted(change: BehaviourChange, predictor: Hypotheses) -> Foretold:
    """Predictions for one change, tick by tick."""
    memory, predictions = None, []
    seen = [people for people in change.people if len(people) == 1]
    for people in seen:
        found, memory = predictor.predict(people, 12, 0.1, memory)
        predictions.append(found)
    return Foretold(
        title=change.name.replace("_", " "),
        change=change.onset,
        times=np.array([people.time for people in seen]),
        positions=np.array([people.mean[0, :2] for people in seen]),
        predictions=predictions,
    )


def main() -> None:
    """Draw one change of each kind."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--plot", type=Path, default=Path("docs/images/prediction.png"))
    chosen = options.parse_args()
    predictor = Hypotheses(Hypotheses.Parameters())
    draw_futures(
        [predicted(each, predictor) for each in simulated_changes(5, counts=[1] * len(CHANGES))],
        chosen.plot,
        moments=(-0.2, 0.3, 0.6),
        alarm=ALARM,
        soon=SOON,
    )


if __name__ == "__main__":
    main()
