# Pure: knows no ROS.
"""Requests to check a formula, and to set or remove a mask (limits around a trace)."""

from typing import Any, Dict, NamedTuple, Optional, Tuple

from topic_scope.formulas.names import is_formula
from topic_scope.formulas.parser import SECONDS
from topic_scope.masks.mask_check import Mask
from topic_scope.protocol.checks import RequestError, field_in, fields_of, number_of


class FormulaText(NamedTuple):
    """Request to check a formula while it is typed.

    :param text: the text as typed
    :param traces: names that its letters denote
    """

    text: str
    traces: Tuple[str, ...]


def formula_text_of(request: Dict[str, Any]) -> FormulaText:
    """Return the formula to check."""
    text = request.get("text")
    if not isinstance(text, str) or not is_formula(text):
        raise RequestError("formula: the text must begin with =")
    return FormulaText(text, fields_of(request.get("traces")))


def mask_of(request: Dict[str, Any]) -> Optional[Mask]:
    """Return the requested mask; None to remove the mask."""
    if request.get("field") == "":
        return None
    mask = Mask(
        field_in(request, "mask"),
        field_in(request, "mask", "reference"),
        number_of(request, "mask", "value", 0.0, 1e300),
        number_of(request, "mask", "time", 0.0, SECONDS),
    )
    if mask.problem:
        raise RequestError(f"mask: {mask.problem}")
    return mask
