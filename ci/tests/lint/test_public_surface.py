"""The lint of nodekit's public surface sees every form in which a module can be named."""

import ast
from typing import List

import pytest

from ci.lint import front_door

NAMES = front_door.offered()


def refused(text: str) -> List[str]:
    named = front_door.named(ast.parse(text))
    return [name for _, name in named if not front_door.is_public(name, NAMES)]


@pytest.mark.parametrize(
    "text",
    [
        "import nodekit.node.node",
        "import nodekit.node.node as node",
        "from nodekit.node.node import Node",
        "from nodekit.node import node",
        "from nodekit import managed",
        "def late():\n    from nodekit.parameters import kinds",
        "try:\n    import nodekit.transport.link\nexcept ImportError:\n    pass",
        "importlib.import_module('nodekit.commands.describe')",
        "Process('-m', ['nodekit.commands.describe', '/'])",
        "main('nodekit.commands.host')",
        "monkeypatch.setattr('nodekit.process.run.end', print)",
        "import nodekit\nnodekit.parameters.kinds",
    ],
)
def test_what_is_inside_is_refused_in_every_form(text: str) -> None:
    assert refused(text)


@pytest.mark.parametrize(
    "text",
    [
        "import nodekit",
        "from nodekit import Node, ParameterClient, run",
        "from nodekit.entry_point import main",
        "import nodekit.master as master",
        "from nodekit import master, message_definitions",
        "from nodekit.testing.graph import Graph",
        "importlib.import_module('nodekit.master')",
        "Process('-m', ['nodekit.testing.stepping_clock', 'basic_comms.nodes.talker'])",
        "import nodekit\nnodekit.run('talker', nodekit.Node), nodekit.__all__",
        "import nodekit_msgs.srv\nfrom nodekit_msgs.srv import SetParameters",
        "raise ValueError('nodekit.node is not for you')",
        "from .nodekit import node",
    ],
)
def test_what_is_public_is_not(text: str) -> None:
    assert not refused(text)


@pytest.mark.parametrize(
    "line, found",
    [
        ("from nodekit.node.node import Node", ["nodekit.node.node"]),
        ("    import nodekit.transport.link", ["nodekit.transport.link"]),
        ("$ python3 -m nodekit.commands.describe /", ["nodekit.commands.describe"]),
        ("nodekit.node.node is a module", []),
    ],
)
def test_examples_in_texts_are_read(line: str, found: List[str]) -> None:
    assert [name for _, name in front_door.named_in_text(line)] == found


def test_nobody_reaches_past_it() -> None:
    assert list(front_door.breaches()) == []


def test_every_public_module_is_described() -> None:
    page = (front_door.WORKSPACE / "docs" / "api.md").read_text("utf-8")
    for module in front_door.PUBLIC:
        assert f"`{module}`" in page, module
        assert f".. automodule:: {module}" in page, module


def test_every_name_of_the_front_door_is_described() -> None:
    page = (front_door.WORKSPACE / "docs" / "api.md").read_text("utf-8")
    table = page.partition("## The front door")[2].partition("\n## ")[0]
    assert [name for name in NAMES if f"`{name}`" not in table] == []
