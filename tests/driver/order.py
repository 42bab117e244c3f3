"""The order of the tests when several processes run them, and what stays in one process.

What shares something that takes long to make stays in one process (with pytest-xdist's
`--dist loadgroup`). They come first, then tests that take long, so that no process is idle at the
end while another one is still at work.
"""

from __future__ import annotations

import pytest
from xdist.scheduler import LoadScopeScheduling

# What each file that shares something belongs to.
GROUPS = {
    "test_python_package": "wheel",
    "test_kernel_arrays": "wheel",
    "test_hosts": "wheel",
    "test_extension": "extension",
    "test_library": "library",
    "test_slurm": "slurm",
    "test_bench": "bench",
    "test_bearing_table": "bearing",
}
# Tests that take more than some ten seconds with one of the builds, the longest first.
LONG = (
    "test_fault_is_noticed",
    "test_random_scenes_run_or_end_with_a_message",
    "test_rigid_scenes_are_the_limit_of_compliant_ones",
    "test_two_spots_that_stick_in_a_bore",
    "test_damaged_files",
    "test_memory_changes_little_where_all_rolls",
    "test_rungs_stick",
    "test_small_creep_is_linear",
    "test_directions",
    "test_hostile_sizes",
    "test_mutated_scenes",
    "test_masses_from_dust_to_boulders",
    "test_what_an_error_of_a_microsecond_costs",
    "test_results_that_are_kept",
    "test_bodies_that_a_drive_turns_and_springs_count",
    "test_threads_and_shards_give_the_same_bits",
    "test_the_shipped_incline_holds_up_to_its_limit",
    "test_file_that_is_being_written",
    "test_rigid_contact_allocates_nothing",
    "test_pace_does_not_depend_on_the_number_of_cases",
    "test_hertz_tables_are_what_is_generated",
    "test_needles",
    "test_kills_at_random_moments",
    "test_derivatives_have_no_jumps",
)


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
