/* Values of all functions at states that are read: q, dq, ddq. */
#define ARM_DECLARATIONS_ONLY
#include "arm.c"
#include <stdio.h>

int main(void)
{
    REAL x[3 * ARM_JOINTS], y[ARM_JOINTS * ARM_JOINTS];
    REAL *q = x, *dq = x + ARM_JOINTS, *ddq = x + 2 * ARM_JOINTS, *tau = ddq;
    for (;;) {
        for (int k = 0; k < 3 * ARM_JOINTS; k++) {
            double z;
            if (scanf("%lf", &z) != 1) return 0;
            x[k] = (REAL)z;
        }
#define SHOW(count) for (int k = 0; k < count; k++) printf("%.17g ", (double)y[k])
CALLS
        puts("");
    }
}
