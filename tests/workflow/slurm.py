"""A Slurm cluster of one node, this machine, for tests: its own keys, ports and folders."""

import getpass
import os
import shutil
import socket
import subprocess
import tempfile
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path

PROGRAMS = ("munged", "slurmctld", "slurmd", "sbatch", "srun", "squeue", "scancel")
PATH = os.pathsep.join([os.environ["PATH"], "/usr/sbin", "/sbin"])
CORES = 4  # that the node claims to have
_START = 30.0  # patience with the daemons [s]

CONF = """
ClusterName=test
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={controller}
SlurmdPort={node}
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
CredType=cred/munge
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
AccountingStorageType=accounting_storage/none
JobAcctGatherType=jobacct_gather/none
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
SwitchType=switch/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core_Memory
SchedulerParameters=batch_sched_delay=0,sched_interval=2,sched_min_interval=0,bf_interval=2
SlurmdParameters=config_overrides
ReturnToService=2
KillWait=5
NodeName={host} NodeAddr=127.0.0.1 CPUs={cores} RealMemory=100000 State=UNKNOWN
PartitionName=all Nodes={host} Default=YES MaxTime=INFINITE State=UP
"""


def missing() -> list[str]:
    """Programs that a cluster needs and this machine lacks."""
    return [name for name in PROGRAMS if shutil.which(name, path=PATH) is None]


@dataclass(frozen=True)
class Cluster:
    """A running one; ``environment`` leads commands to it."""

    environment: dict[str, str]

    def ask(self, *command: str) -> str:
        """Output of a command of Slurm."""
        env = os.environ | self.environment
        done = subprocess.run(command, env=env, capture_output=True, text=True, timeout=60)
        return done.stdout

    def queue(self) -> list[str]:
        """Identifiers of the jobs that wait or run."""
        return self.ask("squeue", "--noheader", "--format=%i").split()

    def becomes_empty(self) -> bool:
        """Tell whether the queue empties within seconds: Slurm ends cancelled jobs by and by."""
        deadline = time.monotonic() + 15
        while self.queue() and time.monotonic() < deadline:
            time.sleep(0.2)
        return not self.queue()


@contextmanager
def one_node() -> Iterator[Cluster]:
    """Start a cluster and stop it at the end, with whatever runs on it."""
    with ExitStack() as stack:
        # In /tmp itself: the path of a socket has at most 107 characters.
        folder = Path(tempfile.mkdtemp(prefix="slurm-", dir="/tmp"))
        stack.callback(shutil.rmtree, folder, ignore_errors=True)
        (folder / "state").mkdir()
        (folder / "spool").mkdir()
        _write_conf(folder)
        key = folder / "munge.key"
        key.write_bytes(os.urandom(128))
        key.chmod(0o600)
        cluster = Cluster({"SLURM_CONF": str(folder / "slurm.conf"), "PATH": _programs(folder)})
        places = [f"--{name}-file={folder}/munge.{name}" for name in ("key", "pid", "log", "seed")]
        munged = ["munged", "--foreground", "--force", f"--socket={folder}/munge.socket", *places]
        for command in (munged, ["slurmctld", "-D", "-c", "-i"], ["slurmd", "-D", "-c"]):
            stack.enter_context(_daemon(command, folder, cluster.environment))
        stack.callback(cluster.becomes_empty)
        stack.callback(cluster.ask, "scancel", f"--user={getpass.getuser()}")
        _wait(lambda: cluster.ask("sinfo", "--noheader", "--format=%T").strip() == "idle")
        yield cluster


def _programs(folder: Path) -> str:
    """Path of programs whose `srun` finds the cluster: the executor clears its environment."""
    srun = folder / "bin" / "srun"
    srun.parent.mkdir()
    real = shutil.which("srun", path=PATH)
    srun.write_text(f'#!/bin/sh\nSLURM_CONF={folder}/slurm.conf exec {real} "$@"\n')
    srun.chmod(0o755)
    return f"{srun.parent}{os.pathsep}{PATH}"


def _write_conf(folder: Path) -> None:
    with socket.socket() as first, socket.socket() as second:
        for free in (first, second):
            free.bind(("127.0.0.1", 0))
        text = CONF.format(
            folder=folder,
            host=socket.gethostname().partition(".")[0],
            user=getpass.getuser(),
            controller=first.getsockname()[1],
            node=second.getsockname()[1],
            cores=CORES,
        )
    (folder / "slurm.conf").write_text(text)
    (folder / "cgroup.conf").write_text("CgroupPlugin=cgroup/v1\n")


@contextmanager
def _daemon(command: list[str], folder: Path, environment: dict[str, str]) -> Iterator[None]:
    program = shutil.which(command[0], path=PATH) or command[0]
    process = subprocess.Popen(
        [program, *command[1:]],
        env=os.environ | environment,
        stdin=subprocess.DEVNULL,
        start_new_session=True,  # Ctrl-C is for pytest, which then stops it
    )
    try:
        if command[0] == "munged":
            _wait(lambda: (folder / "munge.socket").exists())
        yield
    finally:
        process.terminate()
        try:
            process.wait(10)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


def _wait(is_there) -> None:
    deadline = time.monotonic() + _START
    while not is_there():
        if time.monotonic() > deadline:
            raise TimeoutError("expected Slurm to start")
        time.sleep(0.1)
