/* A small FMI 3.0 co-simulation FMU with array variables: y' = (u - y) / 0.1 s for three channels, exact.
 *
 * It defines what it does; the rest of the interface is stubbed by the build.
 *   INTERNAL_STEP_S, or parameter h: y moves on this grid only, and lastSuccessfulTime tells.
 *   STARTS: start values of u.
 *   LAG: what it tells is this much, of t and h, behind.
 */
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#define CHANNELS 3
enum { OK, ERROR = 3 };

typedef struct {
    double u[CHANNELS], y[CHANNELS], time, h;
} Model;

const char *fmi3GetVersion(void) { return "3.0"; }

void *fmi3InstantiateCoSimulation(const char *name, const char *token, const char *resources, bool visible,
                                  bool logging, bool event_mode, bool early, const uint32_t *required, size_t n,
                                  void *environment, void *log, void *update) {
    (void)name, (void)token, (void)resources, (void)visible, (void)logging, (void)event_mode, (void)early;
    (void)required, (void)n, (void)environment, (void)log, (void)update;
    Model *m = calloc(1, sizeof(Model));
#ifdef INTERNAL_STEP_S
    m->h = INTERNAL_STEP_S;
#endif
#ifdef STARTS
    memcpy(m->u, (double[]){STARTS}, sizeof m->u);
#endif
    return m;
}
void fmi3FreeInstance(void *m) { free(m); }
int fmi3EnterInitializationMode(void *m, bool a, double b, double c, bool d, double e) {
    (void)m, (void)a, (void)b, (void)c, (void)d, (void)e;
    return OK;
}
int fmi3ExitInitializationMode(void *m) { return m ? OK : ERROR; }
int fmi3Terminate(void *m) { return m ? OK : ERROR; }

static double *place(Model *m, uint32_t reference) { return reference == 1 ? m->u : m->y; }

int fmi3GetFloat64(void *m, const uint32_t *r, size_t n, double *v, size_t nv) {
    if (nv != n * CHANNELS) return ERROR;
    for (size_t i = 0; i < n; i++) memcpy(v + i * CHANNELS, place(m, r[i]), CHANNELS * sizeof *v);
    return OK;
}
int fmi3SetFloat64(void *m, const uint32_t *r, size_t n, const double *v, size_t nv) {
    if (n == 1 && nv == 1 && r[0] == 3) {
        ((Model *)m)->h = *v;
        return OK;
    }
    if (nv != n * CHANNELS) return ERROR;
    for (size_t i = 0; i < n; i++) memcpy(place(m, r[i]), v + i * CHANNELS, CHANNELS * sizeof *v);
    return OK;
}

static void advance(Model *m, double h) {
    for (int i = 0; i < CHANNELS; i++) m->y[i] = m->u[i] + (m->y[i] - m->u[i]) * exp(-h / 0.1);
    m->time += h;
}

int fmi3DoStep(void *c, double t, double h, bool keep, bool *event, bool *terminate, bool *early, double *reached) {
    (void)keep;
    Model *m = c;
    if (m->h > 0.0)
        while (m->time + m->h <= t + h + 1e-9) advance(m, m->h);
    else
        advance(m, h);
    *event = *terminate = *early = false;
    *reached = m->time;
#ifdef LAG
    *reached -= LAG;
#endif
    return OK;
}

int fmi3GetFMUState(void *m, void **s) {
    *s = malloc(sizeof(Model));
    memcpy(*s, m, sizeof(Model));
    return OK;
}
int fmi3SetFMUState(void *m, void *s) {
    memcpy(m, s, sizeof(Model));
    return OK;
}
int fmi3FreeFMUState(void *m, void **s) {
    (void)m;
    free(*s);
    *s = NULL;
    return OK;
}
int fmi3SerializedFMUStateSize(void *m, void *s, size_t *n) {
    (void)m, (void)s;
    *n = sizeof(Model);
    return OK;
}
int fmi3SerializeFMUState(void *m, void *s, uint8_t *b, size_t n) {
    (void)m;
    memcpy(b, s, n);
    return OK;
}
int fmi3DeserializeFMUState(void *m, const uint8_t *b, size_t n, void **s) {
    (void)m;
    *s = malloc(n);
    memcpy(*s, b, n);
    return OK;
}
