class Truth:
    """What a comparison of array entries gives: it cannot be subtracted."""

    def __init__(self, value):
        self.value = value

    def __bool__(self):
        return self.value

    def __float__(self):
        return float(self.value)


class Number(float):
    """An entry of an array."""

    def __gt__(self, other):
        return Truth(float(self) > other)

    def __lt__(self, other):
        return Truth(float(self) < other)
