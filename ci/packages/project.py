"""Bring what packaging/project.yaml says into the files that repeat it.

``python3 ci packages.project`` prints which files say something else, and ends with status 1 if
there is one.
``python3 ci packages.project --write`` changes them.
"""

import pathlib
import re
import sys
from typing import Dict, Iterator, List, Tuple
from xml.sax.saxutils import escape, quoteattr

import yaml

WORKSPACE = pathlib.Path(__file__).resolve().parents[2]

#: The keys of the file that are URLs of REP 149 in a package.xml.
URLS = ("website", "repository", "bugtracker")
KEYS = ("maintainer", "email", "security", *URLS)
#: The top-level domain that cannot exist, as RFC 2606 reserves it.
PLACEHOLDER = re.compile(r"\.invalid\b")
#: Where other package.xml files are, or are made, which name the maintainer.
OTHERS = (
    "ci/benchmark/peers/course/package.xml",
    "docs/examples/package.xml",
    "src/ros2_bridge/src/ros2_bridge/types/twins.py",
)

_MAINTAINER = re.compile(r"<maintainer .*?</maintainer>")
_LICENSE_AND_URLS = re.compile(r"(  <license .*</license>\n)(?:  <url .*</url>\n)*")
_CONTACT = re.compile(r"^Report it to .*\n(?:.+\n)*", re.MULTILINE)

#: What the file says, by its keys.
Project = Dict[str, str]


def read(workspace: pathlib.Path) -> Project:
    """Return what packaging/project.yaml of a workspace says.

    :raises ValueError: a key is missing, or unknown, or has no text
    """
    project = yaml.safe_load((workspace / "packaging" / "project.yaml").read_text("utf-8"))
    if not isinstance(project, dict) or sorted(project) != sorted(KEYS):
        raise ValueError(f"packaging/project.yaml: must have the keys {', '.join(KEYS)}")
    for key, value in project.items():
        if not isinstance(value, str) or not value.strip():
            raise ValueError(f"packaging/project.yaml: {key} must be a text")
    return project


def placeholders(project: Project) -> List[str]:
    """Return the keys for which the owner has not filled in anything."""
    return [key for key in KEYS if PLACEHOLDER.search(project[key])]


def with_maintainer(text: str, project: Project) -> str:
    """Return a text with another maintainer in its package.xml."""
    address = quoteattr(project["email"])
    element = f"<maintainer email={address}>{escape(project['maintainer'])}</maintainer>"
    return _MAINTAINER.sub(lambda _: element, text)


def with_urls(manifest: str, project: Project) -> str:
    """Return a package.xml with the project's URLs, after its licence."""
    urls = "".join(f'  <url type="{kind}">{escape(project[kind])}</url>\n' for kind in URLS)
    return _LICENSE_AND_URLS.sub(lambda found: found.group(1) + urls, manifest, count=1)


def with_contact(page: str, project: Project) -> str:
    """Return SECURITY.md with the address for reports, or with the words that there is none yet."""
    paragraph = f"Report it to {project['security']}.\n"
    if "security" in placeholders(project):
        paragraph += (
            "**There is no such address yet: the owner of this repository has to fill it in**,"
            " in\n[packaging/project.yaml](packaging/project.yaml).\n"
        )
    return _CONTACT.sub(lambda _: paragraph, page)


def written(workspace: pathlib.Path, project: Project) -> Iterator[Tuple[pathlib.Path, str]]:
    """Yield each file that repeats what the project says, and its text as it has to be."""
    for manifest in sorted(workspace.glob("src/*/package.xml")):
        text = with_maintainer(manifest.read_text("utf-8"), project)
        yield manifest, with_urls(text, project)
    for name in OTHERS:
        yield workspace / name, with_maintainer((workspace / name).read_text("utf-8"), project)
    page = workspace / "SECURITY.md"
    yield page, with_contact(page.read_text("utf-8"), project)


def main(arguments: List[str]) -> int:
    """Print what differs, or write it.

    :returns: exit status
    """
    try:
        project = read(WORKSPACE)
    except ValueError as error:
        print(error)
        return 1
    different = [
        (path, text)
        for path, text in written(WORKSPACE, project)
        if path.read_text("utf-8") != text
    ]
    for path, text in different:
        print(f"{path.relative_to(WORKSPACE)}: differs from packaging/project.yaml")
        if arguments == ["--write"]:
            path.write_text(text, "utf-8")
    return 1 if different and arguments != ["--write"] else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
