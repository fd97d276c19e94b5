"""Report on the grasps of the Feix taxonomy: a row per type, and the criteria."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from thesis.chapter_8.dexterity.feix import PALM_TYPE, GraspType, grasp_types
from thesis.chapter_8.dexterity.posture import FOUR
from thesis.frame import Finding, Report, Results

# runs of the stored patterns
AGAIN, HALF, SLIPPERY, FINER = "again", "half_strength", "no_friction", "finer_step"
STICKY = "double_friction"
ALL = tuple(sorted(grasp_types()))
NOT_COUNTED = 19  # whether scissors cut is not judged
FAILED = (5, 19)  # in the thesis
APART = {  # other verdicts, beside the one that counts
    "by_thirds": "no contact past the border of its third",
    "at_rest": "by what is left of drift and turn at the end",
}
HELD, RIGHT, POWER, FEWER, MOST_SLIPPERY, MOST_CHANGED = 27, 24, 8, 8, 3, 3
LONGEST = 300  # [s] that all stored grasps take


def good(trials: Iterable[Mapping[str, Any]], *words: str) -> bool:
    """Whether all trials succeed in these respects (`held`, `typed`)."""
    return all(trial.get(word, False) for trial in trials for word in words)


def counted(found: Mapping[str, Any], *words: str) -> list[int]:
    """Types whose trials all succeed in these respects, without the type that is not counted."""
    return [
        int(number)
        for number, one in found.items()
        if int(number) != NOT_COUNTED and good(one["trials"], *words)
    ]


def told(results: Results, run: Sequence[int]) -> Report:
    """A row for each type that was run, then the criteria; they are judged when all were."""
    found, types = results["cases"][FOUR], grasp_types()
    whole, of = set(run) == set(ALL), [number for number in run if number != NOT_COUNTED]
    findings = [_row(types[int(number)], one) for number, one in found.items()]
    held, right = counted(found, "held"), counted(found, "held", "typed")
    power = [n for n in of if types[n].opposition == PALM_TYPE]
    wrapped = [number for number in held if number in power]
    findings += [
        _count("held", "31 of 33", held, of, HELD, whole),
        *(
            Finding(f"held, {words}", "-", f"{len(counted(found, key))} of {len(of)}")
            for key, words in APART.items()
        ),
        _count("held by the right parts", "31 of 33", right, of, RIGHT, whole),
        _count("power grasps against the palm held", "9 of 10", wrapped, power, POWER, whole),
        *(_control(case, results["cases"], of, whole) for case in results["cases"] if case != FOUR),
        *_checked(results, whole),
        _human(results["human"]),
        *_times(results),
    ]
    sentence = f"{len(held)} of {len(of)} types are held, {len(right)} of them "
    return Report(findings, sentence + "by the parts of the hand that the type asks for.")


def _row(kind: GraspType, one: Mapping[str, Any]) -> Finding:
    trials = one["trials"]
    held, typed = (sum(t.get(word, False) for t in trials) for word in ("held", "typed"))
    why = {t[f"{word}_reason"] for word in ("held", "typed") for t in trials if "held" in t}
    errors = {trial["error"] for trial in trials if "error" in trial}
    parts = [
        f"held {held} of {len(trials)}",
        f"right {typed} of {len(trials)}",
        f"{trials[0].get('robust', 0.0):.1f} N",
        *summary(sorted(why - {""})),
        *sorted(errors),
    ]
    seen = "fails" if kind.number in FAILED else "succeeds"
    return Finding(f"{kind.number} {kind.name}, {kind.object}", seen, "; ".join(parts))


def summary(reasons: Sequence[str]) -> list[str]:
    """Reasons of several trials in short: equal ones once, their numbers as a range.

    >>> summary(["drifts by 15 mm; turns by 9 deg", "drifts by 52 mm; loses palm, ring's tip"])
    ['drifts by 15 to 52 mm', 'turns by 9 deg', 'loses 2 contacts']
    """
    numbers: dict[str, list[str]] = {}
    for part in [part for reason in reasons for part in reason.split("; ")]:
        if part.startswith("loses "):
            part = f"loses {part.count(',') + 1} contacts"
        form = re.sub(r"\d+", "#", part)
        numbers.setdefault(form, []).extend(re.findall(r"\d+", part))
    return [form.replace("#", _range(found)) for form, found in numbers.items()]


def _range(numbers: Sequence[str]) -> str:
    found = set(map(int, numbers))
    return " to ".join(map(str, sorted({min(found), max(found)}))) if found else ""


def _count(
    what: str, thesis: str, found: Sequence[int], of: Sequence[int], least: int, whole: bool
) -> Finding:
    ours = f"{len(found)} of {len(of)} (>= {least})"
    return Finding(what, thesis, ours, len(found) >= least if whole else None)


def _control(case: str, cases: Mapping[str, Any], of: Sequence[int], whole: bool) -> Finding:
    """A hand that should be worse, with a search of the same budget."""
    ours, without = (counted(cases[name], "held", "typed") for name in (FOUR, case))
    fewer = len(ours) - len(without)
    words = f"{len(without)} of {len(of)}, {fewer} fewer (>= {FEWER})"
    what = f"negative control: {case.replace('_', ' ')}, held by the right parts"
    return Finding(what, "-", words, fewer >= FEWER if whole else None)


def _checked(results: Results, whole: bool) -> list[Finding]:
    found, checks, rows = results["cases"][FOUR], results["checks"], []
    if AGAIN in checks:
        same = [n for n, trials in checks[AGAIN].items() if _same(trials[0], found[n]["trials"][0])]
        seconds = sum(trials[0]["cpu_time"] for trials in checks[AGAIN].values())
        ours = f"{len(same)} of {len(checks[AGAIN])} bit for bit"
        rows.append(Finding("run again from the file", "-", ours, len(same) == len(checks[AGAIN])))
        ours, met = f"{seconds:.0f} s of CPU (<= {LONGEST})", seconds <= LONGEST
        rows.append(Finding("time of that", "-", ours, met if whole else None, seconds, "s"))
    if HALF in checks:
        changed = [
            n
            for n, trials in checks[HALF].items()
            if good(trials, "held") != good(found[n]["trials"], "held")
        ]
        ours = f"{len(changed)} verdicts change (<= {MOST_CHANGED}): {_listed(changed)}"
        met = len(changed) <= MOST_CHANGED if whole else None
        rows.append(Finding("shaken with half the strength", "-", ours, met))
    if SLIPPERY in checks:
        held = [n for n, trials in checks[SLIPPERY].items() if good(trials, "held")]
        ours = f"{len(held)} held (<= {MOST_SLIPPERY}): {_listed(held)}"
        met = len(held) <= MOST_SLIPPERY if whole else None
        rows.append(Finding("negative control: no friction", "-", ours, met))
    for name, words in ((FINER, "in finer steps"), (STICKY, "with twice the friction")):
        if name in checks:
            held = [n for n, trials in checks[name].items() if good(trials, "held")]
            ours = f"{len(held)} held: {_listed(held)}"
            rows.append(Finding(f"the same patterns {words}", "-", ours))
    return rows


def _listed(numbers: Iterable[Any]) -> str:
    return ", ".join(map(str, numbers)) or "none"


def _same(again: Mapping[str, Any], first: Mapping[str, Any]) -> bool:
    """Whether a run from the file found the same as the first one."""
    own = ("key", "wall_time", "cpu_time")
    return all(first.get(key) == value for key, value in again.items() if key not in own)


def _human(verdicts: Mapping[str, Mapping[str, str]]) -> Finding:
    """A person's verdicts from the CSV; they are not part of the judge's."""
    judged = [row["human_good"] for row in verdicts.values() if row["human_good"]]
    yes = sum(word.strip().lower() in ("yes", "y", "1", "true") for word in judged)
    ours = f"{yes} of {len(judged)} good" if judged else "not judged"
    return Finding("by a person, from the pictures", "31 of 33", ours)


def _times(results: Results) -> list[Finding]:
    """Processor times of the searches, if there were any."""
    searches = [one for own in results["cases"].values() for one in own.values()]
    seconds = sum(one["cpu_time"] for one in searches)
    count = sum(one["evaluations"] for one in searches)
    if not count:
        return []
    ours = f"{count} evaluations, {seconds / 3600:.2f} h of CPU, {count / seconds:.2f} a second"
    return [Finding("searches", "-", ours, None, count / seconds, "1/s")]
