"""What integration tests share; a .test file puts the folder above on PYTHONPATH."""
