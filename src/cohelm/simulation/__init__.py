"""The simulator: world, pedestrians, sensors and riders. It never imports the navigator."""

from cohelm.simulation.api import Crowd, CrowdScene, PedestrianModel, Rider, RiderAct, RiderView
from cohelm.simulation.crowds import (
    Aggressive,
    Distracted,
    Inattentive,
    Orca,
    SocialForce,
    TurningBack,
    prepare_crowd,
)
from cohelm.simulation.dynamic_objects import ManualDoor, MapChange
from cohelm.simulation.faults import FAULT_KINDS, Fault, FaultKind
from cohelm.simulation.floor_relief import FLAT, FloorRelief, ThresholdEdge
from cohelm.simulation.ground_truth import GroundTruth, Touch, is_standing
from cohelm.simulation.random_streams import generator
from cohelm.simulation.riders import (
    Biased,
    Delayed,
    Dropout,
    EightDirections,
    Ideal,
    Idle,
    Laggy,
    LookingAway,
    Noisy,
    NoRider,
    Nudge,
    OneSwitch,
    Reluctant,
    Tremor,
    Uncooperative,
    Watchful,
)
from cohelm.simulation.sensors import Localisation, Odometry
from cohelm.simulation.simulated_chair import Contacts, CrowdStep, PlanarChair, SimulatedChair
from cohelm.simulation.spawning import NewPedestrian
from cohelm.simulation.split_knowledge import GoalChange, SplitCells, with_cells
from cohelm.simulation.world import World
from cohelm.simulation.world_setup import WorldSetup

__all__ = [
    "FAULT_KINDS",
    "FLAT",
    "Aggressive",
    "Biased",
    "Contacts",
    "Crowd",
    "CrowdScene",
    "CrowdStep",
    "Delayed",
    "Distracted",
    "Dropout",
    "EightDirections",
    "Fault",
    "FaultKind",
    "FloorRelief",
    "GoalChange",
    "GroundTruth",
    "Ideal",
    "Idle",
    "Inattentive",
    "Laggy",
    "Localisation",
    "LookingAway",
    "ManualDoor",
    "MapChange",
    "NewPedestrian",
    "NoRider",
    "Noisy",
    "Nudge",
    "Odometry",
    "OneSwitch",
    "Orca",
    "PedestrianModel",
    "PlanarChair",
    "Reluctant",
    "Rider",
    "RiderAct",
    "RiderView",
    "SimulatedChair",
    "SocialForce",
    "SplitCells",
    "ThresholdEdge",
    "Touch",
    "Tremor",
    "TurningBack",
    "Uncooperative",
    "Watchful",
    "World",
    "WorldSetup",
    "generator",
    "is_standing",
    "prepare_crowd",
    "with_cells",
]
