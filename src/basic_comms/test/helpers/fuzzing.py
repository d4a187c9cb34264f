"""Seeded random invalid requests for a node's two ports.

Valid requests ``shutdown``, which ends a node, and ``publisherUpdate``, which connects it to
another publisher, are excluded: ROS 1 allows both to every client.
"""

import gzip
import random
import string
import xmlrpc.client
from typing import Any, Callable, List, Sequence

from rosgraph.network import encode_ros_handshake_header

_METHODS = (
    "getBusStats getBusInfo getMasterUri getPid getSubscriptions getPublications paramUpdate "
    "requestTopic system.multicall system.listMethods _shutdown __init__ handler.getPid"
).split()


class Fuzzer:
    """A source of odd requests.

    :param seed: of the sequence
    :param names: of topics, services and parameters, which some of the requests are about
    """

    def __init__(self, seed: int, names: Sequence[str]) -> None:
        self._random = random.Random(seed)
        self._names = names

    def http_request(self) -> bytes:
        """Generate requests for a node's XML-RPC port."""
        make = self._random.choice([self._noise, self._odd_call, self._broken_call, self._odd_http])
        return make()

    def tcpros_request(self) -> bytes:
        """Generate requests for the port of a node's topics and services."""
        make = self._random.choice([self._noise, self._odd_header, self._broken_header])
        return make()

    def _noise(self) -> bytes:
        return bytes(self._random.getrandbits(8) for _ in range(self._random.randrange(300)))

    def _name(self) -> str:
        return self._random.choice([*self._names, self._text()])

    def _text(self) -> str:
        alphabet = self._random.choice(
            [string.printable, "/~{}[]=&<>;'\"", "\u00e4\u4f60\U0001f600"]
        )
        length = self._random.choice([0, 1, 10, 500])
        return "".join(self._random.choice(alphabet) for _ in range(length))

    def _value(self, depth: int = 0) -> Any:
        """Return anything that XML-RPC can carry."""
        makers: List[Callable[[], Any]] = [
            lambda: None,
            lambda: self._random.random() < 0.5,
            lambda: self._random.choice([0, -1, 2**31 - 1, -(2**31)]),
            lambda: self._random.choice([0.0, -0.0, 5e-324, 1.8e308, float("nan"), float("inf")]),
            self._text,
            self._name,
            self._noise,
        ]
        if depth < 4:
            size = self._random.randrange(4)
            makers.append(lambda: [self._value(depth + 1) for _ in range(size)])
            makers.append(lambda: {self._text(): self._value(depth + 1) for _ in range(size)})
        return self._random.choice(makers)()

    def _call(self) -> bytes:
        arguments: Any = tuple(self._value() for _ in range(self._random.randrange(5)))
        if self._random.random() < 0.5:
            arguments = ("/fuzzer", self._name(), self._value())
        method = self._random.choice([*_METHODS, self._text()])
        return xmlrpc.client.dumps(arguments, method, allow_none=True).encode()

    def _odd_call(self) -> bytes:
        body = self._call()
        return self._post(body, f"Content-Length: {len(body)}")

    def _broken_call(self) -> bytes:
        body = self._mutated(self._call())
        return self._post(body, f"Content-Length: {len(body)}")

    def _odd_http(self) -> bytes:
        body = self._random.choice([self._call(), gzip.compress(bytes(100000)), self._noise()])
        headers = (
            "Content-Length: -1",
            "Content-Length: x",
            "Content-Length: 9999999999",
            "X: y",
            "Transfer-Encoding: chunked",
            f"Content-Encoding: gzip\r\nContent-Length: {len(body)}",
            f"Expect: 100-continue\r\nContent-Length: {len(body)}",
        )
        return self._mutated(self._post(body, self._random.choice(headers)))

    @staticmethod
    def _post(body: bytes, headers: str) -> bytes:
        return b"POST /RPC2 HTTP/1.1\r\nHost: node\r\n%s\r\n\r\n%s" % (headers.encode(), body)

    def _header(self) -> bytes:
        fields = {"callerid": "/fuzzer", "md5sum": "*", "type": "*"}
        fields[self._random.choice(["topic", "service", "nothing"])] = self._name()
        for name in "tcp_nodelay latching persistent probe message_definition md5sum type".split():
            if self._random.random() < 0.3:
                fields[name] = self._random.choice(["1", "", "*", self._text()])
        return bytes(encode_ros_handshake_header(fields))

    def _odd_header(self) -> bytes:
        return self._header() + self._noise()

    def _broken_header(self) -> bytes:
        return self._mutated(self._header())

    def _mutated(self, data: bytes) -> bytes:
        """Flip, cut, repeat or insert a few bytes."""
        changed = bytearray(data)
        for _ in range(self._random.randint(1, 4)):
            start = self._random.randrange(len(changed) + 1)
            end = start + self._random.randrange(20)
            patch = self._random.choice([b"", changed[start:end] * 2, self._noise()[:20]])
            changed[start:end] = patch
        return bytes(changed)
