"""Full disk: no command that writes loses an earlier file, ends in a traceback, or leaves unsaid
which file it could not write.

A full disk is played by a limit on the size of files: a few bytes fit, as the semaphores of worker
processes need, no result does. Commands of ROS are left to the recorder's own tests.
"""

from __future__ import annotations

import io
import json
import multiprocessing as mp
import os
import resource
import sys
import tempfile
from collections.abc import Callable, Mapping
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import numpy as np

from bench.row import at_least, at_most
from pneuflex_sim.urdf import joint_names, joint_positions
from softhand_bringup.bags.states import HandStates, write_states
from softhand_bringup.command import main as softhand
from softhand_bringup.film.recording import film_trial
from softhand_trials.search.command import main as search
from softhand_trials.search.objective import objective
from softhand_trials.sweep.command import main as sweep
from softhand_trials.trials import Placement, TrialSettings

TAKES = "5 minutes"
ROOM = 64  # [bytes] that a file may have
EARLIER = b"earlier\n" * 20  # content of files that must stay
ROOT = Path(__file__).resolve().parents[2]
SET = ROOT / "examples" / "measurements" / "finger"
QUICK = "--strategy {}/short.yaml --step 0.01 --segments 2"
STRATEGY = """format: softhand-strategy/1
name: short
description: closes a little in the air
hand: single_finger
phases:
- name: close
  air_mass: {a: 1.0e-5}
  duration: 0.1
- name: hold
  duration: 0.1
"""
PROBLEM = """format: softhand-search/1
name: bowl
objective: bench.robust.full_disk:bowl
variables: {x: [-1, 1]}
sampler: random
evaluations: 4
"""
PLAN = """format: softhand-sweep/1
name: short
strategy: short.yaml
objects: [marker]
step: 0.01
segments: 2
cells: [[0, 0], [0.02, 0]]
"""


@objective
def bowl(values: Mapping[str, float], _settings: Mapping[str, Any]) -> dict[str, Any]:
    """A cost whose least is known."""
    return {"cost": values["x"] ** 2}


# ---------------------------------------------------------------- what must be there before
def _nothing(folder: Path) -> None:
    pass


def _inputs(folder: Path) -> None:
    for name, text in (("short", STRATEGY), ("bowl", PROBLEM), ("plan", PLAN)):
        (folder / f"{name}.yaml").write_text(text, encoding="utf-8")


def _swept(folder: Path) -> None:
    """A finished sweep whose first trial counts as a failure."""
    sweep([str(folder / "plan.yaml"), "--out", str(folder), "--jobs", "0"])
    path = folder / "results.jsonl"
    first, *others = map(json.loads, path.read_text(encoding="utf-8").splitlines())
    first |= {"cause": "missed", "phase": "close", "failed_at": 0.05}
    path.write_text("".join(json.dumps(each) + "\n" for each in [first, *others]))


def _searched(folder: Path) -> None:
    words = [str(folder / "bowl.yaml"), "--out", str(folder), "--jobs", "0", "--allow-objectives"]
    search(words)


def _bag(folder: Path) -> None:
    """The bag of a short grasp, and the same as its recorder left it when it was killed."""
    strategy = str(folder / "short.yaml")
    settings = TrialSettings(strategy=strategy, step=0.01, segments=2)
    film = film_trial(settings, Placement((0.0, 0.0), 1.0), 0.02)
    layout, states = film.renderer.layout, film.states
    grasp = HandStates(
        film.interval * np.arange(len(states)),
        joint_names(layout),
        np.array([joint_positions(state.joints) for state in states]),
        layout.description.channels,
        np.zeros_like(film.pressures),
        film.pressures,
        np.array([np.hstack([s.wrist_position, s.wrist_orientation]) for s in states]),
        np.array([np.hstack([s.object_position, s.object_orientation]) for s in states]),
        ["close"] * len(states),
    )
    for name in ("bag", "cut"):
        write_states(grasp, folder / name)
    (folder / "cut" / "metadata.yaml").unlink()


# ---------------------------------------------------------------- the commands
@dataclass(frozen=True)
class Writer:
    """A command line of `softhand` in which `{}` is its folder; the files of an earlier run; what
    is made before; the exit statuses that are right.
    """

    words: str
    earlier: tuple[str, ...] = ()
    prepare: Callable[[Path], None] = _nothing
    ends: tuple[int, ...] = (1, 2)


MOULD = tuple(f"P10.thumb_{end}" for end in ("shell_1.stl", "mould.txt", "mould.json", "mould.png"))
KIT = (
    *(f"P10.finger_{end}" for end in ("cast.stl", "layer.stl", "layer_tray.stl", "layer_mesh.svg")),
    *(f"single_finger_{end}" for end in ("scaffold.stl", "parts.txt", "parts.json", "bill.csv")),
    "single_finger_assembled.png",
)
FAST = "--points 60 --outlets 1"
LAB = f"--data {SET} --model base"
WRITERS: Mapping[str, Writer] = {
    "calibrate": Writer(f"calibrate --output {{}}/c.yaml --force {FAST}", ("c.yaml",)),
    "trials": Writer(f"trials {QUICK} --seeds 1 --jobs 1 --out {{}}/t.json --force", ("t.json",)),
    "sweep": Writer("sweep {}/plan.yaml --out {} --jobs 0"),
    "sweep report": Writer(
        "sweep report {} --force", ("report.md", "report.json", "shares.png"), _swept
    ),
    "search": Writer("search {}/bowl.yaml --out {} --jobs 0 --allow-objectives"),
    "search, done": Writer(
        "search {}/bowl.yaml --out {} --jobs 0 --allow-objectives", (), _searched, (0,)
    ),
    "failures": Writer("failures {}/results.jsonl -o {}", ("marker.png",), _swept),
    **{
        f"film {kind}": Writer(
            f"film -o {{}}/film{kind} --force --size 64x48 {QUICK}",
            ("film/frame_0000.png",) if kind == "" else (f"film{kind}",),
        )
        for kind in (".gif", ".mp4", "")
    },
    "figures": Writer("figures {}/bag {} --hand single_finger", ("grasp.png",), _bag),
    "repair-bag": Writer("repair-bag {}/cut", (), _bag),
    "hand design": Writer(
        "hand design --ratio 0.7 --stiffness 4 --length 90 -o {}/f.yaml --force", ("f.yaml",)
    ),
    "hand design --figure": Writer(
        "hand design --length 90 --ratio-profile 0.7 --stiffness-profile 4 --figure {}/f.png "
        "--force",
        ("f.png",),
    ),
    "hand mould": Writer("hand mould P10.thumb -o {} --force", MOULD),
    "hand parts": Writer("hand parts single_finger -o {} --force", KIT),
    "hand show": Writer("hand show single_finger --segments 3 -o {}/h.png --force", ("h.png",)),
    "hand urdf": Writer("hand urdf single_finger -o {}/h.urdf --force", ("h.urdf",)),
    **{
        f"skin {kind}": Writer(
            f"skin single_finger --frames 2 --segments 3 --format {kind} --out {{}} --force",
            tuple(f"single_finger_{k:03d}.{kind}" for k in range(2)),
        )
        for kind in ("obj", "stl", "png")
    },
    "skin --figure": Writer(
        "skin single_finger --segments 3 --figure {}/s.png --force", ("s.png",)
    ),
    "objects": Writer("objects ball --figure {}/o.png --force", ("o.png",)),
    "lab compare": Writer(f"lab compare {SET} --json {{}}/c.json --force", ("c.json",)),
    "lab diagnose": Writer(f"lab diagnose {SET} --jobs 1 --report {{}} --force", ("report.html",)),
    "lab add": Writer(f"lab add gent_stiffening {LAB} --out {{}}/m.yaml --force", ("m.yaml",)),
    "lab learn": Writer(
        f"lab learn {SET} --out {{}}/my_own.py --report {{}} --force", ("my_own.py", "learned.html")
    ),
    "lab ladder": Writer(f"lab ladder {SET} base --json {{}}/l.json --force", ("l.json",)),
    "lab plan": Writer(f"lab plan {SET} --jobs 1 --json {{}}/p.json --force", ("p.json",)),
    "lab synthesize": Writer(
        "lab synthesize free_bending --out {} --force", ("experiment.yaml", ".seal")
    ),
}


# ---------------------------------------------------------------- one command
@dataclass(frozen=True)
class Tried:
    """What a command did on a full disk: exit status (None: it raised), what it said on standard
    error, files that are not as they were, and how many new ones hold something.
    """

    status: int | None
    said: str
    lost: tuple[str, ...]
    left: tuple[str, ...]

    def bad(self, name: str) -> str:
        """What is wrong with it, empty if nothing is."""
        if self.status is None:
            return f"traceback: {self.said[-300:]}"
        if self.lost:
            return f"lost: {', '.join(self.lost)}"
        if self.left:
            return f"left behind: {', '.join(self.left)}"
        if self.status not in WRITERS[name].ends:
            return f"exit status {self.status}: {self.said[-300:]}"
        lines = self.said.strip().splitlines() or [""]
        return "" if "{}" in lines[-1] else f"no file named: {lines[-1]}"


def try_writer(name: str) -> Tried:
    """Run one command in a folder of its own, whose disk is full."""
    writer = WRITERS[name]
    with tempfile.TemporaryDirectory(prefix="softhand-full-") as made:
        folder = Path(made)
        _inputs(folder)
        with redirect_stdout(io.StringIO()), redirect_stderr(io.StringIO()):
            writer.prepare(folder)
        for earlier in writer.earlier:
            (folder / earlier).parent.mkdir(exist_ok=True)
            (folder / earlier).write_bytes(EARLIER)
        before = _content(folder)
        ours, theirs = mp.Pipe(duplex=False)
        words = [word.replace("{}", made) for word in writer.words.split()]
        child = mp.get_context("fork").Process(target=_on_full_disk, args=(words, theirs))
        child.start()
        theirs.close()
        try:
            status, said = ours.recv()
        except EOFError:
            status, said = None, "the process died"
        child.join()
        after = _content(folder)
        lost = tuple(path for path in before if after.get(path) != before[path])
        left = tuple(path for path, data in after.items() if data and path not in before)
        return Tried(status, said.replace(made, "{}"), lost, left)


def _content(folder: Path) -> dict[str, bytes]:
    return {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in folder.rglob("*")
        if path.is_file()
    }


def _on_full_disk(words: list[str], pipe: Connection) -> None:
    said = io.StringIO()
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.__stdout__.fileno())
    with redirect_stdout(io.StringIO()), redirect_stderr(said):
        resource.setrlimit(resource.RLIMIT_FSIZE, (ROOM, ROOM))
        try:
            status: int | None = softhand(words)
        except SystemExit as end:
            status = end.code if isinstance(end.code, int) else 1
            said.write("" if isinstance(end.code, int) else str(end.code))
        except BaseException as error:  # noqa: BLE001 (whatever it is, it is counted)
            status = None
            said.write(repr(error))
    pipe.send((status, said.getvalue()))


def run() -> list[dict[str, Any]]:
    """Rows on all commands."""
    found = {}
    for name in WRITERS:
        found[name] = try_writer(name)
        bad = found[name].bad(name)
        print(f"  {name}: {bad or found[name].said.strip().splitlines()[-1]}", flush=True)
    tried = found.values()
    told = sum(not one.bad(name) for name, one in found.items())
    return [
        at_most("full disk: earlier files lost", sum(len(one.lost) for one in tried), "files", 0),
        at_most("full disk: tracebacks", sum(one.status is None for one in tried), "commands", 0),
        at_most("full disk: parts left behind", sum(len(one.left) for one in tried), "files", 0),
        at_least("full disk: file named in one line", told, "commands", len(WRITERS)),
    ]
