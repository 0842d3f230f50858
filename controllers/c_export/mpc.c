
/* ---- Predictive control: condensed programme over HORIZON periods (Maciejowski 2002, chapter 3). ---- */

/* Measurement and reference of a tick, rad, and the instants of capture and tick. */
typedef struct {
    double measured[OUTPUTS], target[HORIZON][OUTPUTS]; /* less the disturbance that is expected of the trial */
    double reference[HORIZON][OUTPUTS];
    int64_t captured_ns, now_ns;
} task;

/* Optimal drives without limits, and bounds of the unknowns and rows. */
typedef struct {
    double best[UNKNOWNS], lower[BOUNDS], upper[BOUNDS];
} programme;

/* At rest, with nothing issued, planned or touched. */
static void begin_trial(block_state *state)
{
    static const block_loop at_rest;
    state->loop = at_rest;
    state->loop.at_ns = state->held_ns = BLOCK_NEVER;
    for (int k = 0; k < KEPT; k++) state->loop.stamps[k] = -(INT64_C(1) << 62);
    state->used = 0;
    forget(&state->qp);
#if CONTACT
    state->touching = 0;
    state->since_ns = BLOCK_NEVER;
#endif
#if GRASPING
    state->led = 0;
#endif
}

void block_init(block_state *state)
{
    static const block_state at_rest;
    *state = at_rest;
    begin_trial(state);
#if MEMORY
    state->touched = -1;
#endif
}

#if MEMORY
void block_next_trial(block_state *state)
{
    learn_trial(state);
    begin_trial(state);
}
#endif

/* Optimal drives without limits, and outputs less target without drives. */
static void free_optimum(const block_loop *loop, const double present[PRESENT],
                         const double target[HORIZON][OUTPUTS], double best[UNKNOWNS])
{
    for (int i = 0; i < UNKNOWNS; i++) best[i] = 0.0;
    for (int j = 0; j < KNOWN; j++) {
        double known;
        if (j < PRESENT) {
            known = present[j];
        } else if (j < PRESENT + HORIZON * OUTPUTS) {
            const int step = (j - PRESENT) / OUTPUTS, output = (j - PRESENT) % OUTPUTS;
            known = loop->disturbance[output] + OFFSET[output] - target[step][output];
        } else {
            known = loop->drive[j - PRESENT - HORIZON * OUTPUTS];
        }
        for (int i = 0; i < UNKNOWNS; i++) best[i] += known * FREE[j][i];
    }
}

/* Bounds of the unknowns and of the rows. The excesses of boxes start at their price's optimum. */
static void limits(const block_loop *loop, const double reference[HORIZON][OUTPUTS], double best[UNKNOWNS],
                   double lower[BOUNDS], double upper[BOUNDS])
{
    double rise[MUSCLES], pulses[MUSCLES][2];
    for (int i = 0; i < MUSCLES; i++) pulses[i][0] = loop->pulses[i][0], pulses[i][1] = loop->pulses[i][1];
    risen(pulses, rise);
    for (int at = 0; at < DRIVES; at++) {
        const int i = at % MUSCLES;
        lower[at] = 0.0;
        upper[at] = DRIVE_GREATEST[i];
        lower[UNKNOWNS + at] = -SLEW;
        upper[UNKNOWNS + at] = SLEW;
    }
    for (int i = 0; i < MUSCLES; i++) {
        const double now = loop->drive[i], risen_to = rise[i] > now ? rise[i] : now;
        lower[UNKNOWNS + i] += now;
        upper[UNKNOWNS + i] = now + SLEW < risen_to ? now + SLEW : risen_to;
    }
#if BOXES > 0
    for (int row = 0; row < BOXES; row++) {
        const int at = BOX_PLACE[row];
        const double unmoved = best[DRIVES + at] + reference[at / OUTPUTS][at % OUTPUTS];
        lower[UNKNOWNS + DRIVES + row] = BOX_LEAST[row] - unmoved;
        upper[UNKNOWNS + DRIVES + row] = BOX_GREATEST[row] - unmoved;
    }
    for (int at = DRIVES; at < UNKNOWNS; at++) best[at] = -KNEE_RAD, lower[at] = 0.0, upper[at] = INFINITY;
#else
    (void)reference, (void)best;
#endif
}

/* Value of a row behind the unknowns: a difference between ticks, or an angle that has a box. */
static double row_value(int row, const double x[UNKNOWNS])
{
    if (row < DRIVES) return row >= MUSCLES ? x[row] - x[row - MUSCLES] : x[row];
    double value = 0.0;
#if BOXES > 0
    for (int i = 0; i < UNKNOWNS; i++) value += BOX_ROW[row - DRIVES][i] * x[i];
#endif
    return value;
}

/* Programme of a tick from the loop's estimate, which is corrected by the sample with a gain; BLOCK_NON_FINITE or
 * BLOCK_INFEASIBLE where its numbers are at fault. */
static int assemble(block_loop *loop, const double gain[STATES + OUTPUTS][OUTPUTS], const task *now, programme *made)
{
    double present[PRESENT];
    int64_t at_ns = loop->at_ns;
    int status = BLOCK_OK;
    if (now->captured_ns > at_ns) {
        correct(loop, gain, now->captured_ns, now->measured);
        at_ns = now->captured_ns;
    }
    predict(loop, now->now_ns, at_ns, present);
    free_optimum(loop, present, now->target, made->best);
    limits(loop, now->reference, made->best, made->lower, made->upper);
    for (int i = 0; i < UNKNOWNS; i++)
        if (!isfinite(made->best[i])) return BLOCK_NON_FINITE;
    for (int row = 0; row < BOUNDS; row++) {
        if (isnan(made->lower[row]) || isnan(made->upper[row])) return BLOCK_NON_FINITE;
        if (made->lower[row] > made->upper[row]) status = BLOCK_INFEASIBLE;
    }
    loop->at_ns = at_ns;
    return status;
}

/* Solve around the free optimum, and clip to the boxes of the unknowns; returns a status. */
static int optimise(block_qp *qp, const programme *made, double x[UNKNOWNS])
{
    for (int row = 0; row < BOUNDS; row++) {
        const double centre = row < UNKNOWNS ? made->best[row] : row_value(row - UNKNOWNS, made->best);
        qp->low[row] = (made->lower[row] - centre) / LENGTH[row];
        qp->high[row] = (made->upper[row] - centre) / LENGTH[row];
    }
    int status = solve_qp(qp, x);
    double worst = 0.0;
    for (int row = 0; row < BOUNDS && status == BLOCK_OK; row++) {
        if (row < UNKNOWNS) x[row] += made->best[row];
        const double value = row < UNKNOWNS ? x[row] : row_value(row - UNKNOWNS, x);
        double bound = value > made->lower[row] ? value : made->lower[row];
        if (bound > made->upper[row]) bound = made->upper[row];
        const double broken = fabs(value - bound) / (1.0 + fabs(bound));
        if (broken > worst) worst = broken;
        if (row < UNKNOWNS) x[row] = bound;
    }
    if (status == BLOCK_OK && !(worst <= ACCEPTED)) status = BLOCK_INACCURATE;
    if (status != BLOCK_OK) forget(qp);
    return status;
}

#if CONTACT
/* Whether the hand touches something, from forces; 0, and no change, if they are not finite or too old. */
static int feel(block_state *state, const block_inputs *in)
{
    double most = -INFINITY;
    if ((double)(in->time_ns - in->force_newest_ns) > AGE_MAX_MS * 1e6) return 0;
    for (int i = 0; i < BLOCK_SENSORS; i++) {
        if (!isfinite(in->force[i])) return 0;
        if (FELT[i] && in->force[i] > most) most = in->force[i];
    }
    if (!(state->touching ? most < RELEASE_N : most > CONTACT_N)) {
        state->since_ns = BLOCK_NEVER;
        return 1;
    }
    if (state->since_ns < 0) state->since_ns = in->time_ns;
    if ((double)(in->time_ns - state->since_ns) >= (state->touching ? RELEASE_MS : CONTACT_MS) * 1e6) {
        state->touching = !state->touching;
        state->since_ns = BLOCK_NEVER;
    }
    return 1;
}
#endif

#if GRASPING
/* In contact grasping channels follow a loop that has the model as its plant and no measurements: it starts as a
 * copy of the true one, and `made` has their drives fixed to its own within twice SLACK. Returns a status. */
static int lead(block_state *state, const task *now, programme *made)
{
    static const double still[STATES + OUTPUTS][OUTPUTS] = {{0.0}};
    block_loop *alone = &state->alone;
    programme own;
    double x[UNKNOWNS];
    if (!state->led) *alone = state->loop;
    state->led = 1;
    int status = assemble(alone, still, now, &own);
    if (status == BLOCK_OK) status = optimise(&state->qp, &own, x);
    if (status != BLOCK_OK) return status;
    for (int i = 0; i < MUSCLES; i++) alone->drive[i] = x[i];
    record(alone, now->now_ns, alone->drive);
    allocate(alone->drive, alone->pulses);
    for (int at = 0; at < DRIVES; at++) {
        if (!GRASPS[at % MUSCLES]) continue;
        double low = x[at] - SLACK > made->lower[at] ? x[at] - SLACK : made->lower[at];
        if (low > made->upper[at]) low = made->upper[at];
        made->lower[at] = low;
        if (made->upper[at] > low + 2.0 * SLACK) made->upper[at] = low + 2.0 * SLACK;
    }
    return BLOCK_OK;
}
#endif

/* Set the drive to the first of the optimal ones; returns a status. */
static int control(block_state *state, const task *now)
{
    programme made;
    double x[UNKNOWNS];
    for (int i = 0; i < OUTPUTS; i++)
        if (!isfinite(now->measured[i])) return BLOCK_NON_FINITE;
    for (int k = 0; k < HORIZON; k++)
        for (int i = 0; i < OUTPUTS; i++)
            if (!isfinite(now->reference[k][i])) return BLOCK_NON_FINITE;
#if CONTACT
    int status = assemble(&state->loop, state->touching ? TOUCHING_GAIN : OBSERVER_GAIN, now, &made);
#else
    int status = assemble(&state->loop, OBSERVER_GAIN, now, &made);
#endif
    if (status == BLOCK_NON_FINITE) return status;
#if GRASPING
    const int led = state->touching ? lead(state, now, &made) : BLOCK_OK;
    if (!state->touching) state->led = 0;
    if (led != BLOCK_OK) return led;
#endif
    if (status == BLOCK_OK) status = optimise(&state->qp, &made, x);
    if (status != BLOCK_OK) return status;
    for (int i = 0; i < DRIVES; i++) state->planned[i] = x[i];
    for (int i = 0; i < MUSCLES; i++) state->loop.drive[i] = x[i];
    state->used = 1;
    state->held_ns = BLOCK_NEVER;
    return status;
}

/* Safe output: where only the programme failed the last solution goes on, else the drive is held, then ramped down. */
static void fall_back(block_state *state, int status, int64_t now_ns)
{
    const int bad_input = status == BLOCK_NO_INPUT || status == BLOCK_STALE_INPUT || status == BLOCK_NON_FINITE;
    if (!bad_input && state->used > 0 && state->used < HORIZON) {
        double rise[MUSCLES];
        risen(state->loop.pulses, rise);
        for (int i = 0; i < MUSCLES; i++) {
            const double now = state->loop.drive[i];
            double next = state->planned[state->used * MUSCLES + i];
            if (next > now + SLEW) next = now + SLEW;
            if (next > DRIVE_GREATEST[i]) next = DRIVE_GREATEST[i];
            if (next > (rise[i] > now ? rise[i] : now)) next = rise[i] > now ? rise[i] : now;
            state->loop.drive[i] = next;
        }
        state->used++;
        state->held_ns = BLOCK_NEVER;
        return;
    }
    if (state->held_ns == BLOCK_NEVER) {
        for (int i = 0; i < MUSCLES; i++) state->held[i] = state->loop.drive[i];
        state->held_ns = now_ns;
    }
    const double ramping_ms = (double)(now_ns - state->held_ns) / 1e6 - HOLD_MS;
    double share = ramping_ms <= 0.0 ? 1.0 : 1.0 - ramping_ms / RAMP_MS;
    if (share < 0.0) share = 0.0;
    for (int i = 0; i < MUSCLES; i++) state->loop.drive[i] = state->held[i] * share;
}

int block_step(block_state *state, const block_inputs *in, block_outputs *out)
{
    task now;
    int status;
    for (int k = 0; k < HORIZON; k++)
        for (int i = 0; i < OUTPUTS; i++) now.reference[k][i] = now.target[k][i] = REFERENCE_AT(in, k, i);
    for (int i = 0; i < OUTPUTS; i++) now.measured[i] = in->measured[i];
    now.now_ns = in->time_ns;
    now.captured_ns = COMPENSATE_AGE ? in->measured_newest_ns : in->time_ns;
#if MEMORY
    expect(state, now.captured_ns, now.now_ns, now.measured, now.target);
#endif
#if CONTACT
    const int sound = in->force_newest_ns < 0 || feel(state, in);
#endif
    const int64_t age_ns = in->time_ns - in->measured_newest_ns;
    if (in->REFERENCE_NEWEST_NS < 0 || in->measured_newest_ns < 0) status = BLOCK_NO_INPUT;
    else if ((double)age_ns > AGE_MAX_MS * 1e6) status = BLOCK_STALE_INPUT;
    else status = control(state, &now);
    if (status != BLOCK_OK) fall_back(state, status, in->time_ns);
    if ((double)in->time_ns < BEGIN_S * 1e9)
        for (int i = 0; i < MUSCLES; i++) state->loop.drive[i] = 0.0;
#if MEMORY
#if CONTACT
    remember(state, in, now.reference[0], state->touching);
#else
    remember(state, in, now.reference[0], 0);
#endif
#endif
    record(&state->loop, in->time_ns, state->loop.drive);
    const int saturated = allocate(state->loop.drive, state->loop.pulses);
    for (int i = 0; i < MUSCLES; i++)
        for (int k = 0; k < 2; k++) out->stimulation[i][k] = state->loop.pulses[i][k];
    if (status != BLOCK_OK) return status;
#if CONTACT
    if (!sound) return BLOCK_NO_FORCE;
#endif
    return saturated > 0 ? BLOCK_SATURATED : BLOCK_OK;
}
