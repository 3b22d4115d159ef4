"""Version of everything that decides the result of a ride: sources, libraries, Python."""

from __future__ import annotations

import hashlib
import platform
from collections.abc import Iterator, Mapping
from functools import cache
from importlib.metadata import entry_points, version
from importlib.util import find_spec
from pathlib import Path

LIBRARIES = ("cohelm", "daqp", "numba", "numpy", "opencv-python-headless", "scipy")
"""Libraries whose versions decide the numbers."""
_OUTPUT_ONLY = ("cli", "evaluation/report", "live", "plotting", "web")
"""Parts of the package that do not affect a row of results."""
_NOT_NAVIGATION = (
    "benchmarks", "cli", "evaluation", "plotting", "recordings", "scenarios", "simulation",
    "testing",
)  # fmt: skip
"""Parts of the package that do not affect a command for given observations."""
_DIGITS = 16


@cache
def code() -> Mapping[str, str]:
    """Source file or library → its digest or version, with the packages of installed parts."""
    out = {name: version(name) for name in LIBRARIES} | {"python": platform.python_version()}
    for package in ("cohelm", *sorted(_part_packages())):
        spec = find_spec(package)
        if spec is None or not spec.origin:
            continue
        file = Path(spec.origin)
        is_package = spec.submodule_search_locations is not None
        for each in _sources(file.parent) if is_package else [file]:
            name = each.relative_to(file.parent).as_posix()
            if not (package == "cohelm" and name.startswith(_OUTPUT_ONLY)):
                out[f"{package}/{name}"] = digest(each.read_bytes())
    return out


def code_digest() -> str:
    """Digest of :func:`code`."""
    lines = [f"{name}={each}" for name, each in sorted(code().items())]
    return digest("\n".join(lines).encode())


def navigation_versions() -> Mapping[str, str]:
    """Versions of the libraries, and a digest of the code that makes a command of observations."""
    known = code()
    ours = [f"{name}={known[name]}" for name in sorted(known) if _is_navigation(name)]
    return {name: known[name] for name in (*LIBRARIES, "python")} | {
        "code": digest("\n".join(ours).encode())
    }


def differences(one: Mapping[str, str], other: Mapping[str, str], most: int = 3) -> str:
    """Names with different values, the first few of them; empty: none."""
    names = sorted(name for name in {*one, *other} if one.get(name) != other.get(name))
    more = f" and {len(names) - most} more" if len(names) > most else ""
    return ", ".join(_difference(name, one, other) for name in names[:most]) + more


def digest(content: bytes) -> str:
    """First 16 hexadecimal digits of the SHA-256 of some bytes."""
    return hashlib.sha256(content).hexdigest()[:_DIGITS]


def _difference(name: str, one: Mapping[str, str], other: Mapping[str, str]) -> str:
    if "/" in name:
        return name
    return f"{name} {one.get(name, 'none')} → {other.get(name, 'none')}"


def _is_navigation(name: str) -> bool:
    package, slash, rest = name.partition("/")
    return bool(slash) and (package != "cohelm" or rest.partition("/")[0] not in _NOT_NAVIGATION)


def _part_packages() -> set[str]:
    """Top-level packages of installed parts other than cohelm's own."""
    points = entry_points()
    found = {
        point.module.partition(".")[0]
        for group in points.groups
        if group.startswith("cohelm.")
        for point in points.select(group=group)
    }
    return found - {"cohelm"}


def _sources(folder: Path) -> Iterator[Path]:
    for file in sorted(folder.rglob("*")):
        if file.suffix in {".py", ".yaml", ".yml", ".so"} and file.is_file():
            yield file
