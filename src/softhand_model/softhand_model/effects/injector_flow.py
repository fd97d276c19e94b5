"""Flow through the choke as the injector term of the thesis has it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from softhand_model.effects.effect import Parameter
from softhand_model.effects.stages import Array, FlowEffect, Pulse


class InjectorFlow(FlowEffect):
    """Choked and unchoked flow through a small orifice: c2*int(p_in*Psi(p_out/p_in)) dt (eq. 4.1).

    It takes the place of the naive term c*p_in*duration, of which it is the refinement: while the
    flow is choked Psi is constant, and the two are collinear. c2 [kg/(s Pa)] is the conductance of
    choke and valve in series (`gas.orifice_conductance`), a value a direction.
    """

    name = "injector_flow"
    experiments = frozenset({"valve_pulse"})
    parameters = (
        Parameter(
            "c2_inflate",
            "kg/(s Pa)",
            1e-12,
            1e-7,
            "conductance of the inlet's choke",
            typical=(8e-11, 2.5e-10),
            logarithmic=True,
        ),
        Parameter(
            "c2_deflate",
            "kg/(s Pa)",
            1e-12,
            1e-7,
            "conductance of the outlet's choke",
            typical=(5e-10, 2e-9),
            logarithmic=True,
        ),
    )
    confounded_with: ClassVar[Mapping[str, str]] = {
        "calibration": "collinear with the naive term, which it replaces, while the flow is choked",
        "line_friction": "both grow as the channel nears p_in; varied supply tells them apart",
    }
    replaces_naive = True

    def act_on_mass(self, mass: Array, pulse: Pulse) -> Array:
        """Mass [kg] with the injector term in place of the naive one."""
        term = self.by_direction("c2", pulse) * pulse.injector_integral
        return mass - pulse.naive + term
