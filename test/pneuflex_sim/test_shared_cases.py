"""Hands and objects as others have them: taken, or refused with what is expected."""

import re
import warnings
from pathlib import Path

import numpy as np
import pytest
import trimesh

from pneuflex_sim.scene.objects import load_object
from pneuflex_sim.simulation.config import SimulationConfig
from pneuflex_sim.simulation.simulation import Simulation
from softhand_common.documents.yaml_document import DocumentError
from softhand_design.commands.hand import main

CASES = Path(__file__).parents[3] / "shared" / "cases"
HANDS, OBJECTS = CASES / "hands", CASES / "objects"
pytestmark = pytest.mark.skipif(not CASES.is_dir(), reason="needs ../shared/cases")


def masses(simulation, pressure):
    """Air [kg] above that at rest, as long as the volumes are those of rest."""
    return simulation.air.rest_volumes * pressure / (287.0 * 293.15)


def simulated(name, pressure):
    """A hand in the simulation after ten steps, with all its channels at about a pressure [Pa]."""
    simulation = Simulation(SimulationConfig(hand=str(HANDS / f"{name}.yaml")))
    simulation.set_air_masses(masses(simulation, pressure))
    for _ in range(10):
        simulation.step()
    return simulation


def test_a_hand_of_twelve_channels_is_simulated():
    simulation = simulated("twelve", 2e4)
    try:
        angles = np.array(list(simulation.tip_angles().values()))
        assert angles.shape == (12,)
        assert np.ptp(angles) < 0.05 * np.abs(angles).max()  # of twelve fingers that are alike
    finally:
        simulation.close()


def test_a_finger_that_would_curl_through_itself_is_told_not_to_be_believed():
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        simulated("long900", 4e4).close()
    said = [str(one.message) for one in caught if one.category is RuntimeWarning]
    assert any("kPa" in text and "believe" in text for text in said), said


REFUSED = {
    "vacuum": "types.t.max_pressure: expected a number from 1000 to 1e.07 Pa, got -60000.0",
    "fibre_angle": "types.t: expected only the keys .*, got fibre_angle",
    "stiff_layer": "types.t: expected only the keys .*, got layer_thickness",
    "multi_material": r"types.t.shear_modulus: expected a number .*, got \[\[0.0",
}


@pytest.mark.parametrize("name", REFUSED)
def test_other_hands_are_refused_with_what_is_expected(name, capsys):
    assert main(["show", str(HANDS / f"{name}.yaml")]) == 2
    (line,) = [text for text in capsys.readouterr().err.splitlines() if "expected" in text]
    assert f"{name}.yaml:6: " in line
    assert re.search(REFUSED[name], line), line


def test_a_urdf_is_told_what_a_hand_is(capsys):
    assert main(["show", str(HANDS / "theirs.urdf")]) == 2
    line = capsys.readouterr().err.splitlines()[-1]
    assert "theirs.urdf" in line and "YAML" in line


def test_a_mesh_without_thickness_is_refused_in_a_line():
    with pytest.raises(DocumentError, match="flat.stl: surface: expected one that encloses"):
        load_object(OBJECTS / "flat.yaml")


def test_bodies_that_overlap_count_once():
    cup = load_object(OBJECTS / "mug_two_bodies.yaml")
    pieces = cup.geometry.pieces
    assert len(pieces) > 1
    bodies = trimesh.load_mesh(OBJECTS / "mug_two_bodies.stl").split()
    assert len(bodies) == 2
    both = sum(body.volume for body in bodies)
    assert 0.5 * both < cup.geometry.solid.volume < 0.999 * both
