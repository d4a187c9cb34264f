"""Statistics printed on the terminal for the named fields."""

from typing import List, Optional

import pytest

from topic_scope.page.statistics_table import warn_of


class Recorder:
    """Knows what is wrong with one field."""

    def problem(self, name: str) -> Optional[str]:
        return "there is no such topic yet" if name == "/b" else None


def test_what_is_wrong_and_what_is_left_out_is_said(monkeypatch: "pytest.MonkeyPatch") -> None:
    said: List[str] = []
    monkeypatch.setattr("rospy.logwarn", said.append)
    recorder: "Recorder" = Recorder()
    warn_of(recorder, ["/a", "/b"], 2)  # type: ignore[arg-type]
    assert said == ["/b: there is no such topic yet"]
    said.clear()
    warn_of(recorder, ["/a", "/a", "/b"], 2)  # type: ignore[arg-type]
    assert said == ["a page shows at most 2 traces: the rest of 3 are left out"]
