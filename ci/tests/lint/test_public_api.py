"""Tests of the lint of nodekit's public modules, with every form of reference."""

import pytest

import nodekit
from ci.lint import public_api


@pytest.mark.parametrize(
    "text, room",
    [
        ("import nodekit.node.ros_node as node", "node"),
        ("from nodekit.node.ros_node import Node", "node"),
        ("from nodekit import managed", "managed"),
        ("from nodekit import Node, managed as m", "managed"),
        ("from nodekit import (\n    Node,\n    managed,\n)", "managed"),
        ("def late():\n    from nodekit.parameters import kinds", "parameters"),
        ("try:\n    import nodekit.transport.delivery\nexcept ImportError:\n    pass", "transport"),
        ("importlib.import_module('nodekit.commands.describe')", "commands"),
        ("Process('-m', ['nodekit.commands.describe', '/'])", "commands"),
        ("$ python3 -m nodekit.commands.describe /", "commands"),
        ("monkeypatch.setattr('nodekit.process.run.end', print)", "process"),
        ("import nodekit\nnodekit.parameters.kinds", "parameters"),
    ],
)
def test_private_modules_are_refused_in_every_form(text: str, room: str) -> None:
    assert [found for _, found in public_api.named(text)] == [room]


@pytest.mark.parametrize(
    "text",
    [
        "import nodekit",
        "from nodekit import Node, ParameterClient, run\n\nnode = Node",
        "from nodekit.entry_point import main",
        "import nodekit.master as master",
        "from nodekit import master, message_definitions",
        "from nodekit.testing.graph import Graph",
        "Process('-m', ['nodekit.testing.stepping_clock', 'basic_comms.nodes.talker'])",
        "import nodekit\nnodekit.run('talker', nodekit.Node), nodekit.__all__",
        "import nodekit_msgs.srv\nfrom nodekit_msgs.srv import SetParameters",
        "from .nodekit import node",
        ".. automodule:: nodekit.node.ros_node",
    ],
)
def test_public_modules_are_accepted(text: str) -> None:
    assert not list(public_api.named(text))


def test_line_is_that_of_the_room() -> None:
    assert list(public_api.named("a\nfrom nodekit import (\n    node,\n)\n")) == [(3, "node")]


def test_every_public_module_is_described() -> None:
    page = (public_api.WORKSPACE / "docs" / "api.md").read_text("utf-8")
    for module in public_api.PUBLIC:
        assert f"`nodekit.{module}`" in page, module
        assert f".. automodule:: nodekit.{module}" in page, module


def test_every_public_name_is_described() -> None:
    page = (public_api.WORKSPACE / "docs" / "api.md").read_text("utf-8")
    table = page.partition("## Public API")[2].partition("\n## ")[0]
    assert [name for name in nodekit.__all__ if f"`{name}`" not in table] == []
