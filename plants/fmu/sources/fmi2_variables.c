/* FMI 2.0: reading and setting variables. */
#include <math.h>

#include "instance.h"

/* Value references, one block after the other; modelDescription.xml is written from the same order. */
enum {
    REF_INPUT = 0,
    REF_OUTPUT = REF_INPUT + INPUTS,
    REF_STATE = REF_OUTPUT + OUTPUTS,
    REF_DERIVATIVE = REF_STATE + STATES,
    REF_PARAMETER = REF_DERIVATIVE + STATES,
    REF_END = REF_PARAMETER + PARAMETERS
};

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference refs[], size_t n, fmi2Real values[]) {
    Instance *self = c;
    const Plant *plant = &self->plant;
    double dx[STATES];
    int have_dx = 0;
    for (size_t k = 0; k < n; k++) {
        int ref = (int)refs[k];
        if (ref < REF_OUTPUT) {
            values[k] = plant->now.input[ref - REF_INPUT];
        } else if (ref < REF_STATE) {
            values[k] = plant_output(plant, ref - REF_OUTPUT);
        } else if (ref < REF_DERIVATIVE) {
            values[k] = plant->now.x[ref - REF_STATE];
        } else if (ref < REF_PARAMETER) {
            if (!have_dx) plant_derivatives(plant, dx);
            have_dx = 1;
            values[k] = dx[ref - REF_DERIVATIVE];
        } else if (ref < REF_END) {
            values[k] = plant->now.parameter[ref - REF_PARAMETER];
        } else {
            return fail(self, "there is no real variable %.0f", ref, 0.0);
        }
    }
    return fmi2OK;
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference refs[], size_t n, const fmi2Real values[]) {
    Instance *self = c;
    for (size_t k = 0; k < n; k++) {
        int ref = (int)refs[k];
        if (!isfinite(values[k])) return fail(self, "variable %.0f set to a value that is not finite", ref, 0.0);
        if (ref < REF_OUTPUT) {
            self->plant.now.input[ref - REF_INPUT] = values[k];
        } else if (ref >= REF_STATE && ref < REF_DERIVATIVE && self->phase != RUNNING) {
            self->plant.now.x[ref - REF_STATE] = values[k];
        } else if (ref >= REF_PARAMETER && ref < REF_END && self->phase != RUNNING) {
            self->plant.now.parameter[ref - REF_PARAMETER] = values[k];
        } else {
            return fail(self, "variable %.0f cannot be set now", ref, 0.0);
        }
    }
    return fmi2OK;
}

#define NO_VARIABLES(Type)                                                                              \
    fmi2Status fmi2Get##Type(fmi2Component c, const fmi2ValueReference refs[], size_t n,                \
                             fmi2##Type values[]) {                                                     \
        (void)refs, (void)values;                                                                       \
        return n ? fail(c, "there are no variables of type " #Type, 0.0, 0.0) : fmi2OK;                 \
    }                                                                                                   \
    fmi2Status fmi2Set##Type(fmi2Component c, const fmi2ValueReference refs[], size_t n,                \
                             const fmi2##Type values[]) {                                               \
        (void)refs, (void)values;                                                                       \
        return n ? fail(c, "there are no variables of type " #Type, 0.0, 0.0) : fmi2OK;                 \
    }
NO_VARIABLES(Integer)
NO_VARIABLES(Boolean)
NO_VARIABLES(String)

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknown[], size_t n_unknown,
                                        const fmi2ValueReference known[], size_t n_known,
                                        const fmi2Real d_known[], fmi2Real d_unknown[]) {
    (void)unknown, (void)n_unknown, (void)known, (void)n_known, (void)d_known, (void)d_unknown;
    return fail(c, "directional derivatives are not provided", 0.0, 0.0);
}
