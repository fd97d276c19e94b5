"""Logs of a rig that writes all that it has: several sensors, set-points, valves, a camera that
follows tags and writes 0 while it sees none, absolute pressures, numbers of channels in brackets.
"""

import numpy as np
import pytest

from model_lab.importing.importing import make_set, propose
from softhand_common.documents.yaml_document import DocumentError

HEADER = (
    "Timestamp (millisec since midnight today),Test time,u_t(0),u_t(1),MPRpressure_0,MPRpressure_1,"
    "ForcePlate_0,ForcePlate_1,tagid_x_104,tagid_y_104,tagid_rotation104"
)
ROWS, UNSEEN = 40, 5  # the camera begins late
PRESSURE = np.linspace(0.0, 400.0, ROWS)  # [mbar]
ANGLE = 0.2 * PRESSURE  # [deg]
MAPS = {
    "time": ("Test time", ""),
    "pressure": ("MPRpressure_0", "mbar"),
    "tip_angle": ("tagid_rotation104", "deg"),
}


@pytest.fixture
def log(tmp_path):
    lines = ["logger started on:,2026-3-25_104015", "ctrl_params:,{'n': 2, 'sep': ','}", HEADER]
    for row, (pressure, angle) in enumerate(zip(PRESSURE, ANGLE, strict=True)):
        seen = (0.0, 0.0, 0.0) if row < UNSEEN else (318.0 + 0.1 * row, 28.0 - 0.1 * row, angle)
        numbers = (
            38419019 + 100 * row,
            0.1 * row,
            pressure,
            0.0,
            1013.2 + pressure,
            1013.4,
            0.0,
            0.0,
        )
        lines.append(",".join(f"{value:.10g}" for value in (*numbers, *seen)))
    path = tmp_path / "log.csv"
    path.write_text("\n".join(lines) + "\n")
    return path


def test_rows_in_which_a_camera_saw_nothing_have_no_angle(log):
    found = make_set(propose([log], maps=MAPS))
    run = found.runs[0]
    np.testing.assert_allclose(run.columns["tip_angle"], ANGLE[UNSEEN:])
    np.testing.assert_allclose(run.columns["pressure"], 1013.2 + PRESSURE[UNSEEN:])
    np.testing.assert_allclose(run.lead["pressure"], 1013.2 + PRESSURE[:UNSEEN])
    assert any("nothing was tracked" in remark for remark in found.remarks)


def test_zeros_at_rest_are_kept(tmp_path):
    """A set-point, a valve and an angle that are 0 together until the first command."""
    command = np.where(np.arange(ROWS) < UNSEEN, 0.0, 40.0)
    angle = np.maximum(np.arange(ROWS) - UNSEEN + 1, 0) * 1.0
    rows = zip(command, command / 40.0, command, angle, strict=True)
    lines = [",".join(map(str, row)) for row in rows]
    path = tmp_path / "steps.csv"
    path.write_text("\n".join(["target kPa,valve,pressure (kPa),angle (deg)", *lines]))
    assert len(make_set(propose([path])).runs[0].columns["tip_angle"]) == ROWS


def test_columns_that_the_stated_output_does_not_need_are_not_asked_for(log):
    assert propose([log], maps=MAPS).experiment == "free_bending"
    without = {name: MAPS[name] for name in ("time", "pressure")}
    with pytest.raises(DocumentError, match="ForcePlate_0, ForcePlate_1.*--experiment free_bend"):
        propose([log], maps=without)
    with pytest.raises(DocumentError, match="u_t\\(0\\), u_t\\(1\\)"):
        propose([log])


def test_a_time_since_midnight_has_its_unit(log):
    run = make_set(propose([log], maps=MAPS | {"time": ("Timestamp", "")})).runs[0]
    np.testing.assert_allclose(np.diff(run.columns["time"]), 0.1)


def test_pressures_that_begin_at_that_of_the_air_are_remarked_on_unless_stated(log):
    (remark,) = (one for one in make_set(propose([log], maps=MAPS)).remarks if "air" in one)
    assert "1013.2 mbar" in remark and "mbar abs" in remark
    stated = MAPS | {"pressure": ("MPRpressure_0", "mbar abs")}
    found = make_set(propose([log], maps=stated))
    assert found.document["columns"]["pressure"]["is"] == "absolute"
    assert not any("about that of the air" in one for one in found.remarks)


def test_files_of_one_name_are_known_by_their_folders(tmp_path):
    paths = []
    for specimen, slope in (("thin", 2.0), ("thick", 1.5)):
        paths.append(tmp_path / specimen / "data.csv")
        paths[-1].parent.mkdir()
        rows = "\n".join(f"{p:g},{slope * p:g}" for p in PRESSURE)
        paths[-1].write_text(f"pressure (mbar),angle (deg)\n{rows}\n")
    found = make_set(propose(paths))
    assert [run.name for run in found.runs] == ["thin_data", "thick_data"]
    assert list(found.document["specimens"]) == ["thin", "thick"]
