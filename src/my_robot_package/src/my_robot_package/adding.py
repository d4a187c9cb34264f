"""Add whole numbers of 64 bits."""

#: The numbers that an int64 holds.
INT64_MIN, INT64_MAX = -(2**63), 2**63 - 1


def add(a: int, b: int) -> int:
    """Return the sum of two numbers.

    :param a: an int64
    :param b: an int64
    :raises OverflowError: if the sum is none
    """
    total = a + b
    if not INT64_MIN <= total <= INT64_MAX:
        raise OverflowError(
            f"{a} + {b} is {total}: must be in [{INT64_MIN}, {INT64_MAX}], which an int64 holds"
        )
    return total
