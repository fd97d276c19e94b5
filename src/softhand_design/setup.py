import os

from setuptools import find_packages, setup

PACKAGE = "softhand_design"
# `ros2 run` finds these under lib/<package>; pip would put them on everybody's PATH
EXECUTABLES = [
    "hand = softhand_design.commands.hand:main",
    "softhand-materials = softhand_design.commands.materials:main",
]
COMMANDS = EXECUTABLES if "COLCON" in os.environ else []

setup(
    name=PACKAGE,
    version="0.1.0",
    description="Design of PneuFlex actuators: sizes, rubbers, fibres and casting moulds",
    license="Apache-2.0",
    maintainer="Softhand developers",
    maintainer_email="softhand@example.org",
    packages=find_packages(include=[PACKAGE, f"{PACKAGE}.*"]),
    package_data={PACKAGE: ["py.typed", "data/**/*.yaml"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{PACKAGE}"]),
        (f"share/{PACKAGE}", ["package.xml"]),
    ],
    install_requires=[
        "setuptools",
        "softhand_common",
        "softhand_model",
        "pneuflex_sim",
        "numpy",
        "scipy",
        "PyYAML",
        "trimesh",
    ],
    extras_require={"test": ["pytest"], "plot": ["matplotlib"], "mould": ["manifold3d"]},
    zip_safe=False,
    entry_points={"console_scripts": COMMANDS},
)
