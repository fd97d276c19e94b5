"""Mutated files of every format: each is read as it should be, or refused with file and place.

`python -m bench.robust.files --per-format 1000 --seed 0` prints what was taken or refused badly.
Every case is read in a worker process with a limit on its memory; one that hangs is ended.
"""

from __future__ import annotations

import argparse
import math
import multiprocessing as mp
import random
import resource
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields, is_dataclass
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import numpy as np

from bench.robust.formats import FORMATS, LARGEST, Format
from bench.robust.mutations import damaged, is_refusal
from bench.row import at_most, stated

LONGEST = 5.0  # [s] of calculation that a file may take
HANGS = 60.0  # [s] of the wall after which it is ended; other work may slow the machine down
MOST_MEMORY = 2**30  # [bytes] beyond what the process has before
NOT_NEGATIVE = frozenset(
    (
        *("length", "width", "height", "wall", "side_wall", "thickness", "diameter", "size"),
        *("mass", "modulus", "shear_modulus", "density", "volume", "tank_volume", "full_scale"),
        *("speed", "duration", "noise", "std", "delivery", "inclination"),
    )
)
KINDS = ("traceback", "over 5 s", "over 1 GB", "refused without file and place", "taken, senseless")


@dataclass(frozen=True)
class Case:
    """What became of one mutated file; `bad` is empty for one that was treated well."""

    seed: int
    taken: bool
    bad: str
    message: str


def try_case(form: Format, name: str, seed: int) -> Case:
    """Write, mutate and read one file; the same seed gives the same file."""
    chance = random.Random(f"{name} {seed}")
    with tempfile.TemporaryDirectory(prefix="softhand-files-") as folder:
        path = form.write(Path(folder))
        mutate = damaged if form.mutate is None or chance.random() < 0.4 else form.mutate
        path.write_bytes(mutate(path.read_bytes(), chance))
        begun = time.process_time()
        taken, bad, message = _outcome(form, path)
        if time.process_time() - begun > LONGEST:
            bad = bad or "over 5 s"
    return Case(seed, taken, bad, message)


def _outcome(form: Format, path: Path) -> tuple[bool, str, str]:
    try:
        found = form.read(path)
    except MemoryError as reason:
        return False, "over 1 GB", repr(reason)
    except ValueError as reason:
        named = is_refusal(str(reason), form.named(path))
        return False, "" if named else "refused without file and place", str(reason)
    except BaseException as reason:  # noqa: BLE001 (whatever it is, it is counted)
        return False, "traceback", repr(reason)
    senseless = next(_senseless(found, ""), "")
    return True, "taken, senseless" if senseless else "", senseless


def _senseless(value: Any, name: str) -> Iterator[str]:
    """Numbers that no quantity can have, with their names."""
    if isinstance(value, np.ndarray) and value.dtype.kind == "f":
        if value.size and not np.abs(value).max() <= LARGEST:
            yield f"{name}: {value}"
    elif isinstance(value, bool | str | Path) or value is None:
        return
    elif isinstance(value, int | float):
        if (
            not math.isfinite(value)
            or (abs(value) > LARGEST and name != "box_seed")
            or (value < 0 and name in NOT_NEGATIVE)
        ):
            yield f"{name}: {value}"
    else:
        for inner, part in _parts(value, name):
            yield from _senseless(part, inner)


def _parts(value: Any, name: str) -> Iterator[tuple[str, Any]]:
    if is_dataclass(value):
        yield from ((field.name, getattr(value, field.name)) for field in fields(value))
    elif isinstance(value, Mapping):
        yield from ((str(key), part) for key, part in value.items())
    elif isinstance(value, list | tuple):
        yield from ((name, part) for part in value)


# ---------------------------------------------------------------------- workers
def run_format(name: str, count: int, seed: int) -> list[Case]:
    """All cases of a format, in a process that is replaced where it hangs or dies."""
    cases: list[Case] = []
    while len(cases) < count:
        begin = seed + len(cases)
        ours, theirs = mp.Pipe(duplex=False)
        worker = mp.get_context("fork").Process(
            target=_work, args=(name, begin, seed + count, theirs), daemon=True
        )
        worker.start()
        theirs.close()
        cases += _collect(ours, seed + len(cases), seed + count)
        worker.kill()
        worker.join()
    return cases


def _collect(pipe: Connection, begin: int, end: int) -> list[Case]:
    cases: list[Case] = []
    while begin + len(cases) < end:
        here = begin + len(cases)
        if not pipe.poll(HANGS):
            return [*cases, Case(here, False, "over 5 s", f"no end within {HANGS:g} s")]
        try:
            cases.append(pipe.recv())
        except EOFError:
            return [*cases, Case(here, False, "traceback", "the process died")]
    return cases


def _work(name: str, begin: int, end: int, pipe: Connection) -> None:
    _warm(name)
    size = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (size + MOST_MEMORY, size + MOST_MEMORY))
    for seed in range(begin, end):
        pipe.send(try_case(FORMATS[name], name, seed))


def _warm(name: str) -> None:
    """Read a sound file, so that what is loaded once does not count."""
    with tempfile.TemporaryDirectory(prefix="softhand-files-") as folder:
        FORMATS[name].read(FORMATS[name].write(Path(folder)))


def rows_of(found: Mapping[str, list[Case]]) -> list[dict[str, Any]]:
    """Rows: badly treated files a format, and of all formats by kind."""
    kinds = Counter(case.bad for cases in found.values() for case in cases)
    rows = [at_most(f"mutated files: {kind}", kinds[kind], "files", 0) for kind in KINDS]
    for name, cases in found.items():
        bad = sum(bool(case.bad) for case in cases)
        rows.append(at_most(f"mutated {name} files badly treated", bad, f"of {len(cases)}", 0))
        rows.append(stated(f"mutated {name} files taken", sum(c.taken for c in cases), "files"))
    return rows


def run(per_format: int = 1000, seed: int = 0) -> list[dict[str, Any]]:
    """Rows of all formats."""
    return rows_of({name: run_format(name, per_format, seed) for name in FORMATS})


def main(arguments: list[str] | None = None) -> int:
    """Print what was treated badly, and the rows; 1 where there is any."""
    parser = argparse.ArgumentParser(prog="python -m bench.robust.files", description=__doc__)
    parser.add_argument("--per-format", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=0, help="of the first file; they go up by one")
    parser.add_argument("--formats", nargs="+", choices=list(FORMATS), default=list(FORMATS))
    options = parser.parse_args(arguments)
    found = {}
    for name in options.formats:
        found[name] = run_format(name, options.per_format, options.seed)
        for case in found[name]:
            if case.bad:
                print(f"{name} {case.seed}: {case.bad}: {case.message[:300]}", flush=True)
    rows = rows_of(found)
    for row in rows:
        print(f"{row['name']}: {row['value']:g} {row['unit']} {row['target'] or ''}")
    return int(any(row["met"] is False for row in rows))


if __name__ == "__main__":
    sys.exit(main())
