/* Nanoseconds of processor time per call of each function of exported code: name, median, least. */

#define _POSIX_C_SOURCE 199309L
#define ARM_DECLARATIONS_ONLY
#include "arm.c"

#include <stdio.h>
#include <stdlib.h>
#include <time.h>

enum { N = ARM_JOINTS, STATES = 256, ROUNDS = 201, CALLS = 2000 };

static double q[STATES][N], dq[STATES][N], ddq[STATES][N], y[N * N], sum;

static double now(void)
{
    struct timespec time;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    return 1e9 * (double)time.tv_sec + (double)time.tv_nsec;
}

static double within(double most)
{
    return most * (2.0 * rand() / RAND_MAX - 1.0);
}

static int order(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

#define TIME(name, call) \
    do { \
        double times[ROUNDS]; \
        for (int round = 0; round < ROUNDS; round++) { \
            const double start = now(); \
            for (int k = 0; k < CALLS; k++) { \
                const int i = k % STATES; \
                call; \
                sum += y[0]; \
            } \
            times[round] = (now() - start) / CALLS; \
        } \
        qsort(times, ROUNDS, sizeof *times, order); \
        printf("%s %.1f %.1f\n", name, times[ROUNDS / 2], times[0]); \
    } while (0)

int main(void)
{
    for (int i = 0; i < STATES; i++) {
        for (int j = 0; j < N; j++) {
            q[i][j] = within(3.0);
            dq[i][j] = within(1.0);
            ddq[i][j] = within(1.0);
        }
    }
    TIME("torque", arm_torque(q[i], dq[i], ddq[i], y));
    TIME("gravity", arm_gravity(q[i], y));
    TIME("coriolis", arm_coriolis(q[i], dq[i], y));
    TIME("inertia", arm_inertia(q[i], y));
    TIME("friction", arm_friction(q[i], dq[i], y));
    TIME("step1", arm_step1(q[i], y));
#ifdef ARM_ELEMENTS
    /* Along a path, as a controller does at every sample. */
    arm_state state;
    arm_reset(&state);
    TIME("step", arm_step(&state, q[i]));
    TIME("torque_after", arm_torque_after(&state, dq[i], ddq[i], y));
#endif
    return sum != sum;
}
