/* FMI 2.0 co-simulation of a sampled block: it steps at its own ticks, under the inputs of the communication step
 * in which they fall, and its outputs are those of its last tick. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "BLOCK_HEADER"
#include "block_fmu.h"
#include "fmi2Functions.h"

typedef struct {
    block_state state;
    block_inputs in;
    block_outputs out;
    double age[BLOCK_FMU_AGES + 1]; /* s, of each input */
    int64_t now_ns, ticks;
    int running;
} Memory;

typedef struct {
    Memory memory;
    const fmi2CallbackFunctions *functions;
    char *name;
} Instance;

static fmi2Status fail(const Instance *self, const char *format, double a, double b)
{
    if (self->functions && self->functions->logger)
        self->functions->logger(self->functions->componentEnvironment, self->name, fmi2Error, "logStatusError",
                                format, a, b);
    return fmi2Error;
}

static double *variable(Memory *m, fmi2ValueReference reference)
{
    switch (reference) {
        BLOCK_FMU_VARIABLES
    default:
        return NULL;
    }
}

static void start(Memory *m)
{
    memset(m, 0, sizeof *m); /* padding too: equal states serialise to equal bytes */
    block_init(&m->state);
    BLOCK_FMU_STARTS
}

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char *fmi2GetVersion(void) { return fmi2Version; }

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String categories[])
{
    (void)c, (void)on, (void)n, (void)categories;
    return fmi2OK; /* nothing but errors is ever logged */
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type kind, fmi2String guid, fmi2String folder,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible, fmi2Boolean logging)
{
    (void)folder, (void)visible, (void)logging;
    Instance *self = calloc(1, sizeof *self);
    if (!self) return NULL;
    self->functions = functions;
    self->name = malloc(strlen(name) + 1);
    if (self->name) strcpy(self->name, name);
    if (!self->name || kind != fmi2CoSimulation || strcmp(guid, BLOCK_FMU_GUID)) {
        if (self->name) fail(self, "not co-simulation, or the GUID is not that of this binary", 0.0, 0.0);
        fmi2FreeInstance(self);
        return NULL;
    }
    start(&self->memory);
    return self;
}

void fmi2FreeInstance(fmi2Component c)
{
    Instance *self = c;
    if (self) free(self->name);
    free(self);
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean tolerance_defined, fmi2Real tolerance, fmi2Real from,
                               fmi2Boolean stop_defined, fmi2Real stop)
{
    (void)tolerance_defined, (void)tolerance, (void)stop_defined, (void)stop;
    return from == 0.0 ? fmi2OK : fail(c, "a start at %g s; the block starts at 0", from, 0.0);
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c)
{
    (void)c;
    return fmi2OK;
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c)
{
    ((Instance *)c)->memory.running = 1;
    return fmi2OK;
}

fmi2Status fmi2Terminate(fmi2Component c)
{
    (void)c;
    return fmi2OK;
}

fmi2Status fmi2Reset(fmi2Component c)
{
    start(&((Instance *)c)->memory);
    return fmi2OK;
}

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference refs[], size_t n, fmi2Real values[])
{
    Instance *self = c;
    for (size_t k = 0; k < n; k++) {
        const double *place = variable(&self->memory, refs[k]);
        if (!place) return fail(c, "there is no real variable %.0f", refs[k], 0.0);
        values[k] = *place;
    }
    return fmi2OK;
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference refs[], size_t n, const fmi2Real values[])
{
    Instance *self = c;
    for (size_t k = 0; k < n; k++) {
        double *place = variable(&self->memory, refs[k]);
        const int age = refs[k] >= BLOCK_FMU_FIRST_AGE, input = refs[k] < BLOCK_FMU_INPUTS;
        if (!place || !(input || (age && !self->memory.running)))
            return fail(c, "variable %.0f cannot be set now", refs[k], 0.0);
        if (age && !(values[k] >= 0.0 && values[k] <= 3600.0))
            return fail(c, "variable %.0f set to an age of %g s, not 0 to 3600 s", refs[k], values[k]);
        *place = values[k];
    }
    return fmi2OK;
}

/* Instant of a tick: periods are added up as a ratio, so that ticks never drift. */
static int64_t tick_ns(int64_t tick) { return tick * BLOCK_FMU_PERIOD_NUM / BLOCK_FMU_PERIOD_DEN; }

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real from, fmi2Real length, fmi2Boolean no_set_state)
{
    (void)no_set_state;
    Memory *m = &((Instance *)c)->memory;
    const int64_t from_ns = llround(from * 1e9), stop_ns = llround((from + length) * 1e9);
    if (llabs(from_ns - m->now_ns) > 1 || stop_ns < from_ns)
        return fail(c, "step from %.9f s, but the block stands at %.9f s", from, (double)m->now_ns / 1e9);
    for (; tick_ns(m->ticks) + 1 < stop_ns; m->ticks++) { /* instants that differ by 1 ns are the same */
        m->in.time_ns = tick_ns(m->ticks);
        BLOCK_FMU_CAPTURES
        block_step(&m->state, &m->in, &m->out);
    }
    m->now_ns = stop_ns;
    return fmi2OK;
}

fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value)
{
    if (kind != fmi2LastSuccessfulTime) return fmi2Discard;
    *value = (double)((Instance *)c)->memory.now_ns / 1e9;
    return fmi2OK;
}

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state)
{
    if (!*state) *state = malloc(sizeof(Memory));
    if (!*state) return fail(c, "out of memory", 0.0, 0.0);
    memcpy(*state, &((Instance *)c)->memory, sizeof(Memory));
    return fmi2OK;
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state)
{
    memcpy(&((Instance *)c)->memory, state, sizeof(Memory));
    return fmi2OK;
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state)
{
    (void)c;
    free(*state);
    *state = NULL;
    return fmi2OK;
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t *size)
{
    (void)c, (void)state;
    *size = sizeof(Memory);
    return fmi2OK;
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size)
{
    if (size < sizeof(Memory)) return fail(c, "a state does not fit into %.0f bytes", (double)size, 0.0);
    memcpy(bytes, state, sizeof(Memory));
    return fmi2OK;
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state)
{
    if (size != sizeof(Memory)) return fail(c, "%.0f bytes are no state", (double)size, 0.0);
    if (!*state) *state = malloc(sizeof(Memory));
    if (!*state) return fail(c, "out of memory", 0.0, 0.0);
    memcpy(*state, bytes, size);
    return fmi2OK;
}

#define NO_VARIABLES(Type)                                                                                          \
    fmi2Status fmi2Get##Type(fmi2Component c, const fmi2ValueReference refs[], size_t n, fmi2##Type values[])       \
    {                                                                                                               \
        (void)refs, (void)values;                                                                                   \
        return n ? fail(c, "there are no variables of type " #Type, 0.0, 0.0) : fmi2OK;                             \
    }                                                                                                               \
    fmi2Status fmi2Set##Type(fmi2Component c, const fmi2ValueReference refs[], size_t n, const fmi2##Type values[]) \
    {                                                                                                               \
        (void)refs, (void)values;                                                                                   \
        return n ? fail(c, "there are no variables of type " #Type, 0.0, 0.0) : fmi2OK;                             \
    }
NO_VARIABLES(Integer)
NO_VARIABLES(Boolean)
NO_VARIABLES(String)

#define NO_STATUS(Name, Type)                                                                \
    fmi2Status fmi2Get##Name(fmi2Component c, const fmi2StatusKind kind, Type *value)        \
    {                                                                                        \
        (void)c, (void)kind, (void)value;                                                    \
        return fmi2Discard; /* steps are never asynchronous */                               \
    }
NO_STATUS(Status, fmi2Status)
NO_STATUS(IntegerStatus, fmi2Integer)
NO_STATUS(BooleanStatus, fmi2Boolean)
NO_STATUS(StringStatus, fmi2String)

fmi2Status fmi2CancelStep(fmi2Component c) { return fail(c, "no step is ever pending", 0.0, 0.0); }

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference refs[], size_t n,
                                       const fmi2Integer order[], const fmi2Real values[])
{
    (void)refs, (void)order, (void)values;
    return n ? fail(c, "inputs are held over a step, they have no derivatives", 0.0, 0.0) : fmi2OK;
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference refs[], size_t n,
                                        const fmi2Integer order[], fmi2Real values[])
{
    (void)refs, (void)order, (void)values;
    return n ? fail(c, "output derivatives are not provided", 0.0, 0.0) : fmi2OK;
}

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknown[], size_t n_unknown,
                                        const fmi2ValueReference known[], size_t n_known, const fmi2Real d_known[],
                                        fmi2Real d_unknown[])
{
    (void)unknown, (void)n_unknown, (void)known, (void)n_known, (void)d_known, (void)d_unknown;
    return fail(c, "directional derivatives are not provided", 0.0, 0.0);
}
