#include "muscle_plant.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "expm.h"

#define NS_PER_S 1e9
#define STACKED (STATES + MUSCLES)

#if LINEAR_RECRUITMENT
static double recruited(const Memory *now, int muscle) { return now->input[2 * muscle + 1] / FULL_SCALE_S; }
#else
/* Fraction of a muscle's axons that a pulse excites: lognormal thresholds behind Lapicque's curve. */
static double recruited(const Memory *now, int muscle) {
    double current = now->input[2 * muscle];
    double width = now->input[2 * muscle + 1];
    if (!(current > 0.0) || !(width > 0.0)) return 0.0;
    double effective = current / (1.0 + now->parameter[CHRONAXIE] / width);
    double z = log(effective / now->parameter[THRESHOLD + muscle]) / now->parameter[SPREAD + muscle];
    return 0.5 * erfc(-z * sqrt(0.5));
}
#endif

void plant_reset(Plant *plant) {
    memset(&plant->now, 0, sizeof plant->now);
    memcpy(plant->now.parameter, PARAMETER_START, sizeof plant->now.parameter);
    plant->count = 0;
    for (int k = 0; k < KEPT_STEPS; k++) plant->steps[k].length_ns = -1;
    plant->next_step = 0;
}

void plant_free(Plant *plant) {
    free(plant->arrivals);
    plant->arrivals = NULL;
    plant->count = plant->capacity = 0;
}

static int reserve(Plant *plant, size_t count) {
    if (count <= plant->capacity) return 1;
    size_t capacity = plant->capacity ? plant->capacity : 64;
    while (capacity < count) capacity *= 2;
    Arrival *grown = realloc(plant->arrivals, capacity * sizeof *grown);
    if (!grown) return 0;
    plant->arrivals = grown;
    plant->capacity = capacity;
    return 1;
}

int plant_assign(Plant *plant, const Memory *now, const Arrival *arrivals, size_t count) {
    if (!reserve(plant, count)) return 0;
    /* The kept steps hold for the gains they were made with. */
    if (memcmp(plant->now.parameter, now->parameter, sizeof now->parameter))
        for (int k = 0; k < KEPT_STEPS; k++) plant->steps[k].length_ns = -1;
    plant->now = *now;
    plant->count = count;
    if (count) memcpy(plant->arrivals, arrivals, count * sizeof *arrivals);
    return 1;
}

int plant_send(Plant *plant) {
    double fraction[MUSCLES];
    for (int i = 0; i < MUSCLES; i++) fraction[i] = recruited(&plant->now, i);
    if (!memcmp(fraction, plant->now.sent, sizeof fraction)) return 1;
    int64_t acts_ns = plant->now.time_ns + llround(plant->now.parameter[DELAY] * NS_PER_S);
    /* Inputs set twice at one instant: only the last counts. */
    if (plant->count && plant->arrivals[plant->count - 1].acts_ns == acts_ns) plant->count--;
    if (!reserve(plant, plant->count + 1)) return 0;
    Arrival *arrival = &plant->arrivals[plant->count++];
    arrival->acts_ns = acts_ns;
    memcpy(arrival->fraction, fraction, sizeof fraction);
    memcpy(plant->now.sent, fraction, sizeof fraction);
    return 1;
}

void plant_receive(Plant *plant) {
    size_t due = 0;
    while (due < plant->count && plant->arrivals[due].acts_ns <= plant->now.time_ns) due++;
    if (!due) return;
    memcpy(plant->now.acting, plant->arrivals[due - 1].fraction, sizeof plant->now.acting);
    plant->count -= due;
    memmove(plant->arrivals, plant->arrivals + due, plant->count * sizeof *plant->arrivals);
}

/* Zero-order hold by one exponential of the stacked matrix [A B G; 0 0] (Van Loan 1978). */
static void make_step(const Plant *plant, int64_t length_ns, Step *step) {
    double stacked[STACKED * STACKED] = {0}, exponential[STACKED * STACKED];
    double length = (double)length_ns / NS_PER_S;
    for (int i = 0; i < STATES; i++) {
        for (int j = 0; j < STATES; j++) stacked[i * STACKED + j] = A[i * STATES + j] * length;
        for (int j = 0; j < MUSCLES; j++)
            stacked[i * STACKED + STATES + j] =
                B[i * MUSCLES + j] * plant->now.parameter[GAIN + j] * length;
    }
    expm(STACKED, stacked, exponential);
    for (int i = 0; i < STATES; i++) {
        memcpy(step->ad + i * STATES, exponential + i * STACKED, STATES * sizeof(double));
        memcpy(step->bd + i * MUSCLES, exponential + i * STACKED + STATES, MUSCLES * sizeof(double));
    }
    step->length_ns = length_ns;
}

static const Step *step_of(Plant *plant, int64_t length_ns) {
    for (int k = 0; k < KEPT_STEPS; k++)
        if (plant->steps[k].length_ns == length_ns) return &plant->steps[k];
    Step *step = &plant->steps[plant->next_step];
    plant->next_step = (plant->next_step + 1) % KEPT_STEPS;
    make_step(plant, length_ns, step);
    return step;
}

static void go(Plant *plant, int64_t stop_ns) {
    const Step *step = step_of(plant, stop_ns - plant->now.time_ns);
    double next[STATES];
    for (int i = 0; i < STATES; i++) {
        double sum = 0.0;
        for (int j = 0; j < STATES; j++) sum += step->ad[i * STATES + j] * plant->now.x[j];
        for (int j = 0; j < MUSCLES; j++) sum += step->bd[i * MUSCLES + j] * plant->now.acting[j];
        next[i] = sum;
    }
    memcpy(plant->now.x, next, sizeof next);
    plant->now.time_ns = stop_ns;
}

void plant_advance(Plant *plant, int64_t stop_ns) {
    plant_receive(plant);
    while (plant->now.time_ns < stop_ns) {
        int64_t until = stop_ns;
        if (plant->count && plant->arrivals[0].acts_ns < stop_ns) until = plant->arrivals[0].acts_ns;
        go(plant, until);
        plant_receive(plant);
    }
}

void plant_derivatives(const Plant *plant, double *dx) {
    for (int i = 0; i < STATES; i++) {
        double sum = 0.0;
        for (int j = 0; j < STATES; j++) sum += A[i * STATES + j] * plant->now.x[j];
        for (int j = 0; j < MUSCLES; j++)
            sum += B[i * MUSCLES + j] * plant->now.parameter[GAIN + j] * plant->now.acting[j];
        dx[i] = sum;
    }
}

double plant_output(const Plant *plant, int index) {
    double sum = OFFSET[index];
    for (int j = 0; j < STATES; j++) sum += C[index * STATES + j] * plant->now.x[j];
    /* The last outputs are activations; their states carry the muscles' gains with them. */
    int muscle = index - (OUTPUTS - MUSCLES);
    return muscle < 0 ? sum : sum / plant->now.parameter[GAIN + muscle];
}
