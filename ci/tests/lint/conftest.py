"""The tests of what ruff refuses need ruff, which ci/test fetches where it runs the lint."""

from ci.tiers.tier_plan import RUFF
from pathlib import Path

collect_ignore = [] if Path(RUFF).exists() else ["test_bans.py"]
