"""Write the tables of the pages from the lists of the lint and the package.xml files.

``python3 ci lint.tables`` replaces the lines between the comments of each table.
"""

from typing import Dict, Sequence, Set
from xml.etree import ElementTree

from .code_rules import INDEPENDENT, PURE, ROOMS, SIBLINGS, SOURCES
from .structure import PAGE, SUBJECTS

DOCS = SOURCES.parent / "docs"
PAGES = (DOCS / "design.md", DOCS / "tutorials" / "other_packages.md")
#: A user's purpose, and the package for it.
WANTED = {
    "live parameters, timers, nodes that own what they create": "nodekit",
    "the course's nodes and signals too": "basic_comms",
    "the plant or the motors": "motor_control",
}


def needed(package: str) -> Set[str]:
    """Return a package and its dependencies in the workspace, except those of its tests."""
    found = {package}
    for element in ElementTree.parse(str(SOURCES / package / "package.xml")).getroot():
        name = (element.text or "").strip()
        if element.tag.endswith("depend") and element.tag != "test_depend":
            if (SOURCES / name / "package.xml").exists():
                found |= needed(name)
    return found


def rooms_in_order(package: str) -> str:
    """Return the folders of a package as text, with marks of pure and independent ones."""
    names = [
        f"`{room}`" + (" (pure)" if f"{package}.{room}" in PURE else "") for room in ROOMS[package]
    ]
    pairs = [
        " and ".join(f"`{room}`" for room in sorted(group))
        for group in INDEPENDENT.get(package, ())
    ]
    return ", ".join(names) + "".join(f"; {pair} are independent" for pair in pairs)


def table(*rows: Sequence[str]) -> str:
    """Return a table in Markdown; the first row is the heading."""
    lines = ["| " + " | ".join(cells).rstrip() + " |" for cells in rows]
    return "\n".join([lines[0], "|" + "---|" * len(rows[0]), *lines[1:]])


def subjects(name: str, package: str, rooms: Dict[str, str]) -> str:
    """Return the table of the folders of a package, or of the page, with their subjects."""
    rows = [
        (f"`{room}`", text + (". Pure" if f"{package}.{room}" in PURE else ""))
        for room, text in rooms.items()
    ]
    return table((f"module of {name}", "subject"), *rows)


def tables() -> Dict[str, str]:
    """Return each table by its name."""
    packages = [(name, allowed, why) for name, (allowed, why) in SIBLINGS.items()]
    small = [name for name, rooms in ROOMS.items() if name not in SUBJECTS and len(rooms) > 1]
    copied = [(what, ", ".join(sorted(needed(package)))) for what, package in WANTED.items()]
    return {
        "packages": table(("package", "its code may import", "why"), *packages),
        **{f"rooms of {name}": subjects(name, name, rooms) for name, rooms in SUBJECTS.items()},
        "rooms of the page": subjects("the page", "", PAGE),
        "rooms": table(
            ("other packages", "modules in import order"),
            *((name, rooms_in_order(name)) for name in small),
        ),
        "copied packages": table(("you want", "copy"), *copied),
    }


def with_tables(text: str) -> str:
    """Return a page with up-to-date tables."""
    for name, rows in tables().items():
        before, begin, rest = text.partition(f"% Table, by lint.tables: {name}\n")
        if begin:
            _, end, after = rest.partition("% End of table\n")
            text = f"{before}{begin}\n{rows}\n\n{end}{after}"
    return text


if __name__ == "__main__":
    for page in PAGES:
        page.write_text(with_tables(page.read_text("utf-8")), "utf-8")
