import os
from glob import glob

from setuptools import find_packages, setup

PACKAGE = "model_lab"
# `ros2 run` finds these under lib/<package>; pip would put them on everybody's PATH
EXECUTABLES = [
    "model_lab = model_lab.cli.main:main",
    "monitor = model_lab.ros.interface:main",
]
COMMANDS = ["model-lab = model_lab.cli.main:main"] + (EXECUTABLES if "COLCON" in os.environ else [])

setup(
    name=PACKAGE,
    version="0.1.0",
    description="Compares the model with measurements, names the missing effect and adds it",
    license="Apache-2.0",
    maintainer="Softhand developers",
    maintainer_email="softhand@example.org",
    packages=find_packages(include=[PACKAGE, f"{PACKAGE}.*"]),
    package_data={
        PACKAGE: ["py.typed", "report/templates/*.html", "learning/*.j2", "diagnosis/*.json"]
    },
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{PACKAGE}"]),
        (f"share/{PACKAGE}", ["package.xml"]),
        (f"share/{PACKAGE}/config", glob("config/*.yaml")),
    ],
    install_requires=[
        "setuptools",
        "softhand_common",
        "softhand_model",
        "softhand_ros",
        "numpy",
        "scipy",
        "PyYAML",
        "lz4",
        "pint",
        "rosbags",
        "matplotlib",
        "pandas",
        "openpyxl",
        "Jinja2",
        "tqdm",
    ],
    extras_require={"test": ["pytest"]},
    zip_safe=False,
    entry_points={"console_scripts": COMMANDS},
)
