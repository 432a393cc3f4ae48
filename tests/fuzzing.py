"""What the fuzz tests of all loaders share: their number of files, damages, and limits."""

import contextlib
import resource
import signal

# Damaged files by loader, over all tests of it.
FILES = {"mesh": 420, "cloud": 400, "hand": 200, "scenario": 100, "weights": 150}


@contextlib.contextmanager
def limits(seconds: float, megabytes: int):
    """Raises in a block that takes longer, or that takes more memory than it found."""

    def stop(*_):
        raise TimeoutError(f"more than {seconds:g} s")

    soft, hard = resource.getrlimit(resource.RLIMIT_AS)
    before = signal.signal(signal.SIGALRM, stop)
    resource.setrlimit(resource.RLIMIT_AS, (_address_space() + megabytes * 2**20, hard))
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        resource.setrlimit(resource.RLIMIT_AS, (soft, hard))
        signal.signal(signal.SIGALRM, before)


def _address_space() -> int:
    """Bytes of address space that this process has now."""
    with open("/proc/self/statm") as file:
        return int(file.read().split()[0]) * resource.getpagesize()


def damaged(data: bytes, rng, snippets: tuple[bytes, ...]) -> bytes:
    """Data with one to five cuts, copies, or changed, added or swapped bytes."""
    raw = bytearray(data)
    for _ in range(rng.integers(1, 6)):
        start = int(rng.integers(len(raw) or 1))
        end = min(len(raw), start + int(rng.choice([1, 2, 10, 200])))
        piece = raw[start:end]
        match rng.integers(6):
            case 0:
                del raw[start:end]
            case 1:
                raw[start:start] = piece * int(rng.choice([1, 3, 50]))
            case 2:
                raw[start:end] = rng.bytes(len(piece))
            case 3:
                raw[start:start] = snippets[rng.integers(len(snippets))]
            case 4:
                raw[start:end] = snippets[rng.integers(len(snippets))]
            case 5:
                del raw[start:]
    return bytes(raw)
