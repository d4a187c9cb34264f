"""Settings of the unit tests."""

import os

from hypothesis import settings

#: How many examples of each property are tried where its test does not say: with a hundred, what
#: hypothesis does by default, these tests would take half of the time of all unit tests.
EXAMPLES = int(os.environ.get("UNIT_TEST_EXAMPLES", "40"))

# The same examples in every run, and no deadline: a busy machine is no failure.
settings.register_profile("deterministic", derandomize=True, deadline=None, max_examples=EXAMPLES)
settings.load_profile("deterministic")
