/* An FMU (FMI 2) without mechanics: a rigid quick-return mechanism at a given speed, whose follower seems to bend a little.
   It obeys the flags of its description, echoes parameters of every type, and can hang in a step. Compiled with -DONCE it allows one
   instance in a process. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { D, R, W, PHI0, L, UNUSED, PHI, OMEGA, Q2, S, XT, YT, U, A, EPS, F, REALS };
enum { OK, ERROR = 3 };

typedef struct {
    double x[REALS], time, step;
    int mode, count, flag;
    size_t letters;
} Plain;

static int alive;

static void observe(Plain *p) {
    double *x = p->x, phi = x[PHI0] + x[W] * p->time, ex = x[R] * cos(phi) - x[D], ey = x[R] * sin(phi);
    double q2 = acos(-1.0) + atan2(-ey, -ex), u = 1e-3 * x[L] * sin(phi);
    x[PHI] = phi, x[OMEGA] = x[W], x[Q2] = q2, x[S] = hypot(ex, ey), x[U] = 1e3 * u;
    x[XT] = x[D] + x[L] * cos(q2) - u * sin(q2), x[YT] = x[L] * sin(q2) + u * cos(q2);
    x[A] = p->count + 100.0 * p->flag + 1000.0 * p->letters + cos(phi), x[EPS] = 1e-4 * sin(phi), x[F] = cos(phi);
}

const char *fmi2GetTypesPlatform(void) { return "default"; }
const char *fmi2GetVersion(void) { return "2.0"; }

void *fmi2Instantiate(const char *name, int kind, const char *guid, const char *place, const void *callbacks, int visible, int logging) {
#ifdef ONCE
    if (alive) return NULL;
#endif
    alive += 1;
    return calloc(1, sizeof(Plain));
}

void fmi2FreeInstance(void *p) { alive -= 1, free(p); }
int fmi2SetupExperiment(void *p, int known, double tolerance, double start, int stops, double stop) { return OK; }
int fmi2EnterInitializationMode(void *p) { return OK; }
int fmi2ExitInitializationMode(void *p) { observe(p); return OK; }

int fmi2SetReal(Plain *p, const unsigned v[], size_t n, const double x[]) {
    for (size_t i = 0; i < n; i++) p->x[v[i]] = x[i];
    return OK;
}

int fmi2GetReal(Plain *p, const unsigned v[], size_t n, double x[]) {
    for (size_t i = 0; i < n; i++) x[i] = p->x[v[i]];
    return OK;
}

int fmi2SetInteger(Plain *p, const unsigned v[], size_t n, const int x[]) { *(v[0] ? &p->count : &p->mode) = x[0]; return OK; }
int fmi2SetBoolean(Plain *p, const unsigned v[], size_t n, const int x[]) { p->flag = x[0]; return OK; }
int fmi2SetString(Plain *p, const unsigned v[], size_t n, const char *const x[]) { p->letters = strlen(x[0]); return OK; }

int fmi2DoStep(Plain *p, double at, double step, int no_return) {
    if (p->step && fabs(step - p->step) > 1e-12) return ERROR;
    for (volatile int hangs = p->mode == 1 && at > 0.05; hangs;);
    p->step = step, p->time += step;
    observe(p);
    return OK;
}

#define ABSENT(name) int fmi2##name(void *p) { return ERROR; }
ABSENT(SetDebugLogging) ABSENT(Terminate) ABSENT(Reset) ABSENT(GetInteger) ABSENT(GetBoolean) ABSENT(GetString) ABSENT(GetFMUstate)
ABSENT(SetFMUstate) ABSENT(FreeFMUstate) ABSENT(SerializedFMUstateSize) ABSENT(SerializeFMUstate) ABSENT(DeSerializeFMUstate)
ABSENT(GetDirectionalDerivative) ABSENT(SetRealInputDerivatives) ABSENT(GetRealOutputDerivatives) ABSENT(CancelStep) ABSENT(GetStatus)
ABSENT(GetRealStatus) ABSENT(GetIntegerStatus) ABSENT(GetBooleanStatus) ABSENT(GetStringStatus)
