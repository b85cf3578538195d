/* What the hosts in C share: a library is loaded, functions are found, rows of bits are printed.
 * Each has a function `run` of its own. With HOST_ROUNDING=upward it calls the FMU while it rounds
 * upward, and must get that back.
 */

#include <fenv.h>
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

enum { OK = 0, MOST = 256 };

typedef void *Component;
typedef void (*Release)(Component);
typedef int (*Plain)(Component);

/* The last line that the FMU logged. */
static char logged[512];

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

/* How the host rounds while it calls. */
static int rounding = FE_TONEAREST;

static void begin(void) { fesetround(rounding); }

static void end(int status, const char *what) {
    int found = fegetround();
    fesetround(FE_TONEAREST);
    check(status, what);
    if (found != rounding) refuse("giving back the host's rounding");
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

static void run(Library library, char **argument, const uint32_t *references, int count);

int main(int arguments, char **argument) {
    uint32_t references[MOST];
    int count = arguments - 5;
    if (count < 1 || count > MOST) refuse("usage: host LIBRARY GUID STEP STEPS REFERENCE...");
    for (int i = 0; i < count; i++) references[i] = (uint32_t)strtoul(argument[5 + i], NULL, 10);
    if (getenv("HOST_ROUNDING")) rounding = FE_UPWARD;
    Library library = OPEN(argument[1]);
    if (!library) refuse(argument[1]);
    run(library, argument, references, count);
    CLOSE(library);
    return 0;
}
