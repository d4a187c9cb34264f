"""Copy the values of packaging/project.yaml into the files that repeat them.

``python3 ci packages.project`` prints the changed files.
"""

import pathlib
import re
import sys
from typing import Dict, Iterator, List, Tuple
from xml.sax.saxutils import escape, quoteattr

import yaml

WORKSPACE = pathlib.Path(__file__).resolve().parents[2]

#: Keys of the URLs in a package.xml, see REP 149.
URLS = ("website", "repository", "bugtracker")
KEYS = ("maintainer", "email", "security", *URLS)
#: Top-level domain that RFC 2606 reserves as invalid.
PLACEHOLDER = re.compile(r"\.invalid\b")
#: Other package.xml files, or templates of them, that name the maintainer.
OTHERS = (
    "ci/benchmark/peers/course/package.xml",
    "docs/examples/package.xml",
    "src/ros2_bridge/src/ros2_bridge/types/ros2_interfaces.py",
)
MISSING = """\
**There is no such address yet: the owner of this repository has to fill it in**, in
[packaging/project.yaml](packaging/project.yaml).
"""

#: Values of the file, by key.
Project = Dict[str, str]


def read(workspace: pathlib.Path) -> Project:
    """Return the values of packaging/project.yaml of a workspace.

    :raises ValueError: if a key is missing or unknown, or its value is not text
    """
    project = yaml.safe_load((workspace / "packaging" / "project.yaml").read_text("utf-8"))
    if not isinstance(project, dict) or sorted(project) != sorted(KEYS):
        raise ValueError(f"packaging/project.yaml: must have the keys {', '.join(KEYS)}")
    for key, value in project.items():
        if not isinstance(value, str) or not value.strip():
            raise ValueError(f"packaging/project.yaml: {key} must be a text")
    return project


def placeholders(project: Project) -> List[str]:
    """Return the keys that still have placeholders."""
    return [key for key in KEYS if PLACEHOLDER.search(project[key])]


def written(workspace: pathlib.Path, project: Project) -> Iterator[Tuple[pathlib.Path, str]]:
    """Yield each file that repeats the values, and its updated text."""
    name, address = escape(project["maintainer"]), quoteattr(project["email"])
    maintainer = f"<maintainer email={address}>{name}</maintainer>"
    urls = "".join(f'  <url type="{kind}">{escape(project[kind])}</url>\n' for kind in URLS)
    manifests = sorted(workspace.glob("src/*/package.xml"))
    for path in [*manifests, *(workspace / other for other in OTHERS)]:
        text = re.sub(
            r"<maintainer .*?</maintainer>", lambda _: maintainer, path.read_text("utf-8")
        )
        if path in manifests:
            text = re.sub(r"  <url .*</url>\n", "", text)
            text = re.sub(r"  <license .*\n", lambda found: found.group() + urls, text, count=1)
        yield path, text
    page = workspace / "SECURITY.md"
    contact = f"Report it to {project['security']}.\n"
    contact += MISSING if "security" in placeholders(project) else ""
    pattern = re.compile(r"^Report it to .*\n(?:.+\n)*", re.MULTILINE)
    yield page, pattern.sub(lambda _: contact, page.read_text("utf-8"))


def main() -> None:
    """Write the files that differ, and print their names."""
    try:
        project = read(WORKSPACE)
    except ValueError as error:
        sys.exit(str(error))
    for path, text in written(WORKSPACE, project):
        if path.read_text("utf-8") != text:
            path.write_text(text, "utf-8")
            print(f"{path.relative_to(WORKSPACE)}: changed")


if __name__ == "__main__":
    main()
