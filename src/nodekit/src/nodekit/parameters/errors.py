"""Errors about several parameters: inconsistent values, and lists of errors."""

from typing import Any, List, Sequence, Tuple

from nodekit.parameters.parameter_types import ParameterError, format_value


class RuleError(ParameterError):
    """Error of values that are allowed individually but inconsistent.

    :param names: names of the parameters
    :param values: their values, in the same order
    :param allowed: condition that must hold, as a clause
    """

    def __init__(self, names: Sequence[str], values: Sequence[Any], allowed: str) -> None:
        super().__init__(", ".join(names), list(values), allowed)
        self._names = tuple(names)

    @property
    def names(self) -> Tuple[str, ...]:
        return self._names

    def in_namespace(self, namespace: str) -> "RuleError":
        names = [f"{namespace}/{name}" for name in self.names]
        return RuleError(names, self.value, self.allowed)

    def __str__(self) -> str:
        noun = "parameters" if len(self.names) > 1 else "parameter"
        values = ", ".join(map(format_value, self.value))
        return f"{noun} {self.name}: refused {values}: {self.allowed}"


class ParameterErrors(ParameterError):
    """Several errors in one, so that a user can correct all of them at once.

    :param errors: the errors
    """

    def __init__(self, errors: Sequence[ParameterError]) -> None:
        super().__init__(", ".join(error.name for error in errors), None, "")
        self.errors: List[ParameterError] = list(errors)

    @property
    def names(self) -> Tuple[str, ...]:
        return tuple(name for error in self.errors for name in error.names)

    def in_namespace(self, namespace: str) -> "ParameterErrors":
        return ParameterErrors([error.in_namespace(namespace) for error in self.errors])

    def __str__(self) -> str:
        return "; ".join(map(str, self.errors))


def raise_all(errors: Sequence[ParameterError]) -> None:
    """Raise errors, if there are any: one error unchanged, several as one.

    A broken rule is omitted if one of its values is rejected individually.

    :param errors: the errors
    :raises ParameterError: if the list is not empty
    """
    alone = {error.name for error in errors if not isinstance(error, RuleError)}
    errors = [e for e in errors if not isinstance(e, RuleError) or alone.isdisjoint(e.names)]
    if errors:
        raise errors[0] if len(errors) == 1 else ParameterErrors(errors)
