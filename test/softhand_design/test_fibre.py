"""Fibres of hull and passive layer (Table 3.1, eq. 3.4)."""

import numpy as np
import pytest

from softhand_design.fibre import (
    griffith_stress,
    load_fibres,
    radial_modulus,
    radial_stretch,
    thinner,
)


@pytest.mark.parametrize(
    ("fibre", "radial", "stretch"),
    [("stiff silicone", 0.177e6, 2.695), ("PET", 50e6, 1.006), ("HD-PE", 2300e6, 1.000)],
)
def test_fibres_of_table_3_1(fibre, radial, stretch):
    fibres = load_fibres()
    modulus = radial_modulus(0.15e6, fibres.moduli[fibre], fibres.share)
    assert modulus == pytest.approx(radial, rel=5e-3)
    assert radial_stretch(3.0, 0.15e6, modulus) == pytest.approx(stretch, abs=5e-4)


def test_springs_side_by_side_share_the_load_as_the_mean_of_their_moduli():
    """A hull of rubber and fibre under the load that stretches rubber alone by a factor 3."""
    rubber, fibre, share = 0.15e6, 2.5e9, 0.02
    load = (3.0 - 1.0) * rubber
    strain = load / ((1 - share) * rubber + share * fibre)
    assert 1 + strain == pytest.approx(radial_stretch(3.0, rubber, radial_modulus(rubber, fibre)))


def test_griffith_stress_halves_for_a_fibre_four_times_as_wide():
    thin, thick = (griffith_stress(0.15e6, 10.0, width) for width in (70e-6, 280e-6))
    assert thin == pytest.approx(2 * thick)
    assert thin == pytest.approx(np.sqrt(4 * 0.15e6 * 10.0 / np.pi) / np.sqrt(70e-6))


def test_a_thinner_fibre_of_a_stiffer_material_carries_the_same_load_at_the_same_strain():
    diameter = thinner(115e9, 2.5e9)
    assert 115e9 * diameter**2 == pytest.approx(2.5e9)
    assert 1 / diameter**2 == pytest.approx(46.0)


def test_a_width_in_millimetres_is_refused_with_file_and_key(tmp_path):
    text = "format: softhand-fibres/1\nshare: 0.02\nfibres: {PET: {modulus: 2.5e+9}}\n"
    path = tmp_path / "fibres.yaml"
    path.write_text(text + "threads: {wide: {fibre: PET, width: 0.5}}\n")
    with pytest.raises(ValueError, match=r"fibres.yaml:4: threads.wide.width: expected .* m"):
        load_fibres(path)
