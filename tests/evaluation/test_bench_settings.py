"""What a benchmark compares is said by its options, and by no setting for all rides."""

import pytest

from cohelm.errors import ConfigError
from cohelm.evaluation.benches import (
    ablation,
    barn,
    cards,
    crowds,
    paper_dynamic,
    paper_static,
    rides,
    speed,
)
from cohelm.evaluation.benches.bench import check_free


@pytest.mark.parametrize("bench", [barn, cards, crowds, paper_dynamic, rides, speed])
@pytest.mark.parametrize("setting", ["local_planner.use=dwa", "local_planner=dwa", "seed=3"])
def test_every_planner_of_a_table_is_itself(bench, setting):
    """Else all rows of the table would be rides of one, each under another's name."""
    with pytest.raises(ConfigError, match=r"is said by --(planners|seeds)"):
        bench.on(planners="dwa,ss_mpc_dcbf", settings=["time_limit=60", setting])


@pytest.mark.parametrize("setting", ["rider=tremor", "rider.use=tremor", "mode=manual"])
def test_every_rider_and_mode_of_a_table_is_itself(setting):
    with pytest.raises(ConfigError, match=r"is said by --(riders|modes)"):
        paper_static.on(settings=[setting])


def test_what_is_varied_is_no_planner_and_no_seed():
    for varied in ("local_planner.use=dwa,mpc", "seed=1,2"):
        with pytest.raises(ConfigError, match="is said by"):
            cards.on(planners="dwa", vary=[varied])


@pytest.mark.parametrize("setting", ["profile.preferred_speed=1.0", "tracker.use=given"])
def test_the_paper_s_tables_are_what_their_titles_say(setting):
    with pytest.raises(ConfigError, match=r"is said by the (pace|rows)"):
        paper_dynamic.on(planners="dwa", settings=[setting])


def test_all_else_can_be_set():
    check_free(["local_planner.steps=20", "mode=shared", "people.seed=1"], {"rider": "--riders"})


def test_who_is_called_blind_is_blind():
    sees = ["people.see_robot=true"]
    for options in ({"blind": True}, {"both": True}):
        with pytest.raises(ConfigError, match="is said by --blind"):
            rides.on(planners="dwa", settings=sees, **options)
    with pytest.raises(ConfigError, match="is said by --seeing"):
        ablation.on(settings=sees)
    check_free(sees, {})


@pytest.mark.parametrize("setting", ["tracker.use=given", "robot=jackal"])
def test_the_cases_of_the_clock_are_what_they_are_called(setting):
    with pytest.raises(ConfigError, match="is said by the cases"):
        speed.on(planners="dwa", settings=[setting])
