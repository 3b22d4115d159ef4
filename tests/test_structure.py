"""The shape of the project itself."""

import ast
import functools
import importlib
import itertools
import pkgutil
import sys
import tomllib
from pathlib import Path

import pytest

import cohelm
from cohelm import plugins

SOURCE = Path(cohelm.__file__).parent
PROJECT = Path(__file__).parent.parent
FILES = sorted(SOURCE.rglob("*.py"))
MODULES = sorted(
    module.name
    for module in pkgutil.walk_packages([str(SOURCE)], "cohelm.")
    if not module.name.endswith("__main__")
)


@functools.cache
def trees():
    return {file: ast.parse(file.read_text(encoding="utf-8")) for file in FILES}


def relative(file):
    return str(file.relative_to(SOURCE))


def test_every_module_imports_and_keeps_what_it_promises():
    for name in MODULES:
        module = importlib.import_module(name)
        assert module.__doc__, name
        promised = getattr(module, "__all__", [])
        assert [each for each in promised if not hasattr(module, each)] == [], name
        assert len(promised) == len(set(promised)), name


@pytest.mark.parametrize(
    ("group", "name"), [(group, name) for group in plugins.GROUPS for name in plugins.names(group)]
)
def test_every_entry_point_loads(group, name):
    part = plugins.load(group, name)
    assert part.__doc__
    assert part(part.Parameters()) is not None


def test_every_group_of_entry_points_is_a_known_kind():
    declared = tomllib.loads((PROJECT / "pyproject.toml").read_text(encoding="utf-8"))
    groups = declared["project"]["entry-points"]
    assert {group.removeprefix("cohelm.") for group in groups} == set(plugins.GROUPS)


BUDGET = {
    "benchmarks": (12875, 65),
    "buildings": (4500, 19),
    "cli": (5450, 33),
    "control": (8625, 55),
    "evaluation": (8400, 54),
    "health": (2225, 13),
    "live": (10050, 61),
    "maps": (1700, 10),
    "messages": (675, 8),
    "navigation": (4825, 34),
    "perception": (7850, 46),
    "planning": (7650, 48),
    "platforms": (3125, 22),
    "plotting": (2400, 14),
    "recordings": (4175, 29),
    "robots": (1850, 15),
    "ros2": (3075, 16),
    "safety": (450, 3),
    "scenarios": (2200, 12),
    "sharing": (1675, 10),
    "simulation": (7300, 49),
    "social": (300, 4),
    "testing": (2075, 14),
    "web": (2425, 18),
    "": (2425, 17),
}
"""Package → (lines, files) at most; "" is the root. Who raises a number says why in the commit."""
LONGEST = 600
"""Lines of a file; longer ones are read in parts."""


@pytest.mark.parametrize("package", BUDGET)
def test_a_package_keeps_its_budget(package):
    folder = SOURCE / package
    files = list(folder.rglob("*.py") if package else folder.glob("*.py"))
    lines = [len(file.read_text(encoding="utf-8").splitlines()) for file in files]
    most, count = BUDGET[package]
    assert sum(lines) <= most
    assert len(files) <= count
    assert max(lines) <= LONGEST


KERNELS = 535
"""Compiled functions at most: each costs most of a second at a first start, and some of each start
of a process. ``cohelm compile --profile`` tells which are dear."""


def is_kernel(node):
    decorators = [ast.unparse(each) for each in getattr(node, "decorator_list", ())]
    return any("njit" in each or "callee" in each for each in decorators)


def test_kernels_do_not_multiply():
    assert sum(is_kernel(node) for tree in trees().values() for node in ast.walk(tree)) <= KERNELS


def test_every_package_has_a_budget():
    assert {file.relative_to(SOURCE).parts[0] for file in FILES if file.parent != SOURCE} == {
        *BUDGET
    } - {""}


def test_an_init_only_says_what_it_exports():
    allowed = ast.Import | ast.ImportFrom | ast.Expr | ast.Assign | ast.AnnAssign
    others = [
        relative(file)
        for file, tree in trees().items()
        if file.name == "__init__.py" and not all(isinstance(each, allowed) for each in tree.body)
    ]
    assert others == []


def test_only_a_compiled_function_takes_more_than_six_positional_arguments():
    many = [
        (relative(file), each.name)
        for file, tree in trees().items()
        for each in ast.walk(tree)
        if isinstance(each, ast.FunctionDef | ast.AsyncFunctionDef)
        and len({arg.arg for arg in each.args.args} - {"self", "cls"}) > 6
        and not is_kernel(each)
    ]
    assert many == []


def test_no_drawer_for_odds_and_ends():
    drawers = {"utils", "util", "helpers", "helper", "misc", "common"}
    assert [relative(file) for file in FILES if file.stem in drawers] == []


def test_every_package_has_its_tests():
    packages = {f.parent.name for f in SOURCE.glob("*/__init__.py")}
    tested = {folder.name for folder in (PROJECT / "tests").iterdir() if folder.is_dir()}
    assert packages <= tested


IMPORTED_AS = {
    "lazy-loader": "lazy_loader",
    "opencv-python-headless": "cv2",
    "pillow": "PIL",
    "pyyaml": "yaml",
    "scikit-learn": "sklearn",
}


def imports(file):
    """The top-level names that a file imports, wherever in it."""
    for node in ast.walk(trees()[file]):
        if isinstance(node, ast.Import):
            yield from (alias.name.partition(".")[0] for alias in node.names)
        if isinstance(node, ast.ImportFrom) and node.module and not node.level:
            yield node.module.partition(".")[0]


def test_what_is_imported_is_what_is_declared():
    """Nothing that a plain installation lacks, and nothing declared that nobody needs."""
    project = tomllib.loads((PROJECT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    names = [dependency.split(">=")[0] for dependency in project["dependencies"]]
    declared = {IMPORTED_AS.get(name, name) for name in names}
    extras = {  # these say that they need one
        SOURCE / "testing" / "strategies.py",
        SOURCE / "evaluation" / "report" / "store.py",
        SOURCE / "cli" / "web_server.py",
        SOURCE / "simulation" / "crowds" / "jupedsim_models.py",
        *(SOURCE / "buildings").glob("*.py"),
        *(SOURCE / "web").glob("*.py"),
        *(SOURCE / "ros2").glob("*.py"),
        *(SOURCE / "platforms" / "luci").glob("*.py"),
        *(SOURCE / "platforms" / "twin").glob("*.py"),
    }
    used = {name for file in FILES if file not in extras for name in imports(file)}
    assert used - set(sys.stdlib_module_names) - {"cohelm"} == declared


def test_the_lock_names_versions_only():
    """No address, no path and no option of the machine that made it."""
    for line in (PROJECT / "requirements.lock").read_text(encoding="utf-8").splitlines():
        assert line.startswith("#") or line.count("==") == 1
        assert "/" not in line
        assert " " not in line or line.startswith("#")


def test_the_lock_holds_every_dependency():
    project = tomllib.loads((PROJECT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    extras = project["optional-dependencies"].values()
    wanted = [*project["dependencies"], *itertools.chain.from_iterable(extras)]
    names = {name.split(">=")[0].lower() for name in wanted if not name.startswith("cohelm")}
    locked = (PROJECT / "requirements.lock").read_text(encoding="utf-8").splitlines()
    assert names <= {line.split("==")[0] for line in locked}
