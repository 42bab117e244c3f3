"""What can go wrong, with the text that the command line would show."""

from __future__ import annotations


class ContensouError(Exception):
    """Something went wrong; `status` is the exit status that the program has for it."""

    def __init__(self, message: str, status: int = 1) -> None:
        super().__init__(message)
        self.status = status

    def __reduce__(self) -> tuple[type, tuple[str, int]]:
        return type(self), (str(self), self.status)


class SimulationError(ContensouError, RuntimeError):
    """The simulation failed."""


class SceneError(ContensouError, ValueError):
    """A mistake in a scene, its settings, a sweep or an argument."""


class FileError(ContensouError, OSError):
    """A file cannot be read or written."""


class SceneWarning(UserWarning):
    """Something in a scene is legal but hardly intended."""


def error_of(status: int, message: str) -> ContensouError:
    """The error of an exit status of the program, or of a status of the library."""
    message = message.strip()
    if status < 0:
        return SimulationError(f"contensou was ended by signal {-status}\n{message}".strip())
    kind = {1: SimulationError, 2: SceneError, 74: FileError}.get(status, ContensouError)
    return kind(message.removeprefix("error: ") or f"contensou ended with {status}", status)
