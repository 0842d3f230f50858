/* A small FMI 2.0 FMU that behaves or misbehaves as it is compiled to.
 *
 * Co-simulation: x' = (u - x) / 0.1 s, y = x, k = counted steps (Integer), exact between communication points.
 *   CRASH_AT_LOAD, CRASH_IN_INSTANTIATION; NEEDS_MB: refuses instantiation where so much cannot be allocated.
 *    CRASH, ABORT, HANG, REFUSE: in initialisation.
 *   ERROR_AT_S, DISCARD_AT_S: in mid-run (ENDS: for the run to end).    CRASH_AT_END: in fmi2Terminate.    PRINTS: a line every step.
 *   AT_S and MISDEED, a statement: in mid-run.
 *   INTERNAL_STEP_S, or parameter h: x moves on this grid only; TELLS: and the FMU admits it.
 *   LAG: what TELLS says is this much, of t and h, behind.
 *   MOVES: w is the time at the communication point (else y), whatever the grid of y.
 *   WARNS: each step returns fmi2Warning, with a message where SAYS is its text (for a time).
 *   FORGETS: a saved state leaves x out.     SQUARE_S: y is a square wave of this half period instead.
 * Model exchange: BALL is a bouncing ball (state events); else x' = 1 up to 0.0505 s and -1 after (time event).
 */
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "fmi2Functions.h"

#define RESTITUTION 0.8
#define TURN_S 0.0505

typedef struct {
    double x[2], u, time, h, w, lag;
    int steps;
    const fmi2CallbackFunctions *functions;
} Model;

#ifdef CRASH_AT_LOAD
__attribute__((constructor)) static void load(void) { raise(SIGSEGV); }
#endif

fmi2Component fmi2Instantiate(fmi2String n, fmi2Type t, fmi2String g, fmi2String r,
                              const fmi2CallbackFunctions *f, fmi2Boolean v, fmi2Boolean l) {
    (void)n, (void)t, (void)g, (void)r, (void)v, (void)l;
#ifdef CRASH_IN_INSTANTIATION
    raise(SIGSEGV);
#endif
#ifdef NEEDS_MB
    void *needed = malloc(NEEDS_MB * 1000000ul);
    if (!needed) return NULL;
    free(needed);
#endif
    Model *m = calloc(1, sizeof *m);
    m->functions = f;
#ifdef INTERNAL_STEP_S
    m->h = INTERNAL_STEP_S;
#endif
#ifdef BALL
    m->x[0] = 1.0;
#endif
    return m;
}
void fmi2FreeInstance(fmi2Component c) { free(c); }

fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    Model *m = c;
    (void)m;
#ifdef CRASH
    raise(SIGSEGV);
#endif
#ifdef ABORT
    abort();
#endif
#ifdef HANG
    for (;;) sleep(1);
#endif
#ifdef REFUSE
    m->functions->logger(m->functions->componentEnvironment, "small", fmi2Error, "e", "no licence for %s", "small");
    return fmi2Error;
#endif
    return fmi2OK;
}

#ifdef WARNS
#define DONE fmi2Warning
#else
#define DONE fmi2OK
#endif
fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean b) {
    (void)b;
    Model *m = c;
    m->steps++;
#ifdef LAG
    m->lag = LAG;
#endif
    m->w = t + h;
#ifdef PRINTS
    printf("{\"stdout\": %g}\n", t);
    fflush(stdout);
    fprintf(stderr, "stderr at %g s\n", t);
#endif
#ifdef SAYS
    m->functions->logger(m->functions->componentEnvironment, "small", fmi2Warning, "w", SAYS, t);
#endif
#ifdef MISDEED
    if (t + 1e-9 > AT_S) MISDEED;
#endif
#ifdef ERROR_AT_S
    if (t + 1e-9 > ERROR_AT_S) {
        m->functions->logger(m->functions->componentEnvironment, "small", fmi2Error, "e", "dry at %.3f s", t);
        return fmi2Error;
    }
#endif
#ifdef DISCARD_AT_S
    if (t + 1e-9 > DISCARD_AT_S) return fmi2Discard;
#endif
#if defined SQUARE_S
    m->time = t + h;
    m->x[0] = (long)floor(m->time / SQUARE_S + 1e-6) % 2;
#else
    if (m->h > 0.0) {
        while (m->time + m->h <= t + h + 1e-9) {
            m->x[0] = m->u + (m->x[0] - m->u) * exp(-m->h / 0.1);
            m->time += m->h;
        }
        return DONE;
    }
    m->x[0] = m->u + (m->x[0] - m->u) * exp(-h / 0.1);
    m->time = t + h;
#endif
    return DONE;
}

fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind k, fmi2Boolean *v) {
    (void)c, (void)k, (void)v;
#ifdef ENDS
    *v = k == fmi2Terminated;
    return fmi2OK;
#else
    return fmi2Discard;
#endif
}
fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind k, fmi2Real *v) {
    (void)c, (void)k, (void)v;
#ifdef TELLS
    *v = ((Model *)c)->time - ((Model *)c)->lag;
    return fmi2OK;
#else
    return fmi2Discard;
#endif
}

#ifdef MOVES
#define W m->w
#else
#define W m->x[0]
#endif
/* references: 0 u, 1 y, 2 x, 3 der(x), 4 v, 5 der(v), 6 h, 7 w; Integer 0: steps */
fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2Real v[]) {
    Model *m = c;
    for (size_t i = 0; i < n; i++) v[i] = r[i] == 0 ? m->u : r[i] == 4 ? m->x[1] : r[i] == 7 ? W : m->x[0];
    return fmi2OK;
}
fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2Real v[]) {
    for (size_t i = 0; i < n; i++)
        if (r[i] == 0) ((Model *)c)->u = v[i];
        else if (r[i] == 6) ((Model *)c)->h = v[i];
    return fmi2OK;
}
fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2Integer v[]) {
    (void)r;
    for (size_t i = 0; i < n; i++) v[i] = ((Model *)c)->steps;
    return fmi2OK;
}

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *s) {
    Model *copy = malloc(sizeof *copy);
    *copy = *(Model *)c;
#ifdef FORGETS
    copy->x[0] = 0.0;
#endif
    *s = copy;
    return fmi2OK;
}
fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate s) {
    const fmi2CallbackFunctions *functions = ((Model *)c)->functions;
    *(Model *)c = *(Model *)s;
    ((Model *)c)->functions = functions;
    return fmi2OK;
}
fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *s) {
    (void)c;
    free(*s);
    *s = NULL;
    return fmi2OK;
}
fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate s, size_t *n) {
    (void)c, (void)s;
    *n = sizeof(Model);
    return fmi2OK;
}
fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate s, fmi2Byte b[], size_t n) {
    (void)c;
    memcpy(b, s, n);
    return fmi2OK;
}
fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte b[], size_t n, fmi2FMUstate *s) {
    (void)c;
    *s = malloc(n);
    memcpy(*s, b, n);
    return fmi2OK;
}

fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *e) {
    Model *m = c;
    memset(e, 0, sizeof *e);
#ifdef BALL
    if (m->x[0] <= 0.0 && m->x[1] < 0.0) {
        m->x[1] *= -RESTITUTION;
        e->valuesOfContinuousStatesChanged = fmi2True;
    }
#else
    e->nextEventTimeDefined = m->time < TURN_S;
    e->nextEventTime = TURN_S;
    m->steps = m->time >= TURN_S;
#endif
    return fmi2OK;
}
fmi2Status fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean b, fmi2Boolean *e, fmi2Boolean *t) {
    (void)c, (void)b;
    *e = *t = fmi2False;
    return fmi2OK;
}
fmi2Status fmi2SetTime(fmi2Component c, fmi2Real t) {
    ((Model *)c)->time = t;
    return fmi2OK;
}
fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t n) {
    memcpy(((Model *)c)->x, x, n * sizeof *x);
    return fmi2OK;
}
fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t n) {
    memcpy(x, ((Model *)c)->x, n * sizeof *x);
    return fmi2OK;
}
fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real d[], size_t n) {
    Model *m = c;
    (void)n;
#ifdef BALL
    d[0] = m->x[1];
    d[1] = -9.81;
#else
    d[0] = m->steps ? -1.0 : 1.0;
#endif
    return fmi2OK;
}
fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real z[], size_t n) {
    if (n) z[0] = ((Model *)c)->x[0];
    return fmi2OK;
}

/* What is left of the interface does nothing. */
const char *fmi2GetTypesPlatform(void) { return "default"; }
const char *fmi2GetVersion(void) { return "2.0"; }
fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean a, fmi2Real b, fmi2Real t, fmi2Boolean d, fmi2Real e) {
    (void)c, (void)a, (void)b, (void)t, (void)d, (void)e;
    return fmi2OK;
}
fmi2Status fmi2EnterInitializationMode(fmi2Component c) { return c ? fmi2OK : fmi2Error; }
fmi2Status fmi2EnterEventMode(fmi2Component c) { return c ? fmi2OK : fmi2Error; }
fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c) { return c ? fmi2OK : fmi2Error; }
fmi2Status fmi2Terminate(fmi2Component c) {
#ifdef CRASH_AT_END
    raise(SIGSEGV);
#endif
    return c ? fmi2OK : fmi2Error;
}
