/* The units of the benchmark, of FMI 2.0 and 3.0. Which of the two an instance is, its token says:
   `thrown`, a piston in free flight under a constant acceleration, or `valve`, which gives that
   acceleration by the piston's position. Every event has a closed form (score.py). */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "fmi2FunctionTypes.h"
#include "fmi3FunctionTypes.h"

enum { TIME, POSITION, VELOCITY, ACCELERATION };

typedef struct {
    double time, x, v, a;
    bool is_valve, stops;
} Unit;

static const double LEVELS[] = {0.0, -0.01, -0.02, -0.03, -0.04, -0.04405624900000001};
/* Slower than this, m/s, the piston rests after a blow. */
static const double REST = 1e-3;

static void start(Unit *u) { u->time = 0.0, u->x = -1e-3, u->v = -8.3, u->a = 800.0; }

static Unit *create(const char *token, bool stops) {
    bool is_valve = token && strcmp(token, "valve") == 0;
    if (!token || (!is_valve && strcmp(token, "thrown") != 0)) return NULL;
    Unit *u = malloc(sizeof *u);
    if (u) *u = (Unit){.is_valve = is_valve, .stops = stops}, start(u);
    return u;
}

static bool get(const Unit *u, const unsigned r[], size_t n, double values[]) {
    for (size_t i = 0; i < n; i++) {
        double valve = u->x < -0.02 ? 1600.0 : 800.0;
        double all[] = {u->time, u->x, u->v, u->is_valve ? valve : u->a};
        if (r[i] > ACCELERATION || (u->is_valve && r[i] == VELOCITY)) return false;
        values[i] = all[r[i]];
    }
    return true;
}

static bool set(Unit *u, const unsigned r[], size_t n, const double values[]) {
    unsigned input = u->is_valve ? POSITION : ACCELERATION;
    for (size_t i = 0; i < n; i++)
        if (r[i] != input || !isfinite(values[i])) return false;
    for (size_t i = 0; i < n; i++) *(u->is_valve ? &u->x : &u->a) = values[i];
    return true;
}

/* How long until the next level is passed, and which. Of the roots of
   x + v h + a h^2 / 2 = level, each is computed without cancellation. */
static double next(const Unit *u, double *level) {
    double least = INFINITY;
    if (u->x == 0.0 && u->v == 0.0 && u->a >= 0.0) return least;
    for (size_t i = 0; i < sizeof LEVELS / sizeof *LEVELS; i++) {
        double above = u->x - LEVELS[i], square = u->v * u->v - 2.0 * u->a * above;
        if (square < 0.0) continue;
        double q = -(u->v + copysign(sqrt(square), u->v));
        double roots[] = {q / u->a, 2.0 * above / q};
        for (int k = 0; k < 2; k++)
            if (roots[k] > 0.0 && roots[k] < least) least = roots[k], *level = LEVELS[i];
    }
    return least;
}

/* To `end`, or to the first event where the unit stops at events: whether there was one. */
static bool advance(Unit *u, double end) {
    bool met = false;
    while (!u->is_valve) {
        double level = 0.0, h = next(u, &level), left = end - u->time;
        bool event = h <= left;
        if (!event) h = left;
        u->x += h * (u->v + 0.5 * u->a * h), u->v += u->a * h, u->time += h;
        if (!event) break;
        met = true;
        if (level == 0.0) {
            u->x = 0.0, u->v = u->v < 2.0 * REST ? 0.0 : -0.5 * u->v;
        } else {
            /* Beyond the level, so that who compares by < or by <= decides alike. */
            double size = fabs(level) * 0x1p-52;
            u->x = level + (u->v > 0.0 ? size : -size);
        }
        if (u->stops) return true;
    }
    u->time = end;
    return met;
}

static void *copied(const void *bytes, size_t n) {
    void *copy = n == sizeof(Unit) ? malloc(n) : NULL;
    if (copy) memcpy(copy, bytes, n);
    return copy;
}

/* What both standards have alike. */
#define BOTH(P, State, Float, Refs, COUNT, Byte, String, Bool, Instance, Ser, Des)                           \
    P##Status P##SetDebugLogging(Instance c, Bool on, size_t n, const String k[]) { return P##OK; }          \
    void P##FreeInstance(Instance c) { free(c); }                                                            \
    P##Status P##ExitInitializationMode(Instance c) { return P##OK; }                                        \
    P##Status P##Terminate(Instance c) { return P##OK; }                                                     \
    P##Status P##Reset(Instance c) { start(c); return P##OK; }                                               \
    P##Status P##Get##Float(Instance c, const Refs r[], size_t n, P##Float v[] COUNT) {                      \
        return get(c, r, n, v) ? P##OK : P##Error;                                                           \
    }                                                                                                        \
    P##Status P##Set##Float(Instance c, const Refs r[], size_t n, const P##Float v[] COUNT) {                \
        return set(c, r, n, v) ? P##OK : P##Error;                                                           \
    }                                                                                                        \
    P##Status P##Get##State(Instance c, P##State *s) {                                                       \
        if (!*s) *s = malloc(sizeof(Unit));                                                                  \
        if (!*s) return P##Error;                                                                            \
        memcpy(*s, c, sizeof(Unit));                                                                         \
        return P##OK;                                                                                        \
    }                                                                                                        \
    P##Status P##Set##State(Instance c, P##State s) { memcpy(c, s, sizeof(Unit)); return P##OK; }            \
    P##Status P##Free##State(Instance c, P##State *s) { free(*s), *s = NULL; return P##OK; }                 \
    P##Status P##Serialized##State##Size(Instance c, P##State s, size_t *n) {                                \
        *n = sizeof(Unit);                                                                                   \
        return P##OK;                                                                                        \
    }                                                                                                        \
    P##Status P##Ser##State(Instance c, P##State s, Byte b[], size_t n) {                                    \
        if (n < sizeof(Unit)) return P##Error;                                                               \
        memcpy(b, s, sizeof(Unit));                                                                          \
        return P##OK;                                                                                        \
    }                                                                                                        \
    P##Status P##Des##State(Instance c, const Byte b[], size_t n, P##State *s) {                             \
        return (*s = copied(b, n)) ? P##OK : P##Error;                                                       \
    }

#define NOTHING
#define AND_SIZE , size_t m
BOTH(fmi2, FMUstate, Real, fmi2ValueReference, NOTHING, fmi2Byte, fmi2String, fmi2Boolean, fmi2Component, Serialize, DeSerialize)
BOTH(fmi3, FMUState, Float64, fmi3ValueReference, AND_SIZE, fmi3Byte, fmi3String, fmi3Boolean, fmi3Instance, Serialize, Deserialize)

/* FMI 2.0 */

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char *fmi2GetVersion(void) { return "2.0"; }
fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String token, fmi2String resources,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible, fmi2Boolean logging) {
    return type == fmi2CoSimulation ? create(token, false) : NULL;
}
fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean d, fmi2Real tolerance, fmi2Real at, fmi2Boolean e, fmi2Real f) {
    ((Unit *)c)->time = at;
    return fmi2OK;
}
fmi2Status fmi2EnterInitializationMode(fmi2Component c) { return fmi2OK; }
fmi2Status fmi2DoStep(fmi2Component c, fmi2Real at, fmi2Real size, fmi2Boolean keep) {
    ((Unit *)c)->time = at;
    advance(c, at + size);
    return fmi2OK;
}

/* FMI 3.0 */

const char *fmi3GetVersion(void) { return "3.0"; }
fmi3Instance fmi3InstantiateCoSimulation(
    fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible, fmi3Boolean logging, fmi3Boolean events,
    fmi3Boolean early, const fmi3ValueReference intermediate[], size_t n, fmi3InstanceEnvironment environment,
    fmi3LogMessageCallback log, fmi3IntermediateUpdateCallback update) {
    return create(token, events && early);
}
fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean d, fmi3Float64 tolerance, fmi3Float64 at, fmi3Boolean e, fmi3Float64 f) {
    ((Unit *)c)->time = at;
    return fmi3OK;
}
fmi3Status fmi3EnterEventMode(fmi3Instance c) { return fmi3OK; }
fmi3Status fmi3EnterStepMode(fmi3Instance c) { return fmi3OK; }
fmi3Status fmi3EnterConfigurationMode(fmi3Instance c) { return fmi3OK; }
fmi3Status fmi3ExitConfigurationMode(fmi3Instance c) { return fmi3OK; }
fmi3Status fmi3EvaluateDiscreteStates(fmi3Instance c) { return fmi3OK; }
fmi3Status fmi3UpdateDiscreteStates(fmi3Instance c, fmi3Boolean *again, fmi3Boolean *end, fmi3Boolean *nominals,
                                    fmi3Boolean *values, fmi3Boolean *timed, fmi3Float64 *at) {
    *again = *end = *nominals = *values = *timed = false, *at = 0.0;
    return fmi3OK;
}
fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 at, fmi3Float64 size, fmi3Boolean keep, fmi3Boolean *event, fmi3Boolean *end,
                      fmi3Boolean *early, fmi3Float64 *reached) {
    Unit *u = c;
    u->time = at;
    *event = advance(u, at + size), *end = false, *reached = u->time;
    *early = u->stops && u->time < at + size;
    return fmi3OK;
}
