"""What the documents say is so."""

import re
import shlex
from pathlib import Path

import pytest
import yaml

from cohelm.maps import read_places
from cohelm.plugins import GROUPS
from cohelm.robots import load_robot
from cohelm.scenarios import Scenario

PROJECT = Path(__file__).parent.parent
README = (PROJECT / "README.md").read_text(encoding="utf-8")
GUIDES = [
    (PROJECT / f"docs/{name}.md").read_text(encoding="utf-8")
    for name in ("global-planning", "perception")
]
ARCHITECTURE = (PROJECT / "docs/architecture.md").read_text(encoding="utf-8")
DOCUMENTS = [
    *(PROJECT / name for name in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md")),
    *sorted((PROJECT / "docs").rglob("*.md")),
]


def name(file):
    return str(file.relative_to(PROJECT))


def yaml_block(file, folder):
    """The block of the README that is headed ``# file``, written to a folder."""
    block = re.search(rf"```yaml\n(# {re.escape(file)}\n.*?)```", README, flags=re.DOTALL)
    assert block
    written = folder / file
    written.write_text(block[1], encoding="utf-8")
    return written


@pytest.mark.parametrize("document", DOCUMENTS, ids=name)
def test_links_lead_somewhere(document):
    text = document.read_text(encoding="utf-8")
    for link in re.findall(r"\]\(([^)\s]+)\)", text):
        target, _, heading = link.partition("#")
        if target.startswith("http"):
            continue
        file = document.parent / target if target else document
        assert file.exists(), link
        if heading:
            headings = re.findall(r"^#+ (.*)$", file.read_text(encoding="utf-8"), flags=re.M)
            assert heading in {h.lower().replace(" ", "-") for h in headings}, link


def test_the_chair_of_the_readme_loads(tmp_path):
    assert load_robot(yaml_block("chair.yaml", tmp_path)).lasers[0].beams == 540


def test_the_places_of_the_readme_load(tmp_path):
    assert read_places(yaml_block("floor.places.yaml", tmp_path)).names == ("Cafeteria", "Ward 3")


def test_the_scenario_of_the_readme_is_one(tmp_path):
    data = yaml.safe_load(yaml_block("scenario.yaml", tmp_path).read_text(encoding="utf-8"))
    assert Scenario.model_validate(data).people.count == 15


def test_every_option_of_the_readme_and_of_the_guides_exists():
    from typer.main import get_command

    from cohelm.cli.app import app

    commands = get_command(app).commands
    lines = re.findall(r"^\.venv/bin/cohelm (.*)$", README, flags=re.M)
    lines += [line for guide in GUIDES for line in re.findall(r"^cohelm (.*)$", guide, flags=re.M)]
    assert lines
    for line in lines:
        name, *words = shlex.split(line.removesuffix("\\"), comments=True)
        command = commands[name]
        if hasattr(command, "commands"):  # a group: the next word says which
            command = command.commands[words.pop(0)]
        known = {option for p in command.params for option in p.opts}
        assert {word for word in words if word.startswith("--")} <= known


def test_every_make_target_that_is_named_exists():
    makefile = (PROJECT / "Makefile").read_text(encoding="utf-8")
    targets = set(re.findall(r"^([a-z-]+):", makefile, flags=re.M))
    for document in DOCUMENTS:
        text = document.read_text(encoding="utf-8")
        named = re.findall(r"(?:^|`)make ([a-z-]+)", text, flags=re.M)
        assert set(named) <= targets, document


def test_the_architecture_names_every_kind_of_part():
    assert [group for group in GROUPS if f"`{group}`" not in ARCHITECTURE] == []


def test_each_decision_has_its_number():
    numbers = [int(file.name[:4]) for file in (PROJECT / "docs/adr").glob("*.md")]
    assert len(numbers) == len({*numbers})
