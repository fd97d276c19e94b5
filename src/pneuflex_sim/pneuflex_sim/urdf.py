"""URDF of a hand: every spherical joint as three revolute joints (x, then y, then z), with boxes as
visuals.
"""

from __future__ import annotations

from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from pneuflex_sim.hand.layout import HandLayout

AXIS_NAMES = ("x", "y", "z")
URDF_COLORS = {"rubber": "0.93 0.55 0.25 1", "scaffold": "0.35 0.38 0.45 1"}  # rgba


def joint_names(layout: HandLayout) -> list[str]:
    """Names of the revolute joints, three per spherical joint, in the order of
    `joint_positions`.
    """
    return [f"{name}_{axis}" for name in layout.names for axis in AXIS_NAMES]


def joint_positions(q: NDArray[np.float64]) -> NDArray[np.float64]:
    """Angles [rad] of the revolute joints (3 n,) for the joint orientations (n, 4): intrinsic x, y,
    z.
    """
    return Rotation.from_quat(q).as_euler("XYZ").ravel()


def joint_orientations(positions: NDArray[np.float64]) -> NDArray[np.float64]:
    """Inverse of `joint_positions`: orientations (n, 4) from angles (3 n,)."""
    return Rotation.from_euler("XYZ", np.reshape(positions, (-1, 3))).as_quat()


def write_urdf(layout: HandLayout) -> str:
    """URDF text with the root link `wrist`; masses [kg], lengths [m]."""
    robot = ElementTree.Element("robot", name=layout.description.name)
    for name, color in URDF_COLORS.items():
        material = ElementTree.SubElement(robot, "material", name=name)
        ElementTree.SubElement(material, "color", rgba=color)
    wrist, plate = ElementTree.SubElement(robot, "link", name="wrist"), layout.description.plate
    if plate is not None:
        _box(wrist, "visual", np.array(plate.position), np.array(plate.size), "scaffold")
    for body in layout.bodies:
        parent = f"{body.name}_base"
        ElementTree.SubElement(robot, "link", name=parent)
        rpy = Rotation.from_quat(body.orientation).as_euler("xyz")
        _joint(robot, f"{parent}_mount", "fixed", "wrist", parent, body.position, rpy)
        for joint in range(body.joints.start, body.joints.stop):
            parent = _segment(robot, layout, joint, parent)
    ElementTree.indent(robot)
    return ElementTree.tostring(robot, encoding="unicode")


def _segment(robot: ElementTree.Element, layout: HandLayout, joint: int, parent: str) -> str:
    """Three revolute joints and the link they carry; returns the name of the link."""
    name = layout.names[joint]
    for k, axis in enumerate(AXIS_NAMES):
        child = name if k == 2 else f"{name}_{axis}_link"
        link = ElementTree.SubElement(robot, "link", name=child)
        place = layout.offset[joint] if k == 0 else np.zeros(3)
        element = _joint(robot, f"{name}_{axis}", "revolute", parent, child, place, np.zeros(3))
        ElementTree.SubElement(element, "axis", xyz=_text(np.eye(3)[k]))
        ElementTree.SubElement(
            element, "limit", lower="-3.2", upper="3.2", effort="10", velocity="100"
        )
        parent = child
    _fill_link(link, layout, joint)
    return name


def _fill_link(link: ElementTree.Element, layout: HandLayout, joint: int) -> None:
    """Mass, inertia and box of a segment."""
    size, center = layout.size[joint], layout.center[joint]
    inertial = ElementTree.SubElement(link, "inertial")
    ElementTree.SubElement(inertial, "origin", xyz=_text(center), rpy="0 0 0")
    ElementTree.SubElement(inertial, "mass", value=f"{layout.mass[joint]:.6g}")
    x, y, z = (
        layout.mass[joint]
        / 12
        * np.array(
            [size[1] ** 2 + size[2] ** 2, size[0] ** 2 + size[2] ** 2, size[0] ** 2 + size[1] ** 2]
        )
    )
    ElementTree.SubElement(
        inertial,
        "inertia",
        ixx=f"{x:.6g}",
        iyy=f"{y:.6g}",
        izz=f"{z:.6g}",
        ixy="0",
        ixz="0",
        iyz="0",
    )
    _box(link, "visual", center, size, "rubber")
    _box(link, "collision", center, size)


def _box(
    link: ElementTree.Element,
    kind: str,
    center: NDArray[np.float64],
    size: NDArray[np.float64],
    material: str | None = None,
) -> None:
    """Append a box to the `visual` or `collision` elements of a link."""
    element = ElementTree.SubElement(link, kind)
    ElementTree.SubElement(element, "origin", xyz=_text(center), rpy="0 0 0")
    ElementTree.SubElement(ElementTree.SubElement(element, "geometry"), "box", size=_text(size))
    if material is not None:
        ElementTree.SubElement(element, "material", name=material)


def _joint(
    robot: ElementTree.Element,
    name: str,
    kind: str,
    parent: str,
    child: str,
    xyz: NDArray[np.float64],
    rpy: NDArray[np.float64],
) -> ElementTree.Element:
    """Append one joint."""
    element = ElementTree.SubElement(robot, "joint", name=name, type=kind)
    ElementTree.SubElement(element, "origin", xyz=_text(xyz), rpy=_text(rpy))
    ElementTree.SubElement(element, "parent", link=parent)
    ElementTree.SubElement(element, "child", link=child)
    return element


def _text(vector: NDArray[np.float64]) -> str:
    return " ".join(f"{value:.10g}" for value in vector)
