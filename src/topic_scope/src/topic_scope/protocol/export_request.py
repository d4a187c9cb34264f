"""Request for a CSV file, in the form of a URL that can be copied."""

from typing import Any, Dict, NamedTuple, Tuple

from topic_scope.formulas.names import problem_of
from topic_scope.protocol.checks import RequestError, fields_of, time_of


class Export(NamedTuple):
    """Samples to write to a CSV file.

    :param fields: names of the fields
    :param start: start of the time span [s] since the epoch
    :param end: its end [s]
    """

    fields: Tuple[str, ...]
    start: float
    end: float


def export_of(request: Dict[str, Any]) -> Export:
    """Return the samples to write.

    :param request: ``fields``, and optionally ``start`` and ``end``, strings as in a URL
    :raises RequestError: if a time or the names of all fields are invalid
    """
    fields = fields_of(request.get("fields"))
    problems = [problem_of(name) for name in fields]
    if problems and all(problems):  # among valid names, an invalid name has an empty column
        raise RequestError(f"fields: {problems[0]}")
    start, end = time_of(request.get("start", "0")), time_of(request.get("end", "1e11"))
    return Export(fields, start, end)
