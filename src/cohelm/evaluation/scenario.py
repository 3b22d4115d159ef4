"""A scenario: one strict YAML file says where, from where to where, with whom, with which parts.

    description: …              a sentence for ``cohelm scenarios``
    floor: hospital             or  map: file.yaml (Nav2 map_server YAML)
    start: Entrance             a place, [x, y] or [x, y, degrees]
    goal: Ward 3                a place or [x, y]
    prefer: [[20, 8]]           points to pass; avoid: zones; stroke: a line to follow
    people: {count: 12}         and explicit ways, speeds, whether they see the robot
    obstacles: [{at: [5, 3], radius: 0.3, height: 0.9}]           in the world, not on the map
    doors: [{at: [13, 3], size: [0.1, 2.6], closed: [[6, 60]]}]   in the world, not on the map
    filters: [{type: keepout, file: mask.yaml}]                   and speed limits
    plan: {corridors: {Hallway: {width: 1.5}}}                    other than the floor's file has it
    onto: file.yaml         lay all of it on another map, where that is most like the floor
    local_planner: ss_mpc_dcbf  or {use: ss_mpc_dcbf, steps: 30}; so for every part

A key that nobody knows is refused with its file, its dotted key and the nearest right one. All keys
but ``start``, ``goal`` and the floor have defaults, so that a scenario says only what is particular
to it.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from importlib.resources import files
from pathlib import Path
from typing import Annotated, Any, Self

from pydantic import BeforeValidator, Field, PrivateAttr, model_validator

from cohelm.config import Model, nearest, override, read_yaml, validate
from cohelm.errors import ConfigError, ScenarioError
from cohelm.evaluation.collection import Collection
from cohelm.evaluation.company import (
    WALKERS,
    Crowding,
    Point,
    named,
)
from cohelm.evaluation.things import Door, Mask, Obstacle, Onto, Preferred, Storey, Zone
from cohelm.maps import FARTHEST
from cohelm.messages import Mode, RiderProfile
from cohelm.navigation import ProgressParameters, RecoveryParameters, ReplanningParameters
from cohelm.perception import NoveltyParameters, ObstacleLayerParameters
from cohelm.planning import Comfort
from cohelm.plugins import Spec, spelt_out
from cohelm.robots import Robot, load_robot
from cohelm.safety import GateParameters
from cohelm.sharing import AuthorityParameters
from cohelm.simulation import Fault, Localisation, Odometry

PARTS = {
    "global_planner": ("global_planners", "soft_via"),
    "local_planner": ("local_planners", "ss_mpc_dcbf"),
    "detector": ("detectors", "scan_clusters"),
    "cloud_detector": ("cloud_detectors", "cloud_clusters"),
    "tracker": ("trackers", "kalman"),
    "group_detector": ("group_detectors", "affinity"),
    "predictor": ("predictors", "constant_velocity"),
    "social_model": ("social_models", "personal_space"),
    "rider": ("riders", "none"),
}
"""The replaceable parts: key of the scenario → (kind of plugin, the one used by default)."""
NAVIGATOR_PARTS = tuple(key for key in PARTS if key != "rider")
"""Those that the navigator is made of."""
NAVIGATOR_PARAMETERS = (
    "novelty",
    "obstacle_layer",
    "authority",
    "replanning",
    "progress",
    "recovery",
    "gate",
    "comfort",
)
"""Parameter sets of the navigator that a scenario has under the same name."""


def _place(given: Any) -> Any:
    if isinstance(given, str) and given:
        return given
    numbers = isinstance(given, list | tuple) and len(given) in {2, 3}
    if numbers and all(isinstance(x, int | float) and not isinstance(x, bool) for x in given):
        if all(abs(x) <= FARTHEST for x in given):
            return tuple(float(x) for x in given)
        raise ValueError(f"must lie within {FARTHEST:g} m of (0, 0)")
    raise ValueError("write a place's name, [x, y] or [x, y, degrees]")


Spot = Annotated[str | tuple[float, float, float] | Point, BeforeValidator(_place)]


class Scenario(Model):
    """Everything that makes a ride, but its seed's draw. See the module's docstring."""

    name: str = ""
    description: str = ""
    collection: Collection = Collection.OWN
    """Where it is listed."""
    floor: str | None = None
    """A floor that comes with cohelm."""
    map: str | None = None
    """A map_server YAML file; a relative name is looked for beside the scenario."""
    plan: dict[str, Any] = Field(default_factory=dict)
    """What is otherwise than the floor's file has it, key by key as there; a number reaches into a
    list."""
    onto: Onto | None = None
    """Another map to lay all this on: where it is most like the floor."""
    start: Spot
    goal: Spot
    prefer: tuple[Preferred, ...] = ()
    """Points that attract the route, m; several in one entry do so in their order."""
    stroke: tuple[Point, ...] = ()
    """A line that the route is to follow, m."""
    avoid: tuple[Zone, ...] = ()
    """Where the rider would rather not go."""
    robot: str = "quantum_q6_edge"
    """A name, or a YAML file; a relative name is looked for beside the scenario."""
    mode: Mode = Mode.SHARED
    rider: Spec = named(PARTS["rider"][1])
    rider_goal: Spot | None = None
    """Where the rider wants to go; none: where the chair goes."""
    rider_route: tuple[Point, ...] = ()
    """By which way from the start, m; none: the chair's where they go to the same place, else the
    way that is planned there without any wish."""
    profile: RiderProfile = RiderProfile()
    people: Crowding = Crowding()
    companion: int | None = Field(None, ge=0)
    """Which of the people, counted from 0, the chair is to stay beside: for ``beside_share``."""
    obstacles: tuple[Obstacle, ...] = ()
    storey: Storey = Storey()
    """Walls and ceiling."""
    doors: tuple[Door, ...] = ()
    """They close in the true world while the map has them open."""
    filters: tuple[Mask, ...] = ()
    """Keepout zones and speed limits."""
    crowding: str | None = None
    """A heat map of where people are known to be; a relative name is looked for beside the
    scenario."""
    global_planner: Spec = named(PARTS["global_planner"][1])
    local_planner: Spec = named(PARTS["local_planner"][1])
    detector: Spec = named(PARTS["detector"][1])
    cloud_detector: Spec = named(PARTS["cloud_detector"][1])
    tracker: Spec = named(PARTS["tracker"][1])
    group_detector: Spec = named(PARTS["group_detector"][1])
    predictor: Spec = named(PARTS["predictor"][1])
    social_model: Spec = named(PARTS["social_model"][1])
    novelty: NoveltyParameters = NoveltyParameters()
    obstacle_layer: ObstacleLayerParameters = ObstacleLayerParameters()
    authority: AuthorityParameters = AuthorityParameters()
    replanning: ReplanningParameters = ReplanningParameters()
    progress: ProgressParameters = ProgressParameters()
    recovery: RecoveryParameters = RecoveryParameters()
    gate: GateParameters = GateParameters()
    comfort: Comfort = Comfort()
    localisation: Localisation = Localisation()
    odometry: Odometry = Odometry()
    faults: tuple[Fault, ...] = ()
    """What is injected, and when."""
    time_limit: float = Field(180.0, gt=0.0, le=3600.0)
    """s."""
    seed: int = Field(0, ge=0)
    """Used where no other is given."""

    _file: Path | None = PrivateAttr(default=None)

    @model_validator(mode="after")
    def _one_world_and_whole_strokes(self) -> Self:
        if (self.floor is None) == (self.map is None):
            raise ValueError("give either floor: NAME or map: FILE.yaml")
        if len(self.stroke) == 1:
            raise ValueError("a stroke needs two points or more")
        return self

    @property
    def file(self) -> Path | None:
        """Where it was read, to be named in errors."""
        return self._file

    def beside(self, file: str) -> Path:
        """A file as the scenario names it: relative to the scenario's own folder."""
        return self._file.parent / file if self._file is not None else Path(file)


def scenario_names() -> tuple[str, ...]:
    """The scenarios that come with cohelm."""
    return tuple(
        sorted(
            f.name.removesuffix(".yaml")
            for f in _shipped("scenarios").iterdir()
            if f.name.endswith(".yaml")
        )
    )


def floor_file(name: str) -> Path:
    """The drawing of a floor that comes with cohelm.

    Raises:
        ScenarioError: listing the floors there are.
    """
    known = [f.name.removesuffix(".yaml") for f in _shipped("floors").iterdir()]
    if name not in known:
        raise ScenarioError(f"no floor is called {name!r}{nearest(name, known)}", key="floor")
    return Path(str(_shipped("floors") / f"{name}.yaml"))


def load_scenario(
    name_or_file: str | Path,
    settings: Iterable[str] = (),
    changes: Mapping[str, Any] | None = None,
) -> Scenario:
    """A scenario by its name or from a file.

    Args:
        name_or_file: one of :func:`scenario_names`, or a YAML file.
        settings: ``dotted.key=value``, put in last; values are read as YAML.
        changes: top-level keys to replace before; None takes a key away.

    Raises:
        ScenarioError: naming file, dotted key and what to do.
        PluginError: if a part does not exist or does not import.
    """
    file = _scenario_file(str(name_or_file))
    given = {**read_yaml(file, error=ScenarioError), **(changes or {})}
    data = {key: each for key, each in given.items() if each is not None}
    settings = list(settings)
    try:
        data = override(_spelt_out(data, settings), settings)
    except ConfigError as cause:
        raise ScenarioError(cause.problem, key=cause.key) from None
    data.setdefault("name", file.stem)
    scenario = validate(Scenario, data, file=file, error=ScenarioError)
    scenario._file = file
    _check_names(scenario, file)
    return scenario


def _spelt_out(data: Mapping[str, Any], settings: Sequence[str]) -> dict[str, Any]:
    """``data`` with the parts that a setting reaches into written as ``{use: …}``."""
    out = dict(data)
    for key in {setting.partition(".")[0].strip() for setting in settings} & PARTS.keys():
        out[key] = spelt_out(out.get(key, PARTS[key][1]))
    people = out.get("people", {})
    if isinstance(people, Mapping) and any(s.startswith("people.model.") for s in settings):
        out["people"] = {**people, "model": spelt_out(people.get("model", WALKERS))}
    return out


def _check_names(scenario: Scenario, file: Path) -> None:
    """Refuse a floor or a robot that does not exist."""
    if scenario.floor is not None:
        try:
            floor_file(scenario.floor)
        except ScenarioError as cause:
            raise ScenarioError(cause.problem, file=file, key="floor") from None
    robot_of(scenario)


def robot_of(scenario: Scenario) -> Robot:
    """The scenario's robot.

    Raises:
        ConfigError: see :func:`~cohelm.robots.load_robot`.
    """
    beside = scenario.beside(scenario.robot)
    return load_robot(beside if beside.is_file() else scenario.robot)


def _scenario_file(text: str) -> Path:
    names = scenario_names()
    if text in names:
        return Path(str(_shipped("scenarios") / f"{text}.yaml"))
    if text.endswith((".yaml", ".yml")) or "/" in text:
        return Path(text)
    raise ScenarioError(
        f"no scenario is called {text!r}{nearest(text, names)} (or give a .yaml file)"
    )


def _shipped(folder: str) -> Any:
    return files("cohelm.evaluation") / folder
