"""The kind of parameter that holds bytes, such as a key or an address."""

from typing import Any

from nodekit.parameters.kinds import Parameter


class BytesParameter(Parameter[bytes]):
    """Bytes, on the server as a list of numbers from 0 to 255.

    ``!!binary`` in YAML and ``binfile=`` in a launch file are taken, too, and such a list is
    written back: ``rosparam get`` and ``dump`` fail where there is anything binary.

    :param max_length: largest allowed number of bytes
    """

    type_name = "bytes"

    def __init__(
        self, default: bytes, *, max_length: int = 1000, unit: str = "", help: str
    ) -> None:
        super().__init__(default, unit=unit, help=help)
        self.max_length = max_length

    @property
    def allowed(self) -> str:
        return f"at most {self.max_length} bytes, as a list of numbers from 0 to 255"

    @property
    def range(self) -> str:
        return f"at most {self.max_length} bytes"

    def coerce(self, raw: Any) -> bytes:
        value = getattr(raw, "data", raw)  # XML-RPC delivers what is binary wrapped
        if isinstance(value, (list, tuple)) and all(type(number) is int for number in value):
            try:
                value = bytes(value)
            except ValueError:
                pass  # a number that is no byte
        if not isinstance(value, bytes) or len(value) > self.max_length:
            raise self.refuse(raw)
        return value
