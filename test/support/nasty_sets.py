"""Measurement sets that a bench may well produce and that are hard on the lab: by name."""

from dataclasses import dataclass, field

import numpy as np
from measurement_folder import SPECIMEN, csv_text, write_set

SAMPLES = 25
BENDING = {
    "time": {"unit": "s"},
    "pressure": {"unit": "kPa"},
    "tip_angle": {"unit": "deg"},
}
FORCE = {"time": {"unit": "s"}, "pressure": {"unit": "kPa"}, "tip_force": {"unit": "N"}}
PULL = {"time": {"unit": "s"}, "stretch": {"unit": ""}, "stress": {"unit": "kPa"}}
PULSES = {
    "duration": {"unit": "s"},
    "p_in": {"unit": "kPa"},
    "p_out": {"unit": "kPa"},
    "mass": {"unit": "mg"},
}
INTEGRALS = {"friction_integral": {"unit": "Pa*s"}, "injector_integral": {"unit": "Pa*s"}}
BAR = {"f": {"shear_modulus": 50e3}}
NO_FLOOR = "noise floor: expected repeated runs"


@dataclass(frozen=True)
class Nasty:
    """A set; runs: (columns, entries of the document). refused: what the error names, if any."""

    runs: list
    experiment: str = "free_bending"
    columns: dict = field(default_factory=lambda: BENDING)
    specimens: dict = field(default_factory=lambda: {"f": SPECIMEN})
    model: str = "base"
    noise: dict = field(default_factory=dict)
    refused: str = ""

    def write(self, folder):
        """Write the set; returns its folder."""
        entries = {
            f"r{n}": {"specimen": "f", "file": f"r{n}.csv", **entry}
            for n, (_, entry) in enumerate(self.runs)
        }
        content = {
            "format": "softhand-measurement/1",
            "experiment": self.experiment,
            "specimens": self.specimens,
            "columns": self.columns,
            "runs": entries,
        }
        content |= {"noise": self.noise} if self.noise else {}
        files = {f"r{n}.csv": csv_text(columns) for n, (columns, _) in enumerate(self.runs)}
        return write_set(folder, content, files)


def triangle(samples=SAMPLES, peak=40.0, duration=10.0):
    """Time [s] and pressure [kPa]."""
    time = np.linspace(0.0, duration, samples)
    return time, peak * (1.0 - np.abs(2.0 * time / duration - 1.0))


class _Bench:
    """Makes runs with a noise of its own; angles in deg, forces in N, stresses in kPa."""

    def __init__(self, seed=0):
        self.random = np.random.default_rng(seed)

    def bend(self, time, pressure, noise=0.3, **entries):
        """A finger that bends a little more than in proportion."""
        time, pressure = np.asarray(time, float), np.asarray(pressure, float)
        angle = 2.0 * pressure + 0.01 * pressure**2 + noise * self.random.standard_normal(len(time))
        return {"time": time, "pressure": pressure, "tip_angle": angle}, entries

    def press(self, time, pressure, drift=0.0, **entries):
        """A tip force with a gauge that drifts [N/s]."""
        force = 0.02 * pressure + drift * time + 0.01 * self.random.standard_normal(len(time))
        return {"time": time, "pressure": pressure, "tip_force": force}, entries

    def pull(self, stretch, offset=0.0, factor=1.0, **entries):
        """A strip of 50 kPa."""
        stress = 50.0 * factor * (stretch - stretch**-2) + offset
        stress = stress + 0.2 * self.random.standard_normal(len(stretch))
        time = np.linspace(0.0, 10.0, len(stretch))
        return {"time": time, "stretch": stretch, "stress": stress}, entries

    def pulses(self, count, directions=(1.0, -1.0), integrals=True, longest=0.2):
        """Valve pulses of 20 ms up to the longest, or of none."""
        random = self.random
        duration = random.uniform(min(0.02, longest), longest, count)
        p_in, p_out = random.uniform(250.0, 320.0, count), random.uniform(100.0, 200.0, count)
        columns = {
            "direction": random.choice(directions, count),
            "duration": duration,
            "p_in": p_in,
            "p_out": p_out,
            "mass": 0.2 * duration * p_in + 0.05 * random.standard_normal(count),
        }
        if integrals:
            columns["friction_integral"] = 1e3 * (p_in - p_out) * duration
            columns["injector_integral"] = 484.0 * p_in * duration
        return columns, {}


def _without(run, *names):
    columns, entries = run
    return {name: values for name, values in columns.items() if name not in names}, entries


def _with(run, **columns):
    return run[0] | columns, run[1]


def bending_sets():
    """Sets of free bending that can be diagnosed."""
    bench = _Bench()
    time = np.linspace(0.0, 10.0, SAMPLES)
    plateaus = 10.0 * np.round(triangle()[1] / 10.0)
    snap = [bench.bend(*triangle(peak=q), protocol=f"to_{q:g}") for q in (20.0, 30.0, 40.0)]
    no_time = {name: unit for name, unit in BENDING.items() if name != "time"}
    return {
        "nothing_at_all": Nasty(
            [_with(bench.bend(time, 0.0 * time), tip_angle=0.0 * time) for _ in range(2)]
        ),
        "single_run": Nasty([bench.bend(*triangle())]),
        "no_time": Nasty([_without(bench.bend(*triangle()), "time")] * 2, columns=no_time),
        "no_noise": Nasty([bench.bend(*triangle(peak=q), noise=0.0) for q in (20.0, 40.0)]),
        "repeats_without_noise": Nasty([bench.bend(*triangle(), noise=0.0, protocol="a")] * 3),
        "constant_pressures": Nasty([bench.bend(time, 0.0 * time + q) for q in (10.0, 20.0, 30.0)]),
        "plateaus": Nasty([bench.bend(time, plateaus) for _ in range(2)]),
        "below_zero": Nasty([bench.bend(time, q * np.sin(time)) for q in (20.0, 40.0)]),
        "constant_and_equal": Nasty([bench.bend(time, 0.0 * time + 20.0, noise=0.0)] * 2),
        "no_pressure": Nasty([bench.bend(time, 0.0 * time) for _ in range(2)]),
        "no_angle": Nasty([_with(bench.bend(*triangle()), tip_angle=0.0 * time)] * 2),
        "other_sign": Nasty(
            [_with(run := bench.bend(*triangle()), tip_angle=-run[0]["tip_angle"])] * 2
        ),
        "one_long_run": Nasty(
            [bench.bend(*triangle(20, duration=5.0)) for _ in range(2)]
            + [bench.bend(*triangle(120, duration=2000.0))]
        ),
        "repeats_of_other_lengths": Nasty(
            [bench.bend(*triangle(n), protocol="a") for n in (25, 26, 14, 5)]
        ),
        "three_samples_a_run": Nasty(
            [bench.bend(*triangle(3, q), protocol=f"to_{q:g}") for q in (10.0, 30.0, 40.0)] * 2
        ),
        "many_short_runs": Nasty(
            [bench.bend(*triangle(12, 5.0 + n)) for n in range(24)], noise={"tip_angle": 0.3}
        ),
        "absurd_values": Nasty([bench.bend(time, 1e6 * triangle()[1])] * 2),
        "tiny_values": Nasty([bench.bend(time, 1e-9 * triangle()[1], noise=1e-12)] * 2),
        "seconds_since_1970": Nasty([bench.bend(1.7e9 + triangle()[0], triangle()[1])] * 2),
        "steady_and_virgin": Nasty(
            [bench.bend(time, 10.0 + triangle()[1], initial="steady", virgin=True)] * 2
        ),
        "snap": Nasty(
            [_with(r, tip_angle=r[0]["tip_angle"] + 30.0 * (r[0]["pressure"] > 25)) for r in snap]
        ),
        "tiny_noise_stated": Nasty([bench.bend(*triangle())], noise={"tip_angle": 1e-9}),
        "huge_noise_stated": Nasty([bench.bend(*triangle())], noise={"tip_angle": 1e6}),
        "linear": Nasty([bench.bend(*triangle())] * 2, specimens={"f": {}}, model="linear"),
        "linear_without_pressure": Nasty([bench.bend(time, 0.0 * time)], model="linear"),
        "linear_below_zero": Nasty([bench.bend(time, triangle()[1] - 20.0)], model="linear"),
    }


def other_sets():
    """Sets of other experiments that can be diagnosed."""
    bench = _Bench(1)
    ramp, time = np.linspace(1.0, 3.0, SAMPLES), np.linspace(0.0, 6.0, SAMPLES)
    force = {"experiment": "blocked_tip", "columns": FORCE}
    pull = {"experiment": "uniaxial", "columns": PULL, "specimens": BAR}
    pulse = {"experiment": "valve_pulse", "specimens": {"f": {}}}
    whole = pulse | {"columns": PULSES | INTEGRALS}
    drifting = [bench.press(*triangle(15), drift=0.05, protocol="a") for _ in range(3)]
    switched = [bench.press(time, np.where(time < 3.0, q, 0.0)) for q in (10.0, 20.0, 40.0)]
    wave = 1.0 + 0.4 * np.sin(time)
    return {
        "drifting_gauge": Nasty(drifting, **force),
        "drifting_gauge_linear": Nasty(drifting, **force, model="linear"),
        "switched_pressure_linear": Nasty(switched, **force, model="linear"),
        "negative_stress": Nasty([bench.pull(wave, offset=-20.0)], **pull),
        "no_stretch": Nasty([bench.pull(0.0 * ramp + 1.0)], **pull),
        "stretch_to_30": Nasty([bench.pull(np.linspace(1.0, 30.0, SAMPLES))], **pull),
        "modulus_far_off": Nasty([bench.pull(ramp, factor=30.0)] * 2, **pull),
        "pulses": Nasty([bench.pulses(20) for _ in range(3)], **whole),
        "pulses_one_way": Nasty([bench.pulses(20, (1.0,)) for _ in range(3)], **whole),
        "one_pulse_a_run": Nasty(
            [bench.pulses(1) for _ in range(12)], **whole, noise={"mass": 0.05}
        ),
        "pulses_without_integrals": Nasty(
            [bench.pulses(20, integrals=False) for _ in range(2)], **pulse, columns=PULSES
        ),
    }


def refused_sets():
    """Sets that cannot be used, with what the error must name."""
    bench = _Bench(2)
    time, pressure = triangle()
    run = bench.bend(time, pressure)
    holes = run[0]["tip_angle"].copy()
    holes[7] = np.nan
    pull = {"experiment": "uniaxial", "columns": PULL}
    unread = {name: unit for name, unit in BENDING.items() if name != "pressure"}
    return {
        "five_samples": Nasty([bench.bend(*triangle(5))], refused=NO_FLOOR),
        "one_sample": Nasty([bench.bend([0.0], [20.0])], refused=NO_FLOOR),
        "one_sample_a_run": Nasty(
            [bench.bend([0.0], [q]) for q in (10.0, 20.0, 30.0)],
            refused=NO_FLOOR,
        ),
        "unsorted": Nasty([bench.bend(time[::-1], pressure)], refused="r0.csv: row 2 "),
        "time_stands_still": Nasty([bench.bend(np.floor(time), pressure)], refused="again"),
        "column_missing": Nasty([run], columns=BENDING | {"tip_z": {"unit": "m"}}, refused="tip_z"),
        "column_unnamed": Nasty([run], columns=unread, refused="expected the column pressure"),
        "hole": Nasty([_with(run, tip_angle=holes)], refused="r0.csv: row 8 (line 9 of the file)"),
        "no_sizes": Nasty([run], specimens={"f": {"length": 0.05}}, refused="the key height"),
        "pulse_of_no_duration": Nasty(
            [bench.pulses(20, longest=0.0)], "valve_pulse", PULSES | INTEGRALS, {"f": {}},
            refused="r0.csv: row 1 (line 2 of the file), column duration",
        ),
        "strain_for_stretch": Nasty(
            [_with(bench.pull(np.linspace(1.0, 2.0, 20)), stretch=np.linspace(0.0, 1.0, 20))],
            **pull, specimens=BAR, refused="column stretch: expected a number from 0.1 to 50",
        ),
        "no_modulus": Nasty(
            [bench.pull(np.linspace(1.0, 2.0, 20))], **pull, specimens={"f": {}},
            refused="the key shear_modulus",
        ),
    }  # fmt: skip
