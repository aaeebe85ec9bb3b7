"""What calls of the module `arm` add to y, for each state that is read: q, dq, ddq."""

import sys

import arm

NUMBER

def add(values, count):
    """Adds what is computed, or so many NaN where that divides by zero."""
    try:
        y.extend(values())
    except ZeroDivisionError:
        y.extend([float("nan")] * count)


n = arm.JOINTS
BEFORE
for number, line in enumerate(sys.stdin):
    x = [Number(x) for x in line.split()]
    q, dq, ddq = x[:n], x[n : 2 * n], x[2 * n :]
    tau, y = ddq, []
CALLS
    print(*map(repr, y))
