"""The noise floor of valve pulses without repeats, against masses of a known law and noise."""

import numpy as np
import pytest

from model_lab.diagnosis.diagnose import diagnose
from model_lab.fitting.pulse_noise import pulse_level
from model_lab.measurements.load import load_measurements
from softhand_model.model_file import load_model

NOISE = 0.5e-6  # [kg]
AIR, SUPPLY = 101.325e3, 450e3  # [Pa]


def choked(ratio):
    """Flow function of a choke, of the ratio of the pressures behind and before it."""
    open_ = np.sqrt(np.maximum(3.5 * (ratio ** (2 / 1.4) - ratio ** (2.4 / 1.4)), 0.0))
    return np.where(ratio > 0.5283, open_, 0.484)


def pulses(seed, count=120, delay=0.0):
    """Pulses of a choke in random order, each with durations and pressures of its own.

    delay [s]: by which the choke opens late.
    """
    random = np.random.default_rng(seed)
    inflates = np.arange(count) % 2 == 0
    duration = 0.04 + random.exponential(0.1, count)
    chamber = random.uniform(130e3, 400e3, count)
    p_in, p_out = np.where(inflates, SUPPLY, chamber), np.where(inflates, chamber, AIR)
    flow = 3e-9 * p_in * choked(p_out / p_in)
    mass = flow * (duration - delay) + random.normal(0.0, NOISE, count)
    columns = {
        "direction": np.where(inflates, 1.0, -1.0),
        "duration": duration,
        "p_in": p_in,
        "p_out": p_out,
        "mass": mass,
    }
    return columns


def written(folder, columns, *repeats):
    """A set of these pulses; repeats: of runs that are stated as repeats."""
    runs = []
    for number, run in enumerate([columns, *repeats]):
        rows = zip(*run.values(), strict=True)
        text = "\n".join([",".join(run), *(",".join(f"{x:.9g}" for x in row) for row in rows)])
        (folder / f"p{number}.csv").write_text(text + "\n")
        runs.append(f"p{number}: {{specimen: channel, protocol: pulses, file: p{number}.csv}}")
    units = {"direction": "''", "duration": "s", "p_in": "Pa", "p_out": "Pa", "mass": "kg"}
    stated = ", ".join(f"{name}: {{unit: {unit}}}" for name, unit in units.items())
    (folder / "experiment.yaml").write_text(
        "format: softhand-measurement/1\nexperiment: valve_pulse\ntitle: choke\n"
        f"specimens: {{channel: {{}}}}\ncolumns: {{{stated}}}\n"
        f"runs: {{{', '.join(runs)}}}\n"
    )
    return load_measurements(folder)


@pytest.mark.parametrize("seed", [1, 2])
def test_pulses_in_any_order_show_their_noise(tmp_path, seed):
    data = written(tmp_path, pulses(seed))
    level = pulse_level(data, data.table.value - 1e-9 * data.column("p_in"))
    assert level == pytest.approx(NOISE, rel=0.3)


def test_a_choke_is_named_though_no_pulse_is_repeated(tmp_path):
    found = diagnose(written(tmp_path, pulses(3)), load_model("base")).diagnosis
    assert [effect.name for effect in found.effects] == ["injector_flow"]
    assert found.effects[0].parameters["c2_inflate"].value == pytest.approx(3e-9, rel=0.01)
    assert found.noise_floor == pytest.approx(NOISE, rel=0.3)


def test_other_pulses_are_no_repeats_whose_scatter_hides_a_delay(tmp_path):
    data = written(tmp_path, pulses(3, 120, 0.01), pulses(4, 120, 0.01))
    assert data.groups() == [[0], [1]]
    found = diagnose(data, load_model("base")).diagnosis
    assert [effect.name for effect in found.effects] == ["injector_flow", "valve_delay"]
    assert found.effects[1].parameters["delay"].value == pytest.approx(0.01, rel=0.1)
    assert found.noise_floor == pytest.approx(NOISE, rel=0.3)
    assert "p1 of p0" in next(n["text"] for n in found.notices if n["kind"] == "driven")


def test_few_pulses_show_no_noise(tmp_path):
    data = written(tmp_path, pulses(4, 20))
    assert pulse_level(data, data.table.value) is None
