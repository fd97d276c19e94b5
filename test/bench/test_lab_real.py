"""Parts of measurements that stand for sets nobody has seen, and what counts as explained."""

import numpy as np
from lab_sets import bending
from rubber_set import rubber_set

from bench.lab.real import fall_of, pieces, summary


def test_a_test_of_rubber_in_three_modes_is_cut_into_modes_and_runs():
    parts = dict(pieces(rubber_set(samples=20)))
    assert set(parts) == {
        *("uniaxial", "pure_shear", "equibiaxial"),
        *("odd runs", "even runs", "last run"),
    }
    assert {run.mode for run in parts["pure_shear"].runs} == {"pure_shear"}
    assert len(parts["odd runs"].runs) == 3 and len(parts["last run"].runs) == 1


def test_a_single_long_run_is_cut_into_few_samples_and_small_inputs():
    parts = dict(pieces(bending(np.linspace(0.0, 100e3, 101))))
    assert set(parts) == {"few samples", "small inputs"}
    assert parts["few samples"].runs[0].samples == 26
    assert max(parts["small inputs"].runs[0].columns["pressure"]) == 70e3


def test_the_larger_fall_of_names_and_curves_counts():
    one = {"fall_named": 1.0, "fall_learned": 4.0, "seconds": 2.0}
    other = {"fall_named": 2.5, "fall_learned": 1.0, "seconds": 9.0}
    assert fall_of(one) == 4.0
    assert "1 of 2 (target 5 of 6: NO); longest learn 9 s" in summary([one, other])[0]
    assert "no measurements" in summary([])[0]
