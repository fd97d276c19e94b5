"""Files of testing machines: displacement and force become stretch and nominal stress, and the set
is ready for a diagnosis, though nobody states the modulus.
"""

import numpy as np
import pytest

from model_lab.cli.main import main
from model_lab.importing.importing import make_set, propose
from model_lab.importing.told import asked
from model_lab.measurements.load import load_measurements
from softhand_common.documents.yaml_document import DocumentError

GAUGE, AREA, MODULUS = 50.0, 30.0, 80e3  # [mm], [mm^2], [Pa]
SIZES = {"stretch": f"elongation({{}},{GAUGE:g}mm)", "stress": "per_area({},10mm x 3mm)"}


def pull():
    """(time [s], displacement [mm], force [N]) of a neo-Hookean strip, stretched to 3 and back."""
    time = np.arange(0.0, 40.2, 0.2)
    stretch = 1.0 + 2.0 * (1.0 - np.abs(time - 20.0) / 20.0)
    return time, GAUGE * (stretch - 1.0), MODULUS * (stretch - stretch**-2) * AREA * 1e-6


def written(path, header, columns, sign=",", decimal=".", quote=""):
    rows = [
        sign.join(f"{quote}{value:.6f}{quote}" for value in row)
        for row in zip(*columns, strict=True)
    ]
    text = "\n".join(rows)
    if decimal == ",":
        text = text.replace(".", ",")
    path.write_text(header + "\n" + text + "\n", encoding="utf-8")
    return path


def bluehill(folder):
    time, moved, force = pull()
    columns = time, moved, 1e-3 * force
    header = "Time,Displacement,Force\n(s),(mm),(kN)"
    return written(folder / "pull_1.csv", header, columns, quote='"'), "Displacement", "Force"


def zwick(folder):
    header = "Prüfzeit;Standardweg;Standardkraft\ns;mm;N"
    path = written(folder / "zug_1.csv", header, pull(), ";", ",")
    return path, "Standardweg", "Standardkraft"


def shimadzu(folder):
    time, moved, force = pull()
    header = "Time,Force,Stroke\nsec,N,mm"
    return written(folder / "pull_1.csv", header, (time, force, moved)), "Stroke", "Force"


def without_time(folder):
    columns = pull()[1:]
    header = "Extension (mm)\tLoad (N)"
    return written(folder / "pull_1.txt", header, columns, "\t"), "Extension", "Load"


MACHINES = [bluehill, zwick, shimadzu, without_time]


@pytest.mark.parametrize("machine", MACHINES)
def test_a_file_of_a_testing_machine_says_what_to_add_and_makes_a_set_with_it(tmp_path, machine):
    path, moved, force = machine(tmp_path)
    proposal = propose([path])
    assert proposal.experiment == "uniaxial"
    assert f"stretch=elongation({moved},LENGTH)" in proposal.unsure["the stretch"]
    assert f"stress=per_area({force},AREA)" in proposal.unsure["the stress"]
    maps = [
        f"--map={name}={call.format(of)}"
        for (name, call), of in zip(SIZES.items(), (moved, force), strict=True)
    ]
    assert main(["import", str(path), "-o", str(tmp_path / "set"), *maps, "--yes"]) == 0
    data = load_measurements(tmp_path / "set")
    (run,) = data.runs
    stretch = 1.0 + pull()[1] / GAUGE
    np.testing.assert_allclose(run.columns["stretch"], stretch, atol=1e-6)
    np.testing.assert_allclose(
        run.columns["stress"], MODULUS * (stretch - stretch**-2), rtol=1e-4, atol=50.0
    )
    assert data.free_modulus
    assert data.specimens["strip"].values["shear_modulus"] == pytest.approx(MODULUS, rel=0.01)


def test_a_machine_that_computed_strain_and_stress_is_taken_by_these(tmp_path):
    time, moved, force = pull()
    columns = time, moved, force, 100.0 * moved / GAUGE, force / AREA
    header = "Time (s),Extension (mm),Load (N),Tensile strain (%),Tensile stress (MPa)"
    proposal = propose([written(tmp_path / "pull.csv", header, columns)])
    assert proposal.experiment == "uniaxial"
    assert not proposal.unsure


TRUE = "Time (s);True Strain;True Stress (MPa)"


@pytest.mark.parametrize("nominal", [True, False])
def test_true_stresses_and_strains_give_the_nominal_ones(tmp_path, nominal):
    """Nominal ones are taken where a file has both."""
    time, moved, force = pull()
    stretch, stress = 1.0 + moved / GAUGE, force / AREA
    columns = [time, np.log(stretch), stress * stretch]
    header = TRUE
    if nominal:
        header += ";Engineering Strain;Engineering Stress (MPa)"
        columns += [stretch - 1.0, stress]
    found = make_set(propose([written(tmp_path / "pull.csv", header, columns, ";")]))
    (run,) = found.runs
    np.testing.assert_allclose(run.columns["stretch"], stretch, atol=1e-5)
    np.testing.assert_allclose(run.columns["stress"], stress, atol=1e-5)
    assert any("True Stress" in one for one in found.remarks) is not nominal


def test_columns_that_were_left_empty_are_left_out(tmp_path):
    """Beside them a line above the header has as many words as the rows have numbers."""
    time, moved, force = pull()
    rows = zip(time, np.log1p(moved / GAUGE), force, strict=True)
    header = f"Material;Mold Star;;;\n{TRUE};Engineering Strain;Engineering Stress (MPa)\n"
    path = tmp_path / "pull.csv"
    path.write_text(header + "\n".join(f"{t:.2f};{e:.6f};{s:.6f};;" for t, e, s in rows))
    (source,) = propose([path]).sources
    assert [one.column for one in source.meanings] == ["Time", "True Strain", "True Stress"]


def test_a_column_without_numbers_means_nothing(tmp_path):
    time, moved, force = pull()
    rows = zip(time, force, moved, strict=True)
    path = tmp_path / "pull.csv"
    header = "Time (sec), Load (N), Stress (KPa), Strain (mm), Position (mm)\n"
    path.write_text(header + "\n".join(f"{t:.2f}, {f:.4f}, N/A, , {x:.4f}" for t, f, x in rows))
    asked_for = propose([path], maps={"stretch": ("elongation(Position,50mm)", "")}).unsure
    assert "per_area(Load,AREA)" in asked_for["the stress"]


def test_strips_that_are_named_have_a_modulus_each(tmp_path):
    time, moved, force = pull()
    header = "Time (s),Strain,Stress (MPa)"
    files = [
        written(tmp_path / f"{name}.csv", header, (time, moved / GAUGE, factor * force / AREA))
        for name, factor in {"soft": 0.2, "stiff": 1.0}.items()
    ]
    found = make_set(propose(files), specimens={"soft.csv": "soft", "stiff.csv": "stiff"})
    moduli = {name: one["shear_modulus"] for name, one in found.document["specimens"].items()}
    assert moduli == {"soft": pytest.approx(16e3, rel=0.01), "stiff": pytest.approx(80e3, rel=0.01)}
    assert {one["batch"] for one in found.document["specimens"].values()} == {"soft", "stiff"}
    assert found.document["calibration"] == {"modulus": "free"}


def test_a_copy_of_noisy_readings_is_no_repeat(tmp_path):
    time, moved, force = pull()
    noise = 0.01 * np.random.default_rng(0).standard_normal(len(time))
    header = "Time (s),Strain,Stress (MPa)"
    of = {"pull_1": noise, "pull_2": noise, "pull_3": noise[::-1]}
    files = [
        written(tmp_path / f"{name}.csv", header, (time, moved / GAUGE, force / AREA + added))
        for name, added in of.items()
    ]
    found = make_set(propose(files))
    assert [run.name for run in found.runs] == ["pull_1", "pull_3"]
    assert "pull_2 holds the same numbers as pull_1 and is left out" in found.remarks


def test_a_true_stress_needs_the_strain_in_its_file(tmp_path):
    time, moved, force = pull()
    header = TRUE.split(";")
    files = [
        written(tmp_path / "pull_strain.csv", f"{header[0]},{header[1]}", (time, moved / GAUGE)),
        written(tmp_path / "pull_stress.csv", f"{header[0]},{header[2]}", (time, force / AREA)),
    ]
    with pytest.raises(DocumentError, match="True Stress: expected a stretch or strain"):
        make_set(propose(files))


def test_a_finger_beside_its_pressure_is_not_taken_for_a_strip(tmp_path):
    time, moved, force = pull()
    header = "time (s),pressure (kPa),position (mm),force (N)"
    path = written(tmp_path / "finger.csv", header, (time, force, moved, force))
    assert propose([path]).experiment == "blocked_tip"


def test_the_user_is_asked_for_length_and_cross_section(tmp_path):
    path, _, force = bluehill(tmp_path)
    answers = {"between the clamps": "50mm", "cross-section": "30mm2"}

    def ask(question):
        return next(answer for word, answer in answers.items() if word in question)

    maps = asked(propose([path]), {}, ask)
    assert not propose([path], maps=maps).unsure
    assert maps["stress"] == (f"per_area({force},30mm2)", "")


@pytest.mark.parametrize(
    ("call", "told"),
    [
        ("per_area(Force)", "cross-section, as in per_area(Force,30mm2)"),
        ("per_area(Force,50mm)", "cross-section, as in per_area(Force,30mm2)"),
        ("per_area(Force,0mm2)", "cross-section, as in per_area(Force,30mm2)"),
    ],
)
def test_a_wrong_size_is_refused_with_an_example(tmp_path, call, told):
    path, *_ = bluehill(tmp_path)
    with pytest.raises(DocumentError, match="--map stress=per_area") as refused:
        propose([path], maps={"stress": (call, "")})
    assert told in str(refused.value)


def test_a_force_without_a_unit_asks_for_one(tmp_path):
    path = written(tmp_path / "pull.csv", "Time,Displacement,Force", pull())
    with pytest.raises(DocumentError, match="unit of Force"):
        propose([path], maps={"stress": ("per_area(Force,30mm2)", "")})
    maps = {
        "stress": ("per_area(Force,30mm2)", "N"),
        "stretch": ("elongation(Displacement,5cm)", "mm"),
    }
    assert not propose([path], maps=maps).unsure


@pytest.mark.parametrize(("name", "new"), [("DS10_specimen", True), ("pull", False)])
def test_files_that_number_their_specimens_are_of_new_ones(tmp_path, name, new):
    time, moved, force = pull()
    header = "Time (s),stretch,stress (kPa)"
    columns = time, 1.0 + moved / GAUGE, 1e3 * force / AREA
    paths = [written(tmp_path / f"{name}_{n}.csv", header, columns) for n in (1, 2)]
    found = make_set(propose(paths))
    assert [run.get("virgin", False) for run in found.document["runs"].values()] == [new, new]
    assert any("each a new specimen" in remark for remark in found.remarks) == new
