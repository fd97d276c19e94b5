"""Where the time of a step at 1 ms goes, at the end of a grasp with RBO Hand 2: the engine with and
without contacts, its collision detection, its solver's iterations, and what is around it.

The engine is asked for single steps of the held grasp, with all iterations and with one; what is
left of it is setting up the rows of the contacts and the dynamics of the chains. The motors of
spherical joints are measured on a chain of its own, switched off as in the hand and holding.
"""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from bench.row import stated
from bench.sim.mujoco_hand import STRATEGY, configuration
from bench.sim.timing import timed_steps
from grasp_strategies.in_process_scene import InProcessScene
from grasp_strategies.sequencer import Sequencer
from grasp_strategies.strategy import load_strategy
from pneuflex_sim.bullet import pybullet
from pneuflex_sim.simulation import Simulation
from pneuflex_sim.world import solver_settings

STEP = 0.001  # [s]
STEPS = 400  # that are timed
IDENTITY = (0.0, 0.0, 0.0, 1.0)


def rows(small: bool) -> list[dict[str, Any]]:
    """Times of the parts [us]."""
    simulation = Simulation(configuration(0, 0.01 if small else STEP))
    try:
        with timed_steps() as times:
            result = Sequencer(InProcessScene(simulation), load_strategy(STRATEGY)).run()
        client = simulation.engine.world.client
        free = 1e6 * float(np.median(times.inside[:200]))
        points = len(pybullet.getContactPoints(physicsClientId=client))
        held = _held(simulation, 40 if small else STEPS)
    finally:
        simulation.close()
    iterations = solver_settings("default").iterations
    solver = (held["whole"] - held["one iteration"]) * iterations / (iterations - 1)
    parts = {
        "engine, nothing touched but the table": free,
        "engine, object held": held["whole"],
        "a contact point": (held["whole"] - free) / max(points, 1),
        "of the engine: iterations of the solver": solver,
        "of the engine: collision detection": held["collisions"],
        "of the engine: rows of contacts, dynamics": held["whole"] - solver - held["collisions"],
        "outside the engine": 1e6 * times.outside(),
        "chain of 10 spherical joints, motors off": _chain(0.0),
        "chain of 10 spherical joints, motors on": _chain(1.0),
    }
    found = [stated(f"step: {name}", value, "us") for name, value in parts.items()]
    found.append(stated("step: contact points, object held", points, ""))
    return [*found, stated("step: object held at the end", result.gripped, "")]


def _held(simulation: Simulation, steps: int) -> dict[str, float]:
    """Medians of the engine's calls [us] while the grasp is held, measured in turns: a step with
    all iterations, one with a single iteration, and the detection of collisions alone.
    """
    client, iterations = simulation.engine.world.client, solver_settings("default").iterations
    whole, single, collisions = [], [], []
    with timed_steps() as times:
        for _ in range(steps):
            for count, found in ((iterations, whole), (1, single)):
                pybullet.setPhysicsEngineParameter(
                    numSolverIterations=count, physicsClientId=client
                )
                simulation.step()
                found.append(times.inside[-1])
            start = time.thread_time()
            pybullet.performCollisionDetection(client)
            collisions.append(time.thread_time() - start)
    found = {"whole": whole, "one iteration": single, "collisions": collisions}
    return {name: 1e6 * float(np.median(seconds)) for name, seconds in found.items()}


def _chain(force: float, joints: int = 10) -> float:
    """Median time [us] of a step of a chain in free air whose motors have this force [N m]."""
    client = pybullet.connect(pybullet.DIRECT)
    try:
        shape = pybullet.createCollisionShape(
            pybullet.GEOM_SPHERE, radius=0.005, physicsClientId=client
        )
        body = pybullet.createMultiBody(
            0.1,
            linkMasses=[0.01] * joints,
            linkCollisionShapeIndices=[shape] * joints,
            linkVisualShapeIndices=[-1] * joints,
            linkPositions=[(0, 0, 0.02)] * joints,
            linkOrientations=[IDENTITY] * joints,
            linkInertialFramePositions=[(0, 0, 0.01)] * joints,
            linkInertialFrameOrientations=[IDENTITY] * joints,
            linkParentIndices=list(range(joints)),
            linkJointTypes=[pybullet.JOINT_SPHERICAL] * joints,
            linkJointAxis=[(0, 0, 1)] * joints,
            physicsClientId=client,
        )
        for joint in range(joints):
            pybullet.setJointMotorControlMultiDof(
                body,
                joint,
                pybullet.POSITION_CONTROL,
                targetPosition=IDENTITY,
                force=[force] * 3,
                physicsClientId=client,
            )
        seconds = []
        for _ in range(STEPS):
            start = time.thread_time()
            pybullet.stepSimulation(client)
            seconds.append(time.thread_time() - start)
        return 1e6 * float(np.median(seconds))
    finally:
        pybullet.disconnect(client)
