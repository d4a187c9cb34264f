#!/usr/bin/env python3
"""A manager that detects another only after its own registration."""

import itertools
from unittest import mock

from lifecycle_manager.nodes import lifecycle_manager

if __name__ == "__main__":
    found = itertools.chain([None], itertools.repeat("y has one"))
    with mock.patch.object(lifecycle_manager, "find_other_manager", side_effect=found):
        lifecycle_manager.main()
