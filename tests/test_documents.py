"""What the documents say is so."""

import re
from pathlib import Path

import pytest
import yaml

from cohelm.maps import read_places
from cohelm.plugins import GROUPS
from cohelm.robots import load_robot
from cohelm.scenarios import Scenario

PROJECT = Path(__file__).parent.parent
ARCHITECTURE = (PROJECT / "docs/architecture.md").read_text(encoding="utf-8")
DOCUMENTS = [
    *(PROJECT / name for name in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md")),
    *sorted((PROJECT / "docs").rglob("*.md")),
]


def name(file):
    return str(file.relative_to(PROJECT))


def yaml_block(guide, file, folder):
    """The block of a guide that is headed ``# file``, written to a folder."""
    text = (PROJECT / f"docs/{guide}.md").read_text(encoding="utf-8")
    block = re.search(rf"```yaml\n(# {re.escape(file)}\n.*?)```", text, flags=re.DOTALL)
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


def test_the_chair_of_the_guide_loads(tmp_path):
    assert load_robot(yaml_block("your-robot", "chair.yaml", tmp_path)).lasers[0].beams == 540


def test_the_places_of_the_guide_load(tmp_path):
    assert read_places(yaml_block("scenarios", "floor.places.yaml", tmp_path)).names == (
        "Cafeteria",
        "Ward 3",
    )


def test_the_scenario_of_the_guide_is_one(tmp_path):
    data = yaml.safe_load(
        yaml_block("scenarios", "scenario.yaml", tmp_path).read_text(encoding="utf-8")
    )
    assert Scenario.model_validate(data).people.count == 15


def test_the_architecture_names_every_kind_of_part():
    assert [group for group in GROUPS if f"`{group}`" not in ARCHITECTURE] == []


def test_each_decision_has_its_number():
    numbers = [int(file.name[:4]) for file in (PROJECT / "docs/adr").glob("*.md")]
    assert len(numbers) == len({*numbers})
