/* A host in C for any platform: runs the FMU with its start values, and prints some Real
 * variables at each communication point, as their bits.
 *
 *     host LIBRARY GUID STEP STEPS REFERENCE...
 */

#include "host.h"

#include <stdarg.h>

enum { CO_SIMULATION = 1 };

typedef struct {
    void (*logger)(void *, const char *, int, const char *, const char *, ...);
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*step_finished)(void *, int);
    void *environment;
} Callbacks;

typedef Component (*Instantiate)(
    const char *, int, const char *, const char *, const Callbacks *, int, int);
typedef int (*SetUp)(Component, int, double, double, int, double);
typedef int (*GetReal)(Component, const uint32_t *, size_t, double *);
typedef int (*DoStep)(Component, double, double, int);

static void log_line(
    void *environment, const char *name, int status, const char *category, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    (void)environment, (void)status, (void)category, (void)name;
    vsnprintf(logged, sizeof logged, format, arguments);
    va_end(arguments);
}

static void run(Library library, char **argument, const uint32_t *references, int count) {
    double step = atof(argument[3]), values[MOST];
    Callbacks callbacks = {.logger = log_line};
    Instantiate instantiate = (Instantiate)find(library, "fmi2Instantiate");
    GetReal get = (GetReal)find(library, "fmi2GetReal");
    DoStep advance = (DoStep)find(library, "fmi2DoStep");
    /* A logger with open arguments is called as each platform has it. */
    if (instantiate("stranger", CO_SIMULATION, "no guid", NULL, &callbacks, 0, 0)) refuse("GUID");
    if (!strstr(logged, "\"no guid\"")) refuse("the log line of a wrong GUID");
    Component hammer = instantiate("hammer", CO_SIMULATION, argument[2], NULL, &callbacks, 0, 0);
    if (!hammer) refuse("fmi2Instantiate");
    check(((SetUp)find(library, "fmi2SetupExperiment"))(hammer, 0, 0, 0, 0, 0), "setup");
    check(((Plain)find(library, "fmi2EnterInitializationMode"))(hammer), "initialization");
    Plain initialize = (Plain)find(library, "fmi2ExitInitializationMode");
    begin(), end(initialize(hammer), "initialization");
    for (int number = 0; number <= atoi(argument[4]); number++) {
        double point = (number - 1) * step;
        if (number) begin(), end(advance(hammer, point, step, 1), "fmi2DoStep");
        begin(), end(get(hammer, references, (size_t)count, values), "fmi2GetReal");
        print_row(values, count);
    }
    check(((Plain)find(library, "fmi2Terminate"))(hammer), "fmi2Terminate");
    ((Release)find(library, "fmi2FreeInstance"))(hammer);
}
