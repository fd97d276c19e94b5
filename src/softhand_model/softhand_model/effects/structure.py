"""Structure effects: walls, stiffness of joints, and contact of the tip."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from softhand_common.numerics.arrays import Array
from softhand_common.numerics.compiled import compiled
from softhand_model.effects.effect import (
    BENDING,
    NO_PRESSURE,
    POSED,
    Parameter,
    unseen_when_stretched,
)
from softhand_model.effects.kernel import HEIGHT, RATIO, SIDE_WALL, WALL, WIDTH, Kernel, Trial
from softhand_model.effects.stages import Memory, SectionShape, Strain, StructureEffect
from softhand_model.effects.whole_runs import RunTimes
from softhand_model.hand import section

UNCHANGED = 1e-7  # of the force: less is rounding, not motion


@compiled
def _side_walls(stress: Array, trial: Trial, values: Array, state: Array) -> None:
    sizes = trial.sizes
    for lane in range(len(stress)):
        height, wall = sizes[HEIGHT, lane], sizes[WALL, lane]
        share = 2.0 * sizes[SIDE_WALL, lane] / (height * sizes[WIDTH, lane] * wall)
        curvature, inner = (trial.stretch[lane] - 1.0) / height, max(height - wall, 0.0)
        term = share * section.side_wall_integral(curvature, inner)
        stress[lane] = 0.5 * sizes[RATIO, lane] * (stress[lane] + term)


class SideWallIntegral(StructureEffect):
    """Contribution of the side walls without the approximation of eq. 3.34: p*h/(2*G*d) = q + term.

    The base model multiplies q by 2/ratio (eq. 3.35); here the elastic stress is (ratio/2)*(q +
    term) with `section.side_wall_term`. The effect is nearly that of a factor of 0.78 on the
    modulus.
    """

    name = "side_wall_integral"
    cause, member = "gain", "side walls"
    experiments = BENDING | POSED
    unseen_in: ClassVar[Mapping[str, str]] = unseen_when_stretched(
        "a strip in tension has no side walls"
    )
    confounded_with: ClassVar[Mapping[str, str]] = {
        "modulus_scale": "nearly a factor of 0.78 on it",
        "pressure_gain": "nearly a factor of 1.28 on the pressure",
    }
    kernel = Kernel(_side_walls)

    def wall_stress(self, stress: Array, strain: Strain, shape: SectionShape) -> Array:
        """Elastic stress / shear modulus [-], with the integral in place of the factor."""
        curvature = (strain.stretch - 1.0) / shape.height
        term = section.side_wall_term(
            curvature, shape.height, shape.width, shape.wall, shape.side_wall
        )
        return 0.5 * shape.ratio * (stress + term)


class ActuationNonlinearity(StructureEffect):
    """Free curvature by eq. 5.2 and 5.3 with fitted a and p0 instead of the exact form.

    kappa = p*ratio/(8*G*d)*(1/sqrt(a) + p/sqrt(p**2/(a - 1) + (a - 1)*p0**2)): the thesis's remedy
    for its actuator with the 5.5 mm wall (section 5.2.2). Effects on load and elastic stress have
    no influence on it. A blocked tip has a free curvature only with linear springs.
    """

    name = "actuation_nonlinearity"
    experiments = frozenset({"free_bending", "base_torque"}) | POSED
    parameters = (
        Parameter(
            "a",
            "",
            1.01,
            100.0,
            "square of the initial slope's fall: 4 for the rubber of eq. 3.21",
            (2.0, 16.0),
            logarithmic=True,
        ),
        Parameter(
            "p0",
            "Pa",
            100.0,
            1e7,
            "pressure of the transition: 0.90*8*G*d/h for the rubber of eq. 3.21",
            (1e4, 2.5e5),
            logarithmic=True,
        ),
    )
    unseen_in: ClassVar[Mapping[str, str]] = {
        **NO_PRESSURE,
        "blocked_tip": "the exact balance has no free curvature to replace",
    }
    confounded_with: ClassVar[Mapping[str, str]] = {
        "thick_wall": "alike on one wall thickness",
        "section_rounding": "alike on one wall thickness",
    }

    def act_on_curvature(self, curvature: Array, pressure: Array, shape: SectionShape) -> Array:
        """Free curvature [1/m] by the approximation at a chamber pressure [Pa]."""
        rule = section.rule_actuation_ratio(shape.wall, shape.shear_modulus)
        relative = rule * shape.height
        shown = section.printed_nonlinearity(
            pressure * relative, self.values["a"], self.values["p0"] * relative
        )
        return pressure * rule * shape.ratio * shown


class PassiveLayerSlack(StructureEffect):
    """The stiffness is multiplied by `ratio` where the curvature is below the free one.

    A passive layer without tension slackens when the finger is straightened; the thesis suspects it
    behind a torque that is overestimated in one direction only (section 5.2.4).
    """

    name = "passive_layer_slack"
    experiments = frozenset({"blocked_tip", "base_torque"}) | POSED
    parameters = (
        Parameter(
            "ratio",
            "",
            0.02,
            1.0,
            "stiffness against straightening over that against bending further",
            (0.3, 0.95),
            neutral=1.0,
        ),
    )
    unseen_in: ClassVar[Mapping[str, str]] = {
        **NO_PRESSURE,
        "free_bending": "nothing straightens a finger that bends freely",
    }
    confounded_with: ClassVar[Mapping[str, str]] = {
        "pressure_gain": "one with it at small loads of a blocked tip"
    }

    def stiffness_factor(self, bend: Array, rest: Array) -> Array:
        """Factor [-]: `ratio` where the bend is below the rest bend, else 1."""
        return np.where(bend < rest, self.values["ratio"], 1.0)


class BendTwistCoupling(StructureEffect):
    """Lateral bending (about x) and twist (about z) of a joint are coupled: the off-diagonal of its
    stiffness is k45 times that in bending.

    abs(k45) < sqrt(k_lateral*k_torsion)/B, which is 1 where all three axes are equally stiff, or
    the springs would be unstable. The thesis leaves couplings out (5.1.1) and finds its twist
    torque wrong (section 5.2.4).
    """

    name = "bend_twist_coupling"
    experiments = frozenset({"base_torque"})
    parameters = (
        Parameter(
            "k45",
            "",
            -0.95,
            0.95,
            "stiffness between lateral bending and twist over that in bending",
            (0.1, 0.6),
            neutral=0.0,
        ),
    )
    unseen_in: ClassVar[Mapping[str, str]] = {
        **NO_PRESSURE,
        "free_bending": "a finger that bends in its plane neither twists nor bends sideways",
        "blocked_tip": "a finger that is blocked in its plane neither twists nor bends sideways",
    }

    def bend_twist_coupling(self) -> Array | float:
        """Stiffness that couples lateral bending and twist / stiffness B in bending [-]."""
        return self.values["k45"]


class GaugeCompliance(StructureEffect):
    """The blocked tip moves by F/stiffness, as the force gauge or its holder yields."""

    name = "gauge_compliance"
    experiments = frozenset({"blocked_tip"})
    parameters = (
        Parameter(
            "stiffness",
            "N/m",
            1.0,
            1e7,
            "force over the way by which the tip yields",
            (30.0, 3e3),
            logarithmic=True,
        ),
    )
    unseen_in: ClassVar[Mapping[str, str]] = dict.fromkeys(
        ("free_bending", "uniaxial", "rubber", "base_torque"), "there is no force gauge at the tip"
    )
    confounded_with: ClassVar[Mapping[str, str]] = {
        "modulus_scale": "a soft gauge makes the force depend on the modulus",
        "pressure_gain": "alike where the force is proportional to the pressure",
    }

    def tip_compliance(self) -> Array | float:
        """Displacement of the tip per force [m/N]."""
        return 1.0 / self.values["stiffness"]


class MachineCompliance(StructureEffect):
    """Grips and load cell of a testing machine yield, so that the stretch by its crosshead is too
    large: lambda_read = lambda + stress/stiffness.

    An extensometer on the strip does not see it.
    """

    name = "machine_compliance"
    experiments = frozenset({"uniaxial"})
    parameters = (
        Parameter(
            "stiffness",
            "Pa",
            1e3,
            1e10,
            "nominal stress over the stretch by which grips and load cell yield",
            (2e5, 1e7),
            logarithmic=True,
        ),
    )
    unseen_in: ClassVar[Mapping[str, str]] = {
        **dict.fromkeys(sorted(BENDING), "no testing machine pulls"),
        "rubber": "each mode is tested in grips of its own",
    }
    confounded_with: ClassVar[Mapping[str, str]] = {
        "modulus_scale": "alike at large stretches, where the stress grows in proportion"
    }

    def grip_compliance(self) -> Array | float:
        """Stretch by which grips and load cell yield per stress [1/Pa]."""
        return 1.0 / self.values["stiffness"]


class FiniteRotation(StructureEffect):
    """A blocked finger bulges between its base and the gauge, by rotations theta that are not
    small: its tip deflects by int(sin(theta)) dx, not int(theta) dx, and the force acts at x on the
    lever int_x^L(cos(theta)) dx, not L - x.

    It adds 0.1 % to the force where a uniform finger would bend freely by 30 deg, 1.6 % at 120 deg,
    3.5 % at 190 deg, and makes the force depend on the modulus. The tip slides along the gauge.
    """

    name = "finite_rotation"
    experiments = frozenset({"blocked_tip"})
    unseen_in: ClassVar[Mapping[str, str]] = {
        **dict.fromkeys(("uniaxial", "rubber", "base_torque"), "no tip is blocked"),
        "free_bending": "the angle of a free tip is that of finite rotations already",
    }
    bulges = True


class TipFriction(StructureEffect):
    """The force gauge reads F*(1 - coefficient*sign(dF/dt)), as friction opposes the change."""

    name = "tip_friction"
    experiments = frozenset({"blocked_tip"})
    parameters = (
        Parameter(
            "coefficient",
            "",
            0.0,
            0.9,
            "share of the force that friction takes or holds",
            (0.03, 0.5),
            neutral=0.0,
        ),
    )
    unseen_in: ClassVar[Mapping[str, str]] = dict.fromkeys(
        ("free_bending", "uniaxial", "rubber", "base_torque"), "nothing rubs at the tip"
    )
    confounded_with: ClassVar[Mapping[str, str]] = {
        "hysteresis": "both part loading from unloading: friction jumps when the force turns"
    }
    has_memory = True

    def tip_force(self, force: Array, memory: Memory, dt: Array | float) -> Array:
        """Force [N] that reaches the force gauge."""
        change = force - memory.get("force", 0.0)
        memory["force"] = force
        return self._rubbed(force, change)

    def in_runs(self, force: Array, times: RunTimes) -> Array:
        """Force (lanes, rows, 1) [N] that reaches the force gauge through whole runs, as
        `tip_force` gives it step by step.
        """
        change, first = np.diff(force, axis=1, prepend=0.0), times.starts[:-1]
        change[:, first] = np.where(times.steady[:, None], 0.0, force[:, first])
        return self._rubbed(force, change)

    def _rubbed(self, force: Array, change: Array) -> Array:
        """Force [N] that reaches the gauge after a change [N]."""
        direction = np.sign(change) * (np.abs(change) > UNCHANGED * np.abs(force))
        return force * (1.0 - self.values["coefficient"] * direction)
