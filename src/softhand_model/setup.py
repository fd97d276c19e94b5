from glob import glob

from setuptools import find_packages, setup

PACKAGE = "softhand_model"

setup(
    name=PACKAGE,
    version="0.1.0",
    description="Physics of pneumatic soft hands: rubber, actuators, chains, gas and hands",
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
        "numpy",
        "scipy",
        "numba",
        "PyYAML",
    ],
    extras_require={"test": ["pytest"]},
    zip_safe=False,
)
