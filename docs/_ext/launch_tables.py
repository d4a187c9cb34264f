"""Directives that document launch files from their own comments and arguments.

``{launch-file} FILE`` shows the comment at the top of a launch file and a table
of its args with their own ``doc=``; ``{launch-args} FILE`` shows the table
alone; ``{launch-index} FOLDER`` lists the files of a folder with their comments.
"""

import inspect
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import Any, Dict, List, NamedTuple

from docutils import nodes
from sphinx.util.docutils import SphinxDirective
from .tables import paragraph, table

HEADERS = ["Argument", "Default", "What it is"]


class LaunchFile(NamedTuple):
    """The documentation in a launch file.

    :param comment: the comment at its top
    :param rows: name, default and doc of each arg that can be set
    """

    comment: str
    rows: List[List[str]]


def read(path: Path) -> LaunchFile:
    """Read a launch file.

    :param path: the file
    :raises ValueError: if it has no comment at the top or an arg has no doc
    """
    parser = ElementTree.XMLParser(target=ElementTree.TreeBuilder(insert_comments=True))
    root = ElementTree.parse(path, parser).getroot()
    if not len(root) or root[0].tag is not ElementTree.Comment:
        raise ValueError(f"{path} has no comment at its top")
    rows = []
    for arg in root.iter("arg"):
        if arg not in list(root) or "value" in arg.attrib:
            continue  # handed on to an included file, or a constant
        if "doc" not in arg.attrib:
            raise ValueError(f"{path}: arg {arg.get('name')} has no doc")
        default = f"`{arg.get('default')}`" if "default" in arg.attrib else "required"
        rows.append([f"`{arg.get('name')}`", default, arg.get("doc", "")])
    return LaunchFile(inspect.cleandoc(root[0].text or ""), rows)


class LaunchArgs(SphinxDirective):
    """The args of one launch file."""

    required_arguments = 1

    def run(self) -> List[nodes.Node]:
        return [table(HEADERS, self.read().rows)]

    def read(self) -> LaunchFile:
        """Read the file that the directive names."""
        return self.read_path(Path(self.config.launch_tables_folder, self.arguments[0]))

    def read_path(self, path: Path) -> LaunchFile:
        """Read a file that the page depends on."""
        self.env.note_dependency(str(path))
        try:
            return read(path)
        except (OSError, ValueError, ElementTree.ParseError) as error:
            raise self.error(str(error))


class LaunchFileTable(LaunchArgs):
    """Purpose and arguments of one launch file."""

    def run(self) -> List[nodes.Node]:
        told = self.read()
        what = paragraph(_one_line(told.comment))
        return [what] + super().run() if told.rows else [what]


class LaunchIndex(LaunchArgs):
    """All launch files of a folder, by name."""

    def run(self) -> List[nodes.Node]:
        folder = Path(self.config.launch_tables_folder, self.arguments[0])
        files = sorted(folder.glob("*.launch"))
        if not files:
            raise self.error(f"no launch files in {folder}")
        rows = [[f"`{path.name}`", _one_line(self.read_path(path).comment)] for path in files]
        return [table(["File", "What it shows"], rows)]


def _one_line(comment: str) -> str:
    return " ".join(comment.split())


def setup(app: Any) -> Dict[str, bool]:
    """Register the directives with Sphinx."""
    app.add_config_value("launch_tables_folder", "", "env")
    app.add_directive("launch-args", LaunchArgs)
    app.add_directive("launch-file", LaunchFileTable)
    app.add_directive("launch-index", LaunchIndex)
    return {"parallel_read_safe": True}
