from setuptools import find_packages, setup

PACKAGE = "softhand_common"

setup(
    name=PACKAGE,
    version="0.1.0",
    description="What all packages share: documents, numerics, progress, status reports",
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
        "numpy",
        "scipy",
        "numba",
        "PyYAML",
        "tqdm",
    ],
    extras_require={"test": ["pytest"]},
    zip_safe=False,
)
