"""How deep things sink: weight over stiffness; and what a box slides at, in both engines."""

import numpy as np
import pytest

from pneuflex_sim.engines import ENGINES, MUJOCO, PYBULLET
from pneuflex_sim.engines.mujoco.compliance import RIGID_COMPLIANCE
from pneuflex_sim.hand.collision import SKIN_STIFFNESS
from pneuflex_sim.scene.friction import load_friction

GRAVITY = 9.80665
BALL_RADIUS = 0.0325  # [m]
SLIDING = load_friction().pair("wood", "polyolefin")


def depths_and_forces(simulation):
    """Depths [m], normal forces [N] and pairs of names of the object's contacts in MuJoCo."""
    data, names = simulation.engine.data, simulation.engine._touches._names
    found = []
    for k in range(data.ncon):
        contact, row = data.contact[k], data.contact.efc_address[k]
        pair = {names[geom][0] for geom in contact.geom}
        if row >= 0 and "object" in pair:
            depth = contact.includemargin - contact.dist
            found.append((depth, data.efc_force[row], pair - {"object"}))
    return found


def loaded(simulation, load, steps=None):
    """Press the object down by a load [N], by default until it rests."""
    for _ in range(steps or round(0.5 / simulation.step_size)):
        simulation.push_object(np.array([0.0, 0.0, -load]))
        simulation.step()


@pytest.mark.parametrize("step", [0.001, 0.002, 0.01])
@pytest.mark.parametrize("load", [0.0, 1.0])
@pytest.mark.parametrize(("name", "points"), [("marker", 2), ("tape_dispenser", 4)])
def test_an_object_sinks_by_its_weight_over_the_stiffness(simulate, name, points, load, step):
    simulation = simulate(
        engine=MUJOCO, step=step, object=name, object_offset=(0.0, 1.0), segments=2
    )
    # the stiffness does not hang on the mass, from which MuJoCo derives its own
    simulation.place_object((0.0, 1.0), 2.0)
    loaded(simulation, load)
    weight = GRAVITY * simulation.object_mass + load
    sunk = max(depth for depth, _, _ in depths_and_forces(simulation))
    assert sunk == pytest.approx(weight * 2.0 * RIGID_COMPLIANCE / points, rel=0.02)


@pytest.mark.parametrize("step", [0.001, 0.002])
def test_a_soft_object_sinks_by_its_own_stiffness(simulate, step):
    """On average: it has three points of contact, which change from step to step."""
    simulation = simulate(
        engine=MUJOCO, step=step, object="water_balloon", object_offset=(0.0, 1.0), segments=2
    )
    loaded(simulation, 1.0)
    start, depths, forces = simulation.object_pose()[0], [], []
    for _ in range(round(0.5 / step)):
        loaded(simulation, 1.0, 1)
        touching = depths_and_forces(simulation)
        depths.append(sum(depth for depth, _, _ in touching))
        forces.append(sum(force for _, force, _ in touching))
    weight = GRAVITY * simulation.object_mass + 1.0
    assert np.mean(forces) == pytest.approx(weight, rel=0.01)
    compliance = 1.0 / simulation.object.compliance.stiffness + RIGID_COMPLIANCE
    assert np.mean(depths) == pytest.approx(weight * compliance, rel=0.02)
    assert np.linalg.norm(simulation.object_pose()[0] - start) < 5e-5


@pytest.mark.parametrize("load", [0.0, 1.0])
def test_in_pybullet_it_hardly_sinks(simulate, load):
    simulation = simulate(
        engine=PYBULLET, step=0.002, object="marker", object_offset=(0.0, 1.0), segments=2
    )
    loaded(simulation, load)
    radius = 0.0085
    assert simulation.object_pose()[0][2] == pytest.approx(radius, abs=5e-5)


@pytest.mark.parametrize(("step", "stiffer"), [(0.0002, 0.02), (0.002, 0.2)])
def test_a_ball_sinks_into_a_fingers_skin_by_force_over_stiffness(simulate, step, stiffer):
    simulation = simulate(
        engine=MUJOCO, hand="single_finger", scene="held", step=step, segments=2, object="ball"
    )
    low, high = simulation.hand_boxes()[1]  # of the first link; the plate comes before it
    place = 0.5 * (low + high) - simulation.wrist_pose()[0]
    place[0] += 0.5 * (high - low)[0] + BALL_RADIUS - 0.003
    simulation.hold_object(place, np.array([0.0, 0.0, 0.0, 1.0]))
    for _ in range(round(0.4 / step)):
        simulation.step()
    [(depth, force, touched)] = depths_and_forces(simulation)
    assert touched == {"finger"}
    # MuJoCo adds what the joints' springs and dampers weigh in a step
    assert 1.0 <= force / depth * (1.0 / SKIN_STIFFNESS + RIGID_COMPLIANCE) < 1.0 + stiffer


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("degrees", [0.0, 22.5, 45.0])
def test_a_box_slides_at_its_friction_within_3_per_cent(simulate, engine, degrees):
    simulation = simulate(
        engine=engine, step=0.002, object="tape_dispenser", object_offset=(0.0, 1.0), segments=2
    )
    heading = np.array([np.cos(np.radians(degrees)), np.sin(np.radians(degrees)), 0.0])
    moved = []
    for share in (0.97, 1.03):
        simulation.reset()
        loaded(simulation, 0.0)
        start = simulation.object_pose()[0]
        for _ in range(250):
            force = share * SLIDING * simulation.object_mass * GRAVITY
            simulation.push_object(force * heading)
            simulation.step()
        moved.append(float((simulation.object_pose()[0] - start) @ heading))
    assert moved[0] < 2e-4
    assert moved[1] > 5e-4
