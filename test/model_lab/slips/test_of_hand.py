"""Slips of a hand: each is told, its mend gives the set back, and none is told of a sound set."""

from dataclasses import replace

import numpy as np
import pytest
import yaml

from model_lab.bench.synthesize import synthesize
from model_lab.diagnosis.diagnose import diagnose
from model_lab.measurements.hands import MARKER_AXES
from model_lab.measurements.load import load_measurements
from model_lab.measurements.save import write_set
from model_lab.slips.find import find_slips
from softhand_model.effects import effect_classes
from softhand_model.model_file import load_model

SOUND = synthesize("hand_pose", 3, False, noise=0.003).data


def changed(change):
    """The sound set with the columns of each run as `change` gives them."""
    runs = [replace(run, columns={**run.columns, **change(run.columns)}) for run in SOUND.runs]
    return replace(SOUND, runs=tuple(runs))


def swapped(*pairs):
    sources = {a: b for one, other in pairs for a, b in ((one, other), (other, one))}
    return changed(lambda columns: {name: columns[source] for name, source in sources.items()})


def scaled(factors):
    return changed(lambda columns: {name: f * columns[name] for name, f in factors.items()})


def of_markers(axis, factor):
    return {f"{marker}.{axis}": factor for marker in SOUND.markers}


SLIPS = {
    "channels": (swapped(("pressure.a", "pressure.c")), "exchanged", "a, pressure.c"),
    "markers": (
        swapped(*((f"ring_tip.{axis}", f"middle_tip.{axis}") for axis in MARKER_AXES)),
        "exchanged",
        "middle_tip, ring_tip",
    ),
    "mirrored": (scaled(of_markers("y", -1.0)), "mirrored", "all markers"),
    "left_handed": (
        swapped(*((f"{marker}.x", f"{marker}.y") for marker in SOUND.markers)),
        "mirrored",
        "all markers",
    ),
    "m_for_mm": (
        scaled({k: v for axis in MARKER_AXES for k, v in of_markers(axis, 1e-3).items()}),
        "unit",
        "all markers",
    ),
    "psi_for_kPa": (scaled(dict.fromkeys(SOUND.inputs, 1.0 / 6.894757)), "unit", "all pressures"),
}


@pytest.mark.parametrize(("data", "name", "column"), SLIPS.values(), ids=SLIPS)
def test_a_slip_is_told_and_its_mend_gives_the_set_back(tmp_path, data, name, column):
    write_set(data, tmp_path / "set")
    read = load_measurements(tmp_path / "set")
    (slip,) = find_slips(read, load_model()).slips
    assert slip.name == name and column in slip.column
    path = tmp_path / "set" / "experiment.yaml"
    stated = yaml.safe_load(path.read_text())
    stated["columns"] |= yaml.safe_load(slip.mend)["columns"]
    path.write_text(yaml.safe_dump(stated, sort_keys=False))
    mended = load_measurements(tmp_path / "set")
    assert mended.table.value == pytest.approx(SOUND.table.value, rel=1e-4, abs=1e-6)
    for run, sound in zip(mended.runs, SOUND.runs, strict=True):
        for channel in SOUND.inputs:
            assert run.columns[channel] == pytest.approx(sound.columns[channel], rel=1e-4, abs=1.0)


def test_no_slip_is_told_of_a_sound_set():
    assert find_slips(SOUND, load_model()).slips == ()


def test_a_slip_and_an_effect_are_both_told():
    scatter = {"actuator_scatter": effect_classes()["actuator_scatter"]}
    made = synthesize("hand_pose", 4, True, scatter, noise=0.003)
    (hidden,) = made.truth["effects"]
    runs = []
    for run in made.data.runs:
        a, b = (run.columns[name] for name in ("pressure.a", "pressure.b"))
        runs.append(replace(run, columns={**run.columns, "pressure.a": b, "pressure.b": a}))
    found = diagnose(replace(made.data, runs=tuple(runs)), load_model(), scatter).diagnosis
    (slip,) = found.slips
    assert (found.verdict, slip.name) == ("slip", "exchanged")
    assert [(one.kind, one.where) for one in found.effects] == [
        ("actuator_scatter", hidden["where"])
    ]


def test_markers_that_are_shuffled_from_sample_to_sample_are_not_named_for_sure():
    random = np.random.default_rng(5)
    runs = []
    for run in SOUND.runs:
        columns = dict(run.columns)
        for sample in range(run.samples):
            order = random.permutation(list(SOUND.markers))
            for marker, source in zip(SOUND.markers, order, strict=True):
                for axis in MARKER_AXES:
                    column = columns[f"{marker}.{axis}"] = columns[f"{marker}.{axis}"].copy()
                    column[sample] = run.columns[f"{source}.{axis}"][sample]
        runs.append(replace(run, columns=columns))
    shuffled = replace(SOUND, runs=tuple(runs))
    found = diagnose(shuffled, load_model(), {}).diagnosis
    assert found.effects == ()
