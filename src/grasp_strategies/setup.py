import os
from glob import glob

from setuptools import find_packages, setup

PACKAGE = "grasp_strategies"
# `ros2 run` finds these under lib/<package>; pip would put them on everybody's PATH
EXECUTABLES = [
    "sequencer = grasp_strategies.ros.interface:main",
]
COMMANDS = EXECUTABLES if "COLCON" in os.environ else []

setup(
    name=PACKAGE,
    version="0.1.0",
    description="Grasp strategies as data, the sequencer that runs them, and its node",
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
        "pneuflex_sim",
        "numpy",
        "scipy",
        "PyYAML",
    ],
    extras_require={"test": ["pytest"]},
    zip_safe=False,
    entry_points={"console_scripts": COMMANDS},
)
