"""Whether a node waits until others configure and activate it."""

import importlib
from typing import Any, Callable

from nodekit.node.node import Node
from nodekit.node.own_parameters import OwnParameters
from nodekit.parameters.kinds import ParameterError

#: A node's class, or a function that makes its object.
NodeClass = Callable[[Node], object]


def as_wanted(cls: NodeClass, node: str, held: Any) -> NodeClass:
    """Return a node's class, or that of a managed node which makes it at configure.

    :param cls: the class
    :param node: global name of the node
    :param held: the raw value of its private parameters; ``managed`` of them says which
    :raises ParameterError: if that is no truth value
    """
    known = OwnParameters.declared
    given = {name: held[name] for name in known if name in held} if isinstance(held, dict) else {}
    try:
        own = OwnParameters(**given)
    except ParameterError as error:
        raise error.in_namespace(node) from None
    if not own.managed:
        return cls
    # Imported only where it is wanted: it takes time and memory.
    wrapped: NodeClass = importlib.import_module("nodekit.managed.wrapped").wrapped(cls)
    return wrapped
