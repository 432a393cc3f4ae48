"""What a behaviour's phase, as people read it, says about the hand."""

CLOSING = (
    "gather",
    "press",
    "close",
    "squeeze",
    "lift",
    "hold",
    "lower again",
    "open again",
    "seek",
)  # legs of a grasp, see approach.py
AFTER = ("done",)


def hand_is_open(phase: str) -> bool:
    """Whether the object stands where it was seen: no grasp has begun to close.

    Args:
        phase: such as "look" or "grasp: close".
    """
    name, _, leg = phase.partition(": ")
    return name not in AFTER and not (name == "grasp" and leg in CLOSING)
