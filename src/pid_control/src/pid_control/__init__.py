"""A motor to control: the loop closed, and what it takes to judge a controller."""
