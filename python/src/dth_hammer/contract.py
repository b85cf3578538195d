"""Checks the arguments of public functions against their annotations."""

import functools
import inspect
import numbers
import types
from collections.abc import Callable, Iterable, Mapping, Sized
from datetime import timedelta
from typing import Any, Literal, TypeVar, Union, get_args, get_origin

from .errors import DomainError, UnknownNameError

Made = TypeVar("Made", bound=Callable[..., Any])


def typed(**remedies: str) -> Callable[[Made], Made]:
    """Wraps a function or class so that an argument of a wrong type raises a `DomainError`.

    Args:
        remedies: advice to add to the error message, by the argument's name.
    """

    def decorate(target: Made) -> Made:
        function: Any = target.__init__ if isinstance(target, type) else target  # type: ignore[misc]
        signature = inspect.signature(function)
        hints: dict[str, Any] = {}

        @functools.wraps(function)
        def checked(*arguments: Any, **named: Any) -> Any:
            hints.update(hints or hints_of(function))
            try:
                given = signature.bind(*arguments, **named).arguments
            except TypeError as error:
                for name in {*named} - {*signature.parameters}:
                    known = [n for n in signature.parameters if n != "self"]
                    raise UnknownNameError(f"argument of {target.__name__}", name, known) from None
                raise DomainError(f"{target.__name__}: {error}") from None
            for name, value in given.items():
                if wrong := _wrong(value, hints[name], name):
                    remedy = remedies.get(name) or _strength(name, value)
                    remedy = remedy and f"; {remedy}"
                    raise DomainError(f"{target.__name__}: {wrong}{remedy}")
            return function(*arguments, **named)

        if isinstance(target, type):
            target.__init__ = checked  # type: ignore[misc]
            return target
        return checked  # type: ignore[return-value]

    return decorate


def _strength(name: str, value: Any) -> str:
    """Suggests a unit for a number that is given as a rock, if it looks like a strength."""
    return (
        f"is it a strength, rock='{value:g} MPa'?" if name == "rock" and _is_number(value) else ""
    )


def hints_of(function: Callable[..., Any]) -> dict[str, Any]:
    """Returns the annotations of a function's arguments by name."""
    function = inspect.unwrap(function)
    hints = {}
    for name, parameter in inspect.signature(function).parameters.items():
        hint = Any if parameter.annotation is parameter.empty else parameter.annotation
        # An alias is text too, if it contains a type that is slow to import.
        while isinstance(hint, str):
            hint = eval(hint, function.__globals__)
        hints[name] = hint
    return hints


def _wrong(value: Any, hint: Any, name: str) -> str:
    """Returns what is wrong with a value as text; "" if the value matches its annotation."""
    if _is_one(value, hint):
        return ""
    for alternative in alternatives(hint) if isinstance(value, Mapping) else ():
        inner = get_args(alternative)
        for key, item in value.items() if get_origin(alternative) is Mapping else ():
            if not _is_one(key, inner[0]):
                return f"{name} has the key {key!r}, which is not {_words(inner[0])}"
            if not _is_one(item, inner[1]):
                return f"{name}[{key!r}] = {_abridged(item)} is not {_words(inner[1])}"
    return f"{name} = {_abridged(value)} is not {_words(hint)}"


def alternatives(hint: Any) -> tuple[Any, ...]:
    """Returns the members of a union, or the type itself if it is no union."""
    return get_args(hint) if get_origin(hint) in (Union, types.UnionType) else (hint,)


def _is_one(value: Any, hint: Any) -> bool:
    sides, origin, inner = alternatives(hint), get_origin(hint), get_args(hint)
    if len(sides) > 1:
        return any(_is_one(value, alternative) for alternative in sides)
    if (origin or hint) in PLAIN:
        return PLAIN[origin or hint][1](value)
    if origin is Literal:
        return isinstance(value, str) and value in inner
    if origin is Mapping:
        return isinstance(value, Mapping) and all(
            _is_one(k, inner[0]) and _is_one(v, inner[1]) for k, v in value.items()
        )
    if origin is tuple:
        return isinstance(value, tuple | list) and (
            ... in inner or (len(value) == len(inner) and all(map(_is_one, value, inner)))
        )
    if origin is not None:
        return _is_listed(value, origin, inner)
    anything = hint is Any or not isinstance(hint, type) or getattr(hint, "_is_protocol", False)
    return anything or isinstance(value, hint)


def _is_listed(value: Any, origin: Any, inner: tuple[Any, ...]) -> bool:
    """Returns whether the value is a collection whose items match.

    An iterator does not qualify, because checking its items would use them up.
    """
    if isinstance(value, str | bytes) or getattr(value, "ndim", 1) != 1:
        return False
    if isinstance(value, Mapping) and origin is not Iterable:
        return False
    if not isinstance(value, origin) and not hasattr(value, "ndim"):
        return False
    numeric = getattr(getattr(value, "dtype", None), "kind", "O") in "biuf"
    sized = isinstance(value, Sized) and not numeric
    return not sized or all(_is_one(item, inner[0]) for item in value)


def _is_number(value: Any) -> bool:
    """Returns whether it is a number; NumPy scalars, durations and pint's quantities count."""
    number = hasattr(value, "__float__") and not getattr(value, "ndim", 0)
    return number or isinstance(value, timedelta) or hasattr(value, "magnitude")


def _abridged(value: Any) -> str:
    text = " ".join(repr(value).split())
    return text if len(text) <= 60 else f"{text[:57]}..."


#: By type: its name in messages, and the test that a value must pass.
PLAIN: dict[Any, tuple[str, Callable[[Any], bool]]] = {
    float: ("a number", _is_number),
    int: ("a whole number", lambda value: isinstance(value, numbers.Integral)),
    str: ("text", lambda value: isinstance(value, str)),
    bool: ("True or False", lambda value: type(value).__name__ == "bool"),
    type(None): ("None", lambda value: value is None),
    Callable: ("a function", callable),
}


def _words(hint: Any) -> str:
    """Returns the name of a type for error messages."""
    sides, origin = alternatives(hint), get_origin(hint)
    if len(sides) > 1:
        plain = {int, bool, type(None)} if float in sides else {type(None)}
        texts = [
            *dict.fromkeys(_words(alternative) for alternative in sides if alternative not in plain)
        ]
        return " or ".join(texts)
    if origin is Literal:
        return " or ".join(map(repr, get_args(hint)))
    if (origin or hint) in PLAIN:
        return PLAIN[origin or hint][0]
    inner = [i for i in get_args(hint) if i is not ...]
    if origin is Mapping:
        return f"a mapping by name of {_words(inner[1])}"
    if origin is tuple:
        return f"({', '.join(map(_words, inner))})"
    return f"a list of {_words(inner[0])}" if origin else str(getattr(hint, "__name__", hint))
