"""Whether a result file is as it was written: the seal that the program puts behind its end.

A file without a seal (of an earlier version, incomplete, or changed by another program) may be
damaged in any way, and HDF5 may crash over it: it is looked at in a process of its own first.
"""

from __future__ import annotations

import contextlib
import os
import resource
import signal
import zlib
from pathlib import Path

import h5py

SIZE = 64
MAGIC = b"contensou-seal 1 "
SIGNATURE = b"\x89HDF\r\n\x1a\n"
BLOCK = 1 << 20

# CPU time that the reading of one object may take [s], and memory [bytes].
PATIENCE = 5.0
MEMORY = 8 << 30

# More than this is not read for a look.
MOST_VALUES = 1 << 24


class DamageError(Exception):
    """A file is damaged; the text says why we think so."""


def is_sealed(path: Path) -> bool:
    """Whether a file has a seal and is as it was written; an error if it is not."""
    size = path.stat().st_size
    with path.open("rb") as file:
        end = end_of_hdf5(file.read(64))
        file.seek(max(size - SIZE, 0))
        found = file.read()
        if not found.startswith(MAGIC) or len(found) < SIZE:
            if end is not None and end < size <= end + SIZE:
                raise DamageError("its checksum is damaged")
            return False
        file.seek(0)
        crc, left = 0, size - SIZE
        while left > 0 and (block := file.read(min(BLOCK, left))):
            crc = zlib.crc32(block, crc)
            left -= len(block)
    seal = MAGIC + f"size {size - SIZE} crc {crc:08x}".encode()
    if found != seal.ljust(SIZE - 1) + b"\n":
        raise DamageError("its content is not that of its checksum")
    return True


def end_of_hdf5(block: bytes) -> int | None:
    """Where a file ends by what HDF5 has noted in its first bytes; None without such a note."""
    if len(block) < 64 or not block.startswith(SIGNATURE):
        return None
    at = {0: 40, 1: 44, 2: 28, 3: 28}.get(block[8])
    if at is None or block[13 if block[8] < 2 else 9] != 8:
        return None
    return int.from_bytes(block[at : at + 8], "little")


def check(path: Path) -> bool:
    """See that a file can be read without harm; whether it is known to be as it was written."""
    if is_sealed(path):
        return True
    child = os.fork()
    if child == 0:
        look(path)
        os._exit(0)
    _, status = os.waitpid(child, 0)
    if os.WIFSIGNALED(status):
        name = signal.Signals(os.WTERMSIG(status)).name
        raise DamageError(f"the HDF5 library fails over it ({name})")
    return False


def look(path: Path) -> None:
    """Read all of a file; what happens to the process tells how that goes."""
    signal.signal(signal.SIGPROF, signal.SIG_DFL)
    with contextlib.suppress(ValueError, OSError):
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, resource.RLIM_INFINITY))

    def read(_: str, item: object) -> None:
        signal.setitimer(signal.ITIMER_PROF, PATIENCE)
        with contextlib.suppress(Exception):
            for name in item.attrs:
                item.attrs[name]
        with contextlib.suppress(Exception):
            if isinstance(item, h5py.Dataset) and item.size and item.size <= MOST_VALUES:
                item[()]

    with contextlib.suppress(Exception):
        signal.setitimer(signal.ITIMER_PROF, PATIENCE)
        with h5py.File(path, "r", locking=False) as file:
            read("/", file)
            file.visititems(read)
