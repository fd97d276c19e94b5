import os
from glob import glob

from setuptools import find_packages, setup

PACKAGE = "softhand_bringup"
# `ros2 run` finds these under lib/<package>; pip would put them on everybody's PATH
EXECUTABLES = [
    "demo = softhand_bringup.ros.demo:main",
    "film = softhand_bringup.film.command:main",
    "hand_story = softhand_bringup.ros.hand_story:main",
    "hand_with_box = softhand_bringup.ros.hand_with_box.interface:main",
    "lab_story = softhand_bringup.ros.lab_story:main",
    "recorder = softhand_bringup.ros.recorder:main",
    "repair_bag = softhand_bringup.bags.repair:main",
]
COMMANDS = ["softhand = softhand_bringup.command:main"] + (
    EXECUTABLES if "COLCON" in os.environ else []
)

setup(
    name=PACKAGE,
    version="0.1.0",
    description="Starts, records and shows the suite: launcher, bag recorder, demo and figures",
    license="Apache-2.0",
    maintainer="Softhand developers",
    maintainer_email="softhand@example.org",
    packages=find_packages(include=[PACKAGE, f"{PACKAGE}.*"]),
    package_data={PACKAGE: ["py.typed"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{PACKAGE}"]),
        (f"share/{PACKAGE}", ["package.xml"]),
        (f"share/{PACKAGE}/config", glob("config/*")),
        (f"share/{PACKAGE}/launch", glob("launch/*.launch.py")),
    ],
    install_requires=[
        "setuptools",
        "grasp_strategies",
        "model_lab",
        "pneumaticbox_driver",
        "pneuflex_sim",
        "softhand_common",
        "softhand_trials",
        "softhand_design",
        "softhand_model",
        "softhand_ros",
        "argcomplete",
        "numpy",
        "PyYAML",
        "matplotlib",
        "mcap",
        "rosbags",
        "scipy",
    ],
    extras_require={"test": ["pytest"], "film": ["pillow", "imageio-ffmpeg"]},
    zip_safe=False,
    entry_points={"console_scripts": COMMANDS},
)
