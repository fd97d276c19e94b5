"""A second relaxation time of rubber that relaxes already."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from softhand_model.effects.elastic_memory import Viscoelasticity
from softhand_model.effects.lags import lags_kernel


class SecondRelaxation(Viscoelasticity):
    """A second relaxation time: `viscoelasticity` again, of the stress that this or `creep` already
    relaxes. Two of them are a generalized Maxwell solid with two branches, whose shares are
    g1*(1 + g2*tau2/(tau2 - tau1)) and g2*(1 + g1*tau1/(tau1 - tau2)).

    The lab searches it only where the model has one of these two: after `add`.
    """

    name = "second_relaxation"
    cause, member = "", ""
    beside: ClassVar[tuple[str, ...]] = ("viscoelasticity", "creep")
    rank = 2
    confounded_with: ClassVar[Mapping[str, str]] = {
        "tube_lag": "alike on triangles of one rate",
        "hysteresis": "alike on triangles of one rate; steps and rates tell them apart",
    }
    kernel = lags_kernel(1)
