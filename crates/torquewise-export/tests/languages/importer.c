/* What an importer of FMI 2.0 does, as the standard declares it: tau of each state read. */

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
int fmi2Reset(void *);
void fmi2FreeInstance(void *);

int main(void)
{
    const Callbacks callbacks = { 0, calloc, free, 0, 0 };
    unsigned int places[4 * JOINTS];
    double x[3 * JOINTS], tau[JOINTS];
    void *unit = fmi2Instantiate("arm", 1, "THE_GUID", "", &callbacks, 0, 0);
    if (!unit || fmi2GetVersion()[0] != '2') return 1;
    if (fmi2Instantiate("arm", 1, "another", "", &callbacks, 0, 0)) return 2;
    for (unsigned int k = 0; k < 4 * JOINTS; k++) places[k] = k;
    /* An output cannot be set. */
    if (fmi2SetReal(unit, places + 3 * JOINTS, 1, x) == 0 || fmi2Reset(unit) != 0) return 3;
    for (;;) {
        for (int k = 0; k < 3 * JOINTS; k++) {
            if (scanf("%lf", x + k) != 1) {
                fmi2FreeInstance(unit);
                return 0;
            }
        }
        if (fmi2SetReal(unit, places, 3 * JOINTS, x) != 0) return 4;
        if (fmi2DoStep(unit, 0.0, 0.001, 0) != 0) return 5;
        if (fmi2GetReal(unit, places + 3 * JOINTS, JOINTS, tau) != 0) return 6;
        for (int k = 0; k < JOINTS; k++) printf("%.17g ", tau[k]);
        puts("");
    }
}
