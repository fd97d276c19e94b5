from setuptools import find_packages, setup

PACKAGE = "softhand_gym"

setup(
    name=PACKAGE,
    version="0.1.0",
    description="A Gymnasium environment: a soft hand that learns to grasp",
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
        "pneuflex_sim",
        "softhand_common",
        "softhand_model",
        "softhand_trials",
        "gymnasium>=1.0,<2",
        "numpy",
        "scipy",
    ],
    extras_require={"test": ["pytest"]},
    zip_safe=False,
)
