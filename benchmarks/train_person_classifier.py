"""Train the classifier of scan candidates, and write the model that ships with cohelm.

COHELM_DATA=… .venv/bin/python benchmarks/train_person_classifier.py
"""

from __future__ import annotations

from pathlib import Path

from cohelm.benchmarks.perception.held_out import (
    EMPTY,
    LABELLED,
    SCENES,
    recorded_samples,
    save,
    simulated_samples,
    train,
)
from cohelm.perception.scan_detection import person_classifier
from cohelm.recordings.outside_data import outside_file


def main() -> None:
    """Train on all open recordings and the simulated scenes."""
    recorded = []
    for name in (*LABELLED, *EMPTY):
        file = outside_file("lidar", name)
        if file is None:
            raise SystemExit(f"{name} is missing: set COHELM_DATA")
        recorded.append(recorded_samples(file, empty=name in EMPTY))
    trees = train(simulated_samples(range(SCENES)), recorded)
    target = Path(person_classifier.__file__).with_name("person_classifier.npz")
    save(trees, target)
    print(f"{target}: {target.stat().st_size} bytes, {len(trees.feature)} trees")


if __name__ == "__main__":
    main()
