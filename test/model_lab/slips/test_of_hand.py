"""Slips of a hand: each is told, its mend gives the set back, and none is told of a sound set."""

from dataclasses import replace

import numpy as np
import pytest
import yaml
from tracked_body import in_other_frame

from model_lab.bench.layouts import hand_pose_set
from model_lab.bench.synthesize import synthesize
from model_lab.diagnosis.diagnose import diagnose
from model_lab.measurements.hands import MARKER_AXES
from model_lab.measurements.load import load_measurements
from model_lab.measurements.save import write_set
from model_lab.report.sentences import verdict_sentence
from model_lab.slips.find import find_slips
from softhand_model.effects import effect_classes
from softhand_model.model_file import load_model

HAND = hand_pose_set()


@pytest.fixture(scope="module")
def sound(coarse_hands):
    return synthesize("hand_pose", 3, False, noise=0.003).data


def changed(data, change):
    """The set with the columns of each run as `change` gives them."""
    runs = [replace(run, columns={**run.columns, **change(run.columns)}) for run in data.runs]
    return replace(data, runs=tuple(runs))


def swapped(*pairs):
    sources = {a: b for one, other in pairs for a, b in ((one, other), (other, one))}
    return lambda columns: {name: columns[source] for name, source in sources.items()}


def scaled(factors):
    return lambda columns: {name: f * columns[name] for name, f in factors.items()}


def of_markers(axis, factor):
    return {f"{marker}.{axis}": factor for marker in HAND.markers}


SLIPS = {
    "channels": (swapped(("pressure.a", "pressure.c")), "exchanged", "a, pressure.c"),
    "markers": (
        swapped(*((f"ring_tip.{axis}", f"middle_tip.{axis}") for axis in MARKER_AXES)),
        "exchanged",
        "middle_tip, ring_tip",
    ),
    "mirrored": (scaled(of_markers("y", -1.0)), "mirrored", "all markers"),
    "left_handed": (
        swapped(*((f"{marker}.x", f"{marker}.y") for marker in HAND.markers)),
        "mirrored",
        "all markers",
    ),
    "m_for_mm": (
        scaled({k: v for axis in MARKER_AXES for k, v in of_markers(axis, 1e-3).items()}),
        "unit",
        "all markers",
    ),
    "mm_for_m": (
        scaled({k: v for axis in MARKER_AXES for k, v in of_markers(axis, 1e3).items()}),
        "unit",
        "all markers",
    ),
    "psi_for_kPa": (scaled(dict.fromkeys(HAND.inputs, 1.0 / 6.894757)), "unit", "all pressures"),
}


@pytest.mark.parametrize(("change", "name", "column"), SLIPS.values(), ids=SLIPS)
def test_a_slip_is_told_and_its_mend_gives_the_set_back(sound, tmp_path, change, name, column):
    write_set(changed(sound, change), tmp_path / "set")
    read = load_measurements(tmp_path / "set")
    (slip,) = find_slips(read, load_model()).slips
    assert slip.name == name and column in slip.column
    path = tmp_path / "set" / "experiment.yaml"
    stated = yaml.safe_load(path.read_text())
    stated["columns"] |= yaml.safe_load(slip.mend)["columns"]
    path.write_text(yaml.safe_dump(stated, sort_keys=False))
    mended = load_measurements(tmp_path / "set")
    assert mended.table.value == pytest.approx(sound.table.value, rel=1e-4, abs=1e-6)
    for run, before in zip(mended.runs, sound.runs, strict=True):
        for channel in sound.inputs:
            assert run.columns[channel] == pytest.approx(before.columns[channel], rel=1e-4, abs=1.0)


def test_places_of_a_body_that_nobody_aligned_are_told_and_their_frame_is_freed(sound, tmp_path):
    moved = in_other_frame(sound, (0.1, -0.2, 1.5), (0.03, 0.01, -0.02))
    write_set(moved, tmp_path / "set")
    read = load_measurements(tmp_path / "set")
    (slip,) = find_slips(read, load_model()).slips
    assert slip.name == "turned" and "turned by 8" in slip.fits
    path = tmp_path / "set" / "experiment.yaml"
    stated = yaml.safe_load(path.read_text()) | yaml.safe_load(slip.mend)
    path.write_text(yaml.safe_dump(stated, sort_keys=False))
    assert find_slips(load_measurements(tmp_path / "set"), load_model()).slips == ()


def test_no_slip_is_told_of_a_sound_set(sound):
    assert find_slips(sound, load_model()).slips == ()


def test_a_slip_and_an_effect_are_both_told(coarse_hands):
    scatter = {"actuator_scatter": effect_classes()["actuator_scatter"]}
    made = synthesize("hand_pose", 4, True, scatter, noise=0.003)
    (hidden,) = made.truth["effects"]
    exchanged = changed(made.data, swapped(("pressure.a", "pressure.b")))
    found = diagnose(exchanged, load_model(), scatter).diagnosis
    (slip,) = found.slips
    assert (found.verdict, slip.name) == ("slip", "exchanged")
    assert [(one.kind, one.where) for one in found.effects] == [
        ("actuator_scatter", hidden["where"])
    ]


def test_markers_that_are_shuffled_from_sample_to_sample_are_not_named_for_sure(sound):
    random = np.random.default_rng(5)
    runs = []
    for run in sound.runs:
        columns = dict(run.columns)
        for sample in range(run.samples):
            order = random.permutation(list(sound.markers))
            for marker, source in zip(sound.markers, order, strict=True):
                for axis in MARKER_AXES:
                    column = columns[f"{marker}.{axis}"] = columns[f"{marker}.{axis}"].copy()
                    column[sample] = run.columns[f"{source}.{axis}"][sample]
        runs.append(replace(run, columns=columns))
    shuffled = replace(sound, runs=tuple(runs))
    found = diagnose(shuffled, load_model(), {}).diagnosis
    assert found.effects == ()


def test_a_run_with_the_orientation_of_another_is_told_with_its_mend(coarse_hands):
    quiet = synthesize("hand_pose", 3, False, noise=5e-4).data
    runs, fourth = list(quiet.runs), quiet.runs[3]
    assert runs[0].wrist_rpy != fourth.wrist_rpy
    runs[3] = replace(fourth, wrist_rpy=runs[0].wrist_rpy, protocol="alone")
    (slip,) = find_slips(replace(quiet, runs=tuple(runs)), load_model()).slips
    assert (slip.name, slip.column) == ("odd_run", f"the orientation of the wrist of {fourth.name}")
    stated = yaml.safe_load(slip.mend)["runs"][fourth.name]["wrist_rpy"]
    assert stated == pytest.approx(fourth.wrist_rpy)


@pytest.mark.parametrize("beside", [False, True], ids=["alone", "beside an effect"])
def test_a_run_that_is_another_pose_is_left_out_by_its_name(coarse_hands, beside):
    only = {"actuator_scatter": effect_classes()["actuator_scatter"]}
    made = synthesize("hand_pose", 4, beside, only, noise=0.003)
    first, *others, last = made.data.runs
    count = min(first.samples, last.samples)
    columns = {name: column[:count] for name, column in last.columns.items()}
    columns |= {name: first.columns[name][:count] for name in made.data.outputs}
    odd = replace(last, columns=columns, protocol="alone")
    found = diagnose(replace(made.data, runs=(first, *others, odd)), load_model(), only).diagnosis
    (slip,) = found.slips
    assert (found.verdict, slip.name, slip.column) == ("slip", "odd_run", last.name)
    hidden = [(effect["name"], effect["where"]) for effect in made.truth["effects"]]
    assert [(effect.kind, effect.where) for effect in found.effects] == hidden
    assert f"Run {last.name} does not fit with the others" in verdict_sentence(found)
