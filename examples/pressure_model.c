/* Models of a drive as FMUs of their own (FMI 2.0, co-simulation), as hosts couple them with the hammer: where the
   piston is goes in (or the air that the hammer has taken), pressures come out. Within a step it moves evenly from
   where it was to where it is.
   -DCASE=1: trapped oil; 2: gas in two chambers with ports; 3: water behind a valve; 4: a hose as a transmission line
   with a valve at its far end, which gives its wave (-DPRESSURE=1: its pressure); 5: a compressor with receiver and hose.
   -DBEGIN: where the piston starts. See pressure_model.py. */
#include <math.h>
#include <stdlib.h>
#include "fmi2Functions.h"

#ifndef PRESSURE
#define PRESSURE 0
#endif
enum { POSITION, DRIVE_PRESSURE, RETURN_PRESSURE, COUNT };

#if CASE == 1
enum { SIZE = 1 };
static const double FINEST = 1e-5, MODULUS = 1.5e9, VOLUME = 2e-5, AREA = 1e-3, REST = 2e7;
static void begin(double *y, double x) { y[0] = REST; }
static void rates(const double *y, double command, double x, double v, double *d) { d[0] = -MODULUS / VOLUME * AREA * v; }
static double command_at(double command, double x) { return command; }
static void pressures(const double *y, double v, double *p) { p[0] = y[0]; p[1] = REST; }
#elif CASE == 2
enum { SIZE = 2 };
static const double FINEST = 2e-6, R = 287.05, T = 300.0, KAPPA = 1.4, SUPPLY = 2.4e6, EXHAUST = 101325.0;
static const double DOWN = 6e-3, UP = 5e-3, DEAD = 1.2e-4, STROKE = 0.1, PORT = 6e-5;
static void begin(double *y, double x) { y[0] = 3e5; y[1] = 1e6; }
static double nozzle(double area, double p, double q) {
    if (q > p) return -nozzle(area, q, p);
    double r = fmax(q / p, pow(2 / (KAPPA + 1), KAPPA / (KAPPA - 1)));
    double psi = 2 * KAPPA / (KAPPA - 1) * (pow(r, 2 / KAPPA) - pow(r, (KAPPA + 1) / KAPPA));
    return 0.8 * area * p / sqrt(R * T) * sqrt(fmax(0.0, psi));
}
static double open(double beyond) { return fmin(1.0, fmax(0.0, beyond / 0.01)); }
static void rates(const double *y, double command, double x, double v, double *d) {
    double in = nozzle(PORT * open(-0.04 - x), SUPPLY, y[0]) - nozzle(3 * PORT * open(x + 0.02), y[0], EXHAUST);
    double out = nozzle(PORT * open(x + 0.025), SUPPLY, y[1]) - nozzle(3 * PORT * open(-0.045 - x), y[1], EXHAUST);
    d[0] = KAPPA / (DEAD + DOWN * (STROKE + x)) * (R * T * in - y[0] * DOWN * v);
    d[1] = KAPPA / (DEAD - UP * x) * (R * T * out + y[1] * UP * v);
}
static double command_at(double command, double x) { return command; }
static void pressures(const double *y, double v, double *p) { p[0] = y[0] - EXHAUST; p[1] = y[1] - EXHAUST; }
#elif CASE == 3
/* Pressure of the drive chamber, opening of the valve, and a hose of three parts, each a pressure and a flow. */
enum { SIZE = 8 };
static const double FINEST = 1e-6, PUMP = 1.4e7, OUTLET = 2e5, MODULUS = 2.1e9, DENSITY = 1000.0, DOWN = 3.6e-4, UP = 1.8e-4;
static const double VOLUME = 1e-4, LENGTH = 4.0, BORE = 25e-3, RESISTANCE = 2e8, SOFT = 4e-12, PORT = 1.2e-4, LAMINAR = 5e5;
static const double SHIFT = 5e-4, TURNS_UP = -8e-3, TURNS_DOWN = -30e-3;
static void begin(double *y, double x) {
    y[0] = OUTLET;
    y[1] = 1.0;
    for (int k = 2; k < SIZE; k += 2) { y[k] = PUMP; y[k + 1] = 0.0; }
}
static double flow(double opening, double drop) { return 0.65 * PORT * sqrt(2 / DENSITY) * opening * drop / sqrt(hypot(drop, LAMINAR)); }
static void rates(const double *y, double command, double x, double v, double *d) {
    double face = M_PI / 4 * BORE * BORE, give = face * LENGTH / 3 / MODULUS, inertia = DENSITY * LENGTH / 3 / face;
    double in = flow(fmax(0, y[1]), y[2] - y[0]), out = flow(fmax(0, -y[1]), y[0] - OUTLET);
    d[0] = MODULUS / (VOLUME + DOWN * x) * (in - out - DOWN * v);
    d[1] = (command - y[1]) / SHIFT;
    double taken = in - UP * v;
    for (int k = 2; k < SIZE; k += 2) {
        double before = k + 2 < SIZE ? y[k + 2] : PUMP;
        d[k] = (y[k + 1] - taken) / (k == 2 ? give + SOFT : give);
        d[k + 1] = (before - y[k] - RESISTANCE / 3 * y[k + 1]) / inertia;
        taken = y[k + 1];
    }
}
static double command_at(double command, double x) {
    if (command > 0 && x > TURNS_UP) return -1;
    return command < 0 && x < TURNS_DOWN ? 1 : command;
}
static void pressures(const double *y, double v, double *p) { p[0] = y[0]; p[1] = y[2]; }
#elif CASE == 4
/* What is given of the piston's end, and the opening of the valve. */
enum { SIZE = 2, RING = 4096 };
static const double FINEST = 5e-7, PUMP = 1.4e7, OUTLET = 2e5, DOWN = 3.6e-4, LINE = 9e8, DELAY = 1e-3, RESISTANCE = 4e8;
static const double SHIFT = 5e-4, TURNS_UP = -8e-3, TURNS_DOWN = -30e-3;
static void begin(double *y, double x) { y[0] = PUMP; y[1] = 1.0; }
static double command_at(double command, double x) {
    if (command > 0 && x > TURNS_UP) return -1;
    return command < 0 && x < TURNS_DOWN ? 1 : command;
}
static void pressures(const double *y, double v, double *p) { p[0] = y[0]; p[1] = PUMP; }
#else
/* The air that receiver and hose hold, kg. */
enum { SIZE = 1 };
static const double FINEST = 1e-4, R = 287.05, T = 300.0, RATED = 25e5, BAND = 1e5, RECEIVER = 0.02, LENGTH = 15.0, BORE = 51e-3;
static const double FRICTION = 0.02, CAPACITY = 20.0 / 60 * 101325.0 / (287.05 * 273.15);
static double per_mass(void) { return R * T / (RECEIVER + M_PI / 4 * BORE * BORE * LENGTH); }
static void begin(double *y, double x) { y[0] = RATED / per_mass(); }
static void rates(const double *y, double command, double x, double v, double *d) {
    d[0] = CAPACITY * fmin(1, fmax(0, (RATED + BAND - per_mass() * y[0]) / BAND)) - v;
}
static double command_at(double command, double x) { return command; }
static void pressures(const double *y, double v, double *p) {
    double face = M_PI / 4 * BORE * BORE, held = per_mass() * y[0];
    p[0] = sqrt(fmax(0, held * held - FRICTION * LENGTH / BORE * R * T / (face * face) * v * fabs(v)));
}
#endif

typedef struct {
    double values[COUNT], y[SIZE], command, before;
    int begun;
#if CASE == 4
    /* Waves that have set out from either end, a sample a part of a step. */
    double to_valve[RING], to_piston[RING];
    long at;
#endif
} Model;

static void start(Model *m) {
    begin(m->y, m->values[POSITION]);
    m->command = 1;
    m->begun = 0;
#if CASE == 4
    m->at = RING;
    for (int k = 0; k < RING; k++) m->to_valve[k] = m->to_piston[k] = PUMP;
#endif
    pressures(m->y, 0, m->values + 1);
}

#if CASE == 4
/* A step of the line: what left one end arrives at the other after its delay. Leaves what the piston's end is to be
   given: the mean pressure there, or the mean wave that arrives over the next step of this length. */
static void line(Model *m, double from, double v, double h, int parts) {
    long delay = lround(DELAY / h);
    double flow = -DOWN * v, sum = 0;
    for (int k = 0; k < parts; k++, m->at++) {
        double wave = m->to_piston[(m->at - delay) % RING], other = m->to_valve[(m->at - delay) % RING];
        m->command = command_at(m->command, from + v * h * (k + 1));
        m->y[1] += (m->command - m->y[1]) * -expm1(-h / SHIFT);
        double source = OUTLET + (PUMP - OUTLET) * 0.5 * (1 + m->y[1]), in = (source - other) / (RESISTANCE + LINE);
        m->to_valve[m->at % RING] = wave + 2 * LINE * flow;
        m->to_piston[m->at % RING] = other + 2 * LINE * in;
        sum += wave + LINE * flow;
    }
    if (!PRESSURE) {
        sum = 0;
        for (int k = 0; k < parts; k++) sum += m->to_piston[(m->at + k - delay) % RING];
    }
    m->y[0] = sum / parts;
}
#else
/* The classical method of Runge and Kutta over part of a step, in which the piston moves evenly. */
static void part(Model *m, double x, double v, double h) {
    static const double AT[4] = {0, 0.5, 0.5, 1}, WEIGHT[4] = {1. / 6, 1. / 3, 1. / 3, 1. / 6};
    double k[SIZE] = {0}, y[SIZE], sum[SIZE];
    for (int i = 0; i < SIZE; i++) sum[i] = m->y[i];
    for (int stage = 0; stage < 4; stage++) {
        for (int i = 0; i < SIZE; i++) y[i] = m->y[i] + AT[stage] * h * k[i];
        rates(y, m->command, x + AT[stage] * h * v, v, k);
        for (int i = 0; i < SIZE; i++) sum[i] += WEIGHT[stage] * h * k[i];
    }
    for (int i = 0; i < SIZE; i++) m->y[i] = sum[i];
}

#endif

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real size, fmi2Boolean keep) {
    Model *m = c;
    double to = m->values[POSITION], from = m->begun ? m->before : to;
    m->begun = 1;
    m->before = to;
    if (size <= 0) return fmi2OK;
    int parts = (int)ceil(size / FINEST - 1e-9);
    double h = size / parts, v = (to - from) / size;
#if CASE == 4
    line(m, from, v, h, parts);
#else
    for (int k = 0; k < parts; k++) {
        m->command = command_at(m->command, from + v * h * (k + 1));
        part(m, from + v * h * k, v, h);
    }
#endif
    pressures(m->y, v, m->values + 1);
    return fmi2OK;
}

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char *fmi2GetVersion(void) { return fmi2Version; }
fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String k[]) { return fmi2OK; }

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible, fmi2Boolean logging) {
    Model *m = calloc(1, sizeof *m);
    if (m) m->values[POSITION] = BEGIN;
    if (m) start(m);
    return m;
}

void fmi2FreeInstance(fmi2Component c) { free(c); }
fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean d, fmi2Real t, fmi2Real s, fmi2Boolean e, fmi2Real f) { return fmi2OK; }
fmi2Status fmi2EnterInitializationMode(fmi2Component c) { return fmi2OK; }
fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    Model *m = c;
    start(m);
    m->begun = 1;
    m->before = m->values[POSITION];
    return fmi2OK;
}
fmi2Status fmi2Terminate(fmi2Component c) { return fmi2OK; }
fmi2Status fmi2Reset(fmi2Component c) { ((Model *)c)->values[POSITION] = BEGIN; start(c); return fmi2OK; }

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2Real v[]) {
    for (size_t i = 0; i < n; i++) v[i] = ((Model *)c)->values[r[i]];
    return fmi2OK;
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2Real v[]) {
    for (size_t i = 0; i < n; i++) ((Model *)c)->values[r[i]] = v[i];
    return fmi2OK;
}

/* What it has none of. */
#define NONE(name, ...) fmi2Status name(fmi2Component c, __VA_ARGS__) { return n ? fmi2Error : fmi2OK; }
#define GET(kind) NONE(fmi2Get##kind, const fmi2ValueReference r[], size_t n, fmi2##kind v[])
#define SET(kind) NONE(fmi2Set##kind, const fmi2ValueReference r[], size_t n, const fmi2##kind v[])
GET(Integer) GET(Boolean) GET(String) SET(Integer) SET(Boolean) SET(String)
NONE(fmi2SetRealInputDerivatives, const fmi2ValueReference r[], size_t n, const fmi2Integer o[], const fmi2Real v[])
NONE(fmi2GetRealOutputDerivatives, const fmi2ValueReference r[], size_t n, const fmi2Integer o[], fmi2Real v[])
#define NEVER(name, ...) fmi2Status name(fmi2Component c, __VA_ARGS__) { return fmi2Error; }
NEVER(fmi2GetFMUstate, fmi2FMUstate *s)
NEVER(fmi2SetFMUstate, fmi2FMUstate s)
NEVER(fmi2FreeFMUstate, fmi2FMUstate *s)
NEVER(fmi2SerializedFMUstateSize, fmi2FMUstate s, size_t *n)
NEVER(fmi2SerializeFMUstate, fmi2FMUstate s, fmi2Byte b[], size_t n)
NEVER(fmi2DeSerializeFMUstate, const fmi2Byte b[], size_t n, fmi2FMUstate *s)
NEVER(fmi2GetDirectionalDerivative, const fmi2ValueReference u[], size_t n, const fmi2ValueReference k[], size_t m, const fmi2Real d[], fmi2Real v[])
NEVER(fmi2GetStatus, const fmi2StatusKind k, fmi2Status *v)
NEVER(fmi2GetRealStatus, const fmi2StatusKind k, fmi2Real *v)
NEVER(fmi2GetIntegerStatus, const fmi2StatusKind k, fmi2Integer *v)
NEVER(fmi2GetBooleanStatus, const fmi2StatusKind k, fmi2Boolean *v)
NEVER(fmi2GetStringStatus, const fmi2StatusKind k, fmi2String *v)
fmi2Status fmi2CancelStep(fmi2Component c) { return fmi2Error; }
