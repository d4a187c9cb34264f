"""Python modules of a package's messages, generated without a build."""

import contextlib
import io
import os
import re
from typing import Any, Dict, List
from xml.etree import ElementTree

import genmsg
import genpy.dynamic
import genpy.generate_initpy
import genpy.generator
import rospkg
import roslib.message

#: Legal name of a package with messages: it becomes a folder and a Python name.
_LEGAL = re.compile("[A-Za-z][A-Za-z0-9_]*")
_INIT = "import pkgutil\n\n__path__ = pkgutil.extend_path(__path__, __name__)\n"


class MessageTypeError(Exception):
    """Error of a type that cannot be used for a topic; the text gives the reason."""


def definitions(package: str) -> Dict[str, str]:
    """Return the texts of a package's messages by name.

    :param package: folder of the package; empty without one
    """
    found: Dict[str, str] = {}
    folder = os.path.join(package, "msg")
    if package and os.path.isdir(folder):
        for name in sorted(os.listdir(folder)):
            if name.endswith(".msg"):
                with open(os.path.join(folder, name), encoding="utf-8", errors="replace") as file:
                    found[name[: -len(".msg")]] = file.read()
    return found


def package_name(package: str) -> str:
    """Return the name in a package.xml; empty without one.

    :param package: folder of the package
    """
    with contextlib.suppress(OSError, ElementTree.ParseError):
        return (
            ElementTree.parse(os.path.join(package, "package.xml")).findtext("name") or ""
        ).strip()
    return ""


def check_legal(name: str) -> None:
    """Check the name of a package that has messages.

    :param name: the name
    :raises MessageTypeError: if it is illegal
    """
    if not _LEGAL.fullmatch(name):
        raise MessageTypeError(
            "package.xml: <name> must be letters, digits and _, with a letter first"
            f" ({name[:80]!r})"
        )


def generate(name: str, texts: Dict[str, str], scratch: str) -> Dict[str, Any]:
    """Generate Python modules, and return the classes by type; empty if that fails.

    :param name: name of the package
    :param texts: definition of each message
    :param scratch: folder for the modules, to be put first in PYTHONPATH
    """
    source, target = os.path.join(scratch, name, "definitions"), os.path.join(scratch, name, "msg")
    os.makedirs(source)
    paths = []
    for message, text in texts.items():
        paths.append(os.path.join(source, message + ".msg"))
        with open(paths[-1], "w", encoding="utf-8") as file:
            file.write(text)
    with open(os.path.join(scratch, name, "__init__.py"), "w", encoding="utf-8") as file:
        file.write(_INIT)
    places = rospkg.RosPack()
    search = {package: [os.path.join(places.get_path(package), "msg")] for package in places.list()}
    search[name] = [source]
    try:
        with contextlib.redirect_stderr(io.StringIO()):
            status = genpy.generator.MsgGenerator().generate_messages(name, paths, target, search)
        if status != 0:
            return {}
        genpy.generate_initpy.write_modules(target)
        return {f"{name}/{message}": _class(f"{name}/{message}", search) for message in texts}
    except (genmsg.InvalidMsgSpec, genmsg.MsgGenerationException, OSError):
        return {}


def _class(msg_type: str, search: Dict[str, List[str]]) -> Any:
    context = genmsg.MsgContext.create_default()
    spec = genmsg.load_msg_by_type(context, msg_type, search)
    genmsg.load_depends(context, spec, search)
    text = genmsg.compute_full_text(context, spec)
    return genpy.dynamic.generate_dynamic(msg_type, text)[msg_type]


def class_of(topic: str, msg_type: str, own: Dict[str, Any]) -> Any:
    """Return the class of a type.

    :param topic: name of the topic
    :param msg_type: ``PACKAGE/TYPE``
    :param own: classes of the student's package by type
    :raises MessageTypeError: if there is no such type
    """
    found = own.get(msg_type)
    if found is None:
        try:
            found = roslib.message.get_message_class(msg_type)
        except (ImportError, ValueError, AttributeError):
            found = None
    if found is None:
        raise MessageTypeError(f"{topic}: type not found ({msg_type}); build its package first")
    return found
