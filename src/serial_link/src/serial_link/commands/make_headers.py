"""Command ``rosrun serial_link make_headers``: C++ message and service headers for sketches."""

import argparse
import pathlib
import sys
import zipfile
from typing import Any, Dict, List, Set

import rosmsg
import rospkg

from nodekit.message_definitions import constant_in, fields_of, parts_of
from nodekit.package_version import ShowVersion
from serial_link.endpoints.types import TypeRefused, message_class, service_class
from serial_link.headers.arduino_library import NAME, arduino_library
from serial_link.headers.cpp_class import CppClass, header
from serial_link.headers.wire_header import WIRE_HEADER, WIRE_PATH


class HeaderError(ValueError):
    """Error of a package without types, or of the output folder; the text gives the cause."""


def build_headers(packages: List[str]) -> Dict[str, str]:
    """Return headers by path, for the packages' types and the types nested in them.

    :param packages: names
    :raises HeaderError: if a package is missing, has no types, or is not built
    """
    found = {WIRE_PATH: WIRE_HEADER}
    for package in packages:
        try:
            messages = rosmsg.list_types(package, mode=".msg")
            services = rosmsg.list_types(package, mode=".srv")
        except rospkg.ResourceNotFound:
            raise HeaderError(f"package {package} not found") from None
        if not messages and not services:
            raise HeaderError(f"{package} has neither messages nor services")
        try:
            for datatype in messages:
                _add_message(found, datatype)
            for datatype in services:
                _add_service(found, datatype)
        except TypeRefused as error:
            raise HeaderError(str(error)) from None
    return found


def _add_message(found: Dict[str, str], datatype: str) -> None:
    package, _, name = datatype.partition("/")
    path = datatype + ".h"
    if path not in found:
        one = _class(name, datatype, message_class(datatype, "*"))
        found[path] = header(package, name, [one])
        _add_parts(found, [one])


def _add_service(found: Dict[str, str], datatype: str) -> None:
    package, _, name = datatype.partition("/")
    service = service_class(datatype, "*", "*")
    classes = [
        _class(name + "Request", datatype, service._request_class),
        _class(name + "Response", datatype, service._response_class),
    ]
    found[datatype + ".h"] = header(package, name, classes, service=True)
    _add_parts(found, classes)


def _add_parts(found: Dict[str, str], classes: List[CppClass]) -> None:
    bases: Set[str] = {field.base for one in classes for field in one.fields if "/" in field.base}
    for base in sorted(bases):
        _add_message(found, base)


def _class(name: str, datatype: str, generated: Any) -> CppClass:
    """Convert a generated Python class to a C++ class description."""
    text = parts_of(datatype, generated._full_text)[datatype]
    constants = [constant_in(line) for line in text.splitlines()]
    return CppClass(
        name,
        datatype,
        generated._md5sum,
        tuple(constant for constant in constants if constant is not None),
        fields_of(datatype, text),
    )


def write(headers: Dict[str, str], folder: pathlib.Path) -> None:
    """Write headers.

    :param headers: by their paths in the folder
    :param folder: created if missing
    :raises HeaderError: if writing fails
    """
    try:
        for path, text in headers.items():
            (folder / path).parent.mkdir(parents=True, exist_ok=True)
            (folder / path).write_text(text)
    except OSError as error:
        raise HeaderError(f"cannot write {error.filename}: {error.strerror}") from None


def write_zip(files: Dict[str, str], archive: pathlib.Path) -> None:
    """Write files into a zip file, which the Arduino IDE can add as a library.

    :param files: by their paths
    :param archive: overwritten if it exists
    :raises HeaderError: if writing fails
    """
    try:
        with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as opened:
            for path, text in files.items():
                opened.writestr(path, text)
    except OSError as error:
        raise HeaderError(f"cannot write {archive}: {error.strerror}") from None


def main() -> None:
    """Write the headers requested on the command line; exit with status 1 on failure."""
    parser = argparse.ArgumentParser(
        prog="make_headers",
        description="Write C++ headers of the messages and services of packages, for a sketch "
        "that uses rosserial's Arduino library.",
    )
    parser.add_argument("--version", action=ShowVersion, package="serial_link")
    parser.add_argument("packages", nargs="+", metavar="PACKAGE")
    parser.add_argument(
        "--into", default="ros_headers", metavar="FOLDER", help="output folder (ros_headers)"
    )
    parser.add_argument(
        "--arduino",
        action="store_true",
        help=f"write a library, {NAME}, for the Arduino IDE and arduino-cli: then FOLDER is the "
        "folder libraries of the sketchbook, or a name that ends with .zip",
    )
    arguments = parser.parse_args(sys.argv[1:])
    folder = pathlib.Path(arguments.into)
    try:
        headers = build_headers(arguments.packages)
        files = headers
        if arguments.arduino:
            version = rospkg.RosPack().get_manifest("serial_link").version
            files = arduino_library(headers, ", ".join(arguments.packages), version)
        elif folder.suffix == ".zip":
            raise HeaderError(f"{folder} is a zip file: add --arduino")
        if folder.suffix == ".zip":
            write_zip(files, folder)
        else:
            write(files, folder)
    except HeaderError as reason:
        sys.exit(f"make_headers: {reason}")
    if arguments.arduino:
        where = folder if folder.suffix == ".zip" else folder / NAME
        print(f"{where}: a library with {len(headers)} headers; #include <{NAME}.h>")
    else:
        print(f"{len(headers)} headers are in {arguments.into}")
