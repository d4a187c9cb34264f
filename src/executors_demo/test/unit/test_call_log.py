"""Lines of the call log, and their order."""

import threading
import time
from typing import List

import pytest
from executors_demo.call_log import CallLog
from executors_demo.events import read


def test_it_says_begin_and_end_with_number_thread_and_time() -> None:
    said: List[str] = []
    times = iter([10.0, 10.5, 12.0, 12.0, 12.25])
    call_log = CallLog(said.append, lambda: next(times))
    with call_log.call("timer1"):
        pass
    with call_log.call("timer1", "again\nand again"):
        pass
    thread = threading.current_thread().name
    assert said == [
        f"   0.500 s  {thread:<12}  timer1 #1 begins",
        f"   2.000 s  {thread:<12}  timer1 #1 ends",
        f"   2.000 s  {thread:<12}  timer1 #2 begins: again and again",
        f"   2.250 s  {thread:<12}  timer1 #2 ends",
    ]


def test_it_says_the_end_of_a_call_that_fails() -> None:
    said: List[str] = []
    with pytest.raises(KeyError):
        with CallLog(said.append).call("timer1"):
            raise KeyError
    assert said[-1].endswith("timer1 #1 ends")


def test_log_lines_of_threads_are_complete_and_ordered() -> None:
    said: List[str] = []
    inside = threading.Lock()

    def say(line: str) -> None:
        assert inside.acquire(False), "two at once"
        time.sleep(0.0005)  # so that others come meanwhile
        said.append(line)
        inside.release()

    call_log = CallLog(say)

    def work() -> None:
        for _ in range(10):
            with call_log.call("job"):
                pass

    threads = [threading.Thread(target=work, name=f"thread{number}") for number in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    events = list(read(said))
    assert [event.time for event in events] == sorted(event.time for event in events)
    assert sorted(event.number for event in events if event.begins) == list(range(1, 81))
