/* A trapped chamber of oil as an FMU of its own (FMI 2.0, co-simulation): the volume swept goes in, its
   pressure comes out. See oil_chamber.py. */
#include <stdlib.h>
#include "fmi2Functions.h"

enum { DRIVE_VOLUME, DRIVE_PRESSURE, MODULUS, VOLUME, REST, COUNT };

static const double STARTS[COUNT] = {0.0, 2e7, 1.5e9, 2e-5, 2e7};

static void settle(double *x) { x[DRIVE_PRESSURE] = x[REST] - x[MODULUS] * x[DRIVE_VOLUME] / x[VOLUME]; }

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char *fmi2GetVersion(void) { return fmi2Version; }
fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String k[]) { return fmi2OK; }

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible, fmi2Boolean logging) {
    double *x = malloc(sizeof STARTS);
    for (int i = 0; x && i < COUNT; i++) x[i] = STARTS[i];
    return x;
}

void fmi2FreeInstance(fmi2Component c) { free(c); }
fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean d, fmi2Real t, fmi2Real s, fmi2Boolean e, fmi2Real f) { return fmi2OK; }
fmi2Status fmi2EnterInitializationMode(fmi2Component c) { return fmi2OK; }
fmi2Status fmi2ExitInitializationMode(fmi2Component c) { settle(c); return fmi2OK; }
fmi2Status fmi2Terminate(fmi2Component c) { return fmi2OK; }
fmi2Status fmi2Reset(fmi2Component c) { for (int i = 0; i < COUNT; i++) ((double *)c)[i] = STARTS[i]; return fmi2OK; }

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2Real v[]) {
    for (size_t i = 0; i < n; i++) v[i] = ((double *)c)[r[i]];
    return fmi2OK;
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2Real v[]) {
    for (size_t i = 0; i < n; i++) ((double *)c)[r[i]] = v[i];
    return fmi2OK;
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real size, fmi2Boolean keep) { settle(c); return fmi2OK; }

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
