"""Check of the promises: a removal or a change breaks one, an addition does not."""

import copy
import pathlib
from typing import Any, Dict, List

import pytest
from helpers import promises

PROMISED: Dict[str, Any] = {
    "messages": {"a_msgs/One": "abc"},
    "nodes": {"a.nodes.talk": {"name": "talk", "publishes": {"chatter": "std_msgs/String"}}},
    "executables": {"a": ["listen", "talk"]},
}


def found() -> Dict[str, Any]:
    """As much as is promised, and more."""
    table = copy.deepcopy(PROMISED)
    table["messages"]["a_msgs/Two"] = "def"
    table["nodes"]["a.nodes.talk"]["publishes"]["more"] = "std_msgs/String"
    table["executables"]["a"].append("add")
    return table


def test_additions_break_no_promise() -> None:
    assert list(promises.broken(PROMISED, found())) == []


@pytest.mark.parametrize(
    "path, value, sentence",
    [
        (["messages", "a_msgs/One"], "ab", "messages/a_msgs/One is promised as abc, and is ab"),
        (["nodes", "a.nodes.talk", "name"], "say", "talk/name is promised as talk, and is say"),
        (["nodes", "a.nodes.talk", "publishes"], {}, "publishes/chatter is promised, and is gone"),
        (["executables", "a"], ["listen"], "executables/a/talk is promised, and is gone"),
        (["executables"], {}, "executables/a is promised, and is gone"),
    ],
)
def test_removals_and_changes_are_reported(path: List[str], value: Any, sentence: str) -> None:
    table = found()
    place = table
    for name in path[:-1]:
        place = place[name]
    place[path[-1]] = value
    (told,) = promises.broken(PROMISED, table)
    assert told.endswith(sentence)


def test_additions_are_added_to_promises(tmp_path: pathlib.Path) -> None:
    changed = found()
    changed["messages"]["a_msgs/One"] = "other"
    del changed["nodes"]
    both = promises.merged(PROMISED, changed)
    assert list(promises.broken(PROMISED, both)) == []
    assert both["messages"] == {"a_msgs/One": "abc", "a_msgs/Two": "def"}
    assert both["executables"]["a"] == ["add", "listen", "talk"]
    file = tmp_path / "table.yaml"
    promises.write(both, file)
    assert promises.read(file) == both
    assert file.read_text().startswith("# What is kept")
