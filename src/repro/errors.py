"""The one exception a user is meant to read."""


class InputError(ValueError):
    """Something the user gave is wrong: the message is one line naming file, field, found and expected.

    Command-line programs print it without a traceback and exit with code 2.
    """

    @classmethod
    def at(cls, place: str, found: object, expected: str) -> "InputError":
        """Build the message ``place: found ..., expected ...``."""
        return cls(f"{place}: found {found}, expected {expected}")
