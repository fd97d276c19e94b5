import os

from setuptools import find_packages, setup

PACKAGE = "softhand_trials"
# `ros2 run` finds these under lib/<package>; pip would put them on everybody's PATH
EXECUTABLES = ["trials = softhand_trials.trials:main"]
COMMANDS = [
    "softhand-sweep = softhand_trials.sweep.command:main",
    "softhand-search = softhand_trials.search.command:main",
    *(EXECUTABLES if "COLCON" in os.environ else []),
]

setup(
    name=PACKAGE,
    version="0.1.0",
    description="Many grasps in process: trials, sweeps, success maps and searches",
    license="Apache-2.0",
    maintainer="Softhand developers",
    maintainer_email="softhand@example.org",
    packages=find_packages(include=[PACKAGE, f"{PACKAGE}.*"]),
    package_data={PACKAGE: ["py.typed"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{PACKAGE}"]),
        (f"share/{PACKAGE}", ["package.xml"]),
    ],
    install_requires=[
        "setuptools",
        "softhand_common",
        "softhand_model",
        "pneuflex_sim",
        "grasp_strategies",
        "numpy",
        "scipy",
        "matplotlib",
        "optuna>=5,<6",  # parts of its samplers may change between major versions
        "cmaes",
        "PyYAML",
    ],
    extras_require={"test": ["pytest"], "dask": ["distributed"]},
    zip_safe=False,
    entry_points={"console_scripts": COMMANDS},
)
