/* FMI 2.0, co-simulation: steps are exact whatever their length. */
#include <stdlib.h>

#include "instance.h"

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real start, fmi2Real length, fmi2Boolean no_set_state) {
    (void)no_set_state;
    Instance *self = c;
    int64_t start_ns = nanoseconds(start), stop_ns = nanoseconds(start + length);
    if (llabs(start_ns - self->plant.now.time_ns) > 1 || stop_ns < start_ns)
        return fail(self, "step from %.9f s, but the model stands at %.9f s", start,
                    (double)self->plant.now.time_ns / 1e9);
    if (!plant_send(&self->plant)) return no_memory(self);
    plant_advance(&self->plant, stop_ns);
    return fmi2OK;
}

fmi2Status fmi2CancelStep(fmi2Component c) {
    return fail(c, "no step is ever pending", 0.0, 0.0);
}

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference refs[], size_t n,
                                       const fmi2Integer order[], const fmi2Real values[]) {
    (void)refs, (void)order, (void)values;
    return n ? fail(c, "inputs are held over a step, they have no derivatives", 0.0, 0.0) : fmi2OK;
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference refs[], size_t n,
                                        const fmi2Integer order[], fmi2Real values[]) {
    (void)refs, (void)order, (void)values;
    return n ? fail(c, "output derivatives are not provided", 0.0, 0.0) : fmi2OK;
}

fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value) {
    if (kind != fmi2LastSuccessfulTime) return fmi2Discard;
    *value = (double)((Instance *)c)->plant.now.time_ns / 1e9;
    return fmi2OK;
}

fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value) {
    (void)c;
    if (kind != fmi2Terminated) return fmi2Discard;
    *value = fmi2False;
    return fmi2OK;
}

fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Status *value) {
    (void)c, (void)kind, (void)value;
    return fmi2Discard; /* steps are never asynchronous */
}

fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Integer *value) {
    (void)c, (void)kind, (void)value;
    return fmi2Discard;
}

fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind kind, fmi2String *value) {
    (void)c, (void)kind, (void)value;
    return fmi2Discard;
}
