"""Helpers of tests of the server's interface; a .test file puts the folder above on PYTHONPATH."""
