"""Which pages something that has changed may have an effect on."""

import re
import subprocess
from pathlib import Path
from typing import Dict, Iterable, Mapping, Set

from console_blocks import instructions_of
from typist import lines_of


#: What has an effect on all pages.
_OF_ALL = ("ci/exec", "ci/setup/", "docs/tests/", "src/nodekit/src/nodekit/testing/")
_DEPENDENCY = re.compile(r"<\w*depend\b[^>]*>\s*(\w+)\s*</")


def commands_of(text: str) -> str:
    """Return all that a page tells its reader to type."""
    typed = [instruction.typed or "" for instruction in instructions_of(text)]
    return "\n".join(typed + [line.command for line in lines_of(text)])


def pages_to_type(
    pages: Mapping[str, str], changed: Iterable[str], depends_on: Mapping[str, Set[str]]
) -> Set[str]:
    """Return the pages that have changed, or that name a file or a package that has.

    A package has changed with any that it depends on.

    :param pages: text of each page by its path
    :param changed: paths of the files that have changed
    :param depends_on: names of the packages that each package depends on
    """
    files = set(changed)
    if any(file.startswith(_OF_ALL) for file in files):
        return set(pages)
    packages = {file.split("/")[1] for file in files if file.startswith("src/")}
    more = packages
    while more:
        more = {name for name, needs in depends_on.items() if needs & packages} - packages
        packages |= more
    examples = {file for file in files if file.startswith("docs/examples/")}
    return {
        page
        for page, text in pages.items()
        if page in files
        or packages & set(re.findall(r"\w+", commands_of(text)))
        or any(example in commands_of(text) for example in examples)
    }


def changed_files(workspace: Path, commit: str) -> Set[str]:
    """Return the files that differ from a commit, new ones included."""
    found: Set[str] = set()
    for command in (
        ["diff", "--name-only", commit],
        ["ls-files", "--others", "--exclude-standard"],
    ):
        output = subprocess.run(
            ["git", *command], cwd=str(workspace), stdout=subprocess.PIPE, check=True
        ).stdout
        found |= set(output.decode().splitlines())
    return found


def dependencies(workspace: Path) -> Dict[str, Set[str]]:
    """Return what each package of the workspace depends on, by the names in package.xml."""
    manifests = (workspace / "src").glob("*/package.xml")
    return {path.parent.name: set(_DEPENDENCY.findall(path.read_text())) for path in manifests}
