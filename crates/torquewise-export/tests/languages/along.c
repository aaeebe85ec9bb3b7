/* Torque, friction, external torque and the acceleration of that torque along a path. */
#define ARM_DECLARATIONS_ONLY
#include "arm.c"
#include <stdio.h>

enum { N = ARM_JOINTS };

int main(void)
{
    arm_state state;
    arm_observer observer;
    double x[3 * N], y[4 * N];
    for (int row = 0;; row++) {
        for (int k = 0; k < 3 * N; k++) if (scanf("%lf", x + k) != 1) return 0;
        if (row % RESET == 0) arm_reset(&state), arm_observer_reset(&observer);
        arm_step(&state, x);
        arm_torque_after(&state, x + N, x + 2 * N, y);
        arm_friction_after(&state, x + N, y + N);
        arm_observer_step(&observer, GAIN, STEP, x, x + N, x + 2 * N, y + 2 * N);
        arm_forward_dynamics_after(&state, x + N, y, y + 3 * N);
        for (int k = 0; k < 4 * N; k++) printf("%.17g ", y[k]);
        puts("");
    }
}
