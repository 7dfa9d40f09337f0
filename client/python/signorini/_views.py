"""Read-only views of messages: what the generated classes of `reports` are made of."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

Vector = npt.NDArray[np.float64]


class View:
    """A message, read when asked."""

    def __init__(self, message: Any) -> None:
        self._message = message

    @property
    def message(self) -> Any:
        """The message itself."""
        return self._message

    @staticmethod
    def _vector(values: Any) -> Vector:
        return np.asarray(values, dtype=np.float64)

    @classmethod
    def names(cls) -> tuple[str, ...]:
        """Names of what it says, in the order of the contract."""
        return tuple(name for name, one in vars(cls).items() if isinstance(one, cached_property))

    def as_dict(self) -> dict[str, Any]:
        """All of it as plain values, views inside included."""
        return {name: plain(getattr(self, name)) for name in self.names()}

    def __eq__(self, other: object) -> bool:
        return type(other) is type(self) and bool(self._message == other._message)

    def __hash__(self) -> int:
        return id(self._message)

    def __reduce__(self) -> tuple[Any, ...]:
        return (type(self), (self._message,))

    def __repr__(self) -> str:
        said = ", ".join(f"{name}={getattr(self, name)!r}" for name in self.names())
        return f"{type(self).__name__}({said})"


def plain(value: Any) -> Any:
    """Views as dictionaries, arrays as lists."""
    if isinstance(value, View):
        return value.as_dict()
    if isinstance(value, dict):
        return {name: plain(one) for name, one in value.items()}
    if isinstance(value, tuple):
        return [plain(one) for one in value]
    return value.tolist() if isinstance(value, np.ndarray) else value


def word(message: Any, field: str, prefix: str) -> str | None:
    """The word of an enumeration as result lines spell it; None for the unspecified value."""
    number = getattr(message, field)
    known = message.DESCRIPTOR.fields_by_name[field].enum_type.values_by_number.get(number)
    if number == 0:
        return None
    return known.name.removeprefix(prefix).lower() if known else str(number)
