/* A host in C for any platform: runs the FMU with its start values, and prints some Real
 * variables at each communication point, as their bits.
 *
 *     host LIBRARY GUID STEP STEPS REFERENCE...
 */

#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#ifdef _WIN32
#include <windows.h>
#define OPEN(path) LoadLibraryA(path)
#define FIND(library, name) GetProcAddress(library, name)
#define CLOSE(library) FreeLibrary(library)
typedef HMODULE Library;
#else
#include <dlfcn.h>
#define OPEN(path) dlopen(path, RTLD_NOW | RTLD_LOCAL)
#define FIND(library, name) dlsym(library, name)
#define CLOSE(library) dlclose(library)
typedef void *Library;
#endif

enum { OK = 0, CO_SIMULATION = 1, MOST = 256 };

typedef void *Component;

typedef struct {
    void (*logger)(void *, const char *, int, const char *, const char *, ...);
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*step_finished)(void *, int);
    void *environment;
} Callbacks;

typedef Component (*Instantiate)(
    const char *, int, const char *, const char *, const Callbacks *, int, int);
typedef void (*Release)(Component);
typedef int (*SetUp)(Component, int, double, double, int, double);
typedef int (*Plain)(Component);
typedef int (*GetReal)(Component, const uint32_t *, size_t, double *);
typedef int (*DoStep)(Component, double, double, int);

/* The last line that the FMU logged. */
static char logged[512];

static void log_line(
    void *environment, const char *name, int status, const char *category, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    (void)environment, (void)status, (void)category, (void)name;
    vsnprintf(logged, sizeof logged, format, arguments);
    va_end(arguments);
}

static void refuse(const char *what) {
    fprintf(stderr, "host: %s failed: %s\n", what, logged);
    exit(1);
}

static void *find(Library library, const char *name) {
    void *function = (void *)FIND(library, name);
    if (!function) refuse(name);
    return function;
}

static void check(int status, const char *what) {
    if (status != OK) refuse(what);
}

static void print_row(const double *values, int count) {
    for (int i = 0; i < count; i++) {
        uint64_t bits;
        memcpy(&bits, &values[i], sizeof bits);
        /* In halves: the old C runtime of Windows has its own letters for 64 bits. */
        printf("%s%08x%08x", i ? " " : "", (unsigned)(bits >> 32), (unsigned)bits);
    }
    printf("\n");
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
    check(((Plain)find(library, "fmi2ExitInitializationMode"))(hammer), "initialization");
    for (int number = 0; number <= atoi(argument[4]); number++) {
        if (number) check(advance(hammer, (number - 1) * step, step, 1), "fmi2DoStep");
        check(get(hammer, references, (size_t)count, values), "fmi2GetReal");
        print_row(values, count);
    }
    check(((Plain)find(library, "fmi2Terminate"))(hammer), "fmi2Terminate");
    ((Release)find(library, "fmi2FreeInstance"))(hammer);
}

int main(int arguments, char **argument) {
    uint32_t references[MOST];
    int count = arguments - 5;
    if (count < 1 || count > MOST) refuse("usage: host LIBRARY GUID STEP STEPS REFERENCE...");
    for (int i = 0; i < count; i++) references[i] = (uint32_t)strtoul(argument[5 + i], NULL, 10);
    Library library = OPEN(argument[1]);
    if (!library) refuse(argument[1]);
    run(library, argument, references, count);
    CLOSE(library);
    return 0;
}
