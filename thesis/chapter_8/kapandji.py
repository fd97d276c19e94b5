"""Kapandji test of RBO Hand 2's thumb (8.2.1, Figs 7.7, 8.7, 8.8).

Pressures are searched, where the thesis chose them by hand; it does not say that these were those
of the four channels, so a channel of its own for each actuator is a reading of it, too. Places and
judge are those of `thesis.chapter_8.dexterity.kapandji`.

A search tries the postures that come nearest to the place by statics, without contact
(`thesis.chapter_8.dexterity.reach`), each with the thumb and with the fingers filled first, with
seven channels before all others the winner with four. The best postures that touch are tried with
varied pressures. Unless one of them is good enough in all these tries, CMA-ES goes on around the
best posture, and its best ones are tried in the same way. The winner is the posture with the lowest
worst cost of all tries. A place that statics leave far away is judged and not searched.

Where the winner misses the place in one of these tries or of two more, a longer search goes on, in
which a posture that touches is repeated with varied pressures at once: from the best postures so
far, and the winners of neighbouring places and of other channels, by CMA-ES around the best one,
CMA-ES around the best so far, and TPE in the whole range. It ends when a posture touches in all its
tries. Pressures vary by more there than in the verdict: with as much, a posture that had touched in
all tries was lost in the verdict (place 6, seven channels). Winners are judged again with other
draws, and a place counts as reached when all of these repeats touch it.

The cost, in which a contact elsewhere is no worse than none, was chosen on place 8 with four
channels. The order became a variable after place 2: in six postures near it the index came down on
the wrong side of the thumb that was filled first, and in two of them the thumb touched the place
when the fingers were filled first. Searches run at steps of 2 ms: at 5 ms, fingers that press on
each other trembled, and touches found there were lost at 2 ms.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from pneuflex_sim.pictures.render import Camera, HandState, Renderer
from softhand_model.hand.hand import load_hand
from softhand_trials.search import (
    SearchProblem,
    SearchResult,
    Tried,
    Variable,
    search_with,
    try_again,
)
from softhand_trials.search.objective import COST
from softhand_trials.search.problem import Evaluation
from softhand_trials.sweep.results import RESULTS_FILE, read_results
from softhand_trials.sweep.results import Results as KeptResults
from softhand_trials.sweep.run import Workers, finish, start_workers
from softhand_trials.sweep.task import Record
from thesis.chapter_8.dexterity.kapandji import OTHER_RADII, RADIUS, TARGETS, Target
from thesis.chapter_8.dexterity.posture import (
    FOUR,
    HAND,
    PALM,
    RIGID,
    SEVEN,
    THUMB_FIRST,
    PosedHand,
    hand_variant,
)
from thesis.chapter_8.dexterity.reach import StaticReach
from thesis.frame import Array, Figure, Finding, Job, Report, Results, option

SIZE = (12.0, 9.5)
NO_INDEX = "no_index"
CASES = {  # hand, channels that stay empty, places
    FOUR: (FOUR, (), tuple(range(1, 9))),
    SEVEN: (SEVEN, (), tuple(range(1, 9))),
    RIGID: (RIGID, (), tuple(range(1, 9))),
    NO_INDEX: (FOUR, ("b",), (1, 2, 3)),
}
OBJECTIVE = "thesis.chapter_8.dexterity.posture:touch_place"
HOLDING = "thesis.chapter_8.dexterity.posture:hold_place"
FIRST_TRY, FIRST_HELD = 100, 200  # seeds of draws of tries, and of the longer search
ALL = "all"
HELD = 2  # draws of the longer search's first round; later ones add those of the tries
WIDER = 0.03  # share by which pressures vary in the longer search: more than in the verdict
KNOWN = 4  # postures of the short search from which the longer one starts
ENOUGH_HELD = 6.0  # cost [mm] with which a round of the longer search ends
A_ROUND = 1000  # between the seeds of its rounds
WORDS = {
    FOUR: "four channels",
    SEVEN: "seven channels",
    RIGID: "palm rigid",
    NO_INDEX: "index empty",
}
LEAST = {FOUR: 6, SEVEN: 7}  # places that are to be reached
MOST_RIGID = 3  # places that may be reached with a palm that is rigid
ENOUGH = 4.0  # worst cost [mm] in tries with which a search ends: half the radius
FAR = 0.030  # [m] of a place by statics from which on it is not searched
SPREAD = 0.1  # of CMA-ES around the best posture from statics, as a share of each range
VIEW = {"target": (0.0, 0.0, 0.12), "distance": 4.0, "view_angle": 3.2, "yaw": 90.0, "pitch": 0.0}
UPRIGHT = np.zeros(3), np.array([0.0, 0.0, 0.0, 1.0])
PIXELS = 420
SMALL = {
    "places": (4,),
    "cases": (FOUR,),
    "starts": 4,
    "around": 4,
    "generation": 4,
    "tried": (1,),
    "sure": 1,
    "local": 4,
    "wide": 4,
    "segments": 5,
    "step": 0.005,
    "fine_step": 0.0025,
    "points": 2,
    "jobs": 0,
}


@dataclass(frozen=True)
class Parameters:
    """Options of the experiment."""

    places: tuple[int, ...] = option(tuple(range(1, 9)), "by their numbers [-]")
    cases: tuple[str, ...] = option(tuple(CASES), "hands and channels that are searched [-]")
    starts: int = option(16, "evaluations of postures from statics, a place [-]")
    around: int = option(40, "evaluations of CMA-ES around the best of them [-]")
    tried: tuple[int, ...] = option(
        (4, 3, 2), "candidates that each draw of other pressures is tried on [-]"
    )
    sure: int = option(2, "further draws in which the best of them is to touch, too [-]")
    longer: tuple[str, ...] = option(
        (ALL,), "searches that go on where they miss, such as seven_channels_6, or all [-]"
    )
    local: int = option(56, "evaluations of CMA-ES in each of two rounds of the longer search [-]")
    wide: int = option(120, "evaluations of TPE after these rounds [-]")
    generation: int = option(8, "evaluations a generation of CMA-ES [-]")
    repeats: int = option(3, "judged postures of each winner [-]")
    step: float = option(0.002, "of the physics [s]")
    fine_step: float = option(0.001, "of another verdict on the first case's winners [s]")
    segments: int = option(8, "an actuator [-]")
    points: int = option(6, "pressures a channel of the thumb base's workspace [-]")
    seed: int = option(9000, "of searches and repeats [-]")
    jobs: int = option(1, "processes [-]")


def problem(given: Parameters, case: str, place: int) -> SearchProblem:
    """The search for one place by CMA-ES."""
    variant, empty, _ = CASES[case]
    hand = hand_variant(variant)
    return SearchProblem(
        f"{case}_{place}",
        OBJECTIVE,
        tuple(
            Variable(name, 0.0, float(limit))
            for name, limit in zip(hand.channels, hand.max_pressures(), strict=True)
            if name not in empty
        )
        + (Variable(THUMB_FIRST, 0.0, 1.0),),
        given.around,
        given.generation,
        seed=given.seed + place,
        settings={
            "place": place,
            "hand": variant,
            "step": given.step,
            "segments": given.segments,
        },
        allow_any=True,
    )


# ---------------------------------------------------------------- run
def run(given: Parameters, job: Job) -> Results:
    """Searches of all cases and places, repeats of the winners, the workspace of the thumb's base,
    and the postures of one case.
    """
    wanted = [(c, p) for c in given.cases for p in CASES[c][2] if p in given.places]
    found: dict[str, dict[str, Any]] = {case: {} for case in given.cases}
    with start_workers(given.jobs) as workers:
        searches = Searches(workers, given, job.folder)
        for number, (case, place) in enumerate(wanted):
            job.progress(f"{case}, place {place}", number / (len(wanted) + 1))
            one = searches.whole(case, place)
            found[case][str(place)] = _judged(workers, given, case, place, one, job.folder)
        job.progress("finer steps, postures, workspace", len(wanted) / (len(wanted) + 1))
        fine = {
            case: finely(workers, given, case, found[case], job.folder)
            for case in LEAST
            if case in found
        }
    return {"cases": found, "fine": fine, **postures(found, given), **workspace(given)}


@dataclass(frozen=True)
class Found:
    """The winner of a search with its tries, its distance without contact [m], values of the best
    evaluations, the best one first, and whether the winner is of the longer search.
    """

    tried: Tried
    statics: float
    best: Sequence[Mapping[str, float]] = ()
    longer: bool = False

    @property
    def values(self) -> Mapping[str, float]:
        """Values of the winner's variables."""
        return dict(self.tried.record["values"])


class Searches:
    """Searches of cases and places, each made when it or one that starts from it is asked for."""

    def __init__(self, workers: Workers, given: Parameters, folder: Path) -> None:
        self._given = workers, given, folder
        self._short: dict[tuple[str, int], Found] = {}
        self._whole: dict[tuple[str, int], Found] = {}

    def short(self, case: str, place: int) -> Found:
        """The winner of the short search; that with four channels is where seven start."""
        if (case, place) not in self._short:
            workers, given, folder = self._given
            known = [by_actuator(self.short(FOUR, place).values)] if case == SEVEN else []
            self._short[case, place] = _searched(workers, given, case, place, known, folder)
        return self._short[case, place]

    def whole(self, case: str, place: int) -> Found:
        """The winner of the longer search where the short one misses the place, else its winner."""
        one = self.short(case, place)
        workers, given, folder = self._given
        named = {ALL, problem(given, case, place).name} & set(given.longer)
        if _holds(one.tried) or one.statics > FAR or not named:
            return one
        if (case, place) not in self._whole:
            known = self._known(case, place)
            self._whole[case, place] = _longer(workers, given, case, place, one, known, folder)
        return self._whole[case, place]

    def _known(self, case: str, place: int) -> list[Mapping[str, float]]:
        """Postures that may be near one that touches: of the same place with other channels, then
        of the places beside it.
        """
        if case == SEVEN:
            other = by_actuator(self.short(FOUR, place).values)
        elif case == FOUR:
            other = by_channel(self.whole(SEVEN, place).values, TARGETS[place - 1].finger)
        else:
            other = dict(self.whole(FOUR, place).values)
        beside = [near for near in (place - 1, place + 1) if near in CASES[case][2]]
        return [other, *(self.short(case, near).values for near in beside)]


@lru_cache(maxsize=len(CASES))
def statics(case: str, segments: int) -> StaticReach:
    """Postures of a case without contact."""
    variant, empty, _ = CASES[case]
    return StaticReach(hand_variant(variant), segments, empty)


def by_actuator(values: Mapping[str, float]) -> dict[str, float]:
    """Pressures [Pa] of the seven channels at given ones of the four, and the order."""
    fed = {k: v for chain in load_hand(HAND).chains for k, v in chain.channels.items()}
    by_name = {actuator: values.get(channel, 0.0) for actuator, channel in fed.items()}
    return by_name | {THUMB_FIRST: values[THUMB_FIRST]}


def by_channel(values: Mapping[str, float], finger: str) -> dict[str, float]:
    """Pressures [Pa] of the four channels near given ones of the seven: that of the finger where it
    has a part in a channel, else their mean; and the order.
    """
    hand = load_hand(HAND)
    fed: dict[str, list[str]] = {name: [] for name in hand.channels}
    for chain in hand.chains:
        for actuator, channel in chain.channels.items():
            fed[channel].append(actuator)
    found = {THUMB_FIRST: values[THUMB_FIRST]}
    for (channel, actuators), limit in zip(fed.items(), hand.max_pressures(), strict=True):
        used = [finger] if finger in actuators else actuators
        found[channel] = min(float(limit), float(np.mean([values[name] for name in used])))
    return found


def _searched(
    workers: Workers,
    given: Parameters,
    case: str,
    place: int,
    known: Sequence[Mapping[str, float]],
    folder: Path,
) -> Found:
    """The winner of a search from known postures and those of statics."""
    reach, folder = statics(case, given.segments), folder / case / str(place)
    nearest = reach.nearest(TARGETS[place - 1])
    search = problem(given, case, place)
    if nearest.distance > FAR:
        values = _named(search, case, nearest.pressures, True)
        return Found(Tried({"values": values, COST: np.inf}, ()), nearest.distance)
    near = reach.starts(TARGETS[place - 1], -(-given.starts // 2))
    both = [_named(search, case, n.pressures, first) for n in near for first in (False, True)]
    result = _all_of(workers, search, [*known, *both[: given.starts]], folder / "statics")
    found = [_tried(workers, given, search, result, folder / "statics_tried")]
    if not (found[0].records and found[0].worst <= ENOUGH):
        around = replace(
            search,
            name=f"{search.name}_around",
            start=dict(found[0].record["values"]),
            spread=SPREAD,
        )
        more = search_with(workers, around, folder / "around")
        found.append(_tried(workers, given, around, more, folder / "around_tried"))
        result = SearchResult([*result.records, *more.records])
    best = _surely(workers, given, search, min(found, key=_rank), folder / "surely")
    others = [record["values"] for record in result.best_of_generations(given.generation)]
    return Found(best, nearest.distance, others[:KNOWN])


def _longer(
    workers: Workers,
    given: Parameters,
    case: str,
    place: int,
    short: Found,
    known: Sequence[Mapping[str, float]],
    folder: Path,
) -> Found:
    """The winner of a longer search, from the best postures of the short one and known ones."""
    folder = folder / case / str(place) / "longer"
    search = problem(given, case, place).with_settings(spread=WIDER)
    draws = [FIRST_HELD + k for k in range(HELD)]
    more = [FIRST_TRY + k for k in range(len(given.tried) + given.sure)]
    holding = replace(search, objective=HOLDING)
    starts = [_within(search, one) for one in (short.values, *short.best, *known)]
    distinct = [one for k, one in enumerate(starts) if one not in starts[:k]]
    seen: list[Record] = []
    found = [short.tried]
    for number, name in enumerate(("starts", "local", "again", "wide")):
        if name == "again":
            draws += more
        holding = holding.with_settings(draws=[[search.seed, draw] for draw in draws])
        if name == "starts":
            result = _all_of(workers, holding, distinct, folder / name)
        else:
            how: dict[str, Any] = {"evaluations": given.wide, "sampler": "tpe"}
            if name != "wide":
                start = dict(SearchResult(seen).values)
                spread = SPREAD if name == "local" else 0.5 * SPREAD
                how = {"evaluations": given.local, "start": start, "spread": spread}
            one = replace(
                holding,
                name=f"{search.name}_{name}",
                seed=search.seed + A_ROUND * number,
                enough=ENOUGH_HELD,
                **how,
            )
            result = search_with(workers, one, folder / name)
        tried = _tried(workers, given, search, result, folder / f"{name}_tried")
        found.append(_surely(workers, given, search, tried, folder / f"{name}_surely"))
        seen += result.records
        if _holds(found[-1]):
            break
    best = min(found, key=_rank)
    return replace(short, tried=best, longer=best is not short.tried)


def _all_of(
    workers: Workers, search: SearchProblem, values: Sequence[Mapping[str, float]], folder: Path
) -> SearchResult:
    """Evaluations of given values."""
    tasks = [Evaluation(search, number, one) for number, one in enumerate(values)]
    with KeptResults(folder, tasks, COST, ("values",)) as kept:
        return SearchResult(finish(workers, tasks, kept))


def _within(search: SearchProblem, values: Mapping[str, float]) -> dict[str, float]:
    """Values of all variables of a search, within their ranges."""
    return {v.name: min(v.high, max(v.low, values.get(v.name, 0.0))) for v in search.variables}


def _tried(
    workers: Workers, given: Parameters, search: SearchProblem, result: SearchResult, folder: Path
) -> Tried:
    """The best evaluation; if it touches, the one that stands most tries with varied pressures."""
    if not result.best["touched"]:
        return Tried(result.best, ())
    # not those of the repeats
    draws = {str(k): (search.seed, FIRST_TRY + k) for k in range(len(given.tried))}
    return try_again(workers, search, result, draws, given.tried, folder)[0]


def _surely(
    workers: Workers, given: Parameters, search: SearchProblem, tried: Tried, folder: Path
) -> Tried:
    """A posture that touched in all its tries, with further ones."""
    if not _holds(tried):
        return tried
    numbers = range(len(given.tried), len(given.tried) + given.sure)
    tasks = [
        Evaluation(
            search.with_settings(draw=[search.seed, FIRST_TRY + k]), k, tried.record["values"]
        )
        for k in numbers
    ]
    with KeptResults(folder, tasks, COST, ("values",)) as kept:
        return Tried(tried.record, [*tried.records, *finish(workers, tasks, kept)])


def _holds(tried: Tried) -> bool:
    """Whether a posture was tried and touched each time."""
    return bool(tried.records) and all(record.get("touched") for record in tried.records)


def _rank(tried: Tried) -> tuple[bool, float]:
    return not tried.records, tried.worst


def _judged(
    workers: Workers, given: Parameters, case: str, place: int, one: Found, folder: Path
) -> dict[str, Any]:
    """What a search found, its cost, and the repeats that judge it."""
    folder, search = folder / case / str(place), problem(given, case, place)
    runs, minutes = effort(folder)
    kept = folder / ("longer/repeats" if one.longer else "repeats")
    return {
        "values": dict(one.values),
        "statics": one.statics,
        "longer": one.longer,
        "runs": runs,
        "minutes": minutes,
        "repeats": repeats(workers, search, one.values, given.repeats, kept),
    }


def effort(folder: Path) -> tuple[int, float]:
    """Simulations of the searches of a place with all tries, but without what judges them, and
    minutes of one core.
    """
    files = [f for f in folder.rglob(RESULTS_FILE) if f.parent.name not in ("repeats", "fine")]
    records = [record for file in sorted(files) for record in read_results(file)]
    seconds = sum(record["cpu_time"] for record in records)
    return sum(record.get("runs", 1) for record in records), seconds / 60.0


def _named(
    search: SearchProblem, case: str, pressures: Array, thumb_first: bool
) -> dict[str, float]:
    """Values of the variables for pressures (channels,) [Pa] and an order."""
    by_name = dict(zip(hand_variant(CASES[case][0]).channels, pressures.tolist(), strict=True))
    by_name[THUMB_FIRST] = float(thumb_first)
    return {variable.name: by_name[variable.name] for variable in search.variables}


def finely(
    workers: Workers, given: Parameters, case: str, found: Mapping[str, Any], folder: Path
) -> dict[str, Any]:
    """Winners of a case that are reached, by place, each repeated with the finer step. With a
    coarse step, fingers that press on each other may tremble, and the joints do not come to rest.
    """
    again = {}
    for place, one in found.items():
        if not reached(one):
            continue
        search = problem(given, case, int(place)).with_settings(step=given.fine_step)
        kept = folder / case / place / "fine"
        again[place] = {
            **one,
            "repeats": repeats(workers, search, one["values"], given.repeats, kept),
        }
    return again


def repeats(
    workers: Workers, search: SearchProblem, values: Mapping[str, float], count: int, folder: Path
) -> list[Any]:
    """Verdicts on a posture with pressures that differ, each by its own draw; from the folder where
    they are known. Raises RuntimeError when a simulation diverges.
    """
    tasks = [
        Evaluation(search.with_settings(draw=[search.seed, 1 + number]), number, values)
        for number in range(count)
    ]
    with KeptResults(folder, tasks, COST, ("values",)) as kept:
        found = finish(workers, tasks, kept)
    for record in found:
        if "error" in record:
            raise RuntimeError(f"{record['key']}: {record['error']}")
    return found


def shown(found: Mapping[str, Any]) -> str:
    """The case whose postures are drawn: seven channels, or the first."""
    return SEVEN if SEVEN in found else next(iter(found))


def postures(found: Mapping[str, Any], given: Parameters) -> Results:
    """Joint orientations (places, n, 4) of the winners of the case that is shown, and the points of
    their places (places, 3) [m] in the wrist frame.
    """
    case = shown(found)
    hand = PosedHand(CASES[case][0], given.step, given.segments)
    joints, marks = [], []
    for place, one in found[case].items():
        target = TARGETS[int(place) - 1]
        values = one["values"]
        pressures = np.array([values.get(name, 0.0) for name in hand.channels])
        hand.take(pressures, values[THUMB_FIRST] > 0.5)
        q = hand.joints()
        joints.append(q)
        marks.append(hand.scene.skin.point(target.finger, target.share, target.side, q))
    hand.close()
    return {"joints": np.array(joints), "marks": np.array(marks)}


def workspace(given: Parameters) -> Results:
    """Place (k, 3) [m] of the thumb's base and its twist [rad] about the palm's end, relative to
    rest: at pressures of c and d (k, 2) [Pa] that are equal, and at different ones (Fig. 7.7); by
    statics.
    """
    hand, reach = load_hand(HAND), statics(FOUR, given.segments)
    used = [hand.channels.index(name) for name in "cd"]
    c, d = hand.max_pressures()[used]
    equal = np.repeat(np.linspace(0.0, min(c, d), given.points)[:, None], 2, axis=1)
    axes = np.linspace(0.0, c, given.points), np.linspace(0.0, d, given.points)
    results: Results = {}
    for name, pressures in (
        ("equal", equal),
        ("differing", np.array(np.meshgrid(*axes)).reshape(2, -1).T),
    ):
        whole = np.zeros((len(pressures), len(hand.channels)))
        whole[:, used] = pressures
        places, twists = reach.chain_end(PALM, whole)
        results |= {
            f"{name}_pressures": pressures,
            f"{name}_places": places,
            f"{name}_twists": twists,
        }
    return results


# ---------------------------------------------------------------- report
def reached(one: Mapping[str, Any], radius: float = RADIUS) -> bool:
    """Whether all repeats of a place's winner touch it within a radius [m]."""
    return all(repeat["at_radius"][f"{1e3 * radius:g}"] for repeat in one["repeats"])


def report(results: Results, given: Parameters) -> Report:
    """A row per place and number of channels, then the criteria."""
    cases = results["cases"]
    counts = {name: sum(map(reached, found.values())) for name, found in cases.items()}
    findings: list[Finding] = []
    for name in [name for name in LEAST if name in cases]:
        findings += [_row(int(place), one, name) for place, one in cases[name].items()]
        findings += _counted(name, cases[name])
        findings += [_first(name, cases[name])] if "1" in cases[name] else []
        fine = results["fine"][name]
        ours = f"{sum(map(reached, fine.values()))} of {len(fine)}: {_numbers(fine)}"
        what = f"winners at steps of {1e3 * given.fine_step:g} ms, {WORDS[name]}"
        findings.append(Finding(what, "-", ours))
    if RIGID in cases:
        ours = f"{counts[RIGID]} of {len(cases[RIGID])}: {_numbers(cases[RIGID])} (<= {MOST_RIGID})"
        findings.append(
            Finding("negative control: palm rigid", "-", ours, counts[RIGID] <= MOST_RIGID)
        )
    if NO_INDEX in cases:
        ours = f"{counts[NO_INDEX]} of {len(cases[NO_INDEX])}: {_numbers(cases[NO_INDEX])} (0)"
        what = "negative control: index empty, places 1 to 3"
        findings.append(Finding(what, "-", ours, counts[NO_INDEX] == 0))
    findings += [_static(name, found) for name, found in cases.items()]
    findings += [_simulations(name, found) for name, found in cases.items()]
    findings += _twists(results)
    said = [f"{counts[c]} of {len(cases[c])} places with {WORDS[c]}" for c in LEAST if c in cases]
    return Report(findings, f"The thumb reaches {' and '.join(said)}." if said else "")


def _static(case: str, found: Mapping[str, Any]) -> Finding:
    far = ", ".join(f"{place}: {1e3 * one['statics']:.1f}" for place, one in found.items())
    what = f"distance by statics, {WORDS[case]}"
    return Finding(what, "-", f"{far} mm; above {1e3 * FAR:g} mm not searched")


def _simulations(case: str, found: Mapping[str, Any]) -> Finding:
    runs = ", ".join(f"{p}: {one['runs']}{'+' * one['longer']}" for p, one in found.items())
    minutes = sum(one["minutes"] for one in found.values())
    what = f"simulations of the search, {WORDS[case]}"
    return Finding(what, "-", f"{runs} (+: winner of the longer one); {minutes:.0f} min of a core")


def _numbers(found: Mapping[str, Any], radius: float = RADIUS) -> str:
    return ", ".join(place for place, one in found.items() if reached(one, radius)) or "none"


def _row(place: int, one: Mapping[str, Any], case: str) -> Finding:
    target = TARGETS[place - 1]
    touched = sum(repeat["touched"] for repeat in one["repeats"])
    pressures = " / ".join(f"{1e-3 * value:.0f}" for value in _pressures(one).values())
    order = "thumb" if one["values"][THUMB_FIRST] > 0.5 else "fingers"
    why = sorted({repeat["reason"] for repeat in one["repeats"]} - {""})
    others = sorted({name for repeat in one["repeats"] for name in repeat["others"]})
    parts = [
        f"{touched} of {len(one['repeats'])}",
        f"{_remaining(one):.1f} mm away",
        f"{pressures} kPa, {order} first",
        *(["also touches " + ", ".join(others)] if others else []),
        *why,
    ]
    seen = "not reached" if place == 1 else "reached"
    what = f"place {place}: {place_name(target)}, {WORDS[case]}"
    return Finding(what, seen, "; ".join(parts))


def _pressures(one: Mapping[str, Any]) -> dict[str, float]:
    """Pressures [Pa] of a winner by channel."""
    return {name: value for name, value in one["values"].items() if name != THUMB_FIRST}


def place_name(target: Target) -> str:
    """A place in words."""
    where = {"+y": "radial side", "pad": "pad", "tip": "tip"}[target.side]
    at = "" if target.side == "tip" else f" at {100 * target.share:.0f} %"
    return f"{target.finger}, {where}{at}"


def _remaining(one: Mapping[str, Any]) -> float:
    """Mean distance [mm] of the repeats from the place: along the skin, or through the air without
    contact.
    """
    far = [r["gap"] if r["distance"] is None else r["distance"] for r in one["repeats"]]
    return float(1e3 * np.mean(far))


def _effort(case: str, one: Mapping[str, Any]) -> float:
    """Mean of the pressures as shares of their limits [-] (ours)."""
    hand = hand_variant(CASES[case][0])
    limits = dict(zip(hand.channels, hand.max_pressures(), strict=True))
    return float(np.mean([value / limits[name] for name, value in _pressures(one).items()]))


def _counted(case: str, found: Mapping[str, Any]) -> list[Finding]:
    whole = len(found) == len(TARGETS)
    count = sum(map(reached, found.values()))
    ours = f"{count} of {len(found)}: {_numbers(found)} (>= {LEAST[case]})"
    met = count >= LEAST[case] if whole else None
    what = f"places reached within {1e3 * RADIUS:g} mm, {WORDS[case]}"
    findings = [Finding(what, "7 of 8", ours, met)]
    for radius in OTHER_RADII:
        number = sum(reached(one, radius) for one in found.values())
        ours = f"{number} of {len(found)}: {_numbers(found, radius)}"
        findings.append(Finding(f"within {1e3 * radius:g} mm, {WORDS[case]}", "-", ours))
    return findings


def _first(case: str, found: Mapping[str, Any]) -> Finding:
    """Whether place 1 is the hardest: not reached, or with the largest distance or effort."""
    farthest = max(found, key=lambda place: _remaining(found[place]))
    hardest = max(found, key=lambda place: _effort(case, found[place]))
    failed = not reached(found["1"])
    easy = "" if failed or "1" in (farthest, hardest) else "; easier than with the real hand"
    ours = (
        f"{'not ' if failed else ''}reached; farthest is {farthest}, most effort takes {hardest}"
        f"{easy}"
    )
    what = f"place 1 is the hardest, {WORDS[case]}"
    return Finding(what, "the only one not reached", ours, failed or not easy)


def _twists(results: Results) -> list[Finding]:
    rows = []
    for name, words in (("equal", "equal"), ("differing", "different")):
        twists, places = np.degrees(results[f"{name}_twists"]), results[f"{name}_places"]
        box = 1e3 * np.ptp(places, axis=0)
        ours = (
            f"{twists.min():.0f} to {twists.max():.0f} deg; within "
            f"{box[0]:.0f} x {box[1]:.0f} x {box[2]:.0f} mm"
        )
        what = f"twist and place of the thumb's base, c and d {words}"
        rows.append(Finding(what, "a picture", ours, None, float(np.ptp(twists)), "deg"))
    return rows


# ---------------------------------------------------------------- figure
def draw(figure: Figure, results: Results, report: Report) -> None:
    """Postures from the palm's side, each with its place, and how often it is touched with four
    channels; the workspace of the thumb's base.
    """
    cases = results["cases"]
    case, headlines = shown(cases), [name for name in LEAST if name in cases]
    found = cases[case]
    top, below = figure.subfigures(2, 1, height_ratios=(2.6, 1.0))
    columns = min(4, len(found))
    rows = -(-len(found) // columns)
    panels = np.atleast_1d(top.subplots(rows, columns, squeeze=False)).ravel()
    for panel in panels[len(found) :]:
        panel.set_axis_off()
    pictures = photographs(results["joints"], case)
    for panel, place, picture, mark in zip(panels, found, pictures, results["marks"], strict=False):
        words = [_tries(name, cases[name][place]) for name in headlines if place in cases[name]]
        title = "\n".join([f"{place}: {place_name(TARGETS[int(place) - 1])}", *words])
        _draw_posture(panel, title, picture, mark)
    _draw_workspace(below.subplots(1, 2), results)


def photographs(joints: Array, case: str) -> list[Any]:
    """Pictures of postures from the palm's side."""
    hand = hand_variant(CASES[case][0])
    count = sum(len(chain.actuators) > 0 for chain in hand.chains)
    struts = sum(chain.strut is not None for chain in hand.chains)
    segments = (joints.shape[1] - struts) // count
    renderer = Renderer(hand, None, "stand", segments)
    camera = Camera(**VIEW, light=(1.6, -0.6, 1.2))
    return [renderer.frame(HandState(q, *UPRIGHT), (PIXELS, PIXELS), camera) for q in joints]


def _tries(case: str, one: Mapping[str, Any]) -> str:
    touched = sum(repeat["touched"] for repeat in one["repeats"])
    return f"{WORDS[case]}: {touched} of {len(one['repeats'])}, {_remaining(one):.1f} mm"


def _draw_posture(panel: Any, title: str, picture: Any, mark: Array) -> None:
    half = VIEW["distance"] * np.tan(np.radians(0.5 * VIEW["view_angle"]))
    y, z = VIEW["target"][1:]
    panel.imshow(picture, extent=[y - half, y + half, z - half, z + half])
    panel.plot(mark[1], mark[2], "o", markersize=7, fillstyle="none", color="tab:red")
    panel.set_title(title, fontsize=9)
    panel.set_axis_off()


def _draw_workspace(panels: Sequence[Any], results: Results) -> None:
    for name, style in (("differing", "."), ("equal", "o")):
        places, twists = 1e3 * results[f"{name}_places"], np.degrees(results[f"{name}_twists"])
        color, label = ("0.6", "c and d differ") if name == "differing" else ("tab:orange", "equal")
        line = "none" if name == "differing" else "-"
        panels[0].plot(
            places[:, 1], places[:, 0], marker=style, linestyle=line, color=color, label=label
        )
        total = 1e-3 * results[f"{name}_pressures"].mean(axis=1)
        panels[1].plot(total, twists, marker=style, linestyle=line, color=color, label=label)
    panels[0].set(xlabel="y, to the thumb's side [mm]", ylabel="x, out of the palm [mm]")
    panels[0].set_title("thumb's base (Fig. 7.7)", fontsize=9)
    panels[1].set(xlabel="mean pressure of c and d [kPa]", ylabel="twist [deg]")
    panels[1].legend(fontsize=8)
