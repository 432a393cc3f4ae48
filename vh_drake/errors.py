"""Errors that a user can cause and mend; each message says what came in and the remedy."""


class VhDrakeError(Exception):
    """Base of every error that vh_drake raises on purpose."""


class BadInput(VhDrakeError):
    """A file, option or array is unusable; the command line exits with status 2."""


class UnknownName(BadInput):
    """A name is not among the choices.

    Example:
        >>> str(UnknownName("object", "mugg", ["mug", "can"]))
        "unknown object 'mugg'; choose one of: can, mug"
    """

    def __init__(self, kind: str, name: str, choices: list[str]) -> None:
        super().__init__(f"unknown {kind} {name!r}; choose one of: {', '.join(sorted(choices))}")


class IllConditionedKernel(VhDrakeError):
    """A kernel matrix is not positive definite."""


class NothingSeen(VhDrakeError):
    """The camera shows no table or no object; the command line exits with status 1."""


class TooLarge(VhDrakeError):
    """A result is larger than it may be; it was not written."""


class NoGraspTried(VhDrakeError):
    """A trial ended before any grasp; the command line exits with status 1."""
