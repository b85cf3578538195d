/* A host that does what none should: it leaves the logger by longjmp, frees and steps the instance in it, steps one
 * instance from two threads, has no file descriptor left, and little stack; at last it leaves a step by longjmp.
 *
 *     battery LIBRARY GUID
 */

#define _GNU_SOURCE
#include <dlfcn.h>
#include <fcntl.h>
#include <link.h>
#include <pthread.h>
#include <setjmp.h>
#include <signal.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/time.h>
#include <ucontext.h>
#include <unistd.h>

enum { OK = 0, ERROR = 3, CO_SIMULATION = 1, STACK = 96 * 1024, STEPS = 50 };

typedef void *Component;
typedef void (*Log)(void *, const char *, int, const char *, const char *, ...);
typedef struct {
    Log logger;
    void *unused[3];
    void *environment;
} Callbacks;

static Component (*instantiate)(
    const char *, int, const char *, const char *, const Callbacks *, int, int);
static int (*set_up)(Component, int, double, double, int, double);
static int (*enter)(Component), (*leave)(Component);
static int (*advance)(Component, double, double, int);
static int (*get)(Component, const uint32_t *, size_t, double *);
static void (*release)(Component);
static const char *guid;

static void demand(int holds, const char *what) {
    if (holds) return;
    printf("not so: %s\n", what);
    exit(1);
}

static Component running(const Callbacks *callbacks) {
    Component hammer = instantiate("hammer", CO_SIMULATION, guid, NULL, callbacks, 0, 0);
    demand(hammer != NULL, "an instance");
    demand(set_up(hammer, 0, 0, 0, 0, 0) == OK && enter(hammer) == OK && leave(hammer) == OK, "a start");
    return hammer;
}

static jmp_buf out;
static Component within;
static int answer, heard;

static void jump(void *e, const char *n, int s, const char *c, const char *f, ...) {
    (void)e, (void)n, (void)s, (void)c, (void)f;
    longjmp(out, 1);
}

static void use(void *e, const char *n, int s, const char *c, const char *f, ...) {
    (void)e, (void)n, (void)s, (void)c, (void)f;
    if (heard++) return; /* The calls below log too. */
    answer = advance(within, 0, 1e-3, 1);
    release(within);
    demand(advance(within, 1e-3, 1e-3, 1) == ERROR, "a freed instance is refused");
}

static void callbacks(void) {
    Callbacks jumping = {.logger = jump}, using = {.logger = use};
    Component hammer = running(&jumping);
    if (!setjmp(out)) advance(hammer, 5, 1e-3, 1), demand(0, "an error is logged");
    demand(advance(hammer, 0, 1e-3, 1) == OK, "it goes on after a longjmp");
    release(hammer);
    within = running(&using);
    demand(advance(within, 5, 1e-3, 1) == ERROR, "a step from nowhere");
    demand(heard && answer == OK, "the logger may step and free");
}

static Component shared;

static void *step_shared(void *count) {
    /* Of two steps from one point one is refused. */
    for (int k = 0; k < STEPS; k++) *(int *)count += advance(shared, k * 1e-3, 1e-3, 1) == OK;
    return NULL;
}

static void threads(void) {
    Callbacks silent = {0};
    int counts[2] = {0, 0};
    pthread_t all[2];
    shared = running(&silent);
    for (int k = 0; k < 2; k++) demand(!pthread_create(&all[k], NULL, step_shared, &counts[k]), "a thread");
    for (int k = 0; k < 2; k++) pthread_join(all[k], NULL);
    demand(counts[0] + counts[1] <= STEPS && counts[0] + counts[1] > 0, "a step is made once");
    release(shared);
}

static void *run_once(void *unused) {
    Callbacks silent = {0};
    Component hammer = running(&silent);
    for (int k = 0; k < STEPS; k++) demand(advance(hammer, k * 1e-3, 1e-3, 1) == OK, "a step");
    release(hammer);
    return unused;
}

static void descriptors(void) {
    struct rlimit limit = {8, 8}, before;
    int open_ones[16], count = 0;
    getrlimit(RLIMIT_NOFILE, &before);
    limit.rlim_max = before.rlim_max;
    setrlimit(RLIMIT_NOFILE, &limit);
    while (count < 16 && (open_ones[count] = open("/dev/null", O_RDONLY)) >= 0) count++;
    demand(open("/dev/null", O_RDONLY) < 0, "none is left");
    run_once(NULL);
    while (count--) close(open_ones[count]);
    setrlimit(RLIMIT_NOFILE, &before);
}

static void little_stack(void) {
    pthread_t thread;
    pthread_attr_t with;
    pthread_attr_init(&with);
    demand(!pthread_attr_setstacksize(&with, STACK), "a stack");
    demand(!pthread_create(&thread, &with, run_once, NULL), "a thread");
    pthread_join(thread, NULL);
}

static sigjmp_buf away;
static uintptr_t code[2];

/* Where the library's code begins and ends. */
static int find_code(struct dl_phdr_info *object, size_t size, void *inside) {
    (void)size;
    for (int k = 0; k < object->dlpi_phnum; k++) {
        uintptr_t start = object->dlpi_addr + object->dlpi_phdr[k].p_vaddr;
        uintptr_t end = start + object->dlpi_phdr[k].p_memsz;
        if (object->dlpi_phdr[k].p_type == PT_LOAD && start <= (uintptr_t)inside && (uintptr_t)inside < end) {
            code[0] = start, code[1] = end;
            return 1;
        }
    }
    return 0;
}

/* Only out of the library's own code: who leaves malloc by a jump leaves it locked for ever. */
static void on_alarm(int signal, siginfo_t *info, void *context) {
    (void)signal, (void)info;
    uintptr_t at = (uintptr_t)((ucontext_t *)context)->uc_mcontext.gregs[REG_RIP];
    if (code[0] <= at && at < code[1]) siglongjmp(away, 1);
    struct itimerval again = {{0, 0}, {0, 100}};
    setitimer(ITIMER_REAL, &again, NULL);
}

/* Its instance stays with the thread that left the step: it is refused everywhere in that thread, and never waited for. */
static void left(void) {
    Callbacks silent = {0};
    struct itimerval soon = {{0, 0}, {0, 50000}};
    struct sigaction alarmed = {.sa_sigaction = on_alarm, .sa_flags = SA_SIGINFO};
    Component hammer = running(&silent);
    demand(dl_iterate_phdr(find_code, *(void **)&advance), "the library's code");
    demand(!sigaction(SIGALRM, &alarmed, NULL), "a handler");
    if (!sigsetjmp(away, 1)) {
        setitimer(ITIMER_REAL, &soon, NULL);
        for (int k = 0; k < 1000; k++) advance(hammer, k * 100.0, 100.0, 1);
        demand(0, "steps of 100 s end too soon");
    }
    double value;
    uint32_t first = 0;
    demand(get(hammer, &first, 1, &value) == ERROR, "the instance is refused");
    release(hammer);
    run_once(NULL);
}

int main(int count, char **argument) {
    demand(count == 3, "battery LIBRARY GUID");
    void *library = dlopen(argument[1], RTLD_NOW);
    demand(library != NULL, "the library");
    guid = argument[2];
    *(void **)&instantiate = dlsym(library, "fmi2Instantiate");
    *(void **)&set_up = dlsym(library, "fmi2SetupExperiment");
    *(void **)&enter = dlsym(library, "fmi2EnterInitializationMode");
    *(void **)&leave = dlsym(library, "fmi2ExitInitializationMode");
    *(void **)&advance = dlsym(library, "fmi2DoStep");
    *(void **)&get = dlsym(library, "fmi2GetReal");
    *(void **)&release = dlsym(library, "fmi2FreeInstance");
    callbacks();
    threads();
    descriptors();
    little_stack();
    left();
    puts("all held");
    return 0;
}
