"""The pedestrian model of docs/own-pedestrians.md works as it stands there."""

import re
from pathlib import Path

from cohelm import plugins
from cohelm.evaluation import run
from cohelm.scenarios import load_scenario
from cohelm.testing import check_pedestrian_model

GUIDE = Path(__file__).parent.parent / "docs/own-pedestrians.md"


def test_the_example_keeps_its_contract_and_walks_in_a_ride(tmp_path, monkeypatch):
    code = re.search(r"```python\n(# my_people.py\n.*?)```", GUIDE.read_text("utf-8"), re.DOTALL)
    (tmp_path / "my_people.py").write_text(code[1], encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    check_pedestrian_model(plugins.build("pedestrian_models", "my_people:Halting"))
    settings = ["people.model.use=my_people:Halting", "people.model.gap=0.6", "time_limit=2"]
    ride = run(load_scenario("hospital", [*settings, "local_planner=path_follower"]), 0)
    assert (ride.people[-1, :, :2] != ride.people[0, :, :2]).any()
