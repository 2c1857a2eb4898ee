"""The one exception a user is meant to read, and how signals become exceptions."""

import re
import signal
import sys
import threading
from collections.abc import Iterable
from difflib import get_close_matches
from importlib.util import find_spec


def shown(text: str) -> str:
    """Escape what a terminal or page would obey instead of showing it: line ends, escape sequences, directions."""
    return text if text.isprintable() else "".join(c if c.isprintable() else ascii(c)[1:-1] for c in text)


class InputError(ValueError):
    """Something the user gave is wrong: the message is one line naming file, field, found and expected.

    Command-line programs print it without a traceback and exit with code 2.

    Examples
    --------
    >>> print(repro.InputError.at("run.csv: line 7, tau2", "'x'", "a finite number"))
    run.csv: line 7, tau2: found 'x', expected a finite number
    """

    place = found = expected = ""  # parts of the message, set by `at`

    def __init__(self, message: str) -> None:
        super().__init__(shown(message))

    @classmethod
    def at(cls, place: str, found: object, expected: str) -> "InputError":
        """Build the message ``place: found ..., expected ...``, whose parts the error has as attributes."""
        error = cls(f"{place}: found {found}, expected {expected}")
        error.place, error.found, error.expected = shown(place), shown(str(found)), shown(expected)
        return error


def one_of(known: Iterable[str], found: object) -> str:
    """State what is expected: the known name that is closest to what was found or has its initials, else all names."""
    names = list(known)
    initials = [name for name in names if "".join(part[:1] for part in re.split(r"\W+", name)) == found]
    close = get_close_matches(str(found), names, n=1, cutoff=0.75) or initials[:1]
    return f"{close[0]}, or one of {len(names) - 1} others" if close else f"one of {', '.join(names)}"


def check_kind(name: str, value: object, kind: type | tuple[type, ...], expected: str) -> None:
    """Refuse an argument of another type than a function takes, in one line."""
    if not isinstance(value, kind):
        text = repr(value)
        raise InputError.at(name, text if len(text) <= 60 else f"a value of type {type(value).__name__}", expected)


def failure(error: OSError) -> str:
    """Name what the operating system refused, as part of a sentence."""
    text = error.strerror or str(error) or "an unreadable file"
    return text[0].lower() + text[1:]


def option(name: str, value: str = "") -> str:
    """Name an option of a command and the argument that it is in Python."""
    argument = f"{name.replace('-', '_')}={repr(value) if value else True}"
    return f"--{name} {value}".rstrip() + f" (Python: {argument})"


def end_by_exception() -> None:
    """Have SIGTERM and SIGHUP end this process as exceptions do: what moves is stopped, temporary folders go."""
    if threading.current_thread() is threading.main_thread():
        for number in (signal.SIGTERM, signal.SIGHUP):
            if signal.getsignal(number) is not signal.SIG_IGN:  # as under nohup
                signal.signal(number, lambda came, _: sys.exit(128 + came))


def require(package: str, extra: str, place: str, otherwise: str = "") -> None:
    """Refuse what needs a package that an extra of the project installs."""
    if find_spec(package) is None:
        expected = f"{otherwise}the extra {extra}: python -m pip install -e '.[{extra}]' in the project's folder"
        raise InputError.at(place, f"no package {package}", expected)
