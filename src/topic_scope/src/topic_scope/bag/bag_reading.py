"""Read the messages of a bag, and say in words what is wrong with one."""

import os
from typing import Any, Dict, Iterator, List, NamedTuple, Optional

import genpy
import rosbag

_MAGIC = b"#ROSBAG V"


class BagError(Exception):
    """A bag that cannot be read; the text is for its owner."""


class Sample(NamedTuple):
    """A message.

    :param time: when it was recorded, since the begin of the bag, ns
    :param topic: global name of its topic
    :param message: the message
    """

    time: int
    topic: str
    message: Any


class BagReader:
    """An open bag; to be used in a ``with`` statement.

    :param path: the file
    :raises BagError: if it cannot be read, or holds nothing
    """

    def __init__(self, path: str) -> None:
        self._path = path
        # Some programs record names that are relative.
        self._recorded: Dict[str, List[str]] = {}
        #: Of the messages of each topic read so far.
        self._checksums: Dict[str, str] = {}
        look_at_begin(path)
        try:
            self._bag = rosbag.Bag(path)
            # Those without messages rosbag leaves out.
            for name in self._bag.get_type_and_topic_info().topics:
                self._recorded.setdefault("/" + name.lstrip("/"), []).append(name)
            if not self._recorded:
                raise BagError(f"{path} holds no messages")
            _, _, self._begin = next(self._bag.read_messages(raw=True))
            end = round(self._bag.get_end_time() * 1e9)
        except rosbag.ROSBagUnindexedException as error:
            raise without_index(path) from error
        except BagError:
            raise
        except Exception as error:  # broken bytes make rosbag raise errors of any kind
            raise broken(path, error) from error
        #: From the first message to the last, ns; rosbag tells it to a microsecond only.
        self.length: int = max(0, end - self._begin.to_nsec())

    def __enter__(self) -> "BagReader":
        return self

    def __exit__(self, *_error: object) -> None:
        self._bag.close()

    @property
    def topics(self) -> List[str]:
        """Global names of the topics, sorted."""
        return sorted(self._recorded)

    def count(self, topics: List[str]) -> int:
        """Return how many messages topics have.

        :param topics: global names
        """
        return int(self._bag.get_message_count(self._names(topics)))

    def first_message(self, topic: str) -> Any:
        """Return the first message of a topic.

        :param topic: global name
        :raises BagError: if it cannot be read
        """
        return next(self.samples([topic])).message

    def samples(
        self, topics: List[str], start: int = 0, end: Optional[int] = None
    ) -> Iterator[Sample]:
        """Read the messages of some topics, in the order of their times.

        :param topics: global names
        :param start: time of the first one, since the begin of the bag, ns
        :param end: time of the last one; None for the end of the bag
        :raises BagError: if a part of the bag is broken, or a topic changes its type
        """
        messages = self._bag.read_messages(
            self._names(topics),
            start_time=self._time(start),
            end_time=None if end is None else self._time(end),
        )
        begin = self._begin.to_nsec()
        while True:
            try:
                topic, message, time = next(messages)
            except StopIteration:
                return
            except Exception as error:  # broken bytes make rosbag raise errors of any kind
                raise broken(self._path, error) from error
            topic = "/" + topic.lstrip("/")
            if self._checksums.setdefault(topic, message._md5sum) != message._md5sum:
                raise BagError(f"{self._path}: the messages of {topic} change their type")
            yield Sample(time.to_nsec() - begin, topic, message)

    def _names(self, topics: List[str]) -> List[str]:
        return [name for topic in topics for name in self._recorded[topic]]

    def _time(self, since_begin: int) -> genpy.Time:
        return genpy.Time(0, self._begin.to_nsec() + since_begin)


def look_at_begin(path: str) -> None:
    """Check that a file begins as bags do.

    :raises BagError: if it does not, or cannot be read
    """
    try:
        with open(path, "rb") as file:
            begin = file.read(len(_MAGIC))
    except OSError as error:
        raise BagError(f"{path}: {os.strerror(error.errno or 0)}") from error
    if begin != _MAGIC:
        raise BagError(f"{path} is no bag")


def without_index(path: str) -> BagError:
    """Return what is to be said of a bag that has no index."""
    return BagError(
        f"{path} has no index, as its recording was cut off; make one: rosbag reindex {path}"
    )


def broken(path: str, error: Exception) -> BagError:
    """Return what is to be said of a bag that is broken.

    :param error: what has shown it
    """
    reason = str(error) or type(error).__name__
    text = "%s is broken (%s); what can be saved of it, this saves: rosbag reindex %s"
    return BagError(text % (path, reason, path))
