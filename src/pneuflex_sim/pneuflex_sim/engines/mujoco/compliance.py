"""Contacts of a stated stiffness.

MuJoCo scales a contact's spring by the inverse masses 1/m of its two bodies (`body_invweight0`), so
that light things, such as the links of a finger, sink deepest: by 4 to 7 mm in a held grasp with
its defaults. At a constant impedance d the normal force is depth*k/((1 - d)*(1/m1 + 1/m2)) with the
k of `solref`, and the damper likewise ("Solver parameters" in MuJoCo's documentation). With a
compliance [m/N] times a factor S for each 1/m and k = S*(1 - d), the force is
depth/(compliance_1 + compliance_2): two springs in series. Integrator `discrete` evaluates them at
the end of a step, stable at any step. It also counts joint springs and dampers as masses there, so
that the skin of a link is 1.1 to 6 times as stiff at 2 ms, and right as the step goes to zero.
"""

from __future__ import annotations

from collections.abc import Sequence

import mujoco

from pneuflex_sim.hand.collision import SKIN_STIFFNESS
from pneuflex_sim.scene.contacts import OBJECT
from pneuflex_sim.scene.objects import Compliance
from softhand_model.hand.joint_stiffness import DAMPING_TIME

SKIN_COMPLIANCE = 1.0 / SKIN_STIFFNESS  # compliance at a contact point [m/N]
RIGID_COMPLIANCE = 1.0e-5  # of all other things [m/N]: a bottle of 0.5 kg sinks by less than 0.1 mm
RELAXATION = DAMPING_TIME  # damping over stiffness [s]: of rubber, as in the joints
PER_COMPLIANCE = 1.0e6  # S [1/s2]; high, so that a contact has no inertia of its own
IMPEDANCE = 0.5  # d [-], at all depths


def set_compliance(
    model: mujoco.MjModel, links: Sequence[str], soft_object: Compliance | None
) -> None:
    """Set the stiffness and damping of all contacts.

    links: names of the links that have a skin. soft_object: compliance of the object, None for a
    rigid one. Everything else is rigid.
    """
    stiffness = PER_COMPLIANCE * (1.0 - IMPEDANCE)
    for reference in (model.geom_solref, model.pair_solref):
        reference[:] = (-stiffness, -RELAXATION * stiffness)
    for impedance in (model.geom_solimp, model.pair_solimp):
        impedance[:, :2] = IMPEDANCE
    rigid_skin(model)
    for name in links:
        model.body_invweight0[model.body(name).id, 0] = PER_COMPLIANCE * SKIN_COMPLIANCE
    if soft_object is not None:
        body = model.body(OBJECT).id
        model.body_invweight0[body, 0] = PER_COMPLIANCE / soft_object.stiffness
        relaxation = soft_object.damping / soft_object.stiffness
        geoms = model.geom_bodyid == body
        pairs = geoms[model.pair_geom1] | geoms[model.pair_geom2]
        model.geom_solref[geoms, 1] = model.pair_solref[pairs, 1] = -relaxation * stiffness


def rigid_skin(model: mujoco.MjModel) -> None:
    """Make contacts of the hand's links as stiff as those of other rigid things."""
    model.body_invweight0[:, 0] = PER_COMPLIANCE * RIGID_COMPLIANCE


def update_constants(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    """Compute anew what MuJoCo derives from masses, which have changed; contacts keep their
    stiffness.
    """
    kept = model.body_invweight0[:, 0].copy()
    mujoco.mj_setConst(model, data)
    model.body_invweight0[:, 0] = kept
