/* FMI 2.0, model exchange: each change that leaves the delay is a time event. */
#include <string.h>

#include "instance.h"

fmi2Status fmi2EnterEventMode(fmi2Component c) {
    (void)c;
    return fmi2OK;
}

fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *info) {
    Instance *self = c;
    if (!plant_send(&self->plant)) return no_memory(self);
    plant_receive(&self->plant);
    memset(info, 0, sizeof *info);
    info->nextEventTimeDefined = self->plant.count > 0;
    if (self->plant.count) info->nextEventTime = (double)self->plant.arrivals[0].acts_ns / 1e9;
    return fmi2OK;
}

fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c) {
    (void)c;
    return fmi2OK;
}

fmi2Status fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean no_set_state, fmi2Boolean *event_mode,
                                       fmi2Boolean *terminate) {
    (void)c, (void)no_set_state;
    *event_mode = *terminate = fmi2False;
    return fmi2OK;
}

fmi2Status fmi2SetTime(fmi2Component c, fmi2Real time) {
    ((Instance *)c)->plant.now.time_ns = nanoseconds(time);
    return fmi2OK;
}

fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t n) {
    if (n != STATES) return fail(c, "%.0f states given, there are %.0f", (double)n, STATES);
    memcpy(((Instance *)c)->plant.now.x, x, n * sizeof(double));
    return fmi2OK;
}

fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real dx[], size_t n) {
    if (n != STATES) return fail(c, "%.0f derivatives asked for, there are %.0f", (double)n, STATES);
    plant_derivatives(&((Instance *)c)->plant, dx);
    return fmi2OK;
}

fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real z[], size_t n) {
    (void)z;
    return n ? fail(c, "there are no event indicators", 0.0, 0.0) : fmi2OK;
}

fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t n) {
    if (n != STATES) return fail(c, "%.0f states asked for, there are %.0f", (double)n, STATES);
    memcpy(x, ((Instance *)c)->plant.now.x, n * sizeof(double));
    return fmi2OK;
}

fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real nominal[], size_t n) {
    (void)c;
    for (size_t i = 0; i < n; i++) nominal[i] = 1.0;
    return fmi2OK;
}
