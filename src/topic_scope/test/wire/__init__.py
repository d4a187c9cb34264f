"""What tests of the server's interface share; a .test file puts the folder above on PYTHONPATH."""
