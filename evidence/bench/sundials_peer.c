/* SUNDIALS on the hammer: IDA (BDF of the equation of motion as it is, with its mass, and an exact
 * Jacobian of HALF diagonals on either side), CVODE (Adams) and ARKODE (explicit, order 5), with
 * their own root finding.
 *
 * Hammer and task are a `Case` of src/schema.rs, as JSON; the answer is its `Answer`. The state
 * is interleaved, (u_0, v_0, u_1, v_1, ..., psi). The explicit solvers have M^-1 f by the factors of
 * M, which is tridiagonal.
 *
 *     sundials_peer case.json ida|adams|erk tolerance
 */
#include <arkode/arkode_erkstep.h>
#include <cvode/cvode.h>
#include <ida/ida.h>
#include <math.h>
#include <nvector/nvector_serial.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sunlinsol/sunlinsol_band.h>
#include <sunmatrix/sunmatrix_band.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>
#include <time.h>

enum { HALF = 3, NAMES = 64, ROOTS = 5, ROOM = 4000000 };
enum { FF, DFC, FC, BC, SS };
enum { IDA, ADAMS, ERK };

static struct {
  char name[24];
  int size;
  double *value;
} table[NAMES];
static int tables;

static int kind, n, bit, closed, rock = SS, down = 1;
static double ul, uu, gain, *forces, *relative, *lower, *inverse, *mass, *mass_off;
static double gap0, dx, dv, vs, stroke, barrier;
static const char *watched[ROOTS];
static double patience;

static int find(const char *name) {
  for (int i = 0; i < tables; i++)
    if (!strcmp(table[i].name, name)) return i;
  fprintf(stderr, "no %s\n", name);
  exit(1);
}

static double *array(const char *name) { return table[find(name)].value; }

static int size(const char *name) { return table[find(name)].size; }

static double number(const char *name) { return *array(name); }

/* Reads an object of numbers and arrays of numbers, which is all that a Case is. */
static void load(const char *path) {
  FILE *file = fopen(path, "r");
  char *text = NULL;
  size_t room = 0;
  if (!file || getdelim(&text, &room, '\0', file) < 0) exit(1);
  fclose(file);
  for (char *at = text; tables < NAMES && (at = strchr(at, '"')); tables++) {
    int used, count = 0;
    sscanf(++at, "%23[^\"]%n", table[tables].name, &used);
    at += used + 2 + (at[used + 2] == '[');
    double *value = malloc((strcspn(at, "\"") / 2 + 1) * sizeof *value), x;
    for (char *end; x = strtod(at, &end), end != at; at = end + (*end == ',')) value[count++] = x;
    table[tables].size = count;
    table[tables].value = value;
  }
  free(text);
}

static int system_index(void) { return 4 * closed + (rock == SS ? 3 : rock); }

static double *row(const char *format) {
  char name[24];
  snprintf(name, sizeof name, format, system_index());
  return array(name);
}

static double *k, *k_off, *c, *c_off;
static double power;

static void enter(void) {
  const double *dead = array("dead"), *drive = array("drive");
  const double amplitude = number("amplitude") * (down ? 1 : -1);
  for (int i = 0; i < n; i++) forces[i] = dead[i] + amplitude * drive[i];
  if (closed) {
    forces[bit - 1] += number("contact") * number("gap");
    forces[bit] -= number("contact") * number("gap");
  }
  if (rock == DFC || rock == FC) forces[n - 1] += number("loading") * ul;
  if (rock == BC || rock == SS) forces[n - 1] += number("unloading") * uu;
  k = row("k%d"), k_off = row("k%d_off"), c = row("c%d"), c_off = row("c%d_off");
  power = rock == DFC ? number("viscosity") : 0;
}

static void solve_mass(double *x) {
  for (int i = 1; i < n; i++) x[i] -= lower[i - 1] * x[i - 1];
  x[n - 1] *= inverse[n - 1];
  for (int i = n - 2; i >= 0; i--) x[i] = x[i] * inverse[i] - lower[i] * x[i + 1];
}

static int rhs(realtype t, N_Vector state, N_Vector rate, void *data) {
  (void)t;
  double *a = data;
  const double *y = N_VGetArrayPointer(state);
  double *out = N_VGetArrayPointer(rate);
  for (int i = 0; i < n; i++) {
    double sum = k[i] * y[2 * i] + c[i] * y[2 * i + 1];
    if (i > 0) sum += k_off[i - 1] * y[2 * i - 2] + c_off[i - 1] * y[2 * i - 1];
    if (i + 1 < n) sum += k_off[i] * y[2 * i + 2] + c_off[i] * y[2 * i + 3];
    a[i] = forces[i] - sum;
  }
  solve_mass(a);
  for (int i = 0; i < n; i++) out[2 * i] = y[2 * i + 1], out[2 * i + 1] = a[i];
  out[2 * n] = power * y[2 * n - 1] * y[2 * n - 1];
  return 0;
}

/* The equation of motion as it is, without the mass's inverse: M v' + K u + C v = f, u' = v. */
static int residual(realtype t, N_Vector state, N_Vector rate, N_Vector imbalance, void *data) {
  (void)t, (void)data;
  const double *y = N_VGetArrayPointer(state), *yp = N_VGetArrayPointer(rate);
  double *out = N_VGetArrayPointer(imbalance);
  for (int i = 0; i < n; i++) {
    double sum = mass[i] * yp[2 * i + 1] + k[i] * y[2 * i] + c[i] * y[2 * i + 1] - forces[i];
    for (int j = i - 1; j <= i + 1; j += 2) {
      if (j < 0 || j == n) continue;
      const int o = j < i ? j : i;
      sum += mass_off[o] * yp[2 * j + 1] + k_off[o] * y[2 * j] + c_off[o] * y[2 * j + 1];
    }
    out[2 * i] = yp[2 * i] - y[2 * i + 1], out[2 * i + 1] = sum;
  }
  out[2 * n] = yp[2 * n] - power * y[2 * n - 1] * y[2 * n - 1];
  return 0;
}

/* Exact, and banded: dF/dy + rate dF/dy'. */
static int jacobian(realtype t, realtype factor, N_Vector state, N_Vector rate, N_Vector imbalance,
                    SUNMatrix matrix, void *data, N_Vector t1, N_Vector t2, N_Vector t3) {
  (void)t, (void)rate, (void)imbalance, (void)data, (void)t1, (void)t2, (void)t3;
  for (int i = 0; i < n; i++) {
    SM_ELEMENT_B(matrix, 2 * i, 2 * i) = factor, SM_ELEMENT_B(matrix, 2 * i, 2 * i + 1) = -1;
    SM_ELEMENT_B(matrix, 2 * i + 1, 2 * i) = k[i];
    SM_ELEMENT_B(matrix, 2 * i + 1, 2 * i + 1) = factor * mass[i] + c[i];
    for (int j = i - 1; j <= i + 1; j += 2) {
      if (j < 0 || j == n) continue;
      const int o = j < i ? j : i;
      SM_ELEMENT_B(matrix, 2 * i + 1, 2 * j) = k_off[o];
      SM_ELEMENT_B(matrix, 2 * i + 1, 2 * j + 1) = factor * mass_off[o] + c_off[o];
    }
  }
  SM_ELEMENT_B(matrix, 2 * n, 2 * n) = factor;
  SM_ELEMENT_B(matrix, 2 * n, 2 * n - 1) = -2 * power * N_VGetArrayPointer(state)[2 * n - 1];
  return 0;
}

/* The guards of the mode, lowered by their resolution; -1 where there is none. */
static int guards(realtype t, N_Vector state, realtype *g, void *data) {
  (void)t, (void)data;
  const double *y = N_VGetArrayPointer(state);
  const double p = y[2 * n - 2], speed = y[2 * n - 1];
  const double gap = y[2 * bit] - y[2 * bit - 2] + gap0;
  double vr = -gap0;
  for (int i = 0; i < n; i++) vr += relative[i] * y[2 * i];
  for (int i = 0; i < ROOTS; i++) g[i] = -1;
  g[0] = (closed ? gap : -gap) - dx, watched[0] = closed ? "Open" : "Close";
  g[1] = (down ? vr : -vr - stroke) - dx, watched[1] = down ? "Q9" : "Q10";
  switch (rock) {
  case FF: g[2] = p - ul - dx, watched[2] = "Q1"; break;
  case DFC:
    g[2] = -speed - dv, watched[2] = "Q2";
    g[3] = y[2 * n] - barrier, watched[3] = "Q3";
    break;
  case FC: g[2] = -speed - dv, watched[2] = "Q4"; break;
  case BC:
    g[2] = uu - p - dx, watched[2] = "Q5";
    g[3] = speed - dv, watched[3] = "Q6";
    break;
  case SS:
    g[2] = uu - p - dx, watched[2] = "LiftOff";
    g[3] = speed - vs - dv, watched[3] = "Q7";
    g[4] = -speed - vs - dv, watched[4] = "Q8";
  }
  return 0;
}

static void transition(const char *event, double *y) {
  const double p = y[2 * n - 2], gamma = number("gamma");
  if (!strcmp(event, "Close") || !strcmp(event, "Open")) closed = *event == 'C';
  else if (!strcmp(event, "Q9")) down = 0;
  else if (!strcmp(event, "Q10")) down = 1;
  else if (!strcmp(event, "Q1")) rock = DFC, y[2 * n] = 0;
  else if (!strcmp(event, "Q3")) rock = FC;
  else if (!strcmp(event, "Q8")) rock = BC;
  else if (!strcmp(event, "Q2") || !strcmp(event, "Q4")) {
    const double foot = p - (p - ul) / gamma;
    gain = foot - uu, uu = foot, rock = BC;
  } else if (!strcmp(event, "Q5") || !strcmp(event, "LiftOff")) ul = uu, rock = FF;
  else if (!strcmp(event, "Q6") && gain < number("penetration")) rock = SS;
  else ul = p - gamma * (p - uu), rock = DFC, y[2 * n] = 0;
}

static int guards_too(realtype t, N_Vector state, N_Vector rate, realtype *g, void *data) {
  (void)rate;
  return guards(t, state, g, data);
}

static void *make(N_Vector y, N_Vector yp, N_Vector tolerances, double tolerance,
                  SUNContext context, double *scratch) {
  void *solver;
  if (kind == ERK) {
    solver = ERKStepCreate(rhs, 0, y, context);
    ERKStepSVtolerances(solver, tolerance, tolerances);
    ERKStepSetOrder(solver, 5);
    ERKStepSetUserData(solver, scratch);
    ERKStepSetMaxNumSteps(solver, -1);
    ERKStepRootInit(solver, ROOTS, guards);
  } else if (kind == ADAMS) {
    solver = CVodeCreate(CV_ADAMS, context);
    CVodeInit(solver, rhs, 0, y);
    CVodeSVtolerances(solver, tolerance, tolerances);
    CVodeSetUserData(solver, scratch);
    CVodeSetMaxNumSteps(solver, -1);
    CVodeRootInit(solver, ROOTS, guards);
    CVodeSetNonlinearSolver(solver, SUNNonlinSol_FixedPoint(y, 0, context));
  } else {
    solver = IDACreate(context);
    rhs(0, y, yp, scratch);
    IDAInit(solver, residual, 0, y, yp);
    IDASVtolerances(solver, tolerance, tolerances);
    IDASetMaxNumSteps(solver, -1);
    IDARootInit(solver, ROOTS, guards_too);
    SUNMatrix matrix = SUNBandMatrix(2 * n + 1, HALF, HALF, context);
    IDASetLinearSolver(solver, SUNLinSol_Band(y, matrix, context), matrix);
    IDASetJacFn(solver, jacobian);
  }
  return solver;
}

static double seconds(void) { return (double)clock() / CLOCKS_PER_SEC; }

static int step(void *solver, double stop, N_Vector y, N_Vector yp, double *t) {
  if (kind == ERK) return ERKStepEvolve(solver, stop, y, t, ARK_ONE_STEP);
  if (kind == ADAMS) return CVode(solver, stop, y, t, CV_ONE_STEP);
  return IDASolve(solver, stop, t, y, yp, IDA_ONE_STEP);
}

/* Goes to `stop`; the flag and, at a root, its index. Steps one by one, to be patient. All three
 * solvers number their successes alike: 0 a step, 1 the stop, 2 a root. */
static int go(void *solver, double stop, N_Vector y, N_Vector yp, double *t, double start,
              int *root) {
  int roots[ROOTS], flag = 0;
  if (kind == ERK) ERKStepSetStopTime(solver, stop);
  else if (kind == ADAMS) CVodeSetStopTime(solver, stop);
  else IDASetStopTime(solver, stop);
  while (flag == 0) {
    flag = step(solver, stop, y, yp, t);
    if (seconds() - start > patience) return -1000;
  }
  if (flag == IDA_ROOT_RETURN) {
    if (kind == ERK) ERKStepGetRootInfo(solver, roots);
    else if (kind == ADAMS) CVodeGetRootInfo(solver, roots);
    else IDAGetRootInfo(solver, roots);
    for (*root = 0; *root < ROOTS - 1 && roots[*root] <= 0; ++*root) {}
    return 1;
  }
  return flag < 0 ? flag : 0;
}

/* Solves the task; the flag of a failure is negative. Fills in the states and the events' text. */
static int solve(void *solver, N_Vector state, N_Vector rate, double *scratch, double *saved,
                 char *events, double *t) {
  const double *instant = array("instants"), start = seconds();
  double *y = N_VGetArrayPointer(state);
  char *at = events;
  const int instants = size("instants");
  int flag = 0, root = 0;
  for (int i = 0; i <= instants && flag >= 0; i++) {
    const double stop = i < instants ? instant[i] : number("end");
    while ((flag = go(solver, stop, state, rate, t, start, &root)) == 1) {
      if (at - events < ROOM - 99)
        at += sprintf(at, "%s[%.17g,\"%s\"]", at > events ? "," : "", *t, watched[root]);
      transition(watched[root], y);
      enter();
      if (kind == ERK) ERKStepReInit(solver, rhs, *t, state);
      else if (kind == ADAMS) CVodeReInit(solver, *t, state);
      else rhs(*t, state, rate, scratch), IDAReInit(solver, *t, state, rate);
    }
    for (int j = 0; j < n && i < instants; j++)
      saved[2 * n * i + j] = y[2 * j], saved[2 * n * i + n + j] = y[2 * j + 1];
  }
  return flag;
}

int main(int count, char **word) {
  if (count != 4) return 1;
  SUNContext context;
  SUNContext_Create(NULL, &context);
  load(word[1]);
  n = (int)number("nodes"), bit = (int)number("bit");
  relative = array("relative"), lower = array("lower"), inverse = array("inverse");
  gap0 = number("gap"), vs = number("speed"), stroke = number("stroke");
  dx = number("position_resolution"), dv = number("velocity_resolution");
  barrier = number("barrier"), patience = number("patience");
  const double tolerance = atof(word[3]);
  const int instants = size("instants");
  kind = !strcmp(word[2], "erk") ? ERK : !strcmp(word[2], "adams") ? ADAMS : IDA;
  double *scratch = malloc(n * sizeof *scratch), t = 0;
  forces = malloc(n * sizeof *forces);
  mass = malloc(n * sizeof *mass), mass_off = malloc(n * sizeof *mass_off);
  for (int i = 0; i < n; i++) { /* M = L D L' */
    const double above = i > 0 ? lower[i - 1] * mass_off[i - 1] : 0;
    mass[i] = 1 / inverse[i] + above, mass_off[i] = i + 1 < n ? lower[i] / inverse[i] : 0;
  }
  N_Vector state = N_VNew_Serial(2 * n + 1, context), rate = N_VClone(state);
  N_Vector tolerances = N_VClone(state);
  double *y = N_VGetArrayPointer(state), *atol = N_VGetArrayPointer(tolerances);
  N_VConst(0, state), N_VConst(tolerance, tolerances);
  for (int i = 0; i < n; i++) y[2 * i] = array("start")[i], atol[2 * i] = 1e-3 * tolerance;
  enter();
  void *solver = make(state, rate, tolerances, tolerance, context, scratch);
  char *events = calloc(1, ROOM);
  double *saved = malloc(instants * 2 * n * sizeof *saved);
  const double start = seconds();
  const int flag = solve(solver, state, rate, scratch, saved, events, &t);
  const double cpu = seconds() - start;
  if (flag < 0) return printf("{\"failure\":\"flag %d at %.6f s\"}\n", flag, t) < 0;
  printf("{\"cpu\":%.9g,\"states\":[", cpu);
  for (int i = 0; i < instants; i++)
    for (int j = 0; j < 2 * n; j++)
      printf("%s%.17g", j ? "," : i ? "],[" : "[", saved[2 * n * i + j]);
  printf("]],\"events\":[%s]}\n", events);
  return 0;
}
