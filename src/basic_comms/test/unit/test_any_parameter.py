"""Any YAML content, for every parameter of every node, is accepted or rejected with a message."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from basic_comms.conditioning.process_parameters import ProcessParameters
from basic_comms.nodes.fleet import FleetParameters
from basic_comms.nodes.talker import TalkerParameters
from basic_comms.signals.signal_parameters import SignalParameters
from nodekit import to_wire
from nodekit.testing.offline_parameters import OfflineParameters

SETS = [FleetParameters, ProcessParameters, SignalParameters, TalkerParameters]
DECLARED = [(kind, name) for kind in SETS for name in kind.declared]

WORDS = st.sampled_from(["", "sine", "delay", "1e3", "-1e999", "nan", "yes", "~", "/", "$(id)"])
NUMBERS = st.floats() | st.integers() | st.sampled_from([0, -0.0, 5e-324, 1e308, 2**31, 10**400])
SCALARS = st.none() | st.booleans() | NUMBERS | WORDS | st.text(max_size=5)
YAML = SCALARS | st.binary(max_size=3) | st.dates() | st.datetimes()
YAML = st.recursive(
    YAML,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=3), inner),
    max_leaves=4,
)


def is_finite(value):
    """Return whether all numbers in a value are finite."""
    if isinstance(value, tuple):
        return all(map(is_finite, value))
    return not isinstance(value, float) or math.isfinite(value)


@pytest.mark.parametrize("kind, name", DECLARED, ids=lambda part: getattr(part, "__name__", part))
@given(raw=YAML)
@settings(max_examples=30)  # for each of 48 parameters, of a few types
def test_any_value_is_accepted_or_rejected_with_message(kind, name, raw):
    parameters = OfflineParameters(kind)
    defaults = parameters.values
    errors = parameters.set({name: raw})
    value = getattr(parameters.values, name)
    assert is_finite(value)
    assert isinstance(value, type(getattr(defaults, name)))
    others = {key: item for key, item in parameters.values.as_dict().items() if key != name}
    assert others == {key: item for key, item in defaults.as_dict().items() if key != name}
    for error in errors:
        assert name in error.names
        assert ": refused " in str(error) and " must " in str(error)
        assert value == getattr(defaults, name)
        assert parameters.server[name] == to_wire(value)
