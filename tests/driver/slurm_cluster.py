"""A Slurm of two nodes on this machine, for the tests: own configuration, key, ports and folder.

Everything listens on loopback, or on what else the name of this machine stands for, and lives in
one temporary folder. Each daemon runs under a keeper, a process that adopts whatever the daemon's
descendants leave behind and kills all of them once its standard input is closed: so nothing stays,
whatever becomes of the tests, and ending the keeper of a node is what a loss of power is to a real
one.
"""

from __future__ import annotations

import os
import pwd
import shutil
import socket
import subprocess
import sys
import tempfile
import time
from pathlib import Path

PROGRAMS = ("munged", "slurmctld", "slurmd", "sbatch", "squeue", "scontrol", "scancel", "sinfo")
NODES = ("n1", "n2")
SBIN = os.pathsep.join(("/usr/sbin", "/sbin", "/usr/local/sbin"))
PATH = os.environ.get("PATH", os.defpath) + os.pathsep + SBIN

# Keeper: `python -c KEEPER COMMAND...`. Becomes the parent of orphaned descendants (subreaper),
# starts the command, and kills every descendant once its standard input ends.
KEEPER = r"""
import ctypes, os, pathlib, signal, subprocess, sys, threading, time

ctypes.CDLL(None).prctl(36, 1, 0, 0, 0)  # PR_SET_CHILD_SUBREAPER
for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
    signal.signal(number, signal.SIG_IGN)  # ends with standard input only


def restore():
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_DFL)


def descendants():
    parents = {}
    for entry in pathlib.Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = entry.read_text().rpartition(")")[2].split()
        except OSError:
            continue
        if fields[0] not in "ZX":
            parents[int(entry.parent.name)] = int(fields[1])
    found, fresh = [], {os.getpid()}
    while fresh:
        fresh = {pid for pid, parent in parents.items() if parent in fresh}
        found += sorted(fresh)
    return found


def send(number, pids):
    for pid in pids:
        try:
            os.kill(pid, number)
        except OSError:
            pass


def reap():
    try:
        while os.waitpid(-1, os.WNOHANG)[0]:
            pass
    except ChildProcessError:
        pass


def wait_for_end():
    while os.read(0, 1024):
        pass


subprocess.Popen(sys.argv[1:], stdin=subprocess.DEVNULL, preexec_fn=restore)
watch = threading.Thread(target=wait_for_end)
watch.start()
while watch.is_alive():
    reap()
    watch.join(0.2)
for _ in range(500):
    # Parents before children, and all stand still before the first dies: a shepherd that saw its
    # job end would report it as failed.
    stopped = []
    while (pids := descendants()) != stopped:
        send(signal.SIGSTOP, pids)
        stopped = pids
    send(signal.SIGKILL, pids)
    reap()
    if not pids:
        break
    time.sleep(0.02)
"""

CONFIGURATION = """\
ClusterName=contensou
SlurmctldHost={host}({address})
SlurmctldPort={ports[0]}
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/munge
CredType=cred/munge
AuthInfo=socket={folder}/munge/socket,cred_expire=8
CommunicationParameters=NoInAddrAny,NoCtldInAddrAny
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool_%n
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/%n.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/%n.log
SlurmctldDebug=verbose
SlurmdDebug=verbose
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
JobCompType=jobcomp/none
MpiDefault=none
SwitchType=switch/none
MailProg=/bin/true
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SchedulerType=sched/builtin
SchedulerParameters=batch_sched_delay=0,sched_min_interval=100000,sched_interval=2
SlurmctldTimeout=30
SlurmdTimeout=10
MessageTimeout=30
KillWait=5
InactiveLimit=0
MinJobAge=600
ReturnToService=2
SlurmdParameters=config_overrides
NodeName=n1 NodeHostname={host} NodeAddr={address} Port={ports[1]} {node}
NodeName=n2 NodeHostname={host} NodeAddr={address} Port={ports[2]} {node}
PartitionName=all Nodes=n1,n2 Default=YES MaxTime=60 State=UP
"""


def missing_programs() -> list[str]:
    """Those of the programs of Slurm and munge that are not installed."""
    return [name for name in PROGRAMS if shutil.which(name, path=PATH) is None]


def free_ports(address: str, count: int) -> list[int]:
    """Ports of an address that nothing listens on, below those that the kernel hands out itself."""
    start = 20000 + 7 * (os.getpid() % 1500)
    found = []
    for port in range(start, start + 1000):
        with socket.socket() as probe:
            try:
                probe.bind((address, port))
            except OSError:
                continue
        found.append(port)
        if len(found) == count:
            return found
    raise ClusterError(f"no free ports on {address}")


def own_address() -> str | None:
    """What the name of this machine resolves to: mostly loopback, in some containers their own.

    All daemons bind to it and to nothing else; without one Slurm does not start.
    """
    try:
        return socket.gethostbyname(host_name())
    except OSError:
        return None


def host_name() -> str:
    """Name of this machine, as Slurm wants it."""
    return socket.gethostname().split(".")[0]


class ClusterError(Exception):
    """The cluster does not do what it should; the text holds the ends of its logs."""


class Cluster:
    """Munge, a controller and two nodes; a context manager that leaves nothing behind."""

    def __init__(self) -> None:
        self.folder = Path(tempfile.mkdtemp(prefix="contensou_slurm_", dir="/tmp"))
        self.keepers: dict[str, subprocess.Popen] = {}
        self.environment = {
            name: value
            for name, value in os.environ.items()
            if not name.startswith(("SLURM", "SBATCH", "SQUEUE", "OMP_"))
        }
        self.environment |= {"SLURM_CONF": str(self.folder / "slurm.conf"), "PATH": PATH}

    def __enter__(self) -> Cluster:
        try:
            self._start()
        except BaseException:
            self.close()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _start(self) -> None:
        self.folder.chmod(0o755)
        for name, mode in (("munge", 0o755), ("state", 0o700), ("spool_n1", 0o755)):
            (self.folder / name).mkdir(mode=mode)
            (self.folder / name).chmod(mode)
        (self.folder / "spool_n2").mkdir(mode=0o755)
        key = self.folder / "munge" / "key"
        key.touch(mode=0o600)
        key.write_bytes(os.urandom(128))
        address = own_address()
        assert address
        (self.folder / "slurm.conf").write_text(
            CONFIGURATION.format(
                host=host_name(),
                address=address,
                user=pwd.getpwuid(os.geteuid()).pw_name,
                folder=self.folder,
                ports=free_ports(address, 3),
                node="CPUs=1 RealMemory=500 State=UNKNOWN",
            )
        )
        (self.folder / "cgroup.conf").write_text("CgroupPlugin=cgroup/v1\nCgroupAutomount=no\n")
        munge = self.folder / "munge"
        self._keep(
            "munged",
            *("--foreground", "--force", f"--socket={munge}/socket", f"--key-file={munge}/key"),
            *(f"--pid-file={munge}/pid", f"--seed-file={munge}/seed", "--num-threads=2"),
            f"--log-file={munge}/log",
            "--origin=127.0.0.1",
        )
        self.wait_for("munge", lambda: (munge / "socket").exists())
        self._keep("slurmctld", "-D", "-i")
        for node in NODES:
            self.start_node(node)
        self.wait_for("two idle nodes", lambda: self.node_states() == ["idle", "idle"])

    def _keep(self, program: str, *arguments: str, name: str | None = None) -> None:
        path = shutil.which(program, path=PATH)
        assert path
        with (self.folder / f"{name or program}.out").open("ab") as out:
            self.keepers[name or program] = subprocess.Popen(
                [sys.executable, "-c", KEEPER, path, *arguments],
                stdin=subprocess.PIPE,
                stdout=out,
                stderr=out,
                env=self.environment,
                cwd=self.folder,
                start_new_session=True,
            )

    def _end(self, name: str) -> None:
        keeper = self.keepers.pop(name)
        keeper.stdin.close()
        keeper.wait(timeout=60)

    def start_node(self, node: str) -> None:
        """Switch a node on."""
        self._keep("slurmd", "-D", "-N", node, name=node)

    def kill_node(self, node: str) -> None:
        """All of a node is gone at once: the daemon, the shepherds of its jobs, the jobs."""
        self._end(node)

    def close(self) -> None:
        """End everything and remove the folder."""
        for name in reversed(list(self.keepers)):
            self._end(name)
        shutil.rmtree(self.folder, ignore_errors=True)

    def command(self, *words: object, cwd: Path | None = None, check: bool = True, **more: str):
        """Run a client of Slurm, or a program that calls one; returns what subprocess.run does."""
        done = subprocess.run(
            [str(word) for word in words],
            cwd=cwd or self.folder,
            env=self.environment | more,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            timeout=120,
            check=False,
        )
        if check and done.returncode != 0:
            raise ClusterError(f"{words} ended with {done.returncode}:\n{done.stdout}{done.stderr}")
        return done

    def processes(self, node: str, program: str) -> list[int]:
        """The processes of a program that run on a node."""
        found = []
        for entry in Path("/proc").glob("[0-9]*"):
            try:
                name = (entry / "comm").read_text().strip()
                words = (entry / "environ").read_bytes().split(b"\0")
            except OSError:
                continue
            ours = f"SLURM_CONF={self.folder}/slurm.conf".encode() in words
            if ours and name == program and f"SLURMD_NODENAME={node}".encode() in words:
                found.append(int(entry.name))
        return found

    def node_states(self) -> list[str]:
        """State of each node, `idle` for one that waits for work."""
        return self.command("sinfo", "--noheader", "-N", "-o", "%T", check=False).stdout.split()

    def tasks(self, job: str) -> dict[str, dict[str, str]]:
        """The fields that the controller shows for each task of an array job, by task number."""
        found = {}
        shown = self.command("scontrol", "--oneliner", "show", "job", job, check=False).stdout
        for line in shown.splitlines():
            fields = dict(word.partition("=")[::2] for word in line.split())
            if "ArrayTaskId" in fields:
                found[fields["ArrayTaskId"]] = fields
        return found

    def wait_for(self, what: str, condition, limit: float = 60.0, interval: float = 0.25):
        """Poll until the condition gives something; an error with the logs when it does not."""
        end = time.monotonic() + limit
        while time.monotonic() < end:
            if answer := condition():
                return answer
            time.sleep(interval)
        raise ClusterError(f"no {what} within {limit:g} s\n{self.logs()}")

    def wait_for_array(self, job: str, limit: float) -> dict[str, dict[str, str]]:
        """Wait until no task of an array job has anything left to do; the fields of the tasks."""
        # All other states pass, such as "SIGNALING" when the time of a job is up soon.
        over = {
            "BOOT_FAIL",
            "CANCELLED",
            "COMPLETED",
            "DEADLINE",
            "FAILED",
            "NODE_FAIL",
            "OUT_OF_MEMORY",
            "PREEMPTED",
            "TIMEOUT",
        }

        def ended() -> dict[str, dict[str, str]] | None:
            tasks = self.tasks(job)
            return tasks if {task["JobState"] for task in tasks.values()} <= over else None

        return self.wait_for(f"end of job {job}", ended, limit)

    def logs(self) -> str:
        """The ends of all logs."""
        text = []
        for path in sorted(self.folder.glob("*.log")) + sorted(self.folder.glob("*.out")):
            lines = path.read_text(errors="replace").splitlines()[-25:]
            text += [f"--- {path.name}", *lines]
        return "\n".join([*text, self.command("squeue", check=False).stdout])
