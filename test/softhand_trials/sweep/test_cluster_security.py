"""A cluster as the page says to start it: who can connect to it, and what a client refuses."""

import os
import re
import shlex
import subprocess
import sys
from contextlib import contextmanager
from pathlib import Path

import dask
import psutil
import pytest
from distributed import Client

from softhand_trials.sweep import read_results
from softhand_trials.sweep.cluster import Cluster, check_address

PAGE = Path(__file__).parents[3] / "docs" / "use" / "cluster.md"
ONE_MACHINE, TLS = "On one machine", "On several machines: TLS"
PLAN = """
format: softhand-sweep/1
name: two
strategy: test_grasp.yaml
objects: [marker]
step: 0.01
segments: 2
cells: [[0, 0], [0.02, 0]]
"""
QUICK = """
format: softhand-strategy/1
name: quick
description: goes up
hand: single_finger
phases:
  - name: hold
    duration: 0.05
"""


def code_of(section):
    """The indented lines of a section of the page, one block after the other."""
    text = re.split(rf"\n##+ {section}\n", PAGE.read_text())[1].split("\n##")[0]
    return re.findall(r"(?:^    .*\n)+", text, re.MULTILINE)


def command(section, name):
    """Words of the first command of a section that starts with a name."""
    lines = "".join(code_of(section)).splitlines()
    line = next(line for line in lines if line.startswith(f"    .venv/bin/{name}"))
    program, *words = shlex.split(line, comments=True)
    return [str(Path(sys.executable).with_name(Path(program).name)), *words]


@contextmanager
def running(words, environment, sign):
    """A program of Dask as a process of its own: that, and the line of its log with a sign."""
    process = subprocess.Popen(words, env=environment, stderr=subprocess.PIPE, text=True)
    family = psutil.Process(process.pid)
    try:
        yield family, next(line for line in process.stderr if sign in line)
    finally:
        left = family.children(recursive=True)
        process.terminate()
        process.communicate(timeout=60)
        assert psutil.wait_procs(left, timeout=60)[1] == []


@contextmanager
def cluster(section, environment):
    """Scheduler and worker as a section says, at a port that is free and on this machine alone: the
    scheduler's address, and both processes.
    """
    words = [
        {"8786": "0", "10.0.0.1": "127.0.0.1", "127.0.0.1:8787": "127.0.0.1:0"}.get(word, word)
        for word in command(section, "dask scheduler")
    ]
    with running(words, environment, "Scheduler at:") as (scheduler, line):
        address = line.split()[-1]
        program, name, _, *options = command(section, "dask worker")
        options[options.index("--nworkers") + 1] = "1"
        if "--host" not in options:
            options += ["--host", "127.0.0.1"]
        words = [program, name, address, *options]
        with running(words, environment, "Registered to:") as (worker, _):
            yield address, (scheduler, worker)


def listening(process):
    """Addresses at which a process and its children listen."""
    family = [process, *process.children(recursive=True)]
    sockets = [socket for member in family for socket in member.net_connections()]
    return {socket.laddr.ip for socket in sockets if socket.status == psutil.CONN_LISTEN}


def sweep(section, folder, address, environment):
    """The page's sweep of a small plan."""
    *words, _, _, _ = command(section, "softhand sweep")
    words += [str(folder / "plan.yaml"), "--scheduler", address, "--out", str(folder / "out")]
    done = subprocess.run(words, env=environment, cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


@pytest.fixture
def plan(write_strategy, tmp_path):
    """A folder with a plan of two short trials."""
    write_strategy(text=QUICK)
    (tmp_path / "plan.yaml").write_text(PLAN)
    return tmp_path


def test_on_one_machine_scheduler_and_workers_listen_on_loopback_alone(plan):
    with cluster(ONE_MACHINE, os.environ) as (address, processes):
        assert [listening(process) for process in processes] == [{"127.0.0.1"}] * 2
        sweep(ONE_MACHINE, plan, address, os.environ)
    assert len(read_results(plan / "out")) == 2


def test_with_the_certificate_of_the_page_a_sweep_runs_and_nobody_without_it_gets_in(plan):
    stranger = os.environ | {"HOME": str(plan)}
    recipe = next(block for block in code_of(TLS) if "openssl" in block)
    script = re.sub("^    ", "", recipe, flags=re.MULTILINE)
    subprocess.run(["bash", "-ec", script], env=stranger, check=True, capture_output=True)
    assert (plan / "sweep-tls").stat().st_mode & 0o77 == 0
    member = stranger | {"DASK_CONFIG": str(plan / "sweep-tls")}
    with cluster(TLS, member) as (address, _):
        assert address.startswith("tls://")
        plain = address.replace("tls:", "tcp:")
        with pytest.raises(OSError, match="Connection reset|Timed out|closed"):
            Client(plain, timeout=5.0, set_as_default=False)
        sweep(TLS, plan, address, member)
    assert len(read_results(plan / "out")) == 2


def test_tls_without_certificates_is_refused():
    with pytest.raises(ValueError, match="expected ca-file and client certificate .* for tls://"):
        next(Cluster("tls://127.0.0.1:9").run(["a line"]))


def test_a_configuration_that_demands_encryption_is_kept():
    with (
        dask.config.set({"distributed.comm.require-encryption": True}),
        pytest.raises(ValueError, match="expected tls://, as Dask's configuration demands"),
    ):
        next(Cluster("tcp://127.0.0.1:9").run(["a line"]))


@pytest.mark.parametrize(
    "address",
    ["tls://10.0.0.1:8786", "tcp://127.0.0.1:8786", "tcp://[::1]:8786", "tcp://localhost:1"],
)
def test_tls_and_loopback_are_accepted(address):
    check_address(address)


@pytest.mark.parametrize(
    "address",
    [
        "tcp://10.0.0.1:8786",
        "tcp://0.0.0.0:8786",
        "tcp://node:8786",
        "10.0.0.1:8786",
        "node",
        "ws://node:1",
    ]
    + ["tcp://localhost.example.org:1", "tcp://127.0.0.1@10.0.0.1:8786"],
)
def test_a_plain_connection_over_a_network_is_refused(address):
    with pytest.raises(ValueError, match="scheduler: expected tls://HOST:PORT, or tcp://127.0.0.1"):
        Cluster(address)
