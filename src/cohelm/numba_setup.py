"""Settings of numba, made by ``cohelm/__init__`` before numba is imported.

numba shall find compiled kernels where :mod:`cohelm.kernel_cache` says, and compile for the CPU of
the kernels that a wheel brings along. Nothing here may be slow to import.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

LOCATORS = "NUMBA_CACHE_LOCATOR_CLASSES"
CPU_NAME, CPU_FEATURES = "NUMBA_CPU_NAME", "NUMBA_CPU_FEATURES"
"""Environment variables of numba."""
CPU = "x86-64-v3"
"""CPU for which the kernels in a wheel are compiled: most x86-64 since 2013 (Intel), 2015 (AMD)."""
_FEATURES = frozenset(("avx", "avx2", "bmi1", "bmi2", "f16c", "fma", "abm", "movbe", "xsave"))
"""The features of x86-64-v3 as Linux names them."""
MANIFEST = "compiled.txt"
"""File of a cache that holds every kernel a ride needs: :func:`manifest`, and a hash of the code.

A wheel with compiled kernels has it in the package.
"""


def prepare() -> None:
    """Set the environment variables that are not set.

    If numba was imported before cohelm, or a CPU is chosen already, that CPU is kept, and kernels
    in a wheel are not used.
    """
    os.environ.setdefault(LOCATORS, "cohelm.kernel_cache.KernelLocator")
    numba = sys.modules.get("numba")
    if numba is not None:
        numba.config.CACHE_LOCATOR_CLASSES = os.environ[LOCATORS]
    elif not {CPU_NAME, CPU_FEATURES} & set(os.environ) and has_matching_kernels():
        os.environ.update({CPU_NAME: CPU, CPU_FEATURES: ""})


def has_matching_kernels() -> bool:
    """Check that this is a wheel with kernels for this Python, numba and machine."""
    try:
        made_for = Path(__file__).with_name(MANIFEST).read_text(encoding="utf-8")
    except OSError:
        return False
    return CPU in made_for and made_for.startswith(manifest(CPU)) and _is_v3()


def manifest(cpu: str) -> str:
    """Return Python, numba, system and CPU, one line."""
    from importlib.metadata import version  # noqa: PLC0415 # slow to import

    python = f"{sys.implementation.name} {sys.version_info.major}.{sys.version_info.minor}"
    return f"{python}, numba {version('numba')}, {sys.platform} {os.uname().machine}, {cpu}\n"


def this_cpu() -> str:
    """Return the CPU for which kernels are compiled: the chosen one, or this machine's."""
    return os.environ.get(CPU_NAME) or _cpu_line("model name")


def _is_v3() -> bool:
    return set(_cpu_line("flags").split()) >= _FEATURES


def _cpu_line(name: str) -> str:
    """Return what Linux says of the first processor; empty if nothing."""
    try:
        with Path("/proc/cpuinfo").open(encoding="utf-8") as file:
            line = next(line for line in file if line.startswith(name))
    except (OSError, StopIteration):
        return ""
    return line.partition(":")[2].strip()
