"""Keys of the configuration: the types of their values, and what a key means, as annotations of a field.

A class that has them is at once a section of the configuration and the settings that a function takes.
"""

import warnings
from collections.abc import Callable
from dataclasses import dataclass
from functools import wraps
from typing import TYPE_CHECKING, Annotated, Any, TypeVar

from annotated_types import Ge, Gt, Le

if TYPE_CHECKING:
    from pydantic import ConfigDict

T = TypeVar("T")


@dataclass(frozen=True)
class Key:
    """Meaning of a key, its unit, its place in the paper, and what is allowed beyond its type."""

    meaning: str
    unit: str = ""
    source: str = ""
    allowed: str = ""

    def __get_pydantic_json_schema__(self, core: Any, handler: Any) -> dict[str, Any]:  # noqa: ANN401
        """Add the texts to a key's schema."""
        texts = {"description": self.meaning, "unit": self.unit, "from": self.source, "allowed": self.allowed}
        return {**handler(core), **{name: text for name, text in texts.items() if text}}


class Exact:
    """Converts no text and no truth value to a number, nor the other way round."""

    def __get_pydantic_core_schema__(self, kind: Any, handler: Any) -> dict[str, Any]:  # noqa: ANN401
        """Make the check of a value strict."""
        return {**handler(kind), "strict": True}


#: Rules of a class that is a section: no other key, no number that is not finite.
SECTION: "ConfigDict" = {
    "extra": "forbid",
    "allow_inf_nan": False,
    "regex_engine": "python-re",
    "hide_input_in_errors": True,
}

# Upper limits are far beyond any use: a misplaced digit must not request terabytes or years.
Flag = Annotated[bool, Exact()]
Real = Annotated[float, Exact()]
Integer = Annotated[int, Exact()]
Positive = Annotated[Real, Gt(0), Le(1e9)]
Level = Annotated[Real, Ge(0), Le(1e9)]
Share = Annotated[Real, Ge(0), Le(1)]
Count = Annotated[Integer, Ge(1), Le(10_000_000)]
Whole = Annotated[Integer, Ge(0), Le(10_000_000)]
Width = Annotated[Integer, Ge(1), Le(4096)]
Seed = Annotated[Integer, Ge(0), Le(2**32 - 1)]
Joints = tuple[Positive, Positive]
JointLevels = tuple[Level, Level]


def renamed(**names: str) -> Callable[[type[T]], type[T]]:
    """Let a class take earlier names of its arguments, each with a `DeprecationWarning`."""

    def with_earlier_names(cls: type[T]) -> type[T]:
        own: Callable[..., None] = cls.__init__

        @wraps(own)
        def init(self: T, *args: Any, **given: Any) -> None:  # noqa: ANN401
            for earlier in names.keys() & given.keys():
                warnings.warn(f"{earlier} is {names[earlier]} now.", DeprecationWarning, stacklevel=2)
                given[names[earlier]] = given.pop(earlier)
            own(self, *args, **given)

        cls.__init__ = init  # type: ignore[method-assign, assignment]
        return cls

    return with_earlier_names
