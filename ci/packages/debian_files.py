"""Create control and changelog of the Debian source package.

``python3 ci packages.debian_files`` prints missing and superfluous keys of
packaging/dependencies.txt, and ends with status 1 if there are any.
``python3 ci packages.debian_files TREE SUITE DATE [SNAPSHOT]`` creates TREE/debian of an exported
workspace.
"""

import pathlib
import re
import shutil
import sys
import textwrap
from typing import Dict, Iterable, Iterator, List, NamedTuple, Set
from xml.etree import ElementTree

WORKSPACE = pathlib.Path(__file__).resolve().parents[2]

#: The release of each suite that has dh-ros.
RELEASES = {"bookworm": 12, "trixie": 13, "forky": 14}
#: Elements of package.xml with dependencies to run, to build, and to build dependents.
RUN = {"depend", "exec_depend"}
BUILD = {"depend", "build_depend", "buildtool_depend"}
EXPORT = {"depend", "build_export_depend", "buildtool_export_depend"}
#: Folders of a package that imply dependencies.
FOLDERS = ("launch/", "scripts/")
#: Most characters of a synopsis.
SYNOPSIS = 79


class Packages(NamedTuple):
    """Debian's packages behind a key."""

    run: List[str]
    build: List[str] = []
    useful: List[str] = []


#: Debian's packages by key.
Table = Dict[str, Packages]


class Manifest(NamedTuple):
    """The parts of a package.xml that are needed, and the folders beside it."""

    name: str
    version: str
    description: str
    maintainer: str
    elements: Dict[str, Set[str]]  # their texts by their names
    folders: Set[str]

    def keys(self, types: Iterable[str]) -> Set[str]:
        """Return the keys of these types of dependencies."""
        return {key for type_ in types for key in self.elements.get(type_, ())}

    def own_keys(self) -> Set[str]:
        """Return the lines of the table about this package itself."""
        return {self.name} | self.folders


def read_table(text: str) -> Table:
    """Return the table in packaging/dependencies.txt.

    :raises ValueError: for a malformed line
    """
    table: Table = {}
    for line in text.splitlines():
        line = line.partition("#")[0].strip()
        key, _, names = line.partition(":")
        columns = [column.split() for column in names.split("|")]
        if line and (not key or not names or len(columns) > 3 or key in table):
            raise ValueError(
                f"packaging/dependencies.txt: '{line}' must be 'key: run | build | useful', once"
            )
        if line:
            table[key] = Packages(*columns)
    return table


def read_manifests(sources: pathlib.Path) -> List[Manifest]:
    """Return the manifests of the packages of a workspace, sorted by name."""
    manifests = []
    for file in sorted(sources.glob("*/package.xml")):
        text: Dict[str, str] = {}
        elements: Dict[str, Set[str]] = {}
        for element in ElementTree.parse(str(file)).getroot():
            text[element.tag] = " ".join((element.text or "").split())
            elements.setdefault(element.tag, set()).add(text[element.tag])
            if element.tag == "maintainer":
                text["maintainer"] += f" <{element.get('email')}>"
        folders = {folder for folder in FOLDERS if (file.parent / folder).is_dir()}
        name, version, maintainer = text["name"], text["version"], text["maintainer"]
        description = text["description"]
        manifests.append(Manifest(name, version, description, maintainer, elements, folders))
    return manifests


def faults(manifests: List[Manifest], table: Table) -> Iterator[str]:
    """Return a message for each missing key, and each key that no package needs."""
    own = {manifest.name for manifest in manifests}
    used: Set[str] = set()
    for manifest in manifests:
        keys = manifest.keys(RUN | BUILD | EXPORT)
        used |= keys - own | manifest.own_keys()
        for key in sorted(keys - own - set(table)):
            yield f"src/{manifest.name}/package.xml: '{key}' is not in packaging/dependencies.txt"
    for key in sorted(set(table) - used):
        yield f"packaging/dependencies.txt: no package.xml names '{key}'"
    if len({(manifest.version, manifest.maintainer) for manifest in manifests}) > 1:
        yield "src/*/package.xml: all must have the same version and the same maintainer"


def debian_name(name: str) -> str:
    """Return the name of the Debian package of a catkin package."""
    return "ros-" + name.replace("_", "-")


def synopsis(description: str) -> str:
    """Return the beginning of a description in Debian's form: one line, no article or period."""
    clause = re.split(r"[.:;](?:\s|$)", description)[0]
    clause = re.sub(r"^(a|an|the)\s+", "", clause, flags=re.IGNORECASE)
    while len(clause) > SYNOPSIS and ", " in clause:
        clause = clause.rpartition(", ")[0]
    clause = textwrap.shorten(clause, SYNOPSIS, placeholder="")
    # Not if it is an abbreviation.
    return clause if clause[1:2].isupper() else clause[:1].lower() + clause[1:]


def field(name: str, values: Iterable[str]) -> str:
    """Return a field with one value per line; empty without values."""
    lines = ",\n ".join(values)
    return f"{name}:\n {lines}\n" if lines else ""


def binary_paragraph(manifest: Manifest, own: Set[str], table: Table) -> str:
    """Return the paragraph of the Debian package of a catkin package."""
    run, export = manifest.keys(RUN), manifest.keys(EXPORT)
    rows = [table[key] for key in (run - own) | manifest.own_keys() if key in table]
    depends = {name for row in rows for name in row.run}
    depends.update(f"{debian_name(key)} (= ${{binary:Version}})" for key in (run | export) & own)
    title = synopsis(manifest.description)
    text = [f"This is the package {manifest.name} of ROS 1."]
    if manifest.description.rstrip(".").lower() != title.lower():
        text = [*textwrap.wrap(manifest.description, 78, break_on_hyphens=False), ".", *text]
    return (
        f"Package: {debian_name(manifest.name)}\n"
        "Architecture: all\n"
        + field("Depends", ["${misc:Depends}", "${python3:Depends}", *sorted(depends)])
        + field("Recommends", sorted({name for row in rows for name in row.useful}))
        + field("Suggests", sorted({name for key in export - own for name in table[key].build}))
        + f"Description: {title}\n"
        + "".join(f" {line}\n" for line in text)
    )


def control(manifests: List[Manifest], table: Table) -> str:
    """Return debian/control."""
    own = {manifest.name for manifest in manifests}
    build = {"debhelper-compat (= 13)", "dh-python", "dh-ros", "python3"}
    for manifest in manifests:
        for key in manifest.keys(BUILD | EXPORT) - own:
            build.update(table[key].build)
    source = (
        "Source: ros-basic-comms\n"
        "Section: science\n"
        "Priority: optional\n"
        f"Maintainer: {manifests[0].maintainer}\n"
        + field("Build-Depends", sorted(build))
        + "Standards-Version: 4.6.2\n"
        "Rules-Requires-Root: no\n"
    )
    return "\n".join([source, *(binary_paragraph(each, own, table) for each in manifests)])


def version_of(released: str, is_release: bool, snapshot: str) -> str:
    """Return the version of a build, which apt considers newer than the previous release.

    :param released: version in the package.xml files
    :param is_release: whether the commit is the release of this version
    :param snapshot: date and abbreviation of the commit, such as ``20261127.abc1234``
    :returns: such as ``1.0.1~git20261127.abc1234`` for a commit after 1.0.0
    """
    if is_release:
        return released
    major, minor, patch = released.split(".")
    return f"{major}.{minor}.{int(patch) + 1}~git{snapshot}"


def is_release(tree: pathlib.Path) -> bool:
    """Return whether a tree is a release: no changelog has a section of future changes."""
    changelogs = tree.glob("src/*/CHANGELOG.rst")
    return not any(re.search("^Forthcoming$", log.read_text("utf-8"), re.M) for log in changelogs)


def make(tree: pathlib.Path, suite: str, date: str, snapshot: str = "") -> None:
    """Create the folder debian of an exported workspace.

    :param date: date of the commit, in RFC 5322 format
    :param snapshot: its date and abbreviation, for a commit between two versions
    """
    manifests = read_manifests(tree / "src")
    table = read_table((tree / "packaging" / "dependencies.txt").read_text("utf-8"))
    released, maintainer, release = manifests[0].version, manifests[0].maintainer, RELEASES[suite]
    version = version_of(released, is_release(tree), snapshot)
    target = tree / "debian"
    shutil.copytree(str(tree / "packaging" / "debian"), str(target))
    (target / "control").write_text(control(manifests, table), "utf-8")
    # The changes are in each package's CHANGELOG.rst.
    (target / "changelog").write_text(
        f"ros-basic-comms ({version}+deb{release}) {suite}; urgency=medium\n\n"
        f"  * Build {version} for Debian {release}.\n\n"
        f" -- {maintainer}  {date}\n",
        "utf-8",
    )


def all_faults() -> Iterator[str]:
    """Return a message for each fault of the workspace's own table."""
    table = read_table((WORKSPACE / "packaging" / "dependencies.txt").read_text("utf-8"))
    return faults(read_manifests(WORKSPACE / "src"), table)


if __name__ == "__main__":
    if sys.argv[1:]:
        make(pathlib.Path(sys.argv[1]), *sys.argv[2:])
    else:
        sys.exit("\n".join(all_faults()) or 0)
