/* What an importer of FMI 2.0 does, as the standard declares it: tau, friction, external torque and
   acceleration of each state read, along a path that begins anew every RESET states. */

#include <stdio.h>
#include <stdlib.h>

typedef struct {
    void (*logger)(void *, const char *, int, const char *, const char *, ...);
    void *(*allocateMemory)(size_t, size_t);
    void (*freeMemory)(void *);
    void (*stepFinished)(void *, int);
    void *environment;
} Callbacks;

const char *fmi2GetVersion(void);
void *fmi2Instantiate(
    const char *, int, const char *, const char *, const Callbacks *, int, int);
int fmi2SetReal(void *, const unsigned int[], size_t, const double[]);
int fmi2GetReal(void *, const unsigned int[], size_t, double[]);
int fmi2DoStep(void *, double, double, int);
int fmi2CompletedIntegratorStep(void *, int, int *, int *);
int fmi2SetTime(void *, double);
int fmi2Reset(void *);
void fmi2FreeInstance(void *);

/* Where outputs begin. */
enum { TAU = 4 * JOINTS + 1, FRICTION = TAU + 3 * JOINTS + JOINTS * JOINTS,
       ACCELERATION = FRICTION + 2 * JOINTS + 2 * JOINTS * JOINTS, EXTERNAL = ACCELERATION + JOINTS };

/* Gives inputs and takes tau and friction; the motors give the numbers of ddq. */
static int answered(void *unit, const double x[3 * JOINTS], double tau[2 * JOINTS])
{
    unsigned int inputs[4 * JOINTS], outputs[2 * JOINTS];
    double given[4 * JOINTS];
    for (unsigned int k = 0; k < 4 * JOINTS; k++) {
        inputs[k] = k;
        given[k] = x[k < 3 * JOINTS ? k : k - JOINTS];
    }
    for (unsigned int k = 0; k < JOINTS; k++) {
        outputs[k] = TAU + k;
        outputs[JOINTS + k] = FRICTION + k;
    }
    return fmi2SetReal(unit, inputs, 4 * JOINTS, given) == 0 &&
        fmi2GetReal(unit, outputs, 2 * JOINTS, tau) == 0;
}

/* The acceleration of an arm whose motors give tau. */
static int accelerated(void *unit, const double tau[JOINTS], double ddq[JOINTS])
{
    unsigned int inputs[JOINTS], outputs[JOINTS];
    for (unsigned int k = 0; k < JOINTS; k++) {
        inputs[k] = 3 * JOINTS + k;
        outputs[k] = ACCELERATION + k;
    }
    return fmi2SetReal(unit, inputs, JOINTS, tau) == 0 &&
        fmi2GetReal(unit, outputs, JOINTS, ddq) == 0;
}

int main(void)
{
    const Callbacks callbacks = { 0, calloc, free, 0, 0 };
    const unsigned int tau_1 = TAU, bandwidth = 4 * JOINTS;
    const double hertz = GAIN / (2.0 * 3.14159265358979323846);
    unsigned int outputs[JOINTS];
    double x[3 * JOINTS], far[3 * JOINTS] = { 1.0 }, tau[2 * JOINTS], again[2 * JOINTS],
        more[2 * JOINTS];
    int event, end;
    void *unit = fmi2Instantiate("arm", 1, "THE_GUID", "", &callbacks, 0, 0);
    if (!unit || fmi2GetVersion()[0] != '2') return 1;
    if (fmi2Instantiate("arm", 1, "another", "", &callbacks, 0, 0)) return 2;
    /* An output cannot be set. */
    if (fmi2SetReal(unit, &tau_1, 1, far) == 0) return 3;
    for (int row = 0;; row++) {
        for (int k = 0; k < 3 * JOINTS; k++) {
            if (scanf("%lf", x + k) != 1) {
                fmi2FreeInstance(unit);
                return 0;
            }
        }
        if (row % RESET == 0 && fmi2Reset(unit) != 0) return 4;
        if (fmi2SetReal(unit, &bandwidth, 1, &hertz) != 0) return 9;
        /* What is tried and not stepped to leaves no trace. */
        if (!answered(unit, far, again) || !answered(unit, x, tau)) return 5;
        if (!accelerated(unit, tau, more + JOINTS) || !answered(unit, x, again)) return 10;
        if (row % 2 ? fmi2DoStep(unit, (row - 1) * STEP, STEP, 0)
                    : fmi2SetTime(unit, row * STEP) ||
                        fmi2CompletedIntegratorStep(unit, 1, &event, &end)) return 6;
        for (unsigned int k = 0; k < JOINTS; k++) outputs[k] = EXTERNAL + k;
        if (fmi2GetReal(unit, outputs, JOINTS, more) != 0) return 11;
        if (!answered(unit, x, again)) return 7;
        for (int k = 0; k < 2 * JOINTS; k++) {
            if (again[k] != tau[k]) return 8;
            printf("%.17g ", tau[k]);
        }
        for (int k = 0; k < 2 * JOINTS; k++) printf("%.17g ", more[k]);
        puts("");
    }
}
