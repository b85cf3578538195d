/* A host in C of FMI 3.0, with event mode and early return: runs the FMU with its start values, and
 * prints some Float64 variables wherever a step ends, as their bits.
 *
 *     host3 LIBRARY TOKEN STEP STEPS REFERENCE...
 */

#include "host.h"

#include <stdbool.h>

typedef void (*Log)(void *, int, const char *, const char *);
typedef Component (*Instantiate)(
    const char *, const char *, const char *, bool, bool, bool, bool, const uint32_t *, size_t,
    void *, Log, void *);
typedef int (*Enter)(Component, bool, double, double, bool, double);
typedef int (*Update)(Component, bool *, bool *, bool *, bool *, bool *, double *);
typedef int (*GetFloat64)(Component, const uint32_t *, size_t, double *, size_t);
typedef int (*DoStep)(Component, double, double, bool, bool *, bool *, bool *, double *);

static void log_line(void *environment, int status, const char *category, const char *message) {
    (void)environment, (void)status, (void)category;
    snprintf(logged, sizeof logged, "%s", message);
}

static void plain(Library library, const char *name, Component hammer) {
    check(((Plain)find(library, name))(hammer), name);
}

/* From event mode back to step mode. */
static void update(Library library, Component hammer) {
    bool again, terminate, nominals, values, next;
    double time;
    Update call = (Update)find(library, "fmi3UpdateDiscreteStates");
    check(call(hammer, &again, &terminate, &nominals, &values, &next, &time), "update");
    if (again || terminate || next) refuse("an update that needs no other");
    plain(library, "fmi3EnterStepMode", hammer);
}

static void run(Library library, char **argument, const uint32_t *references, int count) {
    double step = atof(argument[3]), until = step * atoi(argument[4]), time = 0, values[MOST];
    Instantiate instantiate = (Instantiate)find(library, "fmi3InstantiateCoSimulation");
    GetFloat64 get = (GetFloat64)find(library, "fmi3GetFloat64");
    DoStep advance = (DoStep)find(library, "fmi3DoStep");
    Component hammer = instantiate(
        "hammer", argument[2], NULL, false, false, true, true, NULL, 0, NULL, log_line, NULL);
    if (!hammer) refuse("fmi3InstantiateCoSimulation");
    Enter enter = (Enter)find(library, "fmi3EnterInitializationMode");
    check(enter(hammer, false, 0, 0, false, 0), "initialization");
    plain(library, "fmi3ExitInitializationMode", hammer);
    update(library, hammer);
    for (int number = 1; time < until;) {
        bool event, terminate, early;
        double next = number * step;
        begin();
        end(advance(hammer, time, next - time, true, &event, &terminate, &early, &time),
            "fmi3DoStep");
        begin();
        end(get(hammer, references, (size_t)count, values, (size_t)count), "fmi3GetFloat64");
        print_row(values, count);
        if (event) {
            plain(library, "fmi3EnterEventMode", hammer);
            update(library, hammer);
        }
        if (!early) number++;
    }
    plain(library, "fmi3Terminate", hammer);
    ((Release)find(library, "fmi3FreeInstance"))(hammer);
}
