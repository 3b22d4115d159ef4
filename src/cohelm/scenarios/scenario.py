"""Scenario files: one strict YAML file describes floor, start, goal, people and parts.

    description: …              a sentence for ``cohelm scenarios``
    floor: hospital             or  map: file.yaml (Nav2 map_server YAML)
    start: Entrance             a named place, [x, y] or [x, y, degrees]
    goal: Ward 3                a named place or [x, y]
    prefer: [[20, 8]]           via points; avoid: zones; stroke: a line to follow
    people: {count: 12}         and explicit routes, speeds, whether they see the robot
    obstacles: [{at: [5, 3], radius: 0.3, height: 0.9}]           in the world, not on the map
    doors: [{at: [13, 3], size: [0.1, 2.6], closed: [[6, 60]]}]   in the world, not on the map
    world_plan: {doors: {0: {at: [8, 3]}}}     what the world's drawing has and the map's lacks
    rider_plan: {past: [[7, 12]]}              what the rider wants and the chair does not know
    filters: [{type: keepout, file: mask.yaml}]                   and speed limits
    floor_plan: {corridors: {Hallway: {width: 1.5}}}              changes to the floor's drawing
    local_planner: ss_mpc_dcbf  or {use: ss_mpc_dcbf, steps: 30}; so for every part

An unknown key is refused with its file, its dotted key and the nearest known one. All keys but
``start``, ``goal`` and the floor have defaults.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from importlib.resources import files
from pathlib import Path
from typing import Annotated, Any, Self

from pydantic import BeforeValidator, Field, PrivateAttr, model_serializer, model_validator

from cohelm.config import Model, nearest, override, read_yaml, validate
from cohelm.errors import ConfigError, ScenarioError
from cohelm.health import HealthParameters
from cohelm.maps import MAX_COORDINATE
from cohelm.messages import Mode, RiderProfile
from cohelm.navigation import (
    DestinationParameters,
    ProgressParameters,
    RecoveryParameters,
    ReplanningParameters,
)
from cohelm.perception import ChangeDetectionParameters, ObstacleLayerParameters
from cohelm.planning import ComfortLimits
from cohelm.plugins import Spec, spelt_out
from cohelm.robots import Robot, load_robot
from cohelm.safety import GateParameters
from cohelm.scenarios.collection import Collection
from cohelm.scenarios.objects import Mask, Obstacle, Preferred, ScheduledDoor, Storey, Zone
from cohelm.scenarios.pedestrian_spec import PEDESTRIAN_MODEL, CrowdSpec, Point, part_field
from cohelm.scenarios.rider_plan import RiderPlan
from cohelm.sharing import AuthorityParameters, SteeringParameters, YieldingParameters
from cohelm.simulation import Fault, Localisation, Odometry

PLATFORM = "planar"
"""Default platform."""
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
"""Replaceable parts: key of the scenario → (kind of plugin, default plugin)."""
NAVIGATOR_PARTS = tuple(key for key in PARTS if key != "rider")
"""Parts of the navigator."""
NAVIGATOR_PARAMETERS = (
    "change_detection",
    "obstacle_layer",
    "authority",
    "steering",
    "yielding",
    "destinations",
    "replanning",
    "progress",
    "recovery",
    "gate",
    "health",
    "comfort",
)
"""Parameter sets of the navigator, under the same names in a scenario."""


def _pose_or_place(given: Any) -> Any:
    if isinstance(given, str) and given:
        return given
    numbers = isinstance(given, list | tuple) and len(given) in {2, 3}
    if numbers and all(isinstance(x, int | float) and not isinstance(x, bool) for x in given):
        if all(abs(x) <= MAX_COORDINATE for x in given):
            return tuple(float(x) for x in given)
        raise ValueError(f"must lie within {MAX_COORDINATE:g} m of (0, 0)")
    raise ValueError("write the name of a place, [x, y] or [x, y, degrees]")


PoseOrPlace = Annotated[str | tuple[float, float, float] | Point, BeforeValidator(_pose_or_place)]


class Scenario(Model):
    """Everything that defines a ride except the seed; see the module's docstring."""

    name: str = ""
    platform: Spec = part_field(PLATFORM)
    """Chair that drives: the simulation, or a real one."""
    description: str = ""
    collection: Collection = Collection.OWN
    """Heading of the listing."""
    floor: str | None = None
    """Name of a floor that comes with cohelm."""
    map: str | None = None
    """A map_server YAML file, relative to the scenario's folder."""
    floor_plan: dict[str, Any] = Field(default_factory=dict)
    """Changes to the floor's drawing, with the keys of its file; a number is an index of a list."""
    world_plan: dict[str, Any] = Field(default_factory=dict)
    """Changes to the drawing in the world alone, as ``floor_plan``: the map lacks them."""
    start: PoseOrPlace
    goal: PoseOrPlace
    prefer: tuple[Preferred, ...] = ()
    """Via points that attract the route, m; several in one entry are visited in order."""
    stroke: tuple[Point, ...] = ()
    """Line for the route to follow, m."""
    avoid: tuple[Zone, ...] = ()
    """Zones to avoid."""
    robot: str = "quantum_q6_edge"
    """Name of a robot, or a YAML file, relative to the scenario's folder."""
    mode: Mode = Mode.SHARED
    rider: Spec = part_field(PARTS["rider"][1])
    rider_goal: PoseOrPlace | None = None
    """Destination of the rider; None: the goal of the chair."""
    rider_route: tuple[Point, ...] = ()
    """Waypoints of the rider's own route, m; empty: the route of the chair where both have the same
    destination, else a route planned without wishes."""
    rider_plan: RiderPlan | None = None
    """Knowledge and wishes of the rider that the chair lacks; arriving then counts where the rider
    wants to be."""
    profile: RiderProfile = RiderProfile()
    people: CrowdSpec = CrowdSpec()
    companion: int | None = Field(None, ge=0)
    """Index of the pedestrian whom the chair accompanies, from 0: for ``side_by_side_share``."""
    obstacles: tuple[Obstacle, ...] = ()
    storey: Storey = Storey()
    """Walls and ceiling."""
    doors: tuple[ScheduledDoor, ...] = ()
    """Doors that close in the world and are open on the map."""
    filters: tuple[Mask, ...] = ()
    """Keepout zones and speed limits."""
    crowding: str | None = None
    """Heat map of known crowds: a map_server YAML file, relative to the scenario's folder."""
    global_planner: Spec = part_field(PARTS["global_planner"][1])
    local_planner: Spec = part_field(PARTS["local_planner"][1])
    detector: Spec = part_field(PARTS["detector"][1])
    cloud_detector: Spec = part_field(PARTS["cloud_detector"][1])
    tracker: Spec = part_field(PARTS["tracker"][1])
    group_detector: Spec = part_field(PARTS["group_detector"][1])
    predictor: Spec = part_field(PARTS["predictor"][1])
    social_model: Spec = part_field(PARTS["social_model"][1])
    change_detection: ChangeDetectionParameters = ChangeDetectionParameters()
    obstacle_layer: ObstacleLayerParameters = ObstacleLayerParameters()
    authority: AuthorityParameters = AuthorityParameters()
    steering: SteeringParameters = SteeringParameters()
    yielding: YieldingParameters = YieldingParameters()
    destinations: DestinationParameters = DestinationParameters()
    replanning: ReplanningParameters = ReplanningParameters()
    progress: ProgressParameters = ProgressParameters()
    recovery: RecoveryParameters = RecoveryParameters()
    gate: GateParameters = GateParameters()
    health: HealthParameters = HealthParameters()
    comfort: ComfortLimits = ComfortLimits()
    localisation: Localisation = Localisation()
    odometry: Odometry = Odometry()
    faults: tuple[Fault, ...] = ()
    """Faults to inject, with their times."""
    time_limit: float = Field(180.0, ge=0.05, le=3600.0)
    """Longest simulated time, s; at least one control step."""
    standing_limit: float = Field(20.0, gt=0.0, le=3600.0)
    """Longest time of standing before the ride ends as stopped, s."""
    seed: int = Field(0, ge=0)
    """Default seed."""

    _file: Path | None = PrivateAttr(default=None)

    @model_serializer(mode="wrap")
    def _without_defaults(self, serialize: Any) -> dict[str, Any]:
        """Omit keys without content: their presence must not change a configuration hash."""
        out: dict[str, Any] = serialize(self)
        absent: dict[str, Any] = {
            "world_plan": {},
            "rider_plan": None,
            "platform": {"use": PLATFORM},
        }
        if self.health == HealthParameters():
            out.pop("health", None)
        return {k: each for k, each in out.items() if k not in absent or each != absent[k]}

    @model_validator(mode="after")
    def _one_floor_and_whole_strokes(self) -> Self:
        if (self.floor is None) == (self.map is None):
            raise ValueError("give either floor: NAME or map: FILE.yaml")
        if self.world_plan and self.floor is None:
            raise ValueError("world_plan needs floor: NAME")
        if len(self.stroke) == 1:
            raise ValueError("a stroke needs two points or more")
        return self

    @property
    def file(self) -> Path | None:
        """File it was read from, for error messages."""
        return self._file

    def in_file(self, file: Path) -> Scenario:
        """Copy whose errors name another file, beside which its own files are looked for."""
        copy = self.model_copy()
        copy._file = file
        return copy

    def beside(self, file: str) -> Path:
        """Path of a file that the scenario names, relative to the scenario's folder."""
        return self._file.parent / file if self._file is not None else Path(file)


def scenario_names() -> tuple[str, ...]:
    """Names of the scenarios that come with cohelm."""
    return tuple(
        sorted(
            f.name.removesuffix(".yaml")
            for f in _shipped("library").iterdir()
            if f.name.endswith(".yaml")
        )
    )


def floor_file(name: str) -> Path:
    """File of a floor that comes with cohelm.

    Raises:
        ScenarioError: naming the nearest floor that exists.
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
    """Load a scenario by its name or from a file.

    Args:
        name_or_file: one of :func:`scenario_names`, or a YAML file.
        settings: ``dotted.key=value``, applied last; values are read as YAML.
        changes: top-level keys to replace before; None removes a key.

    Raises:
        ScenarioError: naming file, dotted key and remedy.
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
    """``data`` with every part that a setting changes written as ``{use: …}``."""
    out = dict(data)
    for key in {setting.partition(".")[0].strip() for setting in settings} & PARTS.keys():
        out[key] = spelt_out(out.get(key, PARTS[key][1]))
    people = out.get("people", {})
    if isinstance(people, Mapping) and any(s.startswith("people.model.") for s in settings):
        out["people"] = {**people, "model": spelt_out(people.get("model", PEDESTRIAN_MODEL))}
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
        return Path(str(_shipped("library") / f"{text}.yaml"))
    if text.endswith((".yaml", ".yml")) or "/" in text:
        return Path(text)
    raise ScenarioError(
        f"no scenario is called {text!r}{nearest(text, names)} (or give a .yaml file)"
    )


def _shipped(folder: str) -> Any:
    return files("cohelm.scenarios") / folder
