"""Helpers of the integration tests; a .test file puts the folder above on PYTHONPATH."""
