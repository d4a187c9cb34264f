"""Jobs that may block, each in a thread."""

import threading
from typing import Any, Callable, List

from nodekit.testing.waiting import wait_until
from topic_scope.graph import worker
from topic_scope.graph.worker import Worker


def test_subject_has_one_job_at_a_time_and_its_result_may_start_the_next() -> None:
    results: List[Any] = []
    delivered: List[Callable[[], None]] = []
    work, ended = Worker(delivered.append), threading.Event()

    def fail() -> None:
        ended.wait(30.0)
        raise ValueError("no answer")

    def then(result: Any) -> None:
        results.append(str(result))
        assert work.run("a", lambda: "again", results.append)

    assert work.run("a", fail, then) and work.is_busy("a")
    assert not work.run("a", fail, then)
    assert work.run("b", lambda: 1, results.append)  # another subject does not wait
    wait_until(lambda: len(delivered) == 1, lambda: "the second job does not end")
    ended.set()
    wait_until(lambda: len(delivered) == 2, lambda: "the first job does not end")
    for deliver in delivered[:]:
        deliver()
    wait_until(lambda: len(delivered) == 3, lambda: "the third job does not end")
    delivered[2]()
    assert results == [1, "no answer", "again"] and not work.is_busy("a")


def test_number_of_jobs_is_limited(monkeypatch: Any) -> None:
    monkeypatch.setattr(worker, "LIMIT", 2)
    work = Worker(lambda _function: None)  # no job ever ends
    assert [work.run(subject, lambda: None, print) for subject in "abc"] == [True, True, False]
