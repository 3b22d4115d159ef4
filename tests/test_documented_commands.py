"""Each command of the documents is one that the program understands.

A command runs up to the point where its work would begin: options exist, values convert, the
scenarios, planners, robots, benchmarks and settings that it names are found. The listings run.
"""

import argparse
import copy
import functools
import inspect
import itertools
import re
import runpy
import shlex
import shutil
import sys
import tomllib
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
import yaml
from PIL import Image
from typer.main import get_command

from cohelm.cli import bench
from cohelm.cli.app import app, status
from cohelm.cli.bench_commands import BENCHES, command_of
from cohelm.evaluation.metrics.measures import MEASURES
from cohelm.evaluation.sweeps.ride_task import RideTask
from cohelm.maps import OccupancyGrid
from cohelm.recordings.outside_data import outside_file
from cohelm.scenarios import load_scenario

PROJECT = Path(__file__).parent.parent
DOCUMENTS = [
    PROJECT / "README.md",
    PROJECT / "CONTRIBUTING.md",
    *sorted((PROJECT / "docs").rglob("*.md")),
]
FENCED = re.compile(r"^```(\w*)\n(.*?)^```", flags=re.DOTALL | re.MULTILINE)
COMMAND = re.compile(r"(?:\.venv/bin/)?(?:cohelm|python|make) .*")
PLACEHOLDER = re.compile(r"…|\b[A-Z]{3,}\b(?!=)")


class WorkReached(Exception):
    """The command was understood; a ride, a server or a benchmark would begin."""


def stop(*given, **options):
    raise WorkReached


def shell_lines(text):
    """Command lines of the blocks, fenced ones and indented ones."""
    fenced = [body for kind, body in FENCED.findall(text) if kind in {"", "sh"}]
    rest = FENCED.sub("", text)
    indented = [m[1] for m in re.finditer(r"^    (\S.*)$", rest, flags=re.MULTILINE)]
    lines = [line for body in fenced for line in body.replace("\\\n", " ").splitlines()]
    return [line.strip() for line in (*lines, *indented) if COMMAND.match(line.strip())]


def quoted(text):
    """Commands within sentences; the ones with a value are complete."""
    spans = re.findall(r"`([^`]+)`", FENCED.sub("", text))
    return [" ".join(span.split()) for span in spans if COMMAND.match(span)]


def is_complete(line):
    return bool(re.search(r" --\S+[ =][^-\s]", line)) and not PLACEHOLDER.search(line)


def name(file):
    return str(file.relative_to(PROJECT))


def words_of(line):
    """Words of a command without its comment, and without the program that it is piped to."""
    program, *words = shlex.split(line, comments=True)
    words = words[: words.index("|")] if "|" in words else words
    return (Path(program).name, *words)


TEXTS = [document.read_text(encoding="utf-8") for document in DOCUMENTS]
COMMANDS = sorted(
    {words_of(line) for text in TEXTS for line in shell_lines(text) if not PLACEHOLDER.search(line)}
    | {words_of(line) for text in TEXTS for line in quoted(text) if is_complete(line)}
)


def draw_map(file):
    """A room of 100 × 60 m around the origin, with a named place."""
    pixels = np.full((300, 500), 254, dtype=np.uint8)
    pixels[[0, -1]] = 0
    pixels[:, [0, -1]] = 0
    file.parent.mkdir(parents=True, exist_ok=True)
    Image.fromarray(pixels).save(file.with_suffix(".png"))
    file.write_text(
        f"image: {file.stem}.png\nresolution: 0.2\norigin: [-60.0, -20.0, 0.0]\nnegate: 0\n"
        "occupied_thresh: 0.65\nfree_thresh: 0.196\n"
    )


@pytest.fixture(scope="module")
def reader_s_folder(tmp_path_factory):
    """The files that the commands name: those of the documents' blocks, maps, a film."""
    folder = tmp_path_factory.mktemp("reader")
    for text in TEXTS:
        for _, body in FENCED.findall(text):
            if headed := re.match(r"# ([\w.-]+\.(?:yaml|py))\b", body):
                (folder / headed[1]).write_text(body, encoding="utf-8")
    (folder / "my_chair.yaml").write_text((folder / "chair.yaml").read_text())
    for name in ("floor", "ward", "utexas_gdc_3ne", "benches/paper-global/scenes/2-map"):
        draw_map(folder / f"{name}.yaml")
    draw_map(folder / "floors" / "level-1.yaml")
    (folder / "floors" / "level-1.places.yaml").write_text(
        "A101 Foyer: [2, 3]\nA102 Living Room: [20, 8]\n"
    )
    if film := outside_file("pedestrians", "zara01_obsmat.txt"):
        shutil.copy(film, folder / "my_obsmat.txt")
    return folder


@pytest.fixture(scope="module")
def commands():
    return get_command(app)


@functools.cache
def loaded(scenario, settings):
    return load_scenario(scenario, settings)


@functools.cache
def parsed(text, loader, read=yaml.load):
    return read(text, Loader=loader)


@pytest.fixture
def stopped(monkeypatch, commands, reader_s_folder, tmp_path):
    """Every command ends where its work would begin; its files are the reader's."""
    monkeypatch.chdir(reader_s_folder)
    monkeypatch.syspath_prepend(reader_s_folder)
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    grid = OccupancyGrid(data=np.zeros((9, 9), dtype=np.int8), resolution=1.0, X_MG=np.zeros(3))
    for name, stand_in in {
        "cohelm.cli.app.app": commands,  # converted once
        "cohelm.cli.run._simulated": stop,
        "cohelm.cli.people.open_recording": stop,
        "cohelm.cli.ground.open_recording": stop,
        "cohelm.cli.building.read_building": stop,
        "cohelm.cli.drive.drive_building": stop,
        "cohelm.cli.building_route.read_storeys": stop,
        "cohelm.cli.compile_kernels.compile_all": stop,
        "cohelm.cli.web_server.read_page": dict,
        "cohelm.cli.web_server.serve_ride": stop,
        "cohelm.cli.web_server.show_recording": stop,
        "cohelm.ros2.checking.take_map": lambda parameters: grid,
        "cohelm.ros2.checking.check": stop,
        "cohelm.cli.replay.RecordedRide": stop,
        "cohelm.cli.compare.read_rides": stop,
        "cohelm.cli.bench.bench": prepare_bench,
    }.items():
        module, _, attribute = name.rpartition(".")
        monkeypatch.setattr(import_module(module), attribute, stand_in)
    # A benchmark loads the same files and scenarios for each of its hundreds of rides.
    monkeypatch.setattr(yaml, "load", lambda text, Loader: copy.deepcopy(parsed(text, Loader)))
    monkeypatch.setattr(RideTask, "load", lambda task: loaded(task.scenario, task.settings))
    monkeypatch.setattr(argparse.ArgumentParser, "parse_args", parse_and_stop)


def prepare_bench(name, module, request):
    """Create the benchmark where its options name anything; try settings of rides on a scenario."""
    create = bench.create_of(module)
    usual = {key: each.default for key, each in inspect.signature(create).parameters.items()}
    given = {key: each for key, each in request.options.items() if each != usual[key]}
    if not all(isinstance(value, bool) for value in given.values()):
        create(**request.options)
    function = create.func if isinstance(create, functools.partial) else create
    if function.__annotations__.get("settings") == "Settings":
        loaded("crossing", request.options["settings"])
    raise WorkReached


def parse_and_stop(parser):
    parser.parse_known_args()
    raise WorkReached


def check_cohelm(words, capsys):
    command, *rest = words
    if command == "compare" and "--measures" in rest:
        named = rest[rest.index("--measures") + 1].split(",")
        assert set(named) <= set(MEASURES)
    if command == "replay":
        load_scenario("crossing", [b for a, b in itertools.pairwise(rest) if a == "--set"])
    try:
        code = status(words)
    except WorkReached:
        return
    said = capsys.readouterr().err
    if "COHELM_DATA" in said or ("my_obsmat.txt" in words and outside_file("pedestrians") is None):
        pytest.skip("needs outside data")
    nothing_to_apply = words[:2] == ["map-changes", "apply"]
    assert code == (1 if nothing_to_apply else 0), said


def check_python(words, monkeypatch):
    script = PROJECT / words[0]
    assert script.is_file()
    if "argparse" in script.read_text(encoding="utf-8"):
        monkeypatch.setattr(sys, "argv", words)
        monkeypatch.syspath_prepend(script.parent)
        with pytest.raises(WorkReached):
            runpy.run_path(str(script), run_name="__main__")


def check_make(words, capsys):
    makefile = (PROJECT / "Makefile").read_text(encoding="utf-8")
    target, *variables = words
    assert re.search(rf"^{target}:", makefile, flags=re.MULTILINE)
    for name, _, value in (each.partition("=") for each in variables):
        assert re.search(rf"^{name} \?=", makefile, flags=re.MULTILINE)
        if name == "DRIVE":
            check_cohelm(["drive", *shlex.split(value)], capsys)


@pytest.mark.parametrize("command", COMMANDS, ids=shlex.join)
def test_a_documented_command_is_understood(command, stopped, monkeypatch, capsys):
    program, *words = command
    if program == "make":
        check_make(words, capsys)
    elif program == "python":
        check_python(words, monkeypatch)
    else:
        check_cohelm(words, capsys)


@pytest.mark.parametrize("document", DOCUMENTS, ids=name)
def test_mentioned_commands_and_their_options_exist(document, commands):
    text = document.read_text(encoding="utf-8")
    for line in (*shell_lines(text), *quoted(text)):
        program, *words = words_of(line)
        if program != "cohelm":
            continue
        command = commands
        while words and words[0] in getattr(command, "commands", {}):
            word = words.pop(0)
            is_bench = command.name == "bench"  # whose commands are made when they are called
            command = command_of(word, *BENCHES[word]) if is_bench else command.commands[word]
        if words and words[0].endswith(".py"):  # a reader's study, prepared above
            continue
        assert command.name != "cohelm", line
        known = {option for p in command.params for option in p.opts} | {"--help"}
        assert {word.partition("=")[0] for word in words if word.startswith("--")} <= known, line


@pytest.mark.parametrize("document", DOCUMENTS, ids=name)
def test_named_scripts_targets_and_extras_exist(document):
    text = document.read_text(encoding="utf-8")
    scripts = re.findall(r"(?<![\w/])((?:benchmarks|docs/figures|examples|src)/[\w/]+\.py)\b", text)
    assert [each for each in scripts if not (PROJECT / each).is_file()] == []
    makefile = (PROJECT / "Makefile").read_text(encoding="utf-8")
    targets = re.findall(r"(?:^|`)make ([a-z-]+)", text, flags=re.MULTILINE)
    assert set(targets) <= set(re.findall(r"^([a-z-]+):", makefile, flags=re.MULTILINE))
    project = tomllib.loads((PROJECT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    extras = {
        name for group in re.findall(r"cohelm\[([\w,]+)\]", text) for name in group.split(",")
    }
    assert extras <= set(project["optional-dependencies"])
