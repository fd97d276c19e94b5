import os
from glob import glob

from setuptools import find_packages, setup

PACKAGE = "pneuflex_sim"
# `ros2 run` finds these under lib/<package>; pip would put them on everybody's PATH
EXECUTABLES = [
    "hand_sim = pneuflex_sim.ros.interface:main",
    "hand = pneuflex_sim.commands.hand:main",
    "pneuflex-objects = pneuflex_sim.commands.objects:main",
    "pneuflex-skin = pneuflex_sim.commands.skin:main",
]
COMMANDS = EXECUTABLES if "COLCON" in os.environ else []

setup(
    name=PACKAGE,
    version="0.1.0",
    description="Simulator of soft hands in PyBullet or MuJoCo, and its node",
    license="Apache-2.0",
    maintainer="Softhand developers",
    maintainer_email="softhand@example.org",
    packages=find_packages(include=[PACKAGE, f"{PACKAGE}.*"]),
    package_data={PACKAGE: ["py.typed", "data/**/*.yaml", "data/**/*.xml"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{PACKAGE}"]),
        (f"share/{PACKAGE}", ["package.xml"]),
        (f"share/{PACKAGE}/config", glob("config/*.yaml")),
        (f"share/{PACKAGE}/launch", glob("launch/*.launch.py")),
    ],
    install_requires=[
        "setuptools",
        "softhand_common",
        "softhand_model",
        "softhand_ros",
        "numpy",
        "scipy",
        "PyYAML",
        "pybullet; python_version < '3.12'",
        "mujoco-core",
        "numba",
        "trimesh",
    ],
    extras_require={
        "test": ["pytest"],
        "plot": ["matplotlib"],
        "pybullet": ["pybullet"],
        "mesh": ["coacd", "manifold3d"],
    },
    zip_safe=False,
    entry_points={
        "console_scripts": COMMANDS,
        "model_lab.grasps": ["simulator = pneuflex_sim.simulation.replay:replay_grasp"],
    },
)
