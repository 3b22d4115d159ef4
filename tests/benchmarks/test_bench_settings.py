"""What a benchmark compares is set by its options, and by no setting for all rides."""

import pytest

from cohelm.benchmarks import planning, planning_maps
from cohelm.benchmarks import ride_speed as speed
from cohelm.benchmarks.bench import unset
from cohelm.benchmarks.external import barn
from cohelm.benchmarks.paper import dynamic as paper_dynamic
from cohelm.benchmarks.paper import global_planners as paper_global
from cohelm.benchmarks.perception import bench as perception
from cohelm.benchmarks.rides import ablation, cards, crowds, modes, rides
from cohelm.benchmarks.solver import bench as solver
from cohelm.benchmarks.solver import states as solver_states
from cohelm.errors import ConfigError
from cohelm.planning.costmap.costmap import build_costmap
from cohelm.robots import load_robot


@pytest.mark.parametrize("bench", [barn, cards, crowds, paper_dynamic, rides, speed])
@pytest.mark.parametrize("setting", ["local_planner.use=dwa", "local_planner=dwa", "seed=3"])
def test_every_planner_of_a_table_is_itself(bench, setting):
    """Else all rows of the table would be rides of one, each under another's name."""
    with pytest.raises(ConfigError, match=r"is set by --(planners|seeds)"):
        bench.create(planners="dwa,ss_mpc_dcbf", settings=["time_limit=60", setting])


@pytest.mark.parametrize("setting", ["rider=tremor", "rider.use=tremor", "mode=manual"])
def test_every_rider_and_mode_of_a_table_is_itself(setting):
    with pytest.raises(ConfigError, match=r"is set by --(riders|modes)"):
        modes.create_corridors(settings=[setting])


def test_what_is_varied_is_no_planner_and_no_seed():
    for varied in ("local_planner.use=dwa,mpc", "seed=1,2"):
        with pytest.raises(ConfigError, match="is set by"):
            cards.create(planners="dwa", vary=[varied])


@pytest.mark.parametrize("setting", ["profile.preferred_speed=1.0", "tracker.use=given"])
def test_the_paper_s_tables_are_what_their_titles_say(setting):
    with pytest.raises(ConfigError, match=r"is set by the (pace|rows)"):
        paper_dynamic.create(planners="dwa", settings=[setting])


def test_all_else_can_be_set():
    unset(["local_planner.steps=20", "mode=shared", "people.seed=1"], {"rider": "--riders"})


def test_who_is_called_blind_is_blind():
    sees = ["people.see_robot=true"]
    for options in ({"blind": True}, {"both": True}):
        with pytest.raises(ConfigError, match="is set by --blind"):
            rides.create(planners="dwa", settings=sees, **options)
    with pytest.raises(ConfigError, match="is set by --seeing"):
        ablation.create(settings=sees)
    unset(sees, {})


@pytest.mark.parametrize("setting", ["tracker.use=given", "robot=jackal"])
def test_the_cases_of_the_clock_are_what_they_are_called(setting):
    with pytest.raises(ConfigError, match="is set by the cases"):
        speed.create(planners="dwa", settings=[setting])


@pytest.mark.parametrize("bench", [paper_global, perception, planning, solver])
def test_a_setting_of_nothing_is_refused_before_anything_is_done(bench):
    with pytest.raises(ConfigError, match="nonsense"):
        bench.create(settings=["nonsense=1"])


def test_what_a_global_method_is_called_after_is_not_set():
    settings = ["global_planner.cost_weight=2", "profile.preferred_speed=0.8"]
    assert paper_global.create("astar", settings).settings == tuple(settings)
    with pytest.raises(ConfigError, match="is fixed by the method astar_shortest"):
        paper_global.create("astar,astar_shortest", settings)
    with pytest.raises(ConfigError, match="is set by the scenes"):
        paper_global.create(settings=["goal=[1, 2]"])


def test_a_wider_inflation_is_what_is_timed():
    """Of a plan the cost is what it is: where more is inflated, the same way costs more."""
    grid = planning_maps.floor(200, 0)
    made = []
    for settings in ([], ["inflation.inflation_radius=2.5", "clearance=0.1"]):
        weighed = planning._settings(settings)
        radius = load_robot(weighed.robot).inscribed_radius + weighed.clearance
        made.append(build_costmap(grid, radius, weighed.inflation).cost)
    assert (made[1] >= made[0]).all()
    assert (made[1] > made[0]).any()
    with pytest.raises(ConfigError, match="clearance"):
        planning.create(settings=["clearance=-1"])


def test_the_solver_s_planner_has_the_setting_and_the_rows_their_horizon():
    planner = solver_states.planner_with(["local_planner.iterations=7"])
    assert planner.parameters.iterations == 7
    with pytest.raises(ConfigError, match=r"local_planner\.steps: is set by the rows"):
        solver.create(settings=["local_planner.steps=10"])
