"""What a model asks of specimens and runs, and how it is told that it is missing."""

import numpy as np
import pytest
from measurement_folder import document, write_set

from model_lab.measurements.load import load_measurements
from model_lab.measurements.specimens import require_columns, require_keys
from softhand_common.documents.yaml_document import DocumentError
from softhand_design.hand_file import actuator_entry
from softhand_design.requirements import of_numbers
from softhand_design.sizing import design_actuator
from softhand_model.hand.rubber import Rubber


def test_a_key_that_the_model_needs_is_named_with_unit_and_example(tmp_path):
    data = load_measurements(write_set(tmp_path, document(specimens={"f": {"length": 0.09}})))
    with pytest.raises(DocumentError) as caught:
        require_keys(data, data.specimens["f"], ("length", "wall"), "base pneuflex")
    message = str(caught.value)
    assert str(tmp_path / "experiment.yaml") in message
    assert "specimens.f: expected the key wall [m], which base pneuflex needs" in message
    assert "such as wall: 0.0025" in message


def test_a_column_that_an_effect_needs_is_named_with_the_run(tmp_path):
    data = load_measurements(write_set(tmp_path))
    with pytest.raises(DocumentError, match=r"runs\.r1: expected the column humidity, which it"):
        require_columns(data, ("time", "humidity"), "it")


def test_what_is_there_is_not_refused(tmp_path):
    data = load_measurements(write_set(tmp_path))
    require_keys(data, data.specimens["f"], ("length", "wall"), "base pneuflex")
    require_columns(data, ("time", "pressure"), "it")


def test_a_designed_actuator_is_a_specimen_as_it_stands(tmp_path):
    rubber = Rubber("Dragon Skin 10", "", "", 11.0, 67e3, 1070.0)
    finger = design_actuator(of_numbers(0.9e-3, 4e-3, 0.09, rubber)).actuator
    content = document(specimens={"f": actuator_entry(finger)})
    specimen = load_measurements(write_set(tmp_path, content)).specimens["f"]
    x = np.linspace(0.0, 0.09, 50)
    for key in ("height", "width"):
        read = np.interp(x, *specimen.values[key].T)
        np.testing.assert_allclose(read, getattr(finger, key)(x), rtol=1e-3)
    assert specimen.values["wall"] == finger.wall(0.0)


def test_a_wall_may_vary_along_a_specimen(tmp_path):
    walls = {"wall": [[0.0, 0.003], [0.09, 0.002]], "side_wall": [[0.0, 0.003], [0.09, 0.0]]}
    content = document(specimens={"f": {"length": 0.09, **walls}})
    specimen = load_measurements(write_set(tmp_path, content)).specimens["f"]
    assert specimen.values["wall"].tolist() == walls["wall"]
    assert specimen.values["side_wall"].tolist() == walls["side_wall"]
    assert specimen.mean_wall == pytest.approx(0.0025)


def test_sizes_in_millimetres_are_refused(tmp_path):
    content = document(specimens={"f": {"length": 100.0, "wall": 2.5}})
    with pytest.raises(DocumentError, match=r"specimens.f.length: .* in m.* 0.1"):
        load_measurements(write_set(tmp_path, content))


def test_a_wall_of_nothing_is_refused(tmp_path):
    content = document(specimens={"f": {"length": 0.09, "wall": [[0.0, 0.003], [0.09, 0.0]]}})
    with pytest.raises(DocumentError, match="wall: expected a list of .* with values above 0"):
        load_measurements(write_set(tmp_path, content))


def test_a_broken_taper_is_named(tmp_path):
    sizes = {"length": 0.09, "height": {"maximum": 0.02, "taper": 2.0, "root": 3}}
    with pytest.raises(DocumentError, match=r"specimens\.f\.height\.taper: expected a number"):
        load_measurements(write_set(tmp_path, document(specimens={"f": sizes})))
