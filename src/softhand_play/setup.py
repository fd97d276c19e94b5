from setuptools import find_packages, setup

PACKAGE = "softhand_play"
COMMANDS = ["softhand-play = softhand_play.command:main"]

setup(
    name=PACKAGE,
    version="0.1.0",
    description="A page in the browser to move a soft hand, to let it grasp, and to see recordings",
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
        "grasp_strategies",
        "model_lab",
        "pneumaticbox_driver",
        "pneuflex_sim",
        "softhand_bringup",
        "softhand_common",
        "softhand_trials",
        "softhand_model",
        "softhand_ros",
        "numpy",
        "viser>=1.1.1,<1.2",
    ],
    extras_require={"test": ["pytest"]},
    zip_safe=False,
    entry_points={"console_scripts": COMMANDS},
)
