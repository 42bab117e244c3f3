"""Sweeps on a real Slurm, which the tests start on this machine: each ends with the whole table."""

from __future__ import annotations

import contextlib
import os
import resource
import signal
import subprocess
import threading
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np
import pytest
from slurm_cluster import NODES, Cluster, ClusterError, missing_programs, own_address

ROOT = Path(__file__).resolve().parents[2]
SUBMIT = ROOT / "scripts" / "slurm" / "submit"

SWEEP = """\
&sweep
   scene = 'top.nml', set = 'integrator.method = explicit8', 'scene.t_end = 1.5'
   keep = 'summary', 'events', output = 'table.h5'
/
&parameter name = 'contact.friction_coefficient', first = 0.2, last = 0.4, count = 4 /
&parameter name = 'top.spin(3)', first = 150, last = 200, count = {count} /
"""


@pytest.fixture(scope="module")
def cluster(build_kind):
    """A Slurm of two nodes; one for all tests of this module."""
    if build_kind != "release":
        pytest.skip("one build is enough for the tests with Slurm: the release build")
    if missing := missing_programs():
        pytest.skip(f"Slurm and munge are not installed (no {', '.join(missing)})")
    if own_address() is None:
        pytest.skip("Slurm does not start: the name of this machine does not resolve")
    with Cluster() as running:
        yield running


@dataclass
class Work:
    """A folder with a sweep, and how the tests submit it and look at it."""

    folder: Path
    executable: Path
    cluster: Cluster
    cases: int

    def sweep(self, *options: object) -> subprocess.CompletedProcess:
        """Run the whole sweep here, in one process."""
        return subprocess.run(
            [self.executable, *map(str, options)],
            cwd=self.folder,
            capture_output=True,
            text=True,
            timeout=600,
            check=True,
        )

    def submit(self, *options: object) -> str:
        """Number of the array job."""
        done = self.cluster.command(
            SUBMIT, *options, cwd=self.folder, CONTENSOU=str(self.executable)
        )
        return done.stdout.strip()

    def log(self, job: str, shard: int) -> str:
        """What a shard has written."""
        path = self.folder / f"sweep_{job}_{shard}.log"
        return path.read_text(errors="replace") if path.exists() else ""

    def wait_for_log(self, job: str, shard: int, text: str, limit: float = 120.0) -> str:
        """Wait until a shard has written something."""
        try:
            self.cluster.wait_for(
                f"'{text}' of shard {shard} of job {job}",
                lambda: text in self.log(job, shard),
                limit,
            )
        except ClusterError as error:
            error.add_note(f"--- what the shard wrote\n{self.log(job, shard)}")
            raise
        return self.log(job, shard)

    def merge(self) -> None:
        """Join the shards."""
        self.sweep("merge", "sweep.nml")

    def table(self, name: str = "table.h5") -> dict[str, bytes]:
        """Every column of a table, bit by bit."""
        with h5py.File(self.folder / name) as file:
            assert np.array_equal(file["case"][()], np.arange(1, self.cases + 1))
            assert not file["status"][()].any()
            columns = {}
            for path in ["case", "status", "message", *groups(file)]:
                data = file[path]
                values = data.asstr()[()] if data.dtype.kind == "O" else data[()]
                columns[path] = (
                    "\n".join(values).encode() if data.dtype.kind == "O" else values.tobytes()
                )
            return columns


def groups(file: h5py.File) -> list[str]:
    """Paths of all parameters and results of a table."""
    return [f"{group}/{name}" for group in ("parameters", "results") for name in file[group]]


@pytest.fixture
def work(tmp_path, executable, cluster, scene_text):
    """Make the work of a number of cases, in a folder of its own; how many CPU seconds it takes."""

    def make(count: int) -> Work:
        (tmp_path / "top.nml").write_text(scene_text)
        (tmp_path / "sweep.nml").write_text(SWEEP.format(count=count))
        return Work(tmp_path, executable, cluster, 4 * count)

    return make


@pytest.fixture(scope="module")
def reference(tmp_path_factory, executable, cluster, scene_text):
    """The table of a sweep that one process has made, and its CPU seconds; made once for each."""
    made = {}

    def make(count: int) -> tuple[dict[str, bytes], float]:
        if count not in made:
            folder = tmp_path_factory.mktemp("reference")
            (folder / "top.nml").write_text(scene_text)
            (folder / "sweep.nml").write_text(SWEEP.format(count=count))
            here = Work(folder, executable, cluster, 4 * count)
            before = cpu_seconds()
            here.sweep("sweep", "sweep.nml", "-j", 2, "--quiet")
            made[count] = here.table(), cpu_seconds() - before
        return made[count]

    return make


def cpu_seconds() -> float:
    """CPU time of the processes that have been waited for."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def test_an_array_finishes(work, reference, cluster):
    here = work(25)
    job = here.submit("--shards", 4, "--time", 5, "--merge", "sweep.nml")
    tasks = cluster.wait_for_array(job, 120)
    assert {task["JobState"] for task in tasks.values()} == {"COMPLETED"}
    assert set(tasks) == {"1", "2", "3", "4"}
    assert {task["BatchHost"] for task in tasks.values()} == {"n1", "n2"}
    table = here.folder / "table.h5"
    cluster.wait_for("joined table", table.exists)
    assert here.table() == reference(25)[0]


def test_a_shard_that_is_killed_is_submitted_again_and_runs_what_is_missing(
    work, reference, cluster
):
    here = work(40)
    job = here.submit("--shards", 2, "--time", 5, "sweep.nml")
    here.wait_for_log(job, 2, " 30 %")
    node = cluster.tasks(job)["2"]["BatchHost"]
    victims = cluster.processes(node, "contensou")
    assert victims
    for pid in victims:
        # The step's processes end with the first of them.
        with contextlib.suppress(ProcessLookupError):
            os.kill(pid, signal.SIGKILL)
    tasks = cluster.wait_for_array(job, 120)
    assert tasks["1"]["JobState"] == "COMPLETED"
    assert tasks["2"]["JobState"] == "FAILED"
    assert int(tasks["2"]["Restarts"]) == 0
    first = here.folder / "table_shard_1_of_2.h5"
    before = first.stat().st_mtime_ns
    assert not (here.folder / "table_shard_2_of_2.h5").exists()

    again = here.submit("--time", 5, "sweep.nml")
    tasks = cluster.wait_for_array(again, 120)
    # Its complete neighbour is not even submitted, and of its own cases those that were done are
    # not run again.
    assert {shard: task["JobState"] for shard, task in tasks.items()} == {"2": "COMPLETED"}
    left, total = going_on(here.log(again, 2))
    assert total == 80
    assert 0 < left <= 56
    assert first.stat().st_mtime_ns == before
    here.merge()
    assert here.table() == reference(40)[0]


def running(cluster: Cluster, job: str, number: int) -> dict[str, str]:
    """Where each task of an array runs; empty until so many of them run."""
    tasks = cluster.tasks(job)
    hosts = {i: task["BatchHost"] for i, task in tasks.items() if task["JobState"] == "RUNNING"}
    return hosts if len(hosts) == number else {}


def going_on(log: str) -> tuple[int, int]:
    """Cases that a shard had left when it went on, and all of its cases; the last time."""
    words = log.rpartition("going on with ")[2].split()
    assert words, log
    return int(words[0]), int(words[2])


def test_a_shard_that_is_cancelled_saves_and_is_not_put_back(work, reference, cluster):
    here = work(25)
    job = here.submit("--shards", 1, "--time", 5, "sweep.nml")
    here.wait_for_log(job, 1, " 20 %")
    cluster.command("scancel", job)
    tasks = cluster.wait_for_array(job, 60)
    assert tasks["1"]["JobState"] == "CANCELLED"
    assert int(tasks["1"]["Restarts"]) == 0
    log = here.wait_for_log(job, 1, "cancelled; what is done is saved")
    assert "interrupted; the rows so far are in table_shard_1_of_1.h5.part" in log
    again = here.submit("sweep.nml")
    tasks = cluster.wait_for_array(again, 120)
    assert tasks["1"]["JobState"] == "COMPLETED"
    left, total = going_on(here.log(again, 1))
    assert total == 100
    assert 0 < left <= 80
    here.merge()
    assert here.table() == reference(25)[0]


def test_the_shard_of_a_dead_node_goes_on_elsewhere(work, reference, cluster):
    here = work(40)
    job = here.submit("--shards", 2, "--time", 5, "sweep.nml")
    hosts = cluster.wait_for("two running shards", lambda: running(cluster, job, 2))
    lost = "n1"
    shard = int(next(shard for shard, host in hosts.items() if host == lost))
    here.wait_for_log(job, shard, " 30 %")
    cluster.kill_node(lost)
    try:
        tasks = cluster.wait_for_array(job, 240)
    finally:
        cluster.start_node(lost)
    assert {task["JobState"] for task in tasks.values()} == {"COMPLETED"}
    task = tasks[str(shard)]
    assert task["BatchHost"] == "n2"
    assert int(task["Restarts"]) == 1
    log = here.log(job, shard)
    assert "on n1, restart 0" in log
    assert "on n2, restart 1" in log
    left, total = going_on(log)
    assert total == 80
    assert 0 < left <= 56
    here.merge()
    assert here.table() == reference(40)[0]
    cluster.wait_for("two idle nodes", lambda: cluster.node_states() == ["idle", "idle"])


def used_seconds(pid: int) -> float | None:
    """CPU time of a process; nothing once it is gone."""
    try:
        fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return None
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


@contextlib.contextmanager
def at_a_pace(cluster: Cluster, share: float) -> Iterator[None]:
    """Give the program this share of a core: stop its processes while they are ahead of that."""
    over = threading.Event()

    def control() -> None:
        began: dict[int, float] = {}
        looked = 0.0
        while not over.wait(0.05):
            now = time.monotonic()
            if now - looked > 0.5:
                looked = now
                found = [pid for node in NODES for pid in cluster.processes(node, "contensou")]
                began = {pid: began.get(pid, now) for pid in found}
            for pid, start in began.items():
                if (used := used_seconds(pid)) is None:
                    continue
                ahead = used > share * (now - start)
                with contextlib.suppress(ProcessLookupError):
                    os.kill(pid, signal.SIGSTOP if ahead else signal.SIGCONT)
        for pid in began:
            with contextlib.suppress(ProcessLookupError):
                os.kill(pid, signal.SIGCONT)

    keeper = threading.Thread(target=control)
    keeper.start()
    try:
        yield
    finally:
        over.set()
        keeper.join()


def test_a_time_limit_that_needs_three_lives(work, reference, cluster):
    # Slurm looks every 30 s whose time is up, so that a life of a minute with 30 s of notice has
    # at most 30 s, and the next one, which begins 10 s after that look, 20 s: a minute of work
    # needs more than two. Most of that minute the work stands still.
    share = 0.15
    per_case = reference(40)[1] / 160
    count = max(int(60.0 * share / per_case / 4), 10)
    here = work(count)
    with at_a_pace(cluster, share):
        job = here.submit("--shards", 1, "--time", 1, "sweep.nml", "--", "--signal=B:USR1@30")
        expected, _ = reference(count)
        tasks = cluster.wait_for_array(job, 500)
    assert tasks["1"]["JobState"] == "COMPLETED"
    restarts = int(tasks["1"]["Restarts"])
    assert restarts >= 2
    log = here.log(job, 1)
    assert log.count("the task goes back into the queue") == restarts
    assert log.count("going on with") == restarts
    assert [f"restart {i}\n" in log for i in range(restarts + 1)] == [True] * (restarts + 1)
    here.merge()
    assert here.table() == expected
