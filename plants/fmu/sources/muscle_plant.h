/* A linear plant behind recruitment curves and a pure delay, advanced exactly.
 *
 *   x' = A x + B G v(t - delay),   y = C x + offset,   x(0) = 0
 *
 * v holds the recruited fraction of each muscle, G the gain parameters on its diagonal.  A, B, C, offset and
 * the defaults of the parameters stand in plant_data.h, which the exporter writes.
 */
#ifndef MUSCLE_PLANT_H
#define MUSCLE_PLANT_H

#include <stddef.h>
#include <stdint.h>

#include "plant_data.h"

#define INPUTS (2 * MUSCLES)
#define KEPT_STEPS 8

/* Order of `parameter`: a gain a muscle, the delay in s; where recruitment is lognormal also a threshold in A
 * and a spread a muscle, and the chronaxie in s. */
enum { GAIN = 0, DELAY = MUSCLES, THRESHOLD, SPREAD = THRESHOLD + MUSCLES, CHRONAXIE = SPREAD + MUSCLES };
#if LINEAR_RECRUITMENT
#define PARAMETERS (DELAY + 1)
#else
#define PARAMETERS (CHRONAXIE + 1)
#endif

/* Recruited fractions on their way through the delay; they act from `acts_ns` on. */
typedef struct {
    int64_t acts_ns;
    double fraction[MUSCLES];
} Arrival;

/* All that the plant remembers, but for the arrivals: this is what is saved and restored. */
typedef struct {
    int64_t time_ns;
    double x[STATES];
    double input[INPUTS];          /* current in A and pulse width in s, by muscle */
    double parameter[PARAMETERS];
    double acting[MUSCLES];        /* fractions that act now */
    double sent[MUSCLES];          /* fractions last sent into the delay */
} Memory;

/* Exact step of one length: x(t + h) = ad x(t) + bd v. */
typedef struct {
    int64_t length_ns;
    double ad[STATES * STATES];
    double bd[STATES * MUSCLES];
} Step;

typedef struct {
    Memory now;
    Arrival *arrivals;             /* oldest first */
    size_t count, capacity;
    Step steps[KEPT_STEPS];        /* lengths met lately; derived, never saved */
    int next_step;
} Plant;

/* To the start values, at time 0.  Keeps the memory of `arrivals`. */
void plant_reset(Plant *plant);
void plant_free(Plant *plant);

/* The inputs act as they stand: sends changed fractions into the delay.  0 if memory runs out. */
int plant_send(Plant *plant);
/* Lets everything act that is due by now. */
void plant_receive(Plant *plant);
/* Goes exactly to stop_ns, through every arrival on the way. */
void plant_advance(Plant *plant, int64_t stop_ns);

void plant_derivatives(const Plant *plant, double *dx);
double plant_output(const Plant *plant, int index);

/* Replaces the memory and the arrivals.  0 if memory runs out. */
int plant_assign(Plant *plant, const Memory *now, const Arrival *arrivals, size_t count);

#endif
