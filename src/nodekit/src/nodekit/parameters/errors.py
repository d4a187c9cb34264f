"""Errors about several parameters: values that do not go together, and all that is refused."""

from typing import Any, List, Sequence, Tuple

from nodekit.parameters.parameter_types import ParameterError, format_value


class RuleError(ParameterError):
    """Values that are each allowed but do not go together.

    :param names: names of the parameters
    :param values: their values, in the same order
    :param allowed: what must hold, a clause of its own
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
    """Several errors in one, so that all of them can be mended at once.

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
    """Raise what is refused, if anything is: one error as itself, several as one.

    A rule that is broken while one of its values is refused for itself says
    nothing of its own, and is left out.

    :param errors: the errors
    :raises ParameterError: if there are any
    """
    alone = {error.name for error in errors if not isinstance(error, RuleError)}
    errors = [e for e in errors if not isinstance(e, RuleError) or alone.isdisjoint(e.names)]
    if errors:
        raise errors[0] if len(errors) == 1 else ParameterErrors(errors)
