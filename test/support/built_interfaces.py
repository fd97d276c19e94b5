"""Builds a package of ROS interfaces from its definitions: types as those of an installed one.

The wheels from PyPI have generators and headers, but CMake's part of them cannot be used: here the
generators are called and their output compiled by gcc. Fast DDS alone is supported.
"""

import hashlib
import os
import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path

import numpy as np

PREFIX = Path(sys.prefix)
SUPPORTS = ["rosidl_typesupport_fastrtps_c", "rosidl_typesupport_introspection_c"]
NEEDED = ["-Wl,--no-as-needed"]
COMPILER = shutil.which("g++")
PYTHON_HEADERS = Path(sysconfig.get_path("include"))
CAN_BUILD = bool(COMPILER) and (PYTHON_HEADERS / "Python.h").exists()

HERE = Path(__file__).parent
CONTROL_MSGS = HERE / "interfaces" / "control_msgs"  # fields as in the public definition of Jazzy


def control_msgs():
    """The folder to put on PYTHONPATH for control_msgs; built in a minute, and kept in .cache."""
    text = b"".join(path.read_bytes() for path in sorted(CONTROL_MSGS.glob("*/*")))
    key = hashlib.sha256(text + Path(__file__).read_bytes() + sys.prefix.encode()).hexdigest()
    folder = HERE.parents[1] / ".cache" / "interfaces" / key[:16]
    if not (folder / "whole").exists():
        shutil.rmtree(folder, ignore_errors=True)
        uses = ["std_msgs", "sensor_msgs", "trajectory_msgs", "geometry_msgs"]
        build(CONTROL_MSGS, folder, uses)
        (folder / "whole").touch()
    return folder / "python"


def build(definitions, folder, uses):
    """Build the package whose folder of definitions (msg/*.msg, action/*.action) this is.

    Args:
        definitions: folder; its name is the package's.
        folder: where to build.
        uses: names of the packages whose messages the definitions use.

    Returns the folder to put on PYTHONPATH; libraries are found by their rpath.
    """
    package, out = definitions.name, folder / "python" / definitions.name
    sources = _generate(package, definitions, folder, out)
    uses = {*uses, "action_msgs", "builtin_interfaces", "service_msgs", "unique_identifier_msgs"}
    uses |= {"type_description_interfaces"}
    headers = [folder / "c", folder / "seen", PYTHON_HEADERS, np.get_include(), PREFIX / "include"]
    headers += [path for path in (PREFIX / "include").iterdir() if path.is_dir()]
    common = ["-O0", "-fPIC", "-w", *(f"-I{path}" for path in headers)]
    parts = [f"rosidl_{kind}" for kind in ("generator_c", "typesupport_c", "generator_py")]
    parts += SUPPORTS
    libraries = [f"{one}__{part}" for one in sorted(uses) for part in parts]
    libraries += ["rosidl_runtime_c", "rosidl_typesupport_c", *SUPPORTS, "rcutils", "fastcdr"]
    libraries += ["rosidl_typesupport_fastrtps_cpp", "rmw"]
    found = [path for path in map(_library, libraries) if path]
    places = sorted({str(path.parent) for path in found} | {str(out)})
    links = [*map(str, found), *(f"-Wl,-rpath,{place}" for place in places)]
    objects = [_compile(source, common) for source in sources if "_s.ep." not in source.name]
    whole = out / f"lib{package}.so"
    _run(COMPILER, "-shared", "-o", whole, *objects, *links)
    # ROS looks for one library a type support, by name: found without a path when it is loaded
    names = [f"lib{package}__{support}.so" for support in SUPPORTS]
    for name in names:
        _run(COMPILER, "-shared", "-o", out / name, f"-Wl,-soname,{name}", *NEEDED, whole, *links)
    links = [*NEEDED, *(out / name for name in names), whole, *links]
    for source in sources:
        if "_s.ep." in source.name:
            name = source.name.split(".")[2]
            module = out / f"{package}_s__{name}{sysconfig.get_config_var('EXT_SUFFIX')}"
            _run(COMPILER, "-shared", "-o", module, _compile(source, common), *links)
    return out.parent


def _generate(package, definitions, folder, out):
    """Generate all code; returns the sources to compile."""
    os.environ.setdefault("AMENT_PREFIX_PATH", str(PREFIX))
    from rosidl_cli.command.hash.api import generate_type_hashes
    from rosidl_cli.command.translate.api import translate
    from rosidl_generator_c.cli import GenerateC
    from rosidl_generator_py.cli import GeneratePython
    from rosidl_typesupport_c.cli import GenerateCTypesupport
    from rosidl_typesupport_fastrtps_c.cli import GenerateFastRTPSCTypesupport
    from rosidl_typesupport_introspection_c.cli import GenerateIntrospectionCTypesupport

    share = [str(PREFIX / "share")]
    relative = sorted(path.relative_to(definitions) for path in definitions.glob("*/*.*"))
    given = [f"{definitions}:{path}" for path in map(str, relative)]
    code = folder / "c" / package
    idl = list(
        map(
            str,
            translate(
                package_name=package,
                interface_files=given,
                include_paths=share,
                output_path=folder / "idl",
                output_format="idl",
            ),
        )
    )
    hashes = generate_type_hashes(
        package_name=package,
        interface_files=idl,
        include_paths=share,
        output_path=folder / "hashes",
    )
    made = []
    for kind in ("msg", "action"):  # apart: the generator finds a hash by the name of its file
        these, theirs = (
            [one for one in files if f"{kind}/" in str(one)] for files in (idl, hashes)
        )
        made += GenerateC("c").generate(package, these, share, code, type_description_files=theirs)
    made += GenerateFastRTPSCTypesupport("f").generate(package, idl, share, code)
    # files of the same names as those of GenerateC
    seen = GenerateIntrospectionCTypesupport("i")
    made += seen.generate(package, idl, share, folder / "seen" / package)
    dispatch = GenerateCTypesupport("t", typesupport_implementations=SUPPORTS)
    made += dispatch.generate(package, idl, share, folder / "dispatch" / package)
    python = GeneratePython("py", typesupport_implementations=["rosidl_typesupport_c", *SUPPORTS])
    made += python.generate(package, idl, share, out)
    made += out.rglob("*.c")
    (out / "__init__.py").touch()
    return sorted({Path(path) for path in made if Path(path).suffix in (".c", ".cpp")})


def _library(name):
    """The path of a library, in the environment or in a wheel's folder of libraries."""
    places = [PREFIX / "lib", *Path(np.__file__).parents[1].glob("*.libs")]
    found = (match for place in places for match in place.glob(f"lib{name}.so*"))
    return next(found, None)


def _compile(source, flags):
    compiler = COMPILER if source.suffix == ".cpp" else shutil.which("gcc")
    result = source.with_suffix(source.suffix + ".o")
    _run(compiler, "-c", source, "-o", result, *flags)
    return result


def _run(*command):
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(f"{' '.join(map(str, command[:6]))}: {done.stderr[-3000:]}")
