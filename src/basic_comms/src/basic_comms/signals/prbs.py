"""Pseudo-random binary sequence (PRBS) of maximal length."""

#: Exponents between the order and 0 of a primitive polynomial over GF(2) for each order: those of
#: ITU-T O.150 for its orders 9, 11, 15, 23 and 31, common ones for the rest. The sequence obeys
#: s[k + order] = s[k] xor s[k + a] xor s[k + b] ... for the exponents a, b, ... listed.
TAPS = {
    2: (1,),
    3: (2,),
    4: (3,),
    5: (3,),
    6: (5,),
    7: (6,),
    8: (6, 5, 4),
    9: (5,),
    10: (7,),
    11: (9,),
    12: (6, 4, 1),
    13: (4, 3, 1),
    14: (5, 3, 1),
    15: (14,),
    16: (15, 13, 4),
    17: (14,),
    18: (11,),
    19: (6, 2, 1),
    20: (17,),
    21: (19,),
    22: (21,),
    23: (18,),
    24: (23, 22, 17),
    25: (22,),
    26: (6, 2, 1),
    27: (5, 2, 1),
    28: (25,),
    29: (27,),
    30: (6, 4, 1),
    31: (28,),
}

#: Up to this number of chips, stepping is cheaper than a direct computation.
_SHORT_WAY = 64


class Prbs:
    """Sequence of a linear feedback shift register, with random access to its chips.

    The period is ``2**order - 1`` chips; 1 occurs once more than -1.

    Chip k is a sum over GF(2) of some of the first ``order`` chips, given by the residue of x**k
    modulo the register's polynomial, stored as an integer whose bit i stands for x**i.
    Multiplication by x is one step of the register; repeated squaring gives any power of x.

    :param order: length of the register, 2 to 31
    :param seed: selects the position of chip 0 in the sequence; any integer
    """

    def __init__(self, order: int, seed: int) -> None:
        self.period = (1 << order) - 1
        self._first_chips = seed % self.period + 1
        self._polynomial = 1 | 1 << order | sum(1 << exponent for exponent in TAPS[order])
        self._index = 0
        self._residue = 1

    def chip(self, index: int) -> int:
        """Return one chip of the sequence.

        :param index: number of the chip, from 0; any integer
        :returns: 1 or -1
        """
        index %= self.period
        if 0 <= index - self._index <= _SHORT_WAY:
            for _ in range(index - self._index):
                self._residue = self._times_x(self._residue)
        else:
            self._residue = self._power_of_x(index)
        self._index = index
        return 1 if bin(self._residue & self._first_chips).count("1") % 2 else -1

    def _times_x(self, residue: int) -> int:
        residue <<= 1
        return residue ^ self._polynomial if residue > self.period else residue

    def _times(self, one: int, other: int) -> int:
        product = 0
        while other:
            if other & 1:
                product ^= one
            one = self._times_x(one)
            other >>= 1
        return product

    def _power_of_x(self, exponent: int) -> int:
        power = 1
        for bit in bin(exponent)[2:]:
            power = self._times(power, power)
            if bit == "1":
                power = self._times_x(power)
        return power
