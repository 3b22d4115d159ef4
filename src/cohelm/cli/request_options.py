"""Conversion of a request into the options of a typer command."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from dataclasses import MISSING, fields
from typing import Annotated, Any, TypeVar, get_args, get_origin, get_type_hints

_Request = TypeVar("_Request")


def takes(kind: type[_Request]) -> Callable[[Callable[[_Request], int]], Callable[..., int]]:
    """Decorate a command that takes a request: typer sees one option for each of its fields."""
    hints = get_type_hints(kind, include_extras=True)
    parameters = []
    for each in fields(kind):  # type: ignore[arg-type]  # every request is a dataclass
        default = inspect.Parameter.empty if each.default is MISSING else each.default
        hint, many = _as_list(hints[each.name])
        parameters.append(
            inspect.Parameter(
                each.name,
                inspect.Parameter.KEYWORD_ONLY,
                default=None if many else default,
                annotation=hint,
            )
        )

    def decorate(run: Callable[[_Request], int]) -> Callable[..., int]:
        def command(**given: Any) -> int:
            values = {
                name: tuple(value or ()) if _as_list(hints[name])[1] else value
                for name, value in given.items()
            }
            return run(kind(**values))

        signature = inspect.Signature(parameters, return_annotation=int)
        vars(command)["__signature__"] = signature
        command.__annotations__ = {p.name: p.annotation for p in parameters}
        command.__doc__, command.__name__ = run.__doc__, run.__name__
        return command

    return decorate


def _as_list(hint: Any) -> tuple[Any, bool]:
    """The annotation that typer knows for a repeatable option, and True where it is one."""
    kind, *declared = get_args(hint)
    if get_origin(kind) is not tuple:
        return hint, False
    element: Any = get_args(kind)[0]
    return Annotated[list[element] | None, declared[0]], True
