#!/usr/bin/env python3
"""Tests of many random plants, of which the unit tests have a quarter; without nodes."""

import unittest

from nodekit.testing.running import rosrun
from plants import check_random_plants


class RandomPlants(unittest.TestCase):
    """200 plants of any gain, fast or slow."""

    def test_each_value_without_noise_is_exact(self) -> None:
        check_random_plants(100, noise=0.0, most=0.01, covered=1.0)

    def test_uncertainty_covers_each_value_with_noise(self) -> None:
        # Of a hundred, 95 are to be expected; fewer than 88 would be once in four hundred.
        check_random_plants(100, noise=0.05, most=0.05, covered=0.88)


if __name__ == "__main__":
    rosrun("pid_control", "random_plants", RandomPlants)
