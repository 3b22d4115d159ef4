"""Episodes of SocNavBench (Biswas et al. 2021, THRI): recorded people, start and goal of a robot.

``episodes.ini`` has a section for each episode, ``dataset_params.ini`` beside it one for each
recording: its file, frame rate, and transform to the frame of the map. A recording is a text of
four rows, a column for each sighting: frame, person, y and x, as SocNavBench reads them.
"""

from __future__ import annotations

import ast
from configparser import ConfigParser
from configparser import Error as IniError
from pathlib import Path
from typing import TypeVar

import numpy as np
from pydantic import Field

from cohelm.arrays import Floats, Integers
from cohelm.config import Model, nearest, validate
from cohelm.errors import ConfigError, RecordingError
from cohelm.geometry import transform
from cohelm.recordings.pedestrians.trajectories import Trajectories, trajectories_of

_M = TypeVar("_M", bound=Model)
Pose = tuple[float, float, float]
"""x, y, m, and heading, rad."""


class EpisodeSection(Model):
    """Section of an episode; simulated agents are not supported."""

    pedestrian_datasets: tuple[str, ...] = Field(min_length=1)
    datasets_start_t: tuple[float, ...]
    """Time of the first person of each recording, s."""
    ped_ranges: tuple[tuple[int, int], ...]
    """Ids of each recording: above the first number, up to the second; −1: to the last."""
    agents_start: tuple[Pose, ...] = Field((), max_length=0)
    robot_start_goal: tuple[Pose, Pose]
    max_time: float = Field(gt=0.0, le=3600.0)
    """s."""


class DatasetSection(Model):
    """Section of a recording."""

    file_name: str
    fps: float = Field(gt=0.0, le=1000.0)
    spawn_delay_s: float = 0.0
    offset: Pose
    swapxy: bool
    flipxn: bool
    flipyn: bool


def episode_names(file: Path) -> tuple[str, ...]:
    """Names of the episodes of a file, in its order.

    Raises:
        ConfigError: if it cannot be read or has none.
    """
    names = tuple(name for name in _ini(file).sections() if name != "episodes_params")
    if not names:
        raise ConfigError("has no section of an episode", file=file)
    return names


def read_episode(file: Path, name: str) -> tuple[Trajectories, EpisodeSection]:
    """Read an episode: its people, in the frame of the map and from time 0 on, and its section.

    Raises:
        ConfigError: naming file, section and key.
        RecordingError: if a recording is damaged.
    """
    episode = _section(file, name, EpisodeSection)
    sets = episode.pedestrian_datasets
    begins, spans = episode.datasets_start_t, episode.ped_ranges
    if not len(sets) == len(begins) == len(spans):
        text = "pedestrian_datasets, datasets_start_t and ped_ranges differ in length"
        raise ConfigError(text, file=file, key=name)
    ini = file.with_name("dataset_params.ini")
    parts = [_people(ini, *each) for each in zip(sets, begins, spans, strict=True)]
    if not any(len(who) for who, *_ in parts):
        raise ConfigError("selects no person", file=file, key=f"{name}.ped_ranges")
    firsts = np.cumsum([0, *(who.max(initial=0) + 1 for who, *_ in parts)])
    people = trajectories_of(
        name=name,
        step=min(step for *_, step in parts),
        who=np.concatenate([who + k for (who, *_), k in zip(parts, firsts, strict=False)]),
        time=np.concatenate([time for _, time, *_ in parts]),
        position=np.vstack([position for _, _, position, _ in parts]),
    )
    return people, episode


def _people(
    ini: Path, name: str, begin: float, span: tuple[int, int]
) -> tuple[Integers, Floats, Floats, float]:
    """Ids (k,), times (k,), s, positions (k, 2), m, and step, s, of the people of a recording."""
    dataset = _section(ini, name, DatasetSection)
    frame, number, across, along = _table(ini, name, dataset.file_name)
    who = number.astype(np.int64)
    # Time 0 is the first frame of the first person; without them that of the recording.
    first = frame[who == span[0] + 1]
    zero = first.min() if len(first) else frame.min()
    time = (frame - zero) / dataset.fps + dataset.spawn_delay_s + begin
    x, y = (-along if dataset.flipxn else along), (-across if dataset.flipyn else across)
    moved = transform(dataset.offset, np.column_stack([y, x] if dataset.swapxy else [x, y]))
    steps = np.diff(frame)[np.diff(who) == 0]
    chosen = (who > span[0]) & ((who <= span[1]) | (span[1] == -1))
    step = float(np.median(steps)) if len(steps) else 1.0
    return who[chosen], time[chosen], moved[chosen], step / dataset.fps


def _table(ini: Path, name: str, given: str) -> Floats:
    """Rows (4, k) of a recording, by person and in order of time.

    The file is as named, or beside the ini: ``eth.csv`` for ``eth/….csv``.
    """
    short = f"{Path(given).parent.name or name}.csv"
    found = [ini.with_name(each) for each in (short, f"{name}.csv", Path(given).name)]
    file = next((each for each in (ini.parent / given, *found) if each.is_file()), None)
    if file is None:
        raise ConfigError(f"neither {given} nor {short} exists", file=ini, key=f"{name}.file_name")
    try:
        table = np.loadtxt(file, delimiter=",", ndmin=2)
    except (OSError, ValueError) as cause:
        text = f"is not a table of numbers ({str(cause).splitlines()[0]})"
        raise RecordingError(text, file=file) from None
    if len(table) != 4 or not table.size or not np.isfinite(table).all():
        raise RecordingError("needs four rows of finite numbers: frame, person, y, x", file=file)
    table = table[:, np.lexsort((table[0], table[1]))]
    twice = (np.diff(table[0]) == 0.0) & (np.diff(table[1]) == 0.0)
    if twice.any():
        frame, who = table[:2, int(twice.argmax())]
        raise RecordingError(f"person {who:g} is in frame {frame:g} twice", file=file)
    return np.asarray(table)


def _section(file: Path, name: str, model: type[_M]) -> _M:
    """Validate a section; its values are Python literals, and other keys are of no concern."""
    sections = _ini(file)
    if name not in sections:
        raise ConfigError(f"no section is called {name!r}{nearest(name, sections)}", file=file)
    data: dict[str, object] = {}
    for key in model.model_fields.keys() & sections[name].keys():
        data[key] = sections[name][key]
        try:
            data[key] = ast.literal_eval(sections[name][key])
        except (SyntaxError, ValueError):
            continue  # text
    return validate(model, data, file=file, prefix=name)


def _ini(file: Path) -> ConfigParser:
    out = ConfigParser(inline_comment_prefixes=("#", ";"), interpolation=None)
    try:
        out.read_string(file.read_text(encoding="utf-8"), str(file))
    except (OSError, ValueError, IniError) as cause:
        text = getattr(cause, "strerror", None) or " ".join(str(cause).split())
        raise ConfigError(text, file=file) from None
    return out
