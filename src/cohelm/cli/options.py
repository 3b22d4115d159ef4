"""Options of a command from the parameters of what it calls, which carry their help."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Collection, Mapping
from typing import Annotated, Any, get_args, get_origin, get_type_hints

from cohelm.errors import ConfigError


class Options:
    """Options of a request or a function.

    Args:
        target: a dataclass or a function; each annotated parameter is an option, one of type
            ``tuple[X, ...]`` may be given several times.
        omit: names of parameters that are none.

    Raises:
        ConfigError: if a parameter has no type.
    """

    def __init__(self, target: Callable[..., Any], omit: Collection[str] = ()) -> None:
        function = target.func if isinstance(target, functools.partial) else target
        hints = get_type_hints(function, include_extras=True)
        self._forms: dict[str, tuple[Any, bool, Any]] = {}
        for name, each in inspect.signature(target).parameters.items():
            if name in omit:
                continue
            if name not in hints:
                raise ConfigError(f"the argument {name!r} of create needs a type")
            form, many = _as_list(hints[name])
            needed = each.default is inspect.Parameter.empty
            self._forms[name] = form, many, () if many and needed else each.default

    @property
    def parameters(self) -> list[inspect.Parameter]:
        """Parameters as typer knows them."""
        return [
            inspect.Parameter(
                name, inspect.Parameter.KEYWORD_ONLY, default=None if many else default,
                annotation=form,
            )
            for name, (form, many, default) in self._forms.items()
        ]  # fmt: skip

    def values(self, given: Mapping[str, Any]) -> dict[str, Any]:
        """Arguments of the target from those of the command; a list becomes a tuple."""
        return {
            name: (tuple(given[name]) if given[name] else default) if many else given[name]
            for name, (_, many, default) in self._forms.items()
        }


def command(
    run: Callable[..., int], parameters: list[inspect.Parameter], name: str = "", text: str = ""
) -> Callable[..., int]:
    """Return the function ``run``, which takes keywords, with parameters that typer can read."""

    def called(**given: Any) -> int:
        return run(**given)

    vars(called)["__signature__"] = inspect.Signature(parameters, return_annotation=int)
    called.__annotations__ = {each.name: each.annotation for each in parameters}
    called.__doc__, called.__name__ = text, name or run.__name__
    return called


def _as_list(hint: Any) -> tuple[Any, bool]:
    """Annotation that typer knows for a repeatable option, and True where it is one."""
    kind, *declared = get_args(hint) if get_origin(hint) is Annotated else (hint,)
    if get_origin(kind) is not tuple:
        return hint, False
    several: Any = list[get_args(kind)[0]] | None  # type: ignore[misc]  # known only here
    return Annotated[several, declared[0]] if declared else several, True
