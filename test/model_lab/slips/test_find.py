"""Slips in sets of which the truth is known: the shipped example, stated otherwise."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml

from bench.hidden import make_set
from bench.hidden.cases import all_cases
from bench.lab import slips
from bench.second_author import slip_sets
from model_lab.bench.synthesize import synthesize
from model_lab.comparison.compare import compare
from model_lab.diagnosis.diagnose import diagnose
from model_lab.diagnosis.result import SLIP
from model_lab.diagnosis.slip_beside_effect import find_all_slips
from model_lab.measurements.load import load_measurements
from model_lab.measurements.measurement_set import TIP_POSE
from model_lab.measurements.save import set_files
from model_lab.report.comparison_text import comparison_text
from model_lab.report.sentences import verdict_sentence
from model_lab.rules import RULES
from model_lab.slips.candidates import candidates
from model_lab.slips.find import (
    PREDICTED_SAMPLES,
    Score,
    _jumps,
    _predicted_error,
    _scores,
    absolute_pressures,
    find_slips,
    is_slip,
    score,
)
from model_lab.slips.outside import below_ambient
from softhand_common.documents.output_file import write_files
from softhand_model.effects import effect_classes
from softhand_model.model_file import load_model

ROOT = Path(__file__).parents[3]
EXAMPLE = ROOT / "examples" / "measurements" / "finger"
CASES = ROOT.parent / "shared" / "cases"
PSI = 6894.757  # [Pa]
FINGER_LENGTH = 0.09  # [m] of both fingers of the example
BASE = load_model("base")


def merged(stated, mend):
    """A document with the entries of a mend in the place of its own."""
    if not (isinstance(stated, dict) and isinstance(mend, dict)):
        return mend
    return stated | {key: merged(stated.get(key), value) for key, value in mend.items()}


def mended(folder, slips):
    """The set of a folder, loaded again with the mends pasted into its document."""
    document = folder / "experiment.yaml"
    content = yaml.safe_load(document.read_text(encoding="utf-8"))
    for slip in slips:
        content = merged(content, yaml.safe_load(slip.mend))
    document.write_text(yaml.safe_dump(content), encoding="utf-8")
    return load_measurements(folder)


def scaled(data, column, factor):
    """The set with one column times a factor."""
    runs = (
        replace(run, columns={**run.columns, column: factor * run.columns[column]})
        for run in data.runs
    )
    return replace(data, runs=tuple(runs))


def case(name):
    folder = CASES / name
    if not folder.is_dir():
        pytest.skip("no shared cases")
    return load_measurements(folder)


def test_pressures_in_psi_that_are_said_to_be_kpa(tmp_path):
    example = load_measurements(EXAMPLE)
    write_files(set_files(scaled(example, "pressure", 1e3 / PSI), tmp_path))
    outcome = diagnose(load_measurements(tmp_path), BASE)
    (slip,) = outcome.diagnosis.slips
    assert (slip.name, slip.column, slip.said, slip.fits) == ("unit", "pressure", "kPa", "psi")
    assert outcome.diagnosis.verdict == SLIP
    own = diagnose(example, BASE).diagnosis
    assert outcome.diagnosis.verdict_mended == own.verdict
    assert slip.rmse_before > 50.0 * slip.rmse_after
    again = diagnose(mended(tmp_path, [slip]), BASE).diagnosis
    assert (again.verdict, again.slips) == (own.verdict, ())
    assert again.rmse_before == pytest.approx(own.rmse_before, rel=1e-3)


@pytest.mark.parametrize("air", [98.0e3, 101.325e3])
def test_absolute_pressures_are_told_even_if_the_model_lacks_more(air):
    """Of the linear model much is left without the slip, too; where the finger rests is plain."""
    linear = load_model("linear")
    absolute = stated_otherwise("pressure", lambda pressure: pressure + air)
    (slip,) = find_slips(absolute, linear).slips
    assert (slip.name, slip.column) == ("absolute", "pressure")
    assert slip.rmse_after > 10.0 * score(absolute, linear).floor
    assert not find_slips(load_measurements(EXAMPLE), linear).slips
    bent = stated_otherwise("tip_angle", lambda angle: angle + np.ptp(angle))  # it does not rest
    moved = stated_otherwise("pressure", lambda pressure: pressure + air, bent)
    assert absolute_pressures(moved, linear, score(moved, linear)) is None


def test_a_set_without_a_slip_is_told_none():
    data = load_measurements(EXAMPLE)
    checked = find_slips(data, BASE)
    assert checked.slips == () and checked.data is data
    assert compare(data, BASE).slips == ()


def test_the_shared_case_in_psi():
    (slip,) = compare(case("psi_said_kPa"), BASE).slips
    assert (slip.column, slip.fits) == ("pressure", "psi")


# ---------------------------------------------------------------------- all kinds
def stated_otherwise(column, change, data=None):
    """The example, or another set, with a column that holds something else."""
    data = data or load_measurements(EXAMPLE)
    runs = (
        replace(run, columns={**run.columns, column: change(run.columns[column])})
        for run in data.runs
    )
    return replace(data, runs=tuple(runs))


def resized(factors):
    """The example with entries of its specimens times factors."""
    data = load_measurements(EXAMPLE)
    specimens = {
        name: replace(
            entry, values={key: factors.get(key, 1.0) * v for key, v in entry.values.items()}
        )
        for name, entry in data.specimens.items()
    }
    return replace(data, specimens=specimens)


def exchanged():
    """The example with the sizes of its fingers exchanged."""
    data = load_measurements(EXAMPLE)
    one, other = data.specimens["thin"], data.specimens["thick"]
    swapped = {
        "thin": replace(one, values=other.values),
        "thick": replace(other, values=one.values),
    }
    return replace(data, specimens=swapped)


def of_specimens(specimens):
    """The example with other specimens of some runs."""
    data = load_measurements(EXAMPLE)
    runs = (replace(run, specimen=specimens.get(run.name, run.specimen)) for run in data.runs)
    return replace(data, runs=tuple(runs))


KINDS = {
    "absolute": (lambda: stated_otherwise("pressure", lambda p: p + 100.9e3), "pressure"),
    "unit": (lambda: scaled(load_measurements(EXAMPLE), "tip_angle", np.pi / 180.0), "tip_angle"),
    "sign": (lambda: stated_otherwise("tip_angle", lambda angle: -angle), "tip_angle"),
    "supplement": (lambda: stated_otherwise("tip_angle", lambda angle: np.pi - angle), "tip_angle"),
    "complement": (
        lambda: stated_otherwise("tip_angle", lambda angle: np.pi / 2.0 - angle),
        "tip_angle",
    ),
    "chord": (lambda: stated_otherwise("tip_angle", lambda angle: 0.5 * angle), "tip_angle"),
    "curvature": (
        lambda: stated_otherwise("tip_angle", lambda a: np.radians(a / FINGER_LENGTH)),
        "tip_angle",
    ),  # [1/m], said to be in deg
    "youngs_modulus": (lambda: resized({"shear_modulus": 3.0}), "shear_modulus"),
    "radius": (lambda: resized({"height": 0.5, "width": 0.5}), "height, width"),
    "wall_total": (lambda: resized({"wall": 2.0, "side_wall": 2.0}), "wall, side_wall"),
    "wrapped_180": (
        lambda: stated_otherwise("tip_angle", lambda angle: np.arctan(np.tan(angle))),
        "tip_angle",
    ),
    "exchanged": (exchanged, "thin, thick"),
    "exchanged runs": (
        lambda: of_specimens({"thin_1": "thick", "thick_1": "thin"}),
        "specimen of thin_1 and thick_1",
    ),
    "odd_run": (lambda: of_specimens({"thick_half_2": "thin"}), "specimen of thick_half_2"),
}


@pytest.mark.parametrize(("stated", "column"), KINDS.values(), ids=KINDS)
def test_each_kind_is_found_and_its_mend_mends(stated, column, request, tmp_path):
    write_files(set_files(stated(), tmp_path))
    checked = find_slips(load_measurements(tmp_path), BASE)
    name = request.node.callspec.id.split()[0]
    assert [(slip.name, slip.column) for slip in checked.slips] == [(name, column)]
    after = mended(tmp_path, checked.slips)
    assert find_slips(after, BASE).slips == ()
    floor = compare(after, BASE).errors
    assert floor.held_out.rmse < 1.2 * floor.floor.total


def with_pressures_of(data, others):
    """The set with the pressures of other runs, by name; both are sampled at other times."""
    runs = {run.name: run for run in data.runs}
    changed = []
    for run in data.runs:
        other = runs[others.get(run.name, run.name)].columns
        pressure = np.interp(run.columns["time"], other["time"], other["pressure"])
        changed.append(replace(run, columns={**run.columns, "pressure": pressure}))
    return replace(data, runs=tuple(changed))


def test_two_runs_whose_pressures_are_exchanged_are_found():
    """Angles and pressures are in files of their own; no run is a repeat of another then."""
    data = load_measurements(EXAMPLE)
    others = {"thin_1": "thin_half_2", "thin_half_2": "thin_1"}
    data = with_pressures_of(data, others)
    checked = find_slips(data, BASE)
    (slip,) = checked.slips
    assert (slip.name, slip.column) == ("exchanged", "the pressure of thin_1 and thin_half_2")
    assert slip.rmse_before > 4.0 * slip.rmse_after
    before = {run.name: run.columns["pressure"] for run in load_measurements(EXAMPLE).runs}
    for run in checked.data.runs:
        assert np.allclose(run.columns["pressure"], before[run.name], atol=200.0)  # [Pa]


def test_an_effect_is_not_called_a_slip(tmp_path):
    for hidden in ("ballooning", "gent_stiffening", "pressure_offset"):
        folder = tmp_path / hidden
        make_set(folder, "free_bending", [(hidden, {})], seed=1, ratio=8.0)
        assert find_slips(load_measurements(folder), BASE).slips == ()
    for gain in (0.9, 0.7, 0.5):  # not those of units
        weaker = scaled(load_measurements(EXAMPLE), "pressure", 1.0 / gain)
        assert find_slips(weaker, BASE).slips == ()


def test_what_fits_as_well_is_told_beside_the_slip():
    diagnosis = diagnose(resized({"shear_modulus": 3.0}), BASE).diagnosis
    assert diagnosis.slips[0].name == "youngs_modulus"
    assert "pressure_gain" in diagnosis.instead
    first = verdict_sentence(diagnosis).split("\n")[0]
    assert "Young's modulus" in first and "shear_modulus" in first


def test_slips_that_the_data_do_not_tell_apart_are_told_together():
    inches = stated_otherwise("pressure", lambda pressure: pressure / 3.386389)
    (slip,) = find_slips(inches, BASE).slips
    assert (slip.name, slip.alike) == ("youngs_modulus", ("pressure is inHg, not kPa",))
    diagnosis = diagnose(inches, BASE).diagnosis
    assert "would fit as well if pressure is inHg" in verdict_sentence(diagnosis)


def test_rubber_of_another_mix_is_told_before_the_slip_that_fits_as_well():
    soft = find_slips(resized({"shear_modulus": 1.8}), BASE).slips[0]
    assert soft.name == "wall_total"
    assert soft.modulus == pytest.approx(1.04 / 1.8, rel=0.05)  # the example's is 1.04 already
    walls = find_slips(resized({"wall": 2.0, "side_wall": 2.0}), BASE).slips[0]
    assert (walls.name, walls.modulus) == ("wall_total", 1.0)  # which no modulus explains


def test_exchanged_specimens_are_told_in_the_first_line():
    first = verdict_sentence(diagnose(exchanged(), BASE).diagnosis).split("\n")[0]
    assert "thin, thick is thick and thin, exchanged" in first


def test_pressures_below_those_of_the_air_are_refused_before_any_search():
    vacuum = stated_otherwise("pressure", lambda pressure: -pressure)
    runs = (
        replace(run, columns={**run.columns, "tip_angle": -0.2 * run.columns["tip_angle"]})
        for run in vacuum.runs
    )
    vacuum = replace(vacuum, runs=tuple(runs))
    with pytest.raises(ValueError, match="inflation.*-45"):
        diagnose(vacuum, BASE)
    assert "inflation" in comparison_text(compare(vacuum, BASE), "base").split("\n")[0]


def test_a_modulus_at_its_bound_is_told_with_what_frees_it():
    soft = resized({"shear_modulus": 1.3})
    diagnosis = diagnose(soft, BASE).diagnosis
    assert diagnosis.at_bound == ("modulus_scale[A]",)
    first = verdict_sentence(diagnosis).split("\n")[0]
    assert diagnosis.effects  # beside which the modulus lies off the bound
    assert "at its bound without them, 0.85 times" in first and "--free-modulus" in first
    free = diagnose(replace(soft, free_modulus=True), BASE).diagnosis
    assert free.at_bound == () and "--free-modulus" not in verdict_sentence(free)
    scale = free.calibration_as_is["modulus_scale"]["A"]
    assert diagnosis.freed["modulus_scale"]["A"] == pytest.approx(scale, rel=0.01)
    assert diagnosis.freed["rmse_heldout"] == pytest.approx(free.rmse_before, rel=0.05)
    assert f"and {scale:.1g}" in first and "times the stated one alone leaves" in first


@pytest.mark.parametrize(
    ("name", "kind", "column"),
    [
        ("E_for_G", "youngs_modulus", "shear_modulus"),
        ("neg_angle", "sign", "tip_angle"),
        ("mbar_abs", "absolute", "pressure"),
    ],
)
def test_the_shared_cases(name, kind, column):
    (slip,) = compare(case(name), BASE).slips
    assert (slip.name, slip.column) == (kind, column)


def test_a_gauge_whose_zero_is_off_is_no_vacuum():
    """A sixth of the range too low; what a chamber is sucked to lies below its rest."""
    low = stated_otherwise("pressure", lambda pressure: pressure - 7e3)
    assert min(run.columns["pressure"].min() for run in low.runs) < RULES.vacuum
    assert below_ambient(low, "pneuflex") is None
    sucked = stated_otherwise("pressure", lambda pressure: -7e3 - pressure)
    assert "below the air around" in below_ambient(sucked, "pneuflex")


def test_the_shared_case_of_vacuum():
    with pytest.raises(ValueError, match="inflation"):
        diagnose(case("vacuum"), BASE)


# ---------------------------------------------------------------------- beside an effect
def with_both_walls(data):
    """The set with the thickness of both walls stated where one belongs."""
    changed = {
        name: replace(
            entry,
            values={
                key: 2.0 * np.asarray(value) if key in ("wall", "side_wall") else value
                for key, value in entry.values.items()
            },
        )
        for name, entry in data.specimens.items()
    }
    return replace(data, specimens=changed)


@pytest.mark.parametrize("hidden", ["hysteresis", "angle_offset"])
def test_a_slip_is_found_beside_a_hidden_effect(hidden, tmp_path):
    make_set(tmp_path, "free_bending", [(hidden, {})], seed=3, ratio=12.0)
    data = load_measurements(tmp_path)
    assert find_all_slips(data, BASE, effect_classes()).slips == ()
    (slip,) = find_all_slips(with_both_walls(data), BASE, effect_classes()).slips
    assert (slip.name, set(slip.column.split(", "))) == ("wall_total", {"wall", "side_wall"})
    assert slip.rmse_after < 0.5 * slip.rmse_before


@pytest.mark.parametrize("hidden", ["tube_lag", "hysteresis"])
def test_beside_an_effect_the_slip_is_told_that_needs_no_odd_modulus(hidden, tmp_path):
    make_set(tmp_path, "free_bending", [(hidden, {})], seed=5, ratio=12.0)
    data = load_measurements(tmp_path)
    stiff = {
        name: replace(
            entry,
            values=entry.values | {"shear_modulus": 3.0 * entry.values["shear_modulus"]},
        )
        for name, entry in data.specimens.items()
    }
    (slip,) = find_all_slips(replace(data, specimens=stiff), BASE, effect_classes()).slips
    assert (slip.name, slip.beside) == ("youngs_modulus", hidden)
    assert slip.alike == ("pressure is inHg, not kPa",)


def test_a_slip_that_leaves_much_gives_way_to_an_effect_that_does_not():
    """A sensor that ends at 20 deg: pressures of a quarter would fit better, and still not fit."""
    made = synthesize("free_bending", 5, True, {"saturation": effect_classes()["saturation"]})
    assert find_all_slips(made.data, BASE, effect_classes()).slips == ()
    text = comparison_text(compare(made.data, BASE), "base")
    assert (
        "The data fit better if pressure is" in text
        and "whether an effect explains this error" in text
    )


@pytest.mark.parametrize(("before", "told"), [(3.0, True), (2.0, False)])
def test_a_slip_that_leaves_noise_alone_need_not_remove_the_noise(before, told):
    """Errors of a few floors, of which a mended set keeps one; an error of two floors might fall to
    the noise by chance.
    """
    stated, without = Score(before, 1.0, 100.0), Score(1.0, 1.0, 100.0)
    assert without.relative > RULES.slip_share * stated.relative
    assert is_slip("radius", stated, without) == told


@pytest.mark.parametrize(
    ("case", "kind"),
    [
        ("slips/scarce/free_bending/nothing", "radius"),  # 3.4 floors, and 1.0 without it
        ("slips/hidden/free_bending/angle_offset", "chord"),  # a pair needs three parameters
    ],
)
def test_a_slip_is_found_that_shows_little_or_that_two_effects_could_replace(case, kind):
    seed = {"radius": 9301, "chord": 9300}[kind]
    cases = (one for way in slips.WAYS for one in slips.base_cases(way))
    (found,) = [one for one in cases if one.name == case]
    clean = slips.made(found, seed, slips.NOISE)
    planted = slips.KINDS[kind](clean, np.random.default_rng(0))
    assert slips.found(planted)[0]
    assert slips.told_of(clean).slips == ()


def test_an_effect_alone_comes_before_a_slip_that_needs_one_too(tmp_path):
    """Stiffening rubber, which is also not far from true stresses of rubber that stiffens less."""
    case = next(one for one in all_cases() if one.name == "uniaxial/yeoh_stiffening/strong")
    case.make(tmp_path, 0, case.noises[-1])
    data = load_measurements(tmp_path)
    assert [slip.name for slip in find_slips(data, BASE).slips] == ["true_stress"]
    assert find_all_slips(data, BASE, effect_classes()).slips == ()


@pytest.mark.parametrize("seed", [703, 51013])
def test_a_slip_beside_rubber_that_softens_is_not_lost_among_unlike_repeats(seed, tmp_path):
    """First runs differ from their repeats, which raises the floor, and within that floor a
    stiffening alone would explain the true stresses, too.
    """
    truth = slip_sets.make(seed, tmp_path)
    (slip,) = find_all_slips(load_measurements(tmp_path), BASE, effect_classes()).slips
    assert (slip.name, slip.beside) == (truth.slip, "mullins_softening")


def test_an_effect_that_begins_above_one_of_two_protocols_is_no_slip(tmp_path):
    """The smaller protocol ends before the chambers swell, so that it predicts the other one badly,
    and twice the section beside the ballooning would predict it better.
    """
    slip_sets.make(719, tmp_path)
    assert find_all_slips(load_measurements(tmp_path), BASE, effect_classes()).slips == ()


@pytest.mark.parametrize(
    ("seed", "name"),
    [
        (937, "complement"),  # of two protocols one ends below the onset of ballooning
        (939, "chord"),  # viscoelasticity and a thick wall do as well, at the end of the modulus
        (1030, "wrapped"),  # hysteresis beside it
    ],
)
def test_a_slip_is_found_beside_what_two_protocols_hardly_show(seed, name, tmp_path):
    truth = slip_sets.make(seed, tmp_path)
    assert truth.slip == name and truth.effects
    (slip,) = find_all_slips(load_measurements(tmp_path), BASE, effect_classes()).slips
    assert slip.name == name


def test_a_unit_is_told_by_which_repeats_seem_to_scatter(tmp_path):
    """By pressures 750 times too large the model tells repeats farther apart than all readings."""
    truth = slip_sets.make(900, tmp_path)
    data = load_measurements(tmp_path)
    assert score(data, BASE).floor > 10.0 * np.std(data.table.value)
    (slip,) = find_slips(data, BASE).slips
    assert (slip.column, slip.said, slip.fits) == ("pressure", "bar", "mmHg") and truth.slip


def test_an_angle_jumps_if_it_stays_within_a_turn_and_runs_on_without_the_jumps():
    angle = np.linspace(0.0, 4.0, 60)
    wrapped = (angle + np.pi) % (2.0 * np.pi) - np.pi
    assert _jumps(wrapped) and not _jumps(angle)
    assert not _jumps(np.where(angle > 2.0, angle + 2.5, angle))  # it snaps through
    assert not _jumps(5.9 * (angle > 2.0) + 3.0 * (angle > 3.0))  # and once more
    coarse = wrapped.copy()
    coarse[:2] -= [0.0, 1.5]  # a step that is neither
    assert not _jumps(coarse)


def test_the_unit_is_told_beside_which_an_effect_explains(tmp_path):
    """A wrong unit alone is nearer to stiffening rubber than the right one."""
    make_set(tmp_path, "uniaxial", [("gent_stiffening", {})], seed=6100, ratio=5.0)
    data = load_measurements(tmp_path)
    assert data.units["stress"] == "kPa"
    stated = scaled(data, "stress", 1e3 / 133.3224)  # the numbers are of mmHg
    (slip,) = find_all_slips(stated, BASE, effect_classes()).slips
    assert (slip.column, slip.fits) == ("stress", "mmHg")


@pytest.mark.parametrize("seed", [2, 3])
def test_a_unit_that_the_calibration_takes_up_is_no_slip(seed, tmp_path):
    """Pulses of valves: the calibration has the same factor as the duration, the leak is large."""
    make_set(tmp_path, "valve_pulse", [("leakage", {})], seed=seed, ratio=4.0)
    assert find_all_slips(load_measurements(tmp_path), BASE, effect_classes()).slips == ()


@pytest.mark.parametrize(
    ("change", "name"),
    [
        (lambda stretch: stretch - 1.0, "strain"),
        (lambda stretch: 100.0 * (stretch - 1.0), "strain"),
        (lambda stretch: 100.0 * stretch, "percent"),
    ],
)
def test_stretches_that_cannot_be_are_told_as_a_slip(change, name, tmp_path):
    make_set(tmp_path / "true", "uniaxial", [], seed=1)
    true = load_measurements(tmp_path / "true")
    runs = (
        replace(run, columns={**run.columns, "stretch": change(run.columns["stretch"])})
        for run in true.runs
    )
    write_files(set_files(replace(true, runs=tuple(runs)), tmp_path / "said"))
    checked = find_slips(load_measurements(tmp_path / "said"), BASE)
    assert [slip.name for slip in checked.slips] == [name]
    again = mended(tmp_path / "said", checked.slips)
    for one in (checked.data, again):
        for run, expected in zip(one.runs, true.runs, strict=True):
            np.testing.assert_allclose(run.columns["stretch"], expected.columns["stretch"], 1e-4)


TORQUES = ("torque_x", "torque_y", "torque_z")
POSE = ("tip_qx", "tip_qy", "tip_qz", "tip_qw")
RUNS = {"base_torque": 4, "rubber": 12}  # of a set: poses out of reach are costly
MODES_SAID = {"pure_shear": "equibiaxial", "equibiaxial": "pure_shear", "uniaxial": "uniaxial"}


def in_newton_centimetres(run):
    return replace(run, columns=run.columns | {name: 0.1 * run.columns[name] for name in TORQUES})


def scalar_first(run):
    """As written w, x, y, z under the names of x, y, z, w."""
    written = zip(POSE, (POSE[3], *POSE[:3]), strict=True)
    return replace(run, columns=run.columns | {name: run.columns[own] for name, own in written})


def in_another_mode(run):
    return replace(run, mode=MODES_SAID[run.mode])


@pytest.mark.parametrize(
    ("experiment", "change", "name", "column"),
    [
        ("base_torque", in_newton_centimetres, "unit", "torque_x, torque_y, torque_z"),
        ("base_torque", scalar_first, "exchanged", "tip_qx, tip_qy, tip_qz, tip_qw"),
        ("rubber", in_another_mode, "exchanged", "mode"),
    ],
)
def test_slips_of_a_whole_sensor_and_of_modes(experiment, change, name, column, tmp_path):
    make_set(tmp_path / "true", experiment, [], seed=1, runs=RUNS[experiment])
    true = load_measurements(tmp_path / "true")
    noise = {
        key: 0.1 * sigma if change is in_newton_centimetres else sigma
        for key, sigma in true.noise.items()
    }
    stated = replace(true, runs=tuple(change(run) for run in true.runs), noise=noise)
    write_files(set_files(stated, tmp_path / "said"))
    checked = find_slips(load_measurements(tmp_path / "said"), BASE)
    assert [(slip.name, slip.column) for slip in checked.slips] == [(name, column)]
    again = mended(tmp_path / "said", checked.slips)
    for one in (checked.data, again):
        found = {run.name: run for run in one.runs}
        for expected in true.runs:
            run = found[expected.name]
            assert run.mode == expected.mode
            for key in (*true.inputs, *true.outputs):
                np.testing.assert_allclose(run.columns[key], expected.columns[key], 1e-4, 1e-9)


def in_unsure_poses(data, seed):
    """The set with tips tracked to 0.05 mm and 0.001, and no word of it; repeats pushed by 2 %
    more or less.
    """
    rng = np.random.default_rng(seed)
    sizes = dict.fromkeys(TIP_POSE[:3], 5e-5) | dict.fromkeys(POSE, 1e-3)
    runs = []
    for run in data.runs:
        tracked = {
            key: run.columns[key] + rng.normal(0.0, size, run.samples)
            for key, size in sizes.items()
        }
        torque = {key: (1.0 + 0.02 * rng.normal()) * run.columns[key] for key in TORQUES}
        runs.append(replace(run, columns=run.columns | tracked | torque))
    return replace(data, runs=tuple(runs), noise={})


@pytest.mark.parametrize(
    ("change", "found"),
    [
        (lambda run: run, []),
        (in_newton_centimetres, [("unit", "torque_x, torque_y, torque_z")]),
        (scalar_first, [("exchanged", "tip_qx, tip_qy, tip_qz, tip_qw")]),
    ],
)
def test_slips_of_torques_are_told_though_no_one_states_how_well_the_pose_is_known(
    change, found, tmp_path
):
    make_set(tmp_path, "base_torque", [], seed=1, runs=RUNS["base_torque"])
    true = in_unsure_poses(load_measurements(tmp_path), seed=2)
    said = replace(true, runs=tuple(change(run) for run in true.runs))
    assert [(one.name, one.column) for one in find_slips(said, BASE).slips] == found


def test_gauge_pressures_of_pulses_are_told_though_those_of_the_air_are_zero(tmp_path):
    make_set(tmp_path / "true", "valve_pulse", [("injector_flow", {})], seed=1)
    true = load_measurements(tmp_path / "true")
    air = min(float(run.columns["p_out"].min()) for run in true.runs)
    runs = (
        replace(
            run, columns=run.columns | {key: run.columns[key] - air for key in ("p_in", "p_out")}
        )
        for run in true.runs
    )
    write_files(set_files(replace(true, runs=tuple(runs)), tmp_path / "said"))
    said = load_measurements(tmp_path / "said")
    assert said.doubts and "is: gauge" in said.doubts[0]
    (slip,) = find_slips(said, BASE).slips
    assert (slip.name, slip.column) == ("absolute", "p_in, p_out")
    again = mended(tmp_path / "said", [slip])
    assert again.doubts == ()
    for run in again.runs:
        expected = next(one for one in true.runs if one.name == run.name)
        assert run.columns["p_in"] == pytest.approx(expected.columns["p_in"], abs=200.0)
    with pytest.raises(ValueError, match="is: gauge"):
        compare(said, BASE)


@pytest.mark.parametrize(("said", "unit"), [("psi", PSI), ("Pa", 1.0), ("kPa", 1e3)])
def test_the_unit_is_told_by_which_a_free_modulus_is_about_the_stated_one(said, unit, tmp_path):
    """Any unit fits rubber of which the modulus is sought, up to fifty times the stated one."""
    make_set(tmp_path, "rubber", [], seed=1)
    data = scaled(load_measurements(tmp_path), "stress", unit / 1e6)
    data = replace(data, units={**data.units, "stress": said})
    (slip,) = find_slips(data, BASE).slips
    assert (slip.name, slip.column, slip.said, slip.fits) == ("unit", "stress", said, "MPa")


def test_specimens_out_of_whose_reach_some_poses_lie_are_not_exchanged(tmp_path):
    """A few samples of each run are predicted, here none that only the long one reaches."""
    make_set(tmp_path, "base_torque", [], seed=1, runs=2, repeats=1)
    true = load_measurements(tmp_path)
    (finger,) = true.specimens.values()
    short = replace(finger, name="short", values={**finger.values, "length": 0.08})
    runs = []
    for run, specimen, size in zip(
        true.runs, (finger.name, "short"), (1.0, 8.0 / 9.0), strict=True
    ):
        seen = np.where(np.arange(run.samples) % (run.samples // PREDICTED_SAMPLES), 1.0, 0.9)
        place = {key: size * seen * run.columns[key] for key in TIP_POSE[:3]}
        runs.append(replace(run, specimen=specimen, columns={**run.columns, **place}))
    data = replace(true, runs=tuple(runs), specimens={**true.specimens, "short": short})
    exchanged = [one for one in candidates(data) if one.column == f"{finger.name}, short"]
    assert np.isfinite(_predicted_error(exchanged[0].mended, BASE))
    with pytest.raises(ValueError, match="not farther from the base"):
        score(exchanged[0].mended, BASE)
    assert _scores(exchanged, BASE) == []


INTEGRALS = ("friction_integral", "injector_integral")
PULSE_SLIPS = {  # factors of columns whose numbers are of another unit, and the first such unit
    "duration": ({"duration": 1e3}, "ms"),
    "both": (dict.fromkeys(("duration", *INTEGRALS), 1e3), "ms"),
    "integrals": (dict.fromkeys(INTEGRALS, 1e3), "Pa*ms"),
    "pressures": (dict.fromkeys(("p_in", "p_out"), 0.145038), "psi"),
    "all pressures": (dict.fromkeys(("p_in", "p_out", *INTEGRALS), 0.01), "bar"),
    "mass": ({"mass": 1e-3}, "g"),
}


@pytest.fixture(scope="module")
def pulses(tmp_path_factory):
    """A set of pulses whose units agree."""
    folder = tmp_path_factory.mktemp("pulses")
    make_set(folder, "valve_pulse", [("injector_flow", {})], seed=3, ratio=5.0)
    return load_measurements(folder)


def test_pulses_in_their_units_have_no_slip(pulses):
    assert find_all_slips(pulses, BASE, effect_classes()).slips == ()


@pytest.mark.parametrize(("factors", "fits"), PULSE_SLIPS.values(), ids=PULSE_SLIPS)
def test_units_of_pulses_that_contradict_each_other_are_a_slip(pulses, factors, fits, tmp_path):
    """The calibration takes up the factor, so no error of the model shows it."""
    said = pulses
    for column, factor in factors.items():
        said = scaled(said, column, factor)
    write_files(set_files(said, tmp_path / "said"))
    checked = find_all_slips(load_measurements(tmp_path / "said"), BASE, effect_classes())
    (slip,) = checked.slips
    assert (slip.name, slip.column) == ("unit", ", ".join(factors))
    assert slip.fits.split(", ")[0] == fits
    found = diagnose(said, BASE).diagnosis
    assert "contradict each other" in verdict_sentence(found) and found.instead == ()
    again = mended(tmp_path / "said", checked.slips)
    for run, expected in zip(again.runs, pulses.runs, strict=True):
        for column in factors:
            assert run.columns[column] == pytest.approx(expected.columns[column], rel=1e-4)


@pytest.mark.parametrize(
    ("factor", "told"), [(0.224809, "lbf"), (0.157, "mmHg"), (0.382, ""), (5.06, "")]
)
def test_a_factor_is_a_slip_of_a_blocked_tip_only_where_it_is_that_of_the_unit(factor, told):
    """An actuator of another make differs by some factor, which lies near that of some units."""
    (blocked,) = (one for one in slips.base_cases("nothing") if one.experiment == "blocked_tip")
    clean = slips.made(blocked, 9600, slips.NOISE)
    data = stated_otherwise("tip_force", lambda force: factor * force, clean)
    slip = next(iter(find_slips(data, BASE).slips), None)
    assert (slip.fits if slip else "") == told
    if slip is None:
        assert not find_all_slips(data, BASE, effect_classes()).slips
        return
    said = comparison_text(compare(data, BASE), "base")
    exact = told == "lbf"
    assert slip.factor == pytest.approx(1.0 if exact else factor * 7.50062, rel=0.1)
    assert ("may fit" in said) == ("the data are still" in said) == (not exact)
