"""Builder of twins: ROS 2 packages with the types of ROS 1 packages, for the bridge's environment.

Run with the environment's Python: ``twin_builder.py TWINS PACKAGE[:NEEDED,…]…``. The definitions
are in TWINS/PACKAGE/source; a package follows its dependencies. It calls ROS 2's generators and
compiles their output for rclpy and fastrtps, which also needs introspection. ROS 2's CMake files
would start ten programs for each package, and build unused C++ classes.

A package that does not build is skipped, with the reason in TWINS/PACKAGE/error. ROS 2 sees a
package only once it is complete, because its index entry is written last.
"""

import concurrent.futures
import functools
import os
import pathlib
import shutil
import subprocess
import sys
import sysconfig
from typing import Any, Callable, Dict, List, NamedTuple

import numpy
from rosidl_cli.command.hash.api import generate_type_hashes
from rosidl_cli.command.translate.api import translate
from rosidl_generator_c.cli import GenerateC
from rosidl_generator_py.cli import GeneratePython
from rosidl_parser import parser
from rosidl_typesupport_c.cli import GenerateCTypesupport
from rosidl_typesupport_fastrtps_c.cli import GenerateFastRTPSCTypesupport
from rosidl_typesupport_introspection_c.cli import GenerateIntrospectionCTypesupport

ENVIRONMENT = pathlib.Path(sys.prefix)
LIBRARIES = ENVIRONMENT / "lib"
SHARE = ENVIRONMENT / "share"
INDEX = SHARE / "ament_index" / "resource_index"
SITE = pathlib.Path(sysconfig.get_path("purelib"))

C, FASTRTPS = "rosidl_typesupport_c", "rosidl_typesupport_fastrtps_c"
INTROSPECTION = "rosidl_typesupport_introspection_c"
#: Dependencies of every service: its event has a time.
ALWAYS = ["builtin_interfaces", "service_msgs"]
#: Libraries of a package: from a wheel, or built here.
OF_PACKAGE = ("rosidl_generator_c", FASTRTPS, INTROSPECTION, C, "rosidl_generator_py", "twin")
OF_FASTRTPS = ("rosidl_typesupport_fastrtps_cpp", "fastcdr")
OF_ROS2 = ("rosidl_runtime_c", C, FASTRTPS, INTROSPECTION, *OF_FASTRTPS, "rcutils")
#: Not optimised: that would double the build time, and few messages use this code.
FLAGS = ("-O0", "-fPIC", "-w", "-DNDEBUG")


class Package(NamedTuple):
    """A package to build.

    :param place: its folder
    :param needs: names of its dependencies
    """

    name: str
    place: pathlib.Path
    needs: List[str]

    @property
    def code(self) -> pathlib.Path:
        """Folder of the generated code; its parent is the include folder."""
        return self.place / "generated" / self.name

    @property
    def introspection(self) -> pathlib.Path:
        """Folder of the introspection code, some of whose file names collide with others."""
        return self.place / "introspection" / self.name

    @property
    def module(self) -> pathlib.Path:
        """Folder of its Python module."""
        return SITE / self.name


def generate(package: Package) -> None:
    """Generate a package's code, and install its definitions."""
    name, code, share = package.name, package.code, SHARE / package.name
    source = package.place / "source"
    for kind in ("packages", "rosidl_interfaces"):
        (INDEX / kind / name).unlink(missing_ok=True)
    for place in (code.parent, package.introspection.parent, share, package.module):
        shutil.rmtree(str(place), ignore_errors=True)
    interfaces = sorted(path.relative_to(source) for path in source.glob("*/*"))
    idl: Any = translate(
        package_name=name,
        interface_files=[f"{source}:{path}" for path in interfaces],
        include_paths=[],
        output_format="idl",
        output_path=share,
    )
    paths = [str(SHARE / needed) for needed in package.needs]
    hashes = generate_type_hashes(
        package_name=name, interface_files=idl, include_paths=paths, output_path=share
    )
    GenerateC("c").generate(name, idl, paths, code, type_description_files=hashes)
    for generator in (
        GenerateFastRTPSCTypesupport("fastrtps_c"),
        GenerateCTypesupport("c", typesupport_implementations=[FASTRTPS, INTROSPECTION]),
        GeneratePython("py", typesupport_implementations=[C]),
    ):
        generator.generate(name, idl, paths, code)
    introspection = GenerateIntrospectionCTypesupport("introspection_c")
    introspection.generate(name, idl, paths, package.introspection)
    (code / "__init__.py").touch()
    for path in [*interfaces, pathlib.Path("package.xml")]:
        shutil.copy(str(source / path), str(share / path))
    for path in code.rglob("*.py"):
        target = package.module / path.relative_to(code)
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(str(path), str(target))


def add_to_index(package: Package) -> None:
    """Add a package to ROS 2's index."""
    source = package.place / "source"
    interfaces = sorted(path.relative_to(source) for path in source.glob("*/*"))
    listed = [
        str(path.with_suffix(suffix)) for path in interfaces for suffix in (".idl", path.suffix)
    ]
    (INDEX / "packages" / package.name).touch()
    (INDEX / "rosidl_interfaces" / package.name).write_text("\n".join(listed), "utf-8")


def units(package: Package) -> List[pathlib.Path]:
    """Return the files to compile: few files that include the rest, because headers dominate."""
    alone = [*package.code.glob("*.c"), *package.code.rglob("*__description.c")]
    found = list(alone)
    places = [*package.code.iterdir(), *package.introspection.iterdir()]
    for folder in [path for path in places if path.is_dir()]:
        for suffix in (".c", ".cpp"):
            parts = sorted(path for path in folder.rglob("*" + suffix) if path not in alone)
            if parts:
                lines = [f'#include "{path.relative_to(folder)}"\n' for path in parts]
                found.append(folder / f"all{suffix}")
                found[-1].write_text("".join(lines), "utf-8")
    return found


def build(packages: List[Package], includes: List[pathlib.Path], run_step: "StepRunner") -> None:
    """Compile the generated code on all processors, and link it."""
    options = [f"-I{path}" for path in includes]

    def compiled(source: pathlib.Path) -> pathlib.Path:
        target = source.with_suffix(source.suffix + ".o")
        compiler = "g++" if source.suffix == ".cpp" else "gcc"
        run(compiler, *FLAGS, *options, "-c", source, "-o", target)
        return target

    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        jobs = [[pool.submit(compiled, unit) for unit in units(package)] for package in packages]
    for package, parts in zip(packages, jobs):
        run_step(package, lambda: link_package(package, [job.result() for job in parts]))


def link_package(package: Package, parts: List[pathlib.Path]) -> None:
    """Link the parts of a package, and add it to the index."""
    entry = [path for path in parts if ".ep." in path.name]
    names = [f"{needed}__{part}" for needed in package.needs for part in OF_PACKAGE]
    there = [one for one in (*names, *OF_ROS2) if (LIBRARIES / f"lib{one}.so").exists()]
    own = f"{package.name}__twin"
    link(LIBRARIES / f"lib{own}.so", [one for one in parts if one not in entry], there)
    link(package.module / f"{package.name}_s__{C}.so", entry, [own])
    for kind in (FASTRTPS, INTROSPECTION):  # loaded by these names
        alias = LIBRARIES / f"lib{package.name}__{kind}.so"
        alias.unlink(missing_ok=True)
        alias.symlink_to(f"lib{own}.so")
    add_to_index(package)


def link(target: pathlib.Path, objects: List[pathlib.Path], libraries: List[str]) -> None:
    named = [f"-l{name}" for name in libraries]
    run("g++", "-shared", "-o", target, *objects, f"-L{LIBRARIES}", *named)


def run(*command: object) -> None:
    done = subprocess.run(
        [str(part) for part in command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT
    )
    if done.returncode:
        output = done.stdout.decode("utf-8", "replace").splitlines()
        errors = [line for line in output if "error" in line] or output[-1:]
        raise RuntimeError(errors[0] if errors else f"{command[0]} ended with {done.returncode}")


class StepRunner:
    """Runner of build steps: a package that fails is skipped, and so are its dependents."""

    def __init__(self) -> None:
        self._failed: Dict[str, str] = {}

    def __call__(self, package: Package, step: Callable[[], None]) -> bool:
        """Run a build step of a package.

        :param step: raises any exception on failure, as ROS 2's generators do
        :returns: whether it succeeded
        """
        lost = [needed for needed in package.needs if needed in self._failed]
        try:
            if lost:
                raise RuntimeError(f"it needs {lost[0]}, which does not build")
            step()
        except Exception as error:
            reason = " ".join(str(error).split()) or type(error).__name__
            self._failed[package.name] = reason
            (package.place / "error").write_text(reason, "utf-8")
            shutil.rmtree(str(package.module), ignore_errors=True)
            print(f"{package.name}: {reason}", flush=True)
            return False
        return True


def main(twins: pathlib.Path, given: List[str]) -> None:
    """Build packages, given as on the command line."""
    # Without a cache, each generator would parse all files again, which takes most of the time.
    parser.get_ast_from_idl_string = functools.lru_cache(None)(parser.get_ast_from_idl_string)
    packages, run_step = [], StepRunner()
    for name, _, needed in (one.partition(":") for one in given):
        needs = [*ALWAYS, *needed.split(",")] if needed else ALWAYS
        package = Package(name, twins / name, needs)
        (package.place / "error").unlink(missing_ok=True)
        if run_step(package, functools.partial(generate, package)):
            packages.append(package)
    headers = ENVIRONMENT / "include"
    includes = [
        headers,
        *headers.iterdir(),
        *twins.glob("*/generated"),
        *twins.glob("*/introspection"),
        pathlib.Path(sysconfig.get_path("include")),
        pathlib.Path(numpy.get_include()),
    ]
    build(packages, includes, run_step)
    for package in packages:
        for path in package.place.rglob("*.o"):
            path.unlink()


if __name__ == "__main__":
    main(pathlib.Path(sys.argv[1]), sys.argv[2:])
