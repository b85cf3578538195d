/* SUNDIALS on the hammer: IDA (BDF of the equation of motion as it is, with its mass, and an exact
 * Jacobian of HALF diagonals on either side), CVODE (Adams) and ARKODE (explicit, order 5), with
 * their own root finding.
 *
 * Hammer and task are a `Case` of src/schema.rs, as JSON; the answer is its `Answer`. The state
 * is interleaved, (u_0, v_0, u_1, v_1, ..., psi). The explicit solvers have M^-1 f by the factors of
 * M, which is tridiagonal.
 *
 *     sundials_peer case.json ida|adams|erk|bdf tolerance
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
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_band.h>
#include <sunmatrix/sunmatrix_dense.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>
#include <time.h>

enum { HALF = 3, NAMES = 64, SOLID = 5, PATHS = 5, ROOTS = SOLID + 8 + 2 * PATHS, ROOM = 4000000 };
enum { FF, DFC, FC, BC, SS };
enum { IDA, ADAMS, ERK, BDF };

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

/* Air in two chambers: mass and inner energy of each follow `psi` in the state. A port is shut, open in
 * part or wholly; a flow is straight, slower than sound or choked, from its first side to its second or back. */
enum { SHUT, PART, WHOLE };
enum { STRAIGHT, SUBSONIC, CHOKED };
static const double GAS = 287.05, KAPPA = 1.4, EDGE = 0.995, WAY[4] = {-1, 1, 1, -1};
static struct {
  double area[2], dead[2], length, edge[4], height, port[2], discharge, leak, drag, warm, out[2];
} *air;
static int aired, width[4], flows[PATHS], back[PATHS];
static double choke;

static double jet(double ratio) {
  const double rest = pow(ratio, 2 / KAPPA) - pow(ratio, (KAPPA + 1) / KAPPA);
  return sqrt(rest > 0 ? rest : 0);
}

/* Position and speed of the piston. */
static double moved(const double *y, int rate) {
  double sum = rate ? 0 : -gap0;
  for (int i = 0; i < n; i++) sum += relative[i] * y[2 * i + rate];
  return sum;
}

/* Pressure and temperature of supply, exhaust, drive and return chamber. */
static void sides(const double *y, double side[4][2]) {
  const double x = moved(y, 0), *gas = y + 2 * n + 1;
  const double room[2] = {air->dead[0] + air->area[0] * (air->length + x), air->dead[1] - air->area[1] * x};
  for (int i = 0; i < 2; i++) {
    side[i][0] = air->out[i], side[i][1] = air->warm;
    side[2 + i][0] = (KAPPA - 1) * gas[2 * i + 1] / room[i];
    side[2 + i][1] = (KAPPA - 1) * gas[2 * i + 1] / (GAS * gas[2 * i]);
  }
}

static const int ENDS[PATHS][2] = {{0, 2}, {2, 1}, {0, 3}, {3, 1}, {2, 3}};

static double opened(int path, double x) {
  if (path == 4) return air->leak;
  const double part = WAY[path] * (x - air->edge[path]) / air->height;
  const double share = width[path] == SHUT ? 0 : width[path] == WHOLE ? 1 : part;
  return air->discharge * air->port[path % 2] * share;
}

/* Adds the forces on piston and bit, and gives the rates of the gas. */
static void blow(const double *y, double *force, double *rate) {
  double side[4][2], mass[PATHS], heat[PATHS];
  sides(y, side);
  for (int i = 0; i < PATHS; i++) {
    const double *high = side[ENDS[i][back[i]]], *low = side[ENDS[i][!back[i]]];
    const double straight = jet(EDGE) / (1 - EDGE) * (high[0] - low[0]);
    const double shape = flows[i] == STRAIGHT ? straight
                         : flows[i] == CHOKED ? jet(choke) * high[0] : jet(low[0] / high[0]) * high[0];
    const double unit = sqrt(2 * KAPPA / ((KAPPA - 1) * GAS * high[1])) * shape;
    mass[i] = opened(i, moved(y, 0)) * (back[i] ? -unit : unit);
    heat[i] = KAPPA * GAS / (KAPPA - 1) * mass[i] * high[1];
  }
  const double speed = moved(y, 1), drive = side[2][0], other = side[3][0], out = air->out[1];
  force[0] += (drive - out) * air->area[0] - (other - out) * air->area[1] - air->drag * speed;
  force[1] += (other - out) * air->area[1];
  rate[0] = mass[0] - mass[1] - mass[4], rate[2] = mass[2] - mass[3] + mass[4];
  rate[1] = heat[0] - heat[1] - heat[4] - drive * air->area[0] * speed;
  rate[3] = heat[2] - heat[3] + heat[4] + other * air->area[1] * speed;
}

/* Puts a flow on the formula of the present pressures. */
static void classify(const double *y, int path) {
  double side[4][2];
  sides(y, side);
  const double one = side[ENDS[path][0]][0], two = side[ENDS[path][1]][0];
  const double ratio = one > two ? two / one : one / two;
  back[path] = two > one;
  flows[path] = ratio > EDGE ? STRAIGHT : ratio > choke ? SUBSONIC : CHOKED;
}

/* Ports by the piston's place, chambers at the pressure of supply or exhaust. */
static void fill(double *y) {
  const double x = moved(y, 0);
  const double room[2] = {air->dead[0] + air->area[0] * (air->length + x), air->dead[1] - air->area[1] * x};
  choke = pow(2 / (KAPPA + 1), KAPPA / (KAPPA - 1));
  for (int i = 0; i < 4; i++) {
    const double beyond = WAY[i] * (x - air->edge[i]);
    width[i] = beyond < 0 ? SHUT : beyond < air->height ? PART : WHOLE;
  }
  for (int i = 0; i < 2; i++) {
    const double work = air->out[width[2 * i] == SHUT] * room[i];
    y[2 * n + 1 + 2 * i] = work / (GAS * air->warm), y[2 * n + 2 + 2 * i] = work / (KAPPA - 1);
  }
  for (int i = 0; i < PATHS; i++) classify(y, i);
}

/* Its guards: of each port the ends of its opening, of each flow the bounds of its formula. */
static void air_guards(const double *y, double *g) {
  static const char *names[] = {"Port", "Whole"};
  static char known[16][24];
  double side[4][2];
  const double x = moved(y, 0);
  sides(y, side);
  for (int i = 0; i < 8; i++) {
    const int port = i / 2, whole = i % 2, open = width[port] == (whole ? PART : SHUT);
    const double place = WAY[port] * (x - air->edge[port]) - (whole ? air->height : 0);
    const int leaves = width[port] == (whole ? WHOLE : PART);
    g[i] = open || leaves ? (open ? place : -place) - dx : -1;
    char *name = known[2 * i + open];
    if (!*name)
      sprintf(name, "{\"%s\":[%d,%d,%s]}", names[whole], port / 2, port % 2, open ? "true" : "false");
    watched[SOLID + i] = name;
  }
  for (int i = 0; i < PATHS; i++) {
    const double ratio = side[ENDS[i][!back[i]]][0] / side[ENDS[i][back[i]]][0];
    const double least = flows[i] == STRAIGHT ? EDGE : flows[i] == SUBSONIC ? choke : 0;
    const double most = flows[i] == STRAIGHT ? 1 : flows[i] == SUBSONIC ? EDGE : choke;
    const int still = opened(i, x) == 0;
    g[8 + 2 * i] = still ? -1 : least - ratio - 1e-12, watched[SOLID + 8 + 2 * i] = "";
    g[9 + 2 * i] = still ? -1 : ratio - most - 1e-12, watched[SOLID + 9 + 2 * i] = "";
  }
}

static void turn(int root, double *y) {
  if (root < 8) {
    const int port = root / 2, whole = root % 2;
    width[port] = width[port] == PART ? (whole ? WHOLE : SHUT) : PART;
    if (width[port] == PART && !whole) classify(y, port);
  } else if (root % 2) {
    const int path = (root - 8) / 2;
    if (flows[path] == STRAIGHT) back[path] = !back[path];
    else flows[path]--;
  } else flows[(root - 8) / 2]++;
}

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
  double *out = N_VGetArrayPointer(rate), push[2] = {0, 0};
  if (aired) blow(y, push, out + 2 * n + 1);
  for (int i = 0; i < n; i++) {
    double sum = k[i] * y[2 * i] + c[i] * y[2 * i + 1];
    if (i > 0) sum += k_off[i - 1] * y[2 * i - 2] + c_off[i - 1] * y[2 * i - 1];
    if (i + 1 < n) sum += k_off[i] * y[2 * i + 2] + c_off[i] * y[2 * i + 3];
    a[i] = forces[i] - sum + (i < 2 ? push[i] : 0);
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
  const double vr = moved(y, 0);
  for (int i = 0; i < ROOTS; i++) g[i] = -1;
  if (aired) air_guards(y, g + SOLID);
  g[0] = (closed ? gap : -gap) - dx, watched[0] = closed ? "Open" : "Close";
  g[1] = aired ? -1 : (down ? vr : -vr - stroke) - dx, watched[1] = down ? "Q9" : "Q10";
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
  } else if (kind != IDA) {
    solver = CVodeCreate(kind == BDF ? CV_BDF : CV_ADAMS, context);
    CVodeInit(solver, rhs, 0, y);
    CVodeSVtolerances(solver, tolerance, tolerances);
    CVodeSetUserData(solver, scratch);
    CVodeSetMaxNumSteps(solver, -1);
    CVodeRootInit(solver, ROOTS, guards);
    if (kind == ADAMS) CVodeSetNonlinearSolver(solver, SUNNonlinSol_FixedPoint(y, 0, context));
    else {
      SUNMatrix matrix = SUNDenseMatrix(N_VGetLength(y), N_VGetLength(y), context);
      CVodeSetLinearSolver(solver, SUNLinSol_Dense(y, matrix, context), matrix);
    }
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
  if (kind != IDA) return CVode(solver, stop, y, t, CV_ONE_STEP);
  return IDASolve(solver, stop, t, y, yp, IDA_ONE_STEP);
}

/* Goes to `stop`; the flag and, at a root, its index. Steps one by one, to be patient. All three
 * solvers number their successes alike: 0 a step, 1 the stop, 2 a root. */
static int go(void *solver, double stop, N_Vector y, N_Vector yp, double *t, double start,
              int *root) {
  int roots[ROOTS], flag = 0;
  if (kind == ERK) ERKStepSetStopTime(solver, stop);
  else if (kind != IDA) CVodeSetStopTime(solver, stop);
  else IDASetStopTime(solver, stop);
  while (flag == 0) {
    flag = step(solver, stop, y, yp, t);
    if (seconds() - start > patience) return -1000;
  }
  if (flag == IDA_ROOT_RETURN) {
    if (kind == ERK) ERKStepGetRootInfo(solver, roots);
    else if (kind != IDA) CVodeGetRootInfo(solver, roots);
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
      if (at - events < ROOM - 99 && *watched[root]) {
        const char *quote = root < SOLID ? "\"" : "";
        at += sprintf(at, "%s[%.17g,%s%s%s]", at > events ? "," : "", *t, quote, watched[root], quote);
      }
      if (root < SOLID) transition(watched[root], y);
      else turn(root - SOLID, y);
      enter();
      if (kind == ERK) ERKStepReInit(solver, rhs, *t, state);
      else if (kind != IDA) CVodeReInit(solver, *t, state);
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
  kind = *word[2] == 'e' ? ERK : *word[2] == 'a' ? ADAMS : *word[2] == 'b' ? BDF : IDA;
  aired = size("air") > 0, air = (void *)array("air");
  double *scratch = malloc(n * sizeof *scratch), t = 0;
  forces = malloc(n * sizeof *forces);
  mass = malloc(n * sizeof *mass), mass_off = malloc(n * sizeof *mass_off);
  for (int i = 0; i < n; i++) { /* M = L D L' */
    const double above = i > 0 ? lower[i - 1] * mass_off[i - 1] : 0;
    mass[i] = 1 / inverse[i] + above, mass_off[i] = i + 1 < n ? lower[i] / inverse[i] : 0;
  }
  N_Vector state = N_VNew_Serial(2 * n + 1 + 4 * aired, context), rate = N_VClone(state);
  N_Vector tolerances = N_VClone(state);
  double *y = N_VGetArrayPointer(state), *atol = N_VGetArrayPointer(tolerances);
  N_VConst(0, state), N_VConst(tolerance, tolerances);
  for (int i = 0; i < n; i++) y[2 * i] = array("start")[i], atol[2 * i] = 1e-3 * tolerance;
  for (int i = 0; i < 2 * aired; i++) atol[2 * n + 1 + 2 * i] = 1e-3 * tolerance;
  if (aired) fill(y);
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
