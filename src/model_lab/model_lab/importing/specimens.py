"""Which specimen and which protocol a run has, as the names of files tell."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from string import ascii_lowercase

from model_lab.importing.cell_words import mode_in
from model_lab.measurements.drives import Drive, driven_alike
from model_lab.rules import RULES

PROTOCOL_WORDS = (
    "ramp rampe step sprung stufe half halb full voll slow fast langsam schnell sine sinus "
    "cycle zyklus cyc creep kriechen hold halten relax relaxation pull zug load unload "
    "loading unloading up down auf ab inflate deflate test run lauf exp experiment trial "
    "versuch messung measurement data daten log rec record recording repeat wdh rep low high "
    "small large max min first last before after cold warm hot kalt bending blocked free "
    "uniaxial tensile chirp square triangle tri triangular sawtooth saegezahn zigzag dreieck "
    "stair stairs staircase treppe steps pulse pulses puls burst random peak level amplitude "
    "swing press release grip "
    "spitze niveau day tag jour dia week woche session sitzung sideways roll updown twist"
)  # that say what was done, not to which specimen
SETTING_WORD = re.compile(
    r"[pvtf]?\d+(?:p\d+)?(?:kpa|mbar|bar|psi|hz|mm|s|ms|deg|grad|pct|n|(?:deg|grad|°)?c|k)?$"
)
LEVEL = re.compile(r"[1-9]\d+")
NUMBERED_WORD = re.compile(r"([^\W\d_]+)[_\- ]*\d+(?![^\W_])")
NUMBER_INSIDE = re.compile(r"(?<=[_\- ])(\d+)[_\- ]+(?=[^\W\d])")
"""A number inside of a name, before a word."""
FEWEST_COUNTED = 3  # runs that a number inside of their names may count
SETTING_AND_REPEAT = re.compile(r"[^\W\d_][_\- ]*\d{2,}[_\- ]+\d$")
OTHER_DAY = re.compile(
    r"(?<![^\W_])(?:day|tag|jour|dia|week|woche|session|sitzung)[_\- ]*\d+(?![^\W_])[_\- ]*", re.I
)  # on which the same may be done again
SPECIMEN_NAMES = (
    "specimen|finger|actuator|aktor|sample|strip|dogbone|probe|prüfling|prufling|muster|éprouvette"
)
SPECIMEN_WORD = re.compile(rf"(?:{SPECIMEN_NAMES})\w+", re.I)
SPECIMEN_AT_END = re.compile(
    r"(?<![^\W_])(?:specimen|spec|dogbone|probe|prüfling|éprouvette|probeta|provino)[_\- ]*(\d+)$",
    re.I,
)
NUMBERED_SPECIMEN = re.compile(rf"({SPECIMEN_NAMES})[_\- ]*(\d+)(?=[_\- ]+\w)", re.I)
_PROTOCOLS = frozenset(PROTOCOL_WORDS.split())
FALLBACK_PROTOCOL = "run"


@dataclass(frozen=True)
class Assigned:
    """Specimen and protocol of each run, by the name of the run; a specimen is "" if there is only
    one.

    unsure: words that are in the names of some runs only, and may name a specimen or a protocol.
    """

    specimens: Mapping[str, str]
    protocols: Mapping[str, str]
    unsure: tuple[str, ...] = ()

    @property
    def names(self) -> list[str]:
        """Names of the specimens, in the order of the runs."""
        return list(dict.fromkeys(self.specimens.values()))


def assigned(runs: Sequence[str], telling_mode: bool = False) -> Assigned:
    """Specimens and protocols that the names of runs tell: `thin_ramp_1` is the first ramp of the
    specimen thin.

    Words that all names share, and numbers of repeats at the end, tell nothing. A word that is
    neither a usual name of a protocol nor a setting such as 40kPa names a specimen, if every name
    has such a word. telling_mode: whether words for a mode of a test of rubber say what was done.

    >>> assigned(["thin_1", "thin_2", "thick_1"]).names
    ['thin', 'thick']
    >>> assigned(["ramp_1", "half_1"]).names, assigned(["A_stair", "A_tri", "B_stair"]).names
    ([''], ['A', 'B'])
    >>> assigned(["A_ramp_1", "A_odd_2", "B_ramp_1"]).names
    ['A', 'B']
    >>> assigned(["finger1_odd", "finger1_even", "finger2_odd", "finger2_even"]).names
    ['finger1', 'finger2']
    >>> assigned(["Probe_1_1", "Probe_1_2", "Probe_2_1"]).names
    ['Probe1', 'Probe2']
    """

    def is_done(word: str) -> bool:
        return _is_protocol(word) or (telling_mode and _is_of_mode(word))

    by_name = protocols_of(runs)
    words = {run: _words(name) for run, name in by_name.items()}
    shared = set.intersection(*(set(found) for found in words.values())) if words else set()
    telling = {
        run: [word for word in found if word not in shared and not is_done(word)]
        for run, found in words.items()
    }
    telling = _without_extra_words(telling)
    some = tuple(dict.fromkeys(word for found in telling.values() for word in found))
    if len({tuple(found) for found in telling.values()}) < 2 or not all(telling.values()):
        return Assigned(dict.fromkeys(runs, ""), by_name, some)
    protocols = {
        run: "_".join(word for word in words[run] if word not in telling[run]) or FALLBACK_PROTOCOL
        for run in runs
    }
    return Assigned({run: "_".join(found) for run, found in telling.items()}, protocols)


def _without_extra_words(telling: Mapping[str, list[str]]) -> dict[str, list[str]]:
    """Words that tell the specimen of each run: of `A` and `A_short` both have the specimen A, and
    short says what was done; of `finger1_odd` and `finger2_even` finger1 and finger2.
    """
    named = {run: [w for w in found if SPECIMEN_WORD.match(w)] for run, found in telling.items()}
    telling = named if all(named.values()) else dict(telling)
    known = {tuple(found) for found in telling.values() if found}
    return {
        run: min(
            (list(fewer) for fewer in known if set(fewer) <= set(found)), key=len, default=found
        )
        for run, found in telling.items()
    }


def protocols_by_drive(
    found: Assigned, drives: Mapping[str, Drive], modes: Mapping[str, str]
) -> dict[str, str]:
    """The protocol of each run, by its name: as `found` from the names, but runs of one protocol
    that were driven otherwise, or to levels that their names number, get one of their own, with a
    letter.

    drives: input of each run. modes: of each run in a test of rubber.
    """
    kinds: dict[tuple[str, str, str], list[tuple[str, Drive]]] = defaultdict(list)
    protocols = {}
    for run, drive in drives.items():
        name = found.protocols[run]
        kind = kinds[found.specimens[run], name, modes.get(run, "")]
        alike = [
            number
            for number, (first, other) in enumerate(kind)
            if driven_alike(drive, other) and not _name_levels(run, first, drive, other)
        ]
        number = alike[0] if alike else len(kind)
        if not alike:
            kind.append((run, drive))
        letters = [*ascii_lowercase, str(number + 1)]
        protocols[run] = f"{name}_{letters[min(number, len(ascii_lowercase))]}" if number else name
    return protocols


def new_specimens(runs: Sequence[str]) -> list[str]:
    """Runs whose names end with the number of their specimen; empty unless all do, each with a
    number of its own, as in tests of rubber each is pulled once.

    >>> new_specimens(["DS10_specimen_1", "DS10_specimen_2"]), new_specimens(["pull_1", "pull_2"])
    (['DS10_specimen_1', 'DS10_specimen_2'], [])
    """
    ends = [SPECIMEN_AT_END.search(run) for run in runs]
    numbers = {end[1] for end in ends if end}
    return list(runs) if len(numbers) == len(runs) > 1 else []


def _name_levels(run: str, other: str, drive: Drive, of_other: Drive) -> bool:
    """Whether the names of two runs number the levels to which they were driven, as `peak18` and
    `peak26` do if the second input goes 26/18 times as far.
    """
    numbers = [[int(number) for number in LEVEL.findall(name)] for name in (run, other)]
    if not of_other.extent > 0.0:
        return False
    further = drive.extent / of_other.extent
    return any(
        max(a, b) >= RULES.named_level * min(a, b)
        and abs(a / b / further - 1.0) < RULES.named_level_misses
        for a, b in zip(*numbers, strict=False)
    )


def _words(name: str) -> list[str]:
    """The words of a name."""
    return [word for word in re.split(r"[^0-9A-Za-z\u00c0-\u024f]+", name) if word]


def _is_protocol(word: str) -> bool:
    plain = word.casefold()
    return (
        plain in _PROTOCOLS
        or plain.rstrip("0123456789") in _PROTOCOLS
        or (SETTING_WORD.match(plain) is not None)
    )


def _is_of_mode(word: str) -> bool:
    plain = word.casefold()
    return bool(mode_in(word)) or plain in ("pure", "shear", "reiner", "schub", "scherung")


def protocols_of(runs: Sequence[str]) -> dict[str, str]:
    """Name of the protocol of each run: its name without the number of its repeat, and without a
    number in the middle that counts all runs; a number after a word such as finger, before another
    word or number, belongs to that word.

    >>> protocols_of(["A_01_stairs", "A_02_ramp", "A_03_stairs"])
    {'A_01_stairs': 'A_stairs', 'A_02_ramp': 'A_ramp', 'A_03_stairs': 'A_stairs'}
    >>> [*protocols_of(["A_10_ramp", "A_20_ramp", "A_30_ramp"]).values()]
    ['A_10_ramp', 'A_20_ramp', 'A_30_ramp']
    """
    names = {run: NUMBERED_SPECIMEN.sub(r"\1\2", run) for run in runs}
    plain = {run: NUMBER_INSIDE.sub("", name) for run, name in names.items()}
    counts = {run: NUMBER_INSIDE.findall(name) for run, name in names.items()}
    done: dict[int, set[tuple[str, ...]]] = defaultdict(set)
    for run, found in counts.items():
        for number in found:
            done[int(number)].add(tuple(filter(_is_protocol, _words(plain[run]))))
    counted = (
        all(len(found) == 1 for found in counts.values())
        and len(done) >= FEWEST_COUNTED
        and max(done) - min(done) < len(done)
        and all(len(kinds) == 1 for kinds in done.values())
        and len(set(plain.values())) < len(plain)
    )
    return {run: protocol_of(name) for run, name in (plain if counted else names).items()}


def protocol_of(name: str) -> str:
    """Name of the protocol of a run: the name of the run without the number of its repeat, at its
    beginning, at its end or after a word for what was done. A number of two digits after such a
    word is a setting, such as a pressure, if another number at the end counts the repeats.

    >>> protocol_of("ramp_2"), protocol_of("run3"), protocol_of("7")
    ('ramp', 'run', '7')
    >>> protocol_of("pull1_slow"), protocol_of("02_fast"), protocol_of("20kPa_slow")
    ('pull_slow', 'fast', '20kPa_slow')
    >>> protocol_of("hold30_1"), protocol_of("hold_40_2"), protocol_of("run3_2")
    ('hold30', 'hold_40', 'run')
    >>> protocol_of("strip_day02_1"), protocol_of("day_2_ramp_3"), protocol_of("session 2")
    ('strip', 'ramp', 'session')
    """
    name = OTHER_DAY.sub("", name).strip("_- ") or name
    if SETTING_AND_REPEAT.search(name):
        return name.rstrip("0123456789").rstrip("_- ")
    unnumbered = NUMBERED_WORD.sub(
        lambda found: found[1] if found[1].casefold() in _PROTOCOLS else found[0], name
    )
    unnumbered = re.sub(r"^\d+[_\- ]+(?=\D)", "", unnumbered)
    return unnumbered.rstrip("0123456789").rstrip("_- ") or name
