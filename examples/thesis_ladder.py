"""The ladder of Fig. 4.6: from the naive flow model to equation 4.1, the error falls seven-fold.

Test pulses are recorded on the pretended bench: valves with delays, chokes, dead volumes, a tube, a
supply that gives way and noisy sensors, on a bottle of 0.5 l. None of that is equation 4.1.

`python examples/thesis_ladder.py` writes the measurement set, a model file per step and the picture
to out/thesis-ladder, and prints the table; then

    model-lab ladder out/thesis-ladder/pulses out/thesis-ladder/*.yaml

compares the same files.
"""

import numpy as np

from model_lab.experiments.forward import Forward
from model_lab.measurements.measurement_set import DEFLATE, INFLATE, MeasurementSet, Run, Specimen
from pneumaticbox_driver.calibration.command import BOTTLE, SUPPLY_PRESSURES, record_on_rig
from softhand_model.effects import effect_classes
from softhand_model.model_file import Model

STEPS = ("injector_flow", "line_friction", "switching_volume", "pulse_bias")
NOISE = 0.053e-6  # [kg]: of two means of 100 readings, 60 Pa and 12 bits each, in 0.5 l
PARTS = 3  # runs of each supply pressure, held out in turn
COLUMNS = {
    "duration": "duration",
    "p_in": "pressure_in_abs",
    "p_out": "pressure_out_abs",
    "friction_integral": "friction",
    "injector_integral": "injector",
    "mass": "mass",
}  # of the set, and what a recorded pulse calls them


def recorded_set(cycles, seed=0):
    """Pulses of one channel, `cycles` a direction at each of the thesis's two supply pressures."""
    runs = []
    for level, supply in enumerate(SUPPLY_PRESSURES):
        (pulses,) = record_on_rig(cycles, 1000 * seed + level, 1, BOTTLE, supply)
        for part, rows in enumerate(np.array_split(np.arange(len(pulses)), PARTS)):
            name = f"supply_{supply / 1e3:.0f}_part_{part + 1}"
            chosen = [pulses[row] for row in rows]
            runs.append(Run(name, "channel_1", name, 293.15, _columns(chosen)))
    channel = {"channel_1": Specimen("channel_1")}
    title = "test pulses of one channel of the pretended bench"
    return MeasurementSet("valve_pulse", title, channel, tuple(runs), {"mass": NOISE})


def _columns(pulses):
    direction = [INFLATE if pulse.inflating else DEFLATE for pulse in pulses]
    values = {
        name: np.array([getattr(pulse, attribute) for pulse in pulses])
        for name, attribute in COLUMNS.items()
    }
    return {"direction": np.array(direction), **values}


def ladder():
    """Names of the effects of each step, the naive model first."""
    return [STEPS[:count] for count in range(len(STEPS) + 1)]


def design(forward):
    """Masses (samples, k) of each parameter: all these models are linear in theirs."""
    return forward.predict(np.eye(len(forward.parameters))).T


def fitted(forward, rows):
    """Parameters (k,) with the least squares over some samples."""
    columns = design(forward)
    scale = np.sqrt(np.mean(columns[rows] ** 2, axis=0))
    return np.linalg.lstsq(columns[rows] / scale, forward.measured[rows], rcond=None)[0] / scale


def held_out_errors(data, names):
    """Errors (samples,) [kg] of runs that did not take part in the fit."""
    forward = Forward(data, effects=[effect_classes()[name] for name in names])
    errors = np.empty_like(forward.measured)
    for run in range(len(data.runs)):
        out = data.table.run == run
        errors[out] = (forward.measured - design(forward) @ fitted(forward, ~out))[out]
    return errors


def model_of(data, names):
    """The model with these effects, fitted to the whole set."""
    classes = effect_classes()
    forward = Forward(data, effects=[classes[name] for name in names])
    values = fitted(forward, np.ones(forward.measured.size, bool))
    found = dict(zip((p.name for p in forward.parameters), values.tolist(), strict=True))
    effects = [
        classes[name](**{p.name: found[f"{name}.{p.name}"] for p in classes[name].parameters})
        for name in names
    ]
    calibration = {key: value for key, value in found.items() if "." not in key}
    return Model("pneuflex", calibration, tuple(effects))


def rms(errors):
    """Root mean square."""
    return float(np.sqrt(np.mean(errors**2)))


def test_injector_friction_and_switching_cut_the_naive_error_about_seven_fold():
    data = recorded_set(20)
    naive, full = (rms(held_out_errors(data, names)) for names in ((), STEPS[:3]))
    assert 5.0 < naive / full < 12.0
    assert full < 0.15e-6


if __name__ == "__main__":
    import argparse
    from pathlib import Path

    import matplotlib.pyplot as plt

    from model_lab.comparison.add import write_model
    from model_lab.measurements.save import write_set

    parser = argparse.ArgumentParser(description="the ladder of Fig. 4.6")
    parser.add_argument("--cycles", type=int, default=60, help="pulses a direction and supply")
    parser.add_argument("--out", type=Path, default=Path("out/thesis-ladder"))
    parser.add_argument("--figure", type=Path, help="picture; thesis-ladder.png in --out if absent")
    parser.add_argument("--force", action="store_true", help="overwrite what is there")
    given = parser.parse_args()

    pulses = recorded_set(given.cycles)
    write_set(pulses, given.out / "pulses", given.force)
    direction = np.concatenate([run.columns["direction"] for run in pulses.runs])
    mass = np.concatenate([run.columns["mass"] for run in pulses.runs])
    figure, axis = plt.subplots(figsize=(7.0, 4.2), layout="constrained")
    print(f"{'error, held out [mg]':<22}{'all':>9}{'inflate':>9}{'deflate':>9}{'naive/this':>12}")
    first = None
    for index, names in enumerate(ladder()):
        label = "naive" if not names else f"+ {names[-1]}"
        file = given.out / f"{index}_{names[-1] if names else 'naive'}.yaml"
        write_model(file, model_of(pulses, names), f"step {index} of Fig. 4.6", given.force)
        errors = held_out_errors(pulses, names)
        first = first or rms(errors)
        each = [rms(errors), *(rms(errors[direction == way]) for way in (INFLATE, DEFLATE))]
        numbers = "".join(f"{1e6 * value:9.3f}" for value in each)
        print(f"{label:<22}{numbers}{first / each[0]:12.1f}")
        if index in (0, 3):
            axis.plot(
                1e6 * mass * direction, 1e6 * errors, ".", label=f"{label}: {1e6 * each[0]:.2f} mg"
            )
    axis.set_xlabel("measured change of the channel's air mass [mg]")
    axis.set_ylabel("measured minus predicted [mg]")
    axis.legend(title="RMS error, held out")
    axis.axhline(0.0, color="0.6", linewidth=0.8, zorder=0)
    figure.savefig(given.figure or given.out / "thesis-ladder.png", dpi=100)
    print(f"written to {given.out}")
