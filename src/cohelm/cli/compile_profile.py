"""``cohelm compile --profile``: what compiling each kernel takes."""

from __future__ import annotations

import os
import tempfile
import time
from collections.abc import Callable
from typing import Any

from numba.core import event
from numba.core.codegen import CPUCodeLibrary

from cohelm import kernel_cache
from cohelm.cli.compile_kernels import CompileBar
from cohelm.cli.report import OUTPUT, plain_table

_DEAREST = 30
"""Number of kernels in the table."""


def profile() -> int:
    """Compile everything in this process into an empty cache; print the CPU time by kernel.

    Returns 0.
    """
    with tempfile.TemporaryDirectory(prefix="cohelm-") as folder:
        os.environ[kernel_cache.FOLDER] = folder  # of this process, which ends with the table
        kernel_cache.place.cache_clear()
        from cohelm.live import compilation  # its kernels ask for the folder now

        times = _CompileTimes()
        with CompileBar(kernel_cache.CompileProgress()) as progress:
            for part in compilation.compile_kernels(alone=True):
                progress.enter(part)
    table = plain_table("CPU time of compiling, s", "front end", "LLVM", "both")
    rows = sorted(times.by_kernel.items(), key=lambda row: -sum(row[1]))
    own = [each for name, each in rows if name.startswith("cohelm.")]
    total = [sum(column) for column in zip(*times.by_kernel.values(), strict=True)]
    others = [
        all_ - sum(column) for all_, column in zip(total, zip(*own, strict=True), strict=True)
    ]
    named = [(f"{len(own)} kernels and what they use", total), ("of numba's own library", others)]
    for name, (front, llvm) in [*named, *rows[:_DEAREST]]:
        table.add_row(name, f"{front:.1f}", f"{llvm:.1f}", f"{front + llvm:.1f}")
    OUTPUT.print(table)
    return 0


class _CompileTimes(event.Listener):
    """CPU time of each function that numba compiles, without its callees: (front end, LLVM), s."""

    def __init__(self) -> None:
        self.by_kernel: dict[str, tuple[float, float]] = {}
        self._open: list[list[float]] = []  # (begin, LLVM, callees) of those being compiled
        event.register("numba:compile", self)
        library: Any = CPUCodeLibrary
        for method in ("add_ir_module", "finalize"):
            setattr(library, method, self._timed(getattr(library, method)))

    def on_start(self, event: Any) -> None:
        """Begin with a function; ``event`` is numba's."""
        self._open.append([time.process_time(), 0.0, 0.0])

    def on_end(self, event: Any) -> None:
        """End it: its time is no longer that of its caller."""
        began, llvm, inner = self._open.pop()
        whole = time.process_time() - began
        function = event.data["dispatcher"].py_func
        name = f"{function.__module__}.{function.__qualname__}"
        front, back = self.by_kernel.get(name, (0.0, 0.0))
        self.by_kernel[name] = (front + whole - inner - llvm, back + llvm)
        if self._open:
            self._open[-1][2] += whole

    def _timed(self, method: Callable[..., Any]) -> Callable[..., Any]:
        def timed(*given: Any) -> Any:
            began = time.process_time()
            try:
                return method(*given)
            finally:
                if self._open:
                    self._open[-1][1] += time.process_time() - began

        return timed
