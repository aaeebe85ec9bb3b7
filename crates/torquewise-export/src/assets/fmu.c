/* The functions of FMI 2.0 around a model without continuous states: outputs follow inputs at once.
   MODEL(name), N and GUID are defined above, REMEMBERS where friction remembers the path. */

#include <string.h>

#define PI 3.14159265358979323846

/* Much of what FMI asks for means nothing to a model without continuous states. */
#if defined __GNUC__
#pragma GCC diagnostic ignored "-Wunused-parameter"
#endif

typedef struct instance *fmi2Component;
typedef void *fmi2ComponentEnvironment;
typedef void *fmi2FMUstate;
typedef unsigned int fmi2ValueReference;
typedef double fmi2Real;
typedef int fmi2Integer;
typedef int fmi2Boolean;
typedef const char *fmi2String;
typedef char fmi2Byte;
typedef int fmi2Type;
typedef enum { fmi2OK, fmi2Warning, fmi2Discard, fmi2Error, fmi2Fatal, fmi2Pending } fmi2Status;

typedef struct {
    void (*logger)(fmi2ComponentEnvironment, fmi2String, fmi2Status, fmi2String, fmi2String, ...);
    void *(*allocateMemory)(size_t, size_t);
    void (*freeMemory)(void *);
    void (*stepFinished)(fmi2ComponentEnvironment, fmi2Status);
    fmi2ComponentEnvironment environment;
} fmi2CallbackFunctions;

typedef struct {
    fmi2Boolean newDiscreteStatesNeeded;
    fmi2Boolean terminateSimulation;
    fmi2Boolean nominalsOfContinuousStatesChanged;
    fmi2Boolean valuesOfContinuousStatesChanged;
    fmi2Boolean nextEventTimeDefined;
    fmi2Real nextEventTime;
} fmi2EventInfo;

#if defined _WIN32
#define EXPORT __declspec(dllexport)
#elif defined __GNUC__
#define EXPORT __attribute__((visibility("default")))
#else
#define EXPORT
#endif

#ifdef FMI2_FUNCTION_PREFIX
#define PASTED(prefix, name) prefix##name
#define PASTE(prefix, name) PASTED(prefix, name)
#define FMI(name) PASTE(FMI2_FUNCTION_PREFIX, name)
#else
#define FMI(name) name
#endif

#define STATUS EXPORT fmi2Status

/* Value references count inputs, the parameter, then the outputs of one function after the other. */
enum { Q = 0, DQ = N, DDQ = 2 * N, EFFORT = 3 * N, BANDWIDTH = 4 * N, TORQUE = BANDWIDTH + 1,
       GRAVITY = TORQUE + N, CORIOLIS = GRAVITY + N, INERTIA = CORIOLIS + N,
       FRICTION = INERTIA + N * N, STEP1 = FRICTION + N, CORIOLIS_MATRIX = STEP1 + N,
       INVERSE_INERTIA = CORIOLIS_MATRIX + N * N, FORWARD_DYNAMICS = INVERSE_INERTIA + N * N,
       EXTERNAL = FORWARD_DYNAMICS + N, COUNT = EXTERNAL + N };

struct instance {
    fmi2CallbackFunctions callbacks;
    /* Whether the outputs of a function are of these inputs. */
    int torque, gravity, coriolis, inertia, friction, step1, coriolis_matrix, inverse_inertia,
        forward_dynamics;
    /* Times of model exchange [s]: now, and of the last step that was completed. */
    double time, stepped;
    /* Where friction remembers, it keeps the path up to the last step. */
    MODEL(observer) observer;
    double values[COUNT];
};

static void outdate(struct instance *model)
{
    model->torque = model->gravity = model->coriolis = 0;
    model->inertia = model->friction = model->step1 = 0;
    model->coriolis_matrix = model->inverse_inertia = model->forward_dynamics = 0;
}

/* What friction remembers of the path: nothing at the start, and of each step the q it ends at. */
static void forget(struct instance *model)
{
    MODEL(observer_reset)(&model->observer);
    memset(model->values + EXTERNAL, 0, N * sizeof(double));
    outdate(model);
}

/* A step that took dt seconds has come to q: friction and the observer go on from here. */
static void keep(struct instance *model, double dt)
{
    double *x = model->values;
    MODEL(observer_step)(
        &model->observer, 2.0 * PI * x[BANDWIDTH], dt, x + Q, x + DQ, x + EFFORT, x + EXTERNAL);
}

#ifdef REMEMBERS
/* The path where it goes on from the last step to q. */
static MODEL(state) ahead(const struct instance *model)
{
    MODEL(state) now = model->observer.friction;
    MODEL(step)(&now, model->values + Q);
    return now;
}
#endif

static void torque(const struct instance *model, double tau[N])
{
    const double *x = model->values;
#ifdef REMEMBERS
    const MODEL(state) now = ahead(model);
    MODEL(torque_after)(&now, x + DQ, x + DDQ, tau);
#else
    MODEL(torque)(x + Q, x + DQ, x + DDQ, tau);
#endif
}

static void friction(const struct instance *model, double tau[N])
{
    const double *x = model->values;
#ifdef REMEMBERS
    const MODEL(state) now = ahead(model);
    MODEL(friction_after)(&now, x + DQ, tau);
#else
    MODEL(friction)(x + Q, x + DQ, tau);
#endif
}

static void forward_dynamics(const struct instance *model, double ddq[N])
{
    const double *x = model->values;
#ifdef REMEMBERS
    const MODEL(state) now = ahead(model);
    MODEL(forward_dynamics_after)(&now, x + DQ, x + EFFORT, ddq);
#else
    MODEL(forward_dynamics)(x + Q, x + DQ, x + EFFORT, ddq);
#endif
}

/* Computes the function that an output belongs to, if its inputs have changed. */
static double value(struct instance *model, fmi2ValueReference place)
{
    double *x = model->values;
    if (place < TORQUE) {
        return x[place];
    } else if (place < GRAVITY) {
        if (!model->torque) torque(model, x + TORQUE);
        model->torque = 1;
    } else if (place < CORIOLIS) {
        if (!model->gravity) MODEL(gravity)(x + Q, x + GRAVITY);
        model->gravity = 1;
    } else if (place < INERTIA) {
        if (!model->coriolis) MODEL(coriolis)(x + Q, x + DQ, x + CORIOLIS);
        model->coriolis = 1;
    } else if (place < FRICTION) {
        if (!model->inertia) MODEL(inertia)(x + Q, x + INERTIA);
        model->inertia = 1;
    } else if (place < STEP1) {
        if (!model->friction) friction(model, x + FRICTION);
        model->friction = 1;
    } else if (place < CORIOLIS_MATRIX) {
        if (!model->step1) MODEL(step1)(x + Q, x + STEP1);
        model->step1 = 1;
    } else if (place < INVERSE_INERTIA) {
        if (!model->coriolis_matrix) MODEL(coriolis_matrix)(x + Q, x + DQ, x + CORIOLIS_MATRIX);
        model->coriolis_matrix = 1;
    } else if (place < FORWARD_DYNAMICS) {
        if (!model->inverse_inertia) MODEL(inverse_inertia)(x + Q, x + INVERSE_INERTIA);
        model->inverse_inertia = 1;
    } else if (place < EXTERNAL) {
        if (!model->forward_dynamics) forward_dynamics(model, x + FORWARD_DYNAMICS);
        model->forward_dynamics = 1;
    }
    return x[place];
}

static fmi2Status complain(struct instance *model, fmi2String text)
{
    if (model->callbacks.logger) {
        model->callbacks.logger(
            model->callbacks.environment, "torquewise", fmi2Error, "error", "%s", text);
    }
    return fmi2Error;
}

EXPORT const char *FMI(fmi2GetTypesPlatform)(void)
{
    return "default";
}

EXPORT const char *FMI(fmi2GetVersion)(void)
{
    return "2.0";
}

STATUS FMI(fmi2SetDebugLogging)(
    fmi2Component c, fmi2Boolean on, size_t count, const fmi2String categories[])
{
    return fmi2OK;
}

EXPORT fmi2Component FMI(fmi2Instantiate)(
    fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
    const fmi2CallbackFunctions *callbacks, fmi2Boolean visible, fmi2Boolean logging)
{
    struct instance *model;
    if (!callbacks || !callbacks->allocateMemory || !callbacks->freeMemory) return 0;
    if (!guid || strcmp(guid, GUID) != 0) {
        if (callbacks->logger) {
            callbacks->logger(
                callbacks->environment, "torquewise", fmi2Error, "error",
                "the model description is of another unit: its guid is not %s", GUID);
        }
        return 0;
    }
    model = callbacks->allocateMemory(1, sizeof *model);
    if (!model) return 0;
    memset(model, 0, sizeof *model);
    model->callbacks = *callbacks;
    model->values[BANDWIDTH] = 10.0;
    forget(model);
    return model;
}

EXPORT void FMI(fmi2FreeInstance)(fmi2Component c)
{
    if (c) c->callbacks.freeMemory(c);
}

STATUS FMI(fmi2SetupExperiment)(
    fmi2Component c, fmi2Boolean bounded, fmi2Real tolerance, fmi2Real start, fmi2Boolean ends,
    fmi2Real end)
{
    c->time = c->stepped = start;
    return fmi2OK;
}

STATUS FMI(fmi2EnterInitializationMode)(fmi2Component c)
{
    forget(c);
    return fmi2OK;
}

STATUS FMI(fmi2ExitInitializationMode)(fmi2Component c)
{
    return fmi2OK;
}

STATUS FMI(fmi2Terminate)(fmi2Component c)
{
    return fmi2OK;
}

STATUS FMI(fmi2Reset)(fmi2Component c)
{
    memset(c->values, 0, sizeof c->values);
    c->values[BANDWIDTH] = 10.0;
    c->time = c->stepped = 0.0;
    forget(c);
    return fmi2OK;
}

STATUS FMI(fmi2GetReal)(
    fmi2Component c, const fmi2ValueReference places[], size_t count, fmi2Real values[])
{
    for (size_t k = 0; k < count; k++) {
        if (places[k] >= COUNT) return complain(c, "there is no such variable");
        values[k] = value(c, places[k]);
    }
    return fmi2OK;
}

STATUS FMI(fmi2SetReal)(
    fmi2Component c, const fmi2ValueReference places[], size_t count, const fmi2Real values[])
{
    for (size_t k = 0; k < count; k++) {
        if (places[k] >= TORQUE) return complain(c, "only q, dq, ddq, effort and bandwidth can be set");
        c->values[places[k]] = values[k];
    }
    outdate(c);
    return fmi2OK;
}

/* There are reals only: anything else is asked for in vain, unless nothing is. */
#define NONE(name, type, access) \
    STATUS FMI(name)( \
        fmi2Component c, const fmi2ValueReference places[], size_t count, access type values[]) \
    { \
        return count ? complain(c, "all variables are real") : fmi2OK; \
    }

#define READ
NONE(fmi2GetInteger, fmi2Integer, READ)
NONE(fmi2GetBoolean, fmi2Boolean, READ)
NONE(fmi2GetString, fmi2String, READ)
NONE(fmi2SetInteger, fmi2Integer, const)
NONE(fmi2SetBoolean, fmi2Boolean, const)
NONE(fmi2SetString, fmi2String, const)

/* The model description offers none of these. */
#define REFUSED(name, arguments) \
    STATUS FMI(name) arguments \
    { \
        return complain(c, #name " is not offered"); \
    }

REFUSED(fmi2GetFMUstate, (fmi2Component c, fmi2FMUstate *state))
REFUSED(fmi2SetFMUstate, (fmi2Component c, fmi2FMUstate state))
REFUSED(fmi2FreeFMUstate, (fmi2Component c, fmi2FMUstate *state))
REFUSED(fmi2SerializedFMUstateSize, (fmi2Component c, fmi2FMUstate state, size_t *size))
REFUSED(fmi2SerializeFMUstate, (fmi2Component c, fmi2FMUstate state, fmi2Byte to[], size_t size))
REFUSED(fmi2DeSerializeFMUstate,
        (fmi2Component c, const fmi2Byte from[], size_t size, fmi2FMUstate *state))
REFUSED(fmi2GetDirectionalDerivative,
        (fmi2Component c, const fmi2ValueReference unknown[], size_t n_unknown,
         const fmi2ValueReference known[], size_t n_known, const fmi2Real seed[],
         fmi2Real sensitivity[]))
REFUSED(fmi2SetRealInputDerivatives,
        (fmi2Component c, const fmi2ValueReference places[], size_t count,
         const fmi2Integer orders[], const fmi2Real values[]))
REFUSED(fmi2GetRealOutputDerivatives,
        (fmi2Component c, const fmi2ValueReference places[], size_t count,
         const fmi2Integer orders[], fmi2Real values[]))
REFUSED(fmi2CancelStep, (fmi2Component c))
REFUSED(fmi2GetStatus, (fmi2Component c, const int kind, fmi2Status *status))
REFUSED(fmi2GetRealStatus, (fmi2Component c, const int kind, fmi2Real *status))
REFUSED(fmi2GetIntegerStatus, (fmi2Component c, const int kind, fmi2Integer *status))
REFUSED(fmi2GetBooleanStatus, (fmi2Component c, const int kind, fmi2Boolean *status))
REFUSED(fmi2GetStringStatus, (fmi2Component c, const int kind, fmi2String *status))

/* Model exchange: no continuous states, no events; a step that was completed is remembered. */

STATUS FMI(fmi2EnterEventMode)(fmi2Component c)
{
    return fmi2OK;
}

STATUS FMI(fmi2NewDiscreteStates)(fmi2Component c, fmi2EventInfo *info)
{
    memset(info, 0, sizeof *info);
    return fmi2OK;
}

STATUS FMI(fmi2EnterContinuousTimeMode)(fmi2Component c)
{
    return fmi2OK;
}

STATUS FMI(fmi2CompletedIntegratorStep)(
    fmi2Component c, fmi2Boolean final, fmi2Boolean *enter_event_mode, fmi2Boolean *terminate)
{
    keep(c, c->time - c->stepped);
    c->stepped = c->time;
    *enter_event_mode = 0;
    *terminate = 0;
    return fmi2OK;
}

STATUS FMI(fmi2SetTime)(fmi2Component c, fmi2Real time)
{
    c->time = time;
    return fmi2OK;
}

STATUS FMI(fmi2SetContinuousStates)(fmi2Component c, const fmi2Real x[], size_t count)
{
    return count ? complain(c, "there are no states") : fmi2OK;
}

STATUS FMI(fmi2GetDerivatives)(fmi2Component c, fmi2Real x[], size_t count)
{
    return count ? complain(c, "there are no states") : fmi2OK;
}

STATUS FMI(fmi2GetEventIndicators)(fmi2Component c, fmi2Real x[], size_t count)
{
    return count ? complain(c, "there are no event indicators") : fmi2OK;
}

STATUS FMI(fmi2GetContinuousStates)(fmi2Component c, fmi2Real x[], size_t count)
{
    return count ? complain(c, "there are no states") : fmi2OK;
}

STATUS FMI(fmi2GetNominalsOfContinuousStates)(fmi2Component c, fmi2Real x[], size_t count)
{
    return count ? complain(c, "there are no states") : fmi2OK;
}

/* Co-simulation: a step takes time; friction and the observer remember it. */

STATUS FMI(fmi2DoStep)(fmi2Component c, fmi2Real time, fmi2Real step, fmi2Boolean no_return)
{
    keep(c, step);
    c->time = c->stepped = time + step;
    return fmi2OK;
}
