"""The riddle of Fig. 5.10d: an actuator of 5.5 mm that is stiffer at low pressure than the model.

Four fingers that differ in their wall alone are inflated and deflated, slowly, to half and to full
pressure. In turn something acts in the rubber that could make the thickest one stiff, the base
model is compared with what is measured, and the lab is asked what is missing: with the four fingers
of the thesis, with the 5.5 mm finger alone, and with the four and the run that the lab proposes.

`python examples/stiff_actuator.py` prints a table for each of the three in Markdown;
`--figure docs/figures/riddle.png` draws the first of the causes as Fig. 5.10 does.
"""

import numpy as np

from model_lab.diagnosis.diagnose import diagnose
from model_lab.diagnosis.next_experiment import explanations, next_experiment
from model_lab.experiments.forward import Forward
from model_lab.measurements.measurement_set import MeasurementSet, Run, Specimen
from softhand_model.effects import effect_classes
from softhand_model.model_file import load_model

WALLS = {"d2.5": 0.0025, "d3.5": 0.0035, "d4.5": 0.0045, "d5.5": 0.0055}  # [m]
SHAPE = {"length": 0.09, "height": 0.02, "width": 0.02, "shear_modulus": 67e3, "mass": 0.035}
SCALE = 1.1  # of the modulus, as the thesis fitted it
PEAKS = {"half": 23e3, "full": 46.3e3}  # [Pa]
DURATION, SAMPLES, REPEATS = 40.0, 60, 2
SCATTER, NOISE = 0.006, 0.006  # of a run as a whole; of the largest angle
CAUSES = {
    "thick_wall": {"gain": 1.5},
    "section_rounding": {"gain": 0.35, "pressure_scale": 15e3},
    "dead_zone": {"threshold": 3e3},
    "actuation_nonlinearity": {"a": 5.3, "p0": 110e3},
    "gravity": {"mass_scale": 1.0},
}  # what stands in for nature
REMEDY = "actuation_nonlinearity"  # the thesis's: another `a` in equation 5.3


def thesis_runs(names=tuple(WALLS)):
    """Runs of the fingers: up and down to both pressures, with repeats."""
    runs = []
    for repeat in range(REPEATS):
        for name in names:
            for protocol, peak in PEAKS.items():
                time = np.linspace(0.0, DURATION, SAMPLES)
                pressure = peak * (1.0 - np.abs(2.0 * time / DURATION - 1.0))
                columns = {"time": time, "pressure": pressure, "tip_angle": np.zeros(SAMPLES)}
                runs.append(Run(f"{name}_{protocol}_{repeat}", name, protocol, 293.15, columns))
    return runs


def fingers(mount="base_up"):
    """The four specimens by name."""
    return {
        name: Specimen(name, {**SHAPE, "wall": wall, "side_wall": wall}, mount, "A")
        for name, wall in WALLS.items()
    }


def planned_runs(trial):
    """The run that the lab proposes, with a repeat."""
    columns = {**trial.columns, "tip_angle": np.zeros(trial.columns["time"].size)}
    return [
        Run(f"planned_{repeat}", trial.specimen.name, trial.protocol, trial.temperature, columns)
        for repeat in range(REPEATS)
    ]


def measured(cause, runs, specimens=None, seed=0):
    """What is measured (a set) when a cause of CAUSES, or None, acts."""
    known = fingers() if specimens is None else specimens
    used = {run.specimen: known[run.specimen] for run in runs}
    empty = MeasurementSet("free_bending", f"four walls, {cause} hidden", used, tuple(runs))
    effects = [effect_classes()[cause](**CAUSES[cause])] if cause else []
    true = Forward(empty, "pneuflex", (), effects).predict(np.full((1, 1), SCALE))[0]
    random = np.random.default_rng(seed)
    spread, start, done = NOISE * np.abs(true).max(), 0, []
    for run in runs:
        part = true[start : start + run.samples] * (1.0 + SCATTER * random.standard_normal())
        start += run.samples
        angle = part + spread * random.standard_normal(run.samples)
        columns = {**run.columns, "tip_angle": angle}
        done.append(Run(run.name, run.specimen, run.protocol, run.temperature, columns))
    return MeasurementSet(empty.experiment, empty.title, used, tuple(done))


def excess_stiffness(data):
    """Degrees by which each finger bends less at low pressure than the base model fitted to all.

    Means over 3 to 12 kPa, by the name of the finger.
    """
    forward = Forward(data)
    scales = np.linspace(0.85, 1.15, 61)[:, None]
    rest = forward.measured - forward.predict(scales)
    rest = rest[np.argmin(np.sum(rest**2, axis=1))]
    pressure, names = data.column("pressure"), [run.specimen for run in data.runs]
    low = (pressure > 3e3) & (pressure < 12e3)
    mine = np.array(names)[data.table.run]
    return {name: -float(np.degrees(rest[low & (mine == name)].mean())) for name in data.specimens}


def test_a_factor_that_grows_with_the_wall_stiffens_the_thickest_finger_most():
    stiff = excess_stiffness(measured("thick_wall", thesis_runs(), fingers("bending_plane_level")))
    assert max(stiff, key=stiff.get) == "d5.5"


def test_without_a_cause_no_finger_is_stiffer_than_the_model():
    stiff = excess_stiffness(measured(None, thesis_runs(), fingers("bending_plane_level")))
    assert max(map(abs, stiff.values())) < 0.5


def table(head, rows):
    """A table in Markdown."""
    return (
        "\n".join(f"| {' | '.join(line)} |" for line in [head, ["---"] * len(head), *rows]) + "\n"
    )


def answer(data, jobs):
    """What the lab says: cells of a table, and what came of it."""
    outcome = diagnose(data, load_model("base"), jobs=jobs)
    found = outcome.diagnosis
    named = []
    for effect, ties in zip(found.effects, found.tied, strict=True):
        values = ", ".join(
            f"{name} {e.value:.3g} ± {e.std:.2g}" for name, e in effect.parameters.items()
        )
        tied = f", tied: {', '.join(ties)}" if ties else ""
        named.append(f"`{effect.name}` ({values}){tied}")
    before, after, floor = (
        f"{np.degrees(value):.2f}"
        for value in (found.rmse_before, found.rmse_after, found.noise_floor)
    )
    remedy = [f"{np.degrees(r.rmse_heldout):.2f}" for r in found.ranking if r.name == REMEDY]
    cells = [f"`{found.verdict}`", "; ".join(named) or "-", before, after, floor, *remedy]
    return cells, outcome


def proposed(outcome):
    """The experiment that would separate what is tied; None if nothing is."""
    final, ties = outcome.selection.final, outcome.diagnosis.tied
    return next_experiment(outcome.question, explanations(outcome.question, final, ties))


HEAD = ["verdict", "missing", "error before [deg]", "after", "floor", "thesis's remedy alone"]


def draw(data, path):
    """Tip angle over pressure as in Fig. 5.10: measured, and the base model fitted to all four."""
    import matplotlib.pyplot as plt

    forward = Forward(data)
    scales = np.linspace(0.85, 1.15, 61)[:, None]
    predicted = forward.predict(scales)
    best = predicted[np.argmin(np.sum((forward.measured - predicted) ** 2, axis=1))]
    figure, grid = plt.subplots(1, 4, figsize=(9.0, 2.6), layout="constrained", sharey=True)
    for axis, name in zip(grid, WALLS, strict=True):
        for index, run in enumerate(data.runs):
            if run.specimen == name and run.protocol == "full":
                mine, pressure = data.table.run == index, 1e-3 * run.columns["pressure"]
                axis.plot(pressure, np.degrees(forward.measured[mine]), ".", color="0.35", ms=3)
                axis.plot(pressure, np.degrees(best[mine]), color="#D55E00")
        axis.set_title(f"wall {1e3 * WALLS[name]:g} mm", fontsize=9)
        axis.set_xlabel("pressure [kPa]")
    grid[0].set_ylabel("tip angle [deg]")
    figure.savefig(path, dpi=110)


if __name__ == "__main__":
    import argparse
    from pathlib import Path

    parser = argparse.ArgumentParser(description="the riddle of Fig. 5.10d")
    parser.add_argument("--figure", type=Path, help="picture of the first cause")
    parser.add_argument("--jobs", type=int, default=2, help="processes")
    given = parser.parse_args()

    sets = {cause: measured(cause, thesis_runs()) for cause in CAUSES}
    if given.figure:
        draw(sets["thick_wall"], given.figure)
    rows = [
        [f"`{cause}`", *(f"{value:+.1f}" for value in excess_stiffness(data).values())]
        for cause, data in sets.items()
    ]
    print(table(["hidden", *WALLS], rows))
    rows = [[f"`{cause}`", *answer(data, given.jobs)[0]] for cause, data in sets.items()]
    print(table(["hidden", *HEAD], rows))
    rows, planned = [], {}
    for cause in CAUSES:
        cells, alone = answer(measured(cause, thesis_runs(("d5.5",))), given.jobs)
        rows.append([f"`{cause}`", *cells])
        planned[cause] = proposed(alone)
    print(table(["hidden", *HEAD], rows))
    rows = []
    for cause, experiment in planned.items():
        if experiment is not None:
            trial = experiment.trial
            specimens = {**fingers(), trial.specimen.name: trial.specimen}
            runs = [*thesis_runs(("d5.5",)), *planned_runs(trial)]
            cells, _ = answer(measured(cause, runs, specimens), given.jobs)
            says = ", ".join([trial.description, *trial.changes])
            rows.append([f"`{cause}`", says, *cells])
    if rows:
        print(table(["hidden", "proposed run", *HEAD], rows), end="")
