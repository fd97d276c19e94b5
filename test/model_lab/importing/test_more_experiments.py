"""Tests of rubber in several modes, valve pulses, and torques of a held finger: files as rigs write
them become sets that load, or the message names what is missing.
"""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation, Slerp

from model_lab.cli.main import main
from model_lab.importing.importing import propose
from model_lab.measurements.load import load_measurements

MODULUS = 90e3  # [Pa]
EXPONENTS = {"uniaxial": -2.0, "pure_shear": -3.0, "equibiaxial": -5.0}
STRETCH = 1.0 + 1.2 * np.sin(np.linspace(0.0, np.pi, 41))


def stress(mode):
    return MODULUS * (STRETCH - STRETCH ** EXPONENTS[mode])


def written(path, header, columns, sign=";", decimal=","):
    rows = [
        sign.join(
            value if isinstance(value, str) else f"{value:.7g}".replace(".", decimal)
            for value in row
        )
        for row in zip(*columns, strict=True)
    ]
    path.write_text("\n".join([header, *rows]) + "\n", encoding="utf-8")
    return path


def imported(tmp_path, files, *options):
    out = tmp_path / "set"
    words = ["import", *map(str, files), "-o", str(out), *options, "--yes", "--force"]
    return load_measurements(out) if main(words) == 0 else None


# ---------------------------------------------------------------------- rubber
def in_files(folder):
    names = {"uniaxial": "zugversuch_1", "pure_shear": "planar_1", "equibiaxial": "biax_1"}
    header = "Zeit in s;Dehnung in %;Spannung in MPa"
    time = np.linspace(0.0, 40.0, 41)
    return [
        written(
            folder / f"{name}.csv", header, (time, 100.0 * (STRETCH - 1.0), 1e-6 * stress(mode))
        )
        for mode, name in names.items()
    ]


def by_a_column(folder):
    cells = [mode.replace("_", " ") for mode in EXPONENTS for _ in STRETCH]
    stresses = np.concatenate([stress(mode) for mode in EXPONENTS])
    header = "Mode,Stretch (-),Engineering stress (kPa)"
    columns = cells, np.tile(STRETCH, 3), 1e-3 * stresses
    return [written(folder / "sheet.csv", header, columns, ",", ".")]


def side_by_side(folder):
    header = "\t".join(f"Stretch {mode}\tStress {mode} [kPa]" for mode in EXPONENTS)
    columns = [one for mode in EXPONENTS for one in (STRETCH, 1e-3 * stress(mode))]
    return [written(folder / "rubber.txt", header, columns, "\t", ".")]


@pytest.mark.parametrize("rig", [in_files, by_a_column, side_by_side])
def test_a_rubber_in_three_modes_is_one_set(tmp_path, rig):
    data = imported(tmp_path, rig(tmp_path))
    assert data.experiment == "rubber" and len(data.specimens) == 1
    assert {run.mode for run in data.runs} == set(EXPONENTS)
    assert len({run.protocol for run in data.runs}) == 3
    (specimen,) = data.specimens.values()
    assert specimen.values["shear_modulus"] == pytest.approx(MODULUS, rel=0.01)
    for run in data.runs:
        np.testing.assert_allclose(run.columns["stress"], stress(run.mode), rtol=1e-5, atol=1.0)


def test_a_mode_that_no_name_says_is_asked_and_can_be_said(tmp_path, capsys):
    files = in_files(tmp_path)
    plain = [path.rename(tmp_path / f"r{n}.csv") for n, path in enumerate(files)]
    assert imported(tmp_path, plain, "--experiment", "rubber") is None
    assert "the mode of r0.csv (--mode r0.csv=uniaxial" in capsys.readouterr().err
    said = [f"--mode=r{n}.csv={mode}" for n, mode in enumerate(EXPONENTS)]
    data = imported(tmp_path, plain, "--experiment", "rubber", *said)
    assert [run.mode for run in data.runs] == list(EXPONENTS)
    assert "--mode r1.csv=pure_shear" in capsys.readouterr().out
    assert imported(tmp_path, in_files(tmp_path)[:1], "--mode=uniaxial") is None
    assert "--mode: expected a test of rubber" in capsys.readouterr().err


def test_pulls_alone_stay_an_experiment_in_tension(tmp_path):
    assert propose(in_files(tmp_path)[:1]).experiment == "uniaxial"


# ---------------------------------------------------------------------- pulses
COUNT = 24
WAY = np.tile([1.0, -1.0], COUNT // 2)
DURATION = np.linspace(0.04, 0.4, COUNT)  # [s]
P_IN = np.where(WAY > 0.0, 400e3, 250e3)  # [Pa], absolute
P_OUT = np.where(WAY > 0.0, 150e3, 101.325e3)
MASS = 5e-10 * P_IN * DURATION  # [kg]


def in_german(folder):
    words = np.where(WAY > 0.0, "Belüften", "Entlüften").tolist()
    header = "Richtung;Öffnungszeit [ms];Eingangsdruck [bar];Ausgangsdruck [bar];Luftmasse [mg]"
    columns = words, 1e3 * DURATION, 1e-5 * P_IN, 1e-5 * P_OUT, 1e6 * MASS
    return written(folder / "ventil.csv", header, columns)


def in_german_letters(folder):
    words = np.where(WAY > 0.0, "Belüften", "Entlüften").tolist()
    header = "Richtung;Dauer [ms];p_ein [bar];p_aus [bar];Masse [mg]"
    columns = words, 1e3 * DURATION, 1e-5 * P_IN, 1e-5 * P_OUT, 1e6 * MASS
    return written(folder / "ventil.csv", header, columns)


def in_gauge(folder):
    header = "direction,pulse_width_ms,p_upstream (kPa(g)),p_downstream (kPa(g)),mass (g)"
    header += ",mass flow (g/s)"
    gauge = [1e-3 * (one - 101.325e3) for one in (P_IN, P_OUT)]
    return written(
        folder / "a.csv", header, (WAY, 1e3 * DURATION, *gauge, 1e3 * MASS, MASS), ",", "."
    )


def in_units_below(folder):
    header = "dir\tduration\tp_in\tp_out\tfriction integral\tmass\n-\ts\tmbar\tmbar\tmbar*s\tkg"
    words = np.where(WAY > 0.0, "in", "out").tolist()
    friction = 1e-2 * (P_IN - P_OUT) * DURATION
    columns = words, DURATION, 1e-2 * P_IN, 1e-2 * P_OUT, friction, MASS
    return written(folder / "b.txt", header, columns, "\t", ".")


@pytest.mark.parametrize("rig", [in_german, in_german_letters, in_gauge, in_units_below])
def test_valve_pulses_are_a_set_with_absolute_pressures(tmp_path, rig):
    data = imported(tmp_path, [rig(tmp_path)])
    assert data.experiment == "valve_pulse"
    (run,) = data.runs
    wanted = {"direction": WAY, "duration": DURATION, "p_in": P_IN, "p_out": P_OUT, "mass": MASS}
    if rig is in_units_below:
        wanted["friction_integral"] = (P_IN - P_OUT) * DURATION
    for name, values in wanted.items():
        np.testing.assert_allclose(run.columns[name], values, rtol=1e-5, err_msg=name)


def test_pulses_lower_than_any_air_are_asked_about(tmp_path, capsys):
    header = "direction,duration [s],p_in [kPa],p_out [kPa],mass [mg]"
    gauge = [1e-3 * (one - 101.325e3) for one in (P_IN, P_OUT)]
    path = written(tmp_path / "a.csv", header, (WAY, DURATION, *gauge, 1e6 * MASS), ",", ".")
    assert imported(tmp_path, [path]) is None
    message = capsys.readouterr().err
    assert "whether p_out is absolute (--map 'p_out=p_out:kPa(a)'" in message
    said = [f"--map={name}={name}:kPa(g)" for name in ("p_in", "p_out")]
    data = imported(tmp_path, [path], *said)
    np.testing.assert_allclose(data.runs[0].columns["p_out"], P_OUT, rtol=1e-5)


@pytest.mark.parametrize(
    ("header", "parts"),
    [
        ("valve,duration [s],p_in [kPa],p_out [kPa],mass [mg]", ["the column of direction"]),
        ("direction,duration,p_in [kPa],p_out [kPa],mass [mg]", ["the unit of duration"]),
        ("direction,duration [s],p_in [kPa],outlet [kPa],p_out [kPa],mass [mg]", ["for p_out"]),
    ],
)
def test_what_pulses_lack_is_named(tmp_path, header, parts, capsys):
    columns = WAY, DURATION, 1e-3 * P_IN, *[1e-3 * P_OUT] * (header.count("out")), 1e6 * MASS
    path = written(tmp_path / "a.csv", header, columns, ",", ".")
    assert imported(tmp_path, [path]) is None
    message = capsys.readouterr().err
    assert all(part in message for part in parts), message


def test_a_direction_of_zeros_is_refused(tmp_path, capsys):
    header = "direction,duration [s],p_in [kPa],p_out [kPa],mass [mg]"
    columns = WAY > 0.0, DURATION, 1e-3 * P_IN, 1e-3 * P_OUT, 1e6 * MASS
    path = written(tmp_path / "a.csv", header, columns, ",", ".")
    assert imported(tmp_path, [path]) is None
    assert "column direction, direction of the pulses: expected words" in capsys.readouterr().err


# ---------------------------------------------------------------------- torques
TIME = np.linspace(0.0, 6.0, 61)
TURN = Rotation.from_rotvec(np.outer(np.sin(TIME), [0.2, 0.9, 0.1]))
PLACE = 1e-3 * np.stack([30.0 * np.sin(TIME), 5.0 * np.cos(TIME), 80.0 + 0.0 * TIME])  # [m]
TORQUE = 1e-3 * np.stack([np.sin(TIME), 4.0 * np.cos(TIME), 0.3 * TIME])  # [N m]
PRESSURE = 20e3 + 1e3 * TIME  # [Pa]
POSE = [*PLACE, *TURN.as_quat().T]


def transducer(folder):
    """A force-torque transducer beside a tracker, in German."""
    header = (
        "Zeit [s];Druck [mbar];Fx [N];Fy [N];Fz [N];Mx [Nmm];My [Nmm];Mz [Nmm];"
        "Pos x [mm];Pos y [mm];Pos z [mm];qw;qx;qy;qz"
    )
    turn = TURN.as_quat().T[[3, 0, 1, 2]]
    columns = TIME, 1e-2 * PRESSURE, *TORQUE, *(1e3 * TORQUE), *(1e3 * PLACE), *turn
    return [written(folder / "halten.csv", header, columns)]


def messages(folder):
    """Columns of ROS messages, units in the row below."""
    names = [f"pose.position.{axis}" for axis in "xyz"]
    names += [f"pose.orientation.{axis}" for axis in "xyzw"]
    names += [f"wrench.{kind}.{axis}" for kind in ("force", "torque") for axis in "xyz"]
    units = ["m"] * 3 + [""] * 4 + ["N"] * 3 + ["N m"] * 3
    header = ",".join(["time", "pressure", *names]) + "\n" + ",".join(["s", "kPa", *units])
    columns = TIME, 1e-3 * PRESSURE, *POSE, *TORQUE, *TORQUE
    return [written(folder / "held.csv", header, columns, ",", ".")]


def units_in_names(folder):
    names = ["t_s", "p_kPa", *(f"tip_{axis}_mm" for axis in "xyz")]
    names += [*(f"tip_q{axis}" for axis in "xyzw"), *(f"torque_{axis}_Nm" for axis in "xyz")]
    columns = TIME, 1e-3 * PRESSURE, *(1e3 * PLACE), *TURN.as_quat().T, *TORQUE
    return [written(folder / "held.csv", ",".join(names), columns, ",", ".")]


@pytest.mark.parametrize("rig", [transducer, messages, units_in_names])
def test_torques_of_a_held_finger_are_a_set(tmp_path, rig):
    data = imported(tmp_path, rig(tmp_path), "--hand", "rbo_hand_2:index")
    assert data.experiment == "base_torque"
    (run,) = data.runs
    names = [f"tip_{part}" for part in ("x", "y", "z", "qx", "qy", "qz", "qw")]
    names += [f"torque_{axis}" for axis in "xyz"]
    for name, values in zip(
        ["time", "pressure", *names], [TIME, PRESSURE, *POSE, *TORQUE], strict=True
    ):
        np.testing.assert_allclose(run.columns[name], values, atol=1e-6, rtol=1e-5, err_msg=name)


def test_a_pose_at_another_rate_is_taken_at_the_times_of_the_torques(tmp_path):
    seen = np.linspace(-0.2, 6.2, 400)
    turn = Rotation.from_rotvec(np.outer(np.sin(seen), [0.2, 0.9, 0.1])).as_quat()
    turn[::2] *= -1.0  # as trackers write it: q and -q are the same attitude
    place = np.stack([30.0 * np.sin(seen), 5.0 * np.cos(seen), 80.0 + 0.0 * seen])
    header = "time [s],pressure [kPa],tip x [mm],tip y [mm],tip z [mm],qx,qy,qz,qw"
    columns = seen, 20.0 + seen, *place, *turn.T
    pose = written(tmp_path / "r1_pose.csv", header, columns, ",", ".")
    header = "time [s],T_x [N mm],T_y [N mm],T_z [N mm]"
    torque = written(tmp_path / "r1_torque.csv", header, (TIME, *(1e3 * TORQUE)), ",", ".")
    data = imported(tmp_path, [pose, torque])
    (run,) = data.runs
    np.testing.assert_allclose(run.columns["torque_z"], TORQUE[2], atol=1e-8)
    found = Rotation.from_quat(np.stack([run.columns[f"tip_q{part}"] for part in "xyzw"], axis=1))
    wanted = Slerp(seen, Rotation.from_quat(turn))(TIME)
    assert (found * wanted.inv()).magnitude().max() < 1e-3
    np.testing.assert_allclose(run.columns["pressure"], 1e3 * (20.0 + TIME), rtol=1e-6)


def test_what_a_held_finger_lacks_is_named(tmp_path, capsys):
    (path,) = units_in_names(tmp_path)
    path.write_text(path.read_text().replace("tip_qw", "q_scalar"))
    assert imported(tmp_path, [path]) is None
    assert "the column of tip_qw (--map tip_qw=COLUMN:UNIT)" in capsys.readouterr().err
    data = imported(tmp_path, [path], "--map=tip_qw=q_scalar")
    np.testing.assert_allclose(data.runs[0].columns["tip_qw"], TURN.as_quat()[:, 3], atol=1e-6)


# ---------------------------------------------------------------------- parting into runs
BEND = np.linspace(0.0, 40.0, 41)


def restarted(folder, times):
    rows = np.concatenate(times)
    pressure = np.concatenate([BEND[: len(one)] for one in times])
    header = "time [s],pressure [kPa],angle [deg]"
    return written(folder / "log.csv", header, (rows, pressure, 2.0 * pressure), ",", ".")


def test_a_clock_that_begins_anew_parts_runs_where_the_user_says_so(tmp_path, capsys):
    times = [0.1 * np.arange(41), 0.02 + 0.1 * np.arange(30), 0.1 * np.arange(25)]
    path = restarted(tmp_path, times)
    assert imported(tmp_path, [path]) is None
    message = capsys.readouterr().err
    assert "row 42 of pressure: its clock begins anew there, at 0.02 s after 4 s" in message
    assert "--split-restarts" in message
    data = imported(tmp_path, [path], "--split-restarts")
    assert [run.samples for run in data.runs] == [41, 30, 25]
    for run, clock in zip(data.runs, times, strict=True):
        np.testing.assert_allclose(run.columns["time"], clock - clock[0], atol=1e-9)
        np.testing.assert_allclose(run.columns["pressure"], 1e3 * BEND[: len(clock)])
    said = capsys.readouterr().out
    assert "begins anew in row 42 and 72: its parts are 3 runs" in said
    assert "--split-restarts --yes" in said


def test_a_clock_that_pauses_parts_runs_where_the_user_says_so(tmp_path, capsys):
    times = [0.1 * np.arange(41), 60.0 + 0.1 * np.arange(41)]
    path = restarted(tmp_path, times)
    assert len(imported(tmp_path, [path]).runs) == 1
    said = capsys.readouterr().out
    assert "its clock pauses before row 42; if another run begins there" in said
    data = imported(tmp_path, [path], "--split-restarts", "--force")
    assert [run.samples for run in data.runs] == [41, 41]
    assert "goes on after a pause in row 42" in capsys.readouterr().out


def test_rows_out_of_order_are_no_restart(tmp_path, capsys):
    clock = 0.1 * np.arange(41)
    clock[[3, 4]] = clock[[4, 3]]
    assert imported(tmp_path, [restarted(tmp_path, [clock])], "--split-restarts") is None
    assert "expected a time after" in capsys.readouterr().err


@pytest.mark.parametrize(
    "label", ["Prüfkörper", "Probe", "échantillon", "muestra", "Muestra nº", "Éprouvette"]
)
def test_rows_of_several_specimens_are_runs_in_any_of_the_languages(tmp_path, label):
    header = f"{label},time [s],pressure [kPa],angle [deg]"
    cells = ["thin"] * len(BEND) + ["thick"] * len(BEND)
    pressure = np.tile(BEND, 2)
    columns = cells, np.tile(0.1 * np.arange(len(BEND)), 2), pressure, 2.0 * pressure
    data = imported(tmp_path, [written(tmp_path / "r.csv", header, columns, ",", ".")])
    assert sorted(data.specimens) == ["thick", "thin"] and len(data.runs) == 2
