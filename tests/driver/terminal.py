"""A terminal as the standard error of a command."""

from __future__ import annotations

import errno
import fcntl
import os
import pty
import struct
import subprocess
import termios

import pytest


def read_piece(terminal) -> bytes:
    """What stands to be read from a terminal; nothing when the other side is closed."""
    try:
        return os.read(terminal, 65536)
    except OSError as error:
        if error.errno == errno.EIO:
            return b""
        raise


def on_terminal(command, cwd, columns, *, output=False):
    """What a command writes to a terminal that is its standard error or output; its status."""
    try:
        ours, theirs = pty.openpty()
    except OSError as error:  # as in a chroot without /dev/pts
        pytest.skip(f"no pseudo terminal: {error}")
    fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", 24, columns, 0, 0))
    with subprocess.Popen(
        [str(word) for word in command],
        cwd=cwd,
        stdin=subprocess.DEVNULL,
        stdout=theirs if output else subprocess.DEVNULL,
        stderr=subprocess.DEVNULL if output else theirs,
    ) as process:
        os.close(theirs)
        shown = b""
        while piece := read_piece(ours):
            shown += piece
        os.close(ours)
        status = process.wait(timeout=60)
    return status, shown.decode()
