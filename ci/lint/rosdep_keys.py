"""Check that each key in each package.xml is one that rosdep has a Debian package for.

``python3 ci lint.rosdep_keys`` prints each unknown key and ends with status 1 if there is one.
``python3 ci lint.rosdep_keys FILE.yaml…`` prints the keys of rosdep's own files instead, as
``ci/rosdep-keys.txt`` lists them.
"""

import pathlib
import sys
from typing import Any, Iterator, List, Set
from xml.etree import ElementTree

import yaml

WORKSPACE = pathlib.Path(__file__).resolve().parents[2]
KEYS = WORKSPACE / "ci" / "rosdep-keys.txt"

#: Keys that may enclose the packages in a rule for Debian.
STEPS = ("*", "bookworm", "trixie", "apt", "packages")


def listed(file: pathlib.Path) -> Set[str]:
    """Return the keys in a list with comments."""
    lines = (line.partition("#")[0].strip() for line in file.read_text("utf-8").splitlines())
    return {line for line in lines if line}


def unknown(sources: pathlib.Path, known: Set[str]) -> Iterator[str]:
    """Return a message for each key that is neither known nor a package of the workspace."""
    manifests = sorted(sources.glob("*/package.xml"))
    own = {manifest.parent.name for manifest in manifests}
    for manifest in manifests:
        for element in ElementTree.parse(str(manifest)).getroot():
            key = (element.text or "").strip()
            # depend, build_depend, … but not group_depend, which names no package.
            if element.tag.endswith("depend") and element.tag != "group_depend":
                if key not in known | own:
                    yield (
                        f"{manifest.relative_to(sources.parent)}: {element.tag} '{key}' is "
                        "not a key in ci/rosdep-keys.txt"
                    )


def has_package(rule: Any) -> bool:
    """Return whether a rosdep rule for Debian names a package."""
    if isinstance(rule, dict):
        return any(has_package(rule.get(step)) for step in STEPS)
    return bool(rule)


def keys_of(files: List[str]) -> List[str]:
    """Return the keys of rosdep's files that have a package, except those of Python 2."""
    keys: Set[str] = set()
    for file in files:
        rules = yaml.safe_load(pathlib.Path(file).read_text("utf-8"))
        keys.update(key for key, rule in rules.items() if has_package(rule.get("debian")))
    return sorted(key for key in keys if not key.startswith("python-"))


if __name__ == "__main__":
    if sys.argv[1:]:
        print("\n".join(keys_of(sys.argv[1:])))
    else:
        sys.exit("\n".join(unknown(WORKSPACE / "src", listed(KEYS))) or 0)
