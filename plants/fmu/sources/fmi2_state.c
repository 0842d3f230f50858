/* FMI 2.0: saving and restoring; a restored instance goes on bit for bit as the saved one did. */
#include <stdlib.h>
#include <string.h>

#include "instance.h"

typedef struct {
    Memory now;
    Phase phase;
    size_t count;
    Arrival arrivals[]; /* `count` of them */
} Snapshot;

static size_t snapshot_size(size_t count) { return sizeof(Snapshot) + count * sizeof(Arrival); }

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state) {
    Instance *self = c;
    size_t count = self->plant.count;
    Snapshot *saved = realloc(*state, snapshot_size(count));
    if (!saved) return no_memory(self);
    memset(saved, 0, sizeof *saved); /* padding too: equal states serialise to equal bytes */
    saved->now = self->plant.now;
    saved->phase = self->phase;
    saved->count = count;
    if (count) memcpy(saved->arrivals, self->plant.arrivals, count * sizeof(Arrival));
    *state = saved;
    return fmi2OK;
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) {
    Instance *self = c;
    const Snapshot *saved = state;
    if (!plant_assign(&self->plant, &saved->now, saved->arrivals, saved->count)) return no_memory(self);
    self->phase = saved->phase;
    return fmi2OK;
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state) {
    (void)c;
    free(*state);
    *state = NULL;
    return fmi2OK;
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t *size) {
    (void)c;
    *size = snapshot_size(((const Snapshot *)state)->count);
    return fmi2OK;
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size) {
    size_t needed = snapshot_size(((const Snapshot *)state)->count);
    if (size < needed) return fail(c, "a state of %.0f bytes does not fit into %.0f", (double)needed, (double)size);
    memcpy(bytes, state, needed);
    return fmi2OK;
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state) {
    Snapshot head;
    if (size < sizeof head) return fail(c, "%.0f bytes are no state", (double)size, 0.0);
    memcpy(&head, bytes, sizeof head);
    if (size != snapshot_size(head.count)) return fail(c, "%.0f bytes are no state", (double)size, 0.0);
    Snapshot *saved = realloc(*state, size);
    if (!saved) return no_memory(c);
    memcpy(saved, bytes, size);
    *state = saved;
    return fmi2OK;
}
