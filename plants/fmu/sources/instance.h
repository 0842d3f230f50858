/* One instance of the FMU, as all of its interface functions see it. */
#ifndef INSTANCE_H
#define INSTANCE_H

#include <stdint.h>

#include "fmi2Functions.h"
#include "muscle_plant.h"

typedef enum { SETTING_UP, INITIALISING, RUNNING, TERMINATED } Phase;

typedef struct {
    Plant plant;
    Phase phase;
    fmi2Type kind;
    const fmi2CallbackFunctions *functions;
    char *name;
} Instance;

/* Log an error; `format` may take two doubles. */
fmi2Status fail(const Instance *self, const char *format, double a, double b);
fmi2Status no_memory(const Instance *self);

int64_t nanoseconds(double time_s);

#endif
