"""The order of the tests when several processes run them, and what stays in one process.

Files that share something that takes long to build stay in one process (with pytest-xdist's
`--dist loadgroup`). They come first, then tests that take long, so that no process is idle at the
end while another one is still at work.
"""

from __future__ import annotations

import pytest
from xdist.scheduler import LoadScopeScheduling

# What each file that shares a build belongs to.
GROUPS = {
    "test_python_package": "wheel",
    "test_kernel_arrays": "wheel",
    "test_hosts": "wheel",
    "test_extension": "extension",
    "test_library": "library",
    "test_slurm": "slurm",
}
# Tests that take more than some ten seconds with one of the builds, the longest first.
LONG = ()


def group_of(nodeid):
    """The group of a test, by its identifier; a test that has none is its own."""
    name = nodeid.partition("::")[0].rpartition("/")[2].removesuffix(".py")
    return GROUPS.get(name, nodeid)


def place(item):
    """Where a test comes in the order: groups, then long tests, then the rest."""
    order = [*dict.fromkeys(GROUPS.values()), *LONG]
    for name in (group_of(item.nodeid), getattr(item, "originalname", item.name)):
        if name in order:
            return order.index(name)
    return len(order)


class Groups(LoadScopeScheduling):
    """Hands out groups, and other tests one by one, in the order in which they are collected."""

    def _split_scope(self, nodeid):
        return group_of(nodeid)


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config, log):
    """The scheduler of groups.

    That of pytest-xdist 3.8 takes no notice of its mark with pytest 9.2, whose identifiers it
    cannot change.
    """
    if config.getvalue("dist") != "loadgroup":
        return None
    config.option.loadscopereorder = False
    return Groups(config, log)
