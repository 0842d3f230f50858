/* FMI 2.0: creation, initialisation, end.  Time is counted in whole nanoseconds inside. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "instance.h"

fmi2Status fail(const Instance *self, const char *format, double a, double b) {
    if (self->functions && self->functions->logger)
        self->functions->logger(self->functions->componentEnvironment, self->name, fmi2Error,
                                "logStatusError", format, a, b);
    return fmi2Error;
}

fmi2Status no_memory(const Instance *self) {
    return fail(self, "out of memory at %.9g s", (double)self->plant.now.time_ns / 1e9, 0.0);
}

int64_t nanoseconds(double time_s) { return (int64_t)llround(time_s * 1e9); }

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char *fmi2GetVersion(void) { return fmi2Version; }

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String categories[]) {
    (void)c, (void)on, (void)n, (void)categories;
    return fmi2OK; /* nothing but errors is ever logged */
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type kind, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible,
                              fmi2Boolean logging) {
    (void)resources, (void)visible, (void)logging;
    Instance *self = calloc(1, sizeof *self);
    if (!self) return NULL;
    self->functions = functions;
    self->kind = kind;
    self->name = malloc(strlen(name) + 1);
    if (self->name) strcpy(self->name, name);
    plant_reset(&self->plant);
    if (!self->name || strcmp(guid, MODEL_GUID)) {
        if (self->name) fail(self, "the GUID is not that of this binary", 0.0, 0.0);
        fmi2FreeInstance(self);
        return NULL;
    }
    return self;
}

void fmi2FreeInstance(fmi2Component c) {
    Instance *self = c;
    if (!self) return;
    plant_free(&self->plant);
    free(self->name);
    free(self);
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean tolerance_defined, fmi2Real tolerance,
                               fmi2Real start, fmi2Boolean stop_defined, fmi2Real stop) {
    (void)tolerance_defined, (void)tolerance, (void)stop_defined, (void)stop;
    ((Instance *)c)->plant.now.time_ns = nanoseconds(start);
    return fmi2OK;
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
    ((Instance *)c)->phase = INITIALISING;
    return fmi2OK;
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    Instance *self = c;
    const double *parameter = self->plant.now.parameter;
    for (int i = DELAY; i < PARAMETERS; i++)
        if (!(parameter[i] > 0.0) && !(i == DELAY && parameter[i] == 0.0))
            return fail(self, "parameter %.0f is %g, which is not positive", i, parameter[i]);
    self->phase = RUNNING;
    return fmi2OK;
}

fmi2Status fmi2Terminate(fmi2Component c) {
    ((Instance *)c)->phase = TERMINATED;
    return fmi2OK;
}

fmi2Status fmi2Reset(fmi2Component c) {
    Instance *self = c;
    plant_reset(&self->plant);
    self->phase = SETTING_UP;
    return fmi2OK;
}
