"""Runs a function of an exported module on numbers that count what is done to them."""

import sys

import arm

done = {"operations": 0, "functions": 0}


class Counted(float):
    def note(kind, value):
        done[kind] += 1
        return Counted(value)

    def __add__(self, other):
        return Counted.note("operations", float(self) + float(other))

    def __sub__(self, other):
        return Counted.note("operations", float(self) - float(other))

    def __rsub__(self, other):
        return Counted.note("operations", float(other) - float(self))

    def __mul__(self, other):
        return Counted.note("operations", float(self) * float(other))

    def __rtruediv__(self, other):
        return Counted.note("operations", float(other) / float(self))

    def __neg__(self):
        return Counted.note("operations", -float(self))

    def __abs__(self):
        return Counted.note("operations", abs(float(self)))

    __radd__, __rmul__ = __add__, __mul__


for name in ("sin", "cos", "exp", "tanh", "_sign", "_positive"):
    if hasattr(arm, name):
        plain = getattr(arm, name)
        counting = lambda x, plain=plain: Counted.note("functions", plain(float(x)))
        setattr(arm, name, counting)

for name, arguments in [line.split() for line in sys.stdin]:
    done["operations"] = done["functions"] = 0
    state = [[Counted(0.3 + 0.1 * k)] * arm.JOINTS for k in range(int(arguments))]
    try:
        getattr(arm, name)(*state)
    except ZeroDivisionError:  # M of an arm made up at random need not have an inverse
        done = dict.fromkeys(done, sys.maxsize)
    print(done["operations"], done["functions"])
