
/* ---- Predictive control: condensed programme over HORIZON periods (Maciejowski 2002, chapter 3). ---- */

void block_init(block_state *state)
{
    static const block_state at_rest;
    *state = at_rest;
    state->at_ns = state->held_ns = BLOCK_NEVER;
    for (int k = 0; k < KEPT; k++) state->stamps[k] = -(INT64_C(1) << 62);
}

/* Optimal drives without limits, and outputs less reference without drives. */
static void free_optimum(const block_state *state, const double present[PRESENT],
                         double reference[HORIZON][OUTPUTS], double best[UNKNOWNS])
{
    for (int i = 0; i < UNKNOWNS; i++) best[i] = 0.0;
    for (int j = 0; j < KNOWN; j++) {
        double known;
        if (j < PRESENT) {
            known = present[j];
        } else if (j < PRESENT + HORIZON * OUTPUTS) {
            const int step = (j - PRESENT) / OUTPUTS, output = (j - PRESENT) % OUTPUTS;
            known = state->disturbance[output] + OFFSET[output] - reference[step][output];
        } else {
            known = state->drive[j - PRESENT - HORIZON * OUTPUTS];
        }
        for (int i = 0; i < UNKNOWNS; i++) best[i] += known * FREE[j][i];
    }
}

/* Bounds of the unknowns and of the rows. The excesses of boxes start at their price's optimum. */
static void limits(const block_state *state, double reference[HORIZON][OUTPUTS], double best[UNKNOWNS],
                   double lower[BOUNDS], double upper[BOUNDS])
{
    double rise[MUSCLES], pulses[MUSCLES][2];
    for (int i = 0; i < MUSCLES; i++) pulses[i][0] = state->pulses[i][0], pulses[i][1] = state->pulses[i][1];
    risen(pulses, rise);
    for (int at = 0; at < DRIVES; at++) {
        const int i = at % MUSCLES;
        lower[at] = 0.0;
        upper[at] = DRIVE_GREATEST[i];
        lower[UNKNOWNS + at] = -SLEW;
        upper[UNKNOWNS + at] = SLEW;
    }
    for (int i = 0; i < MUSCLES; i++) {
        const double now = state->drive[i], risen_to = rise[i] > now ? rise[i] : now;
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

/* Solve around the free optimum, and clip to the boxes of the unknowns; returns a status. */
static int optimise(block_state *state, const double best[UNKNOWNS], const double lower[BOUNDS],
                    const double upper[BOUNDS], double x[UNKNOWNS])
{
    block_qp *qp = &state->qp;
    for (int i = 0; i < UNKNOWNS; i++)
        if (!isfinite(best[i])) return BLOCK_NON_FINITE;
    for (int row = 0; row < BOUNDS; row++)
        if (isnan(lower[row]) || isnan(upper[row])) return BLOCK_NON_FINITE;
    for (int row = 0; row < BOUNDS; row++)
        if (lower[row] > upper[row]) return BLOCK_INFEASIBLE;
    for (int row = 0; row < BOUNDS; row++) {
        const double centre = row < UNKNOWNS ? best[row] : row_value(row - UNKNOWNS, best);
        qp->low[row] = (lower[row] - centre) / LENGTH[row];
        qp->high[row] = (upper[row] - centre) / LENGTH[row];
    }
    int status = solve_qp(qp, x);
    double worst = 0.0;
    for (int row = 0; row < BOUNDS && status == BLOCK_OK; row++) {
        if (row < UNKNOWNS) x[row] += best[row];
        const double value = row < UNKNOWNS ? x[row] : row_value(row - UNKNOWNS, x);
        double bound = value > lower[row] ? value : lower[row];
        if (bound > upper[row]) bound = upper[row];
        const double broken = fabs(value - bound) / (1.0 + fabs(bound));
        if (broken > worst) worst = broken;
        if (row < UNKNOWNS) x[row] = bound;
    }
    if (status == BLOCK_OK && !(worst <= ACCEPTED)) status = BLOCK_INACCURATE;
    if (status != BLOCK_OK) forget(qp);
    return status;
}

/* Set the drive to the first of the optimal ones; returns a status. */
static int control(block_state *state, double reference[HORIZON][OUTPUTS], const double measured[OUTPUTS],
                   int64_t captured_ns, int64_t now_ns)
{
    double present[PRESENT], best[UNKNOWNS], lower[BOUNDS], upper[BOUNDS], x[UNKNOWNS];
    for (int i = 0; i < OUTPUTS; i++)
        if (!isfinite(measured[i])) return BLOCK_NON_FINITE;
    for (int k = 0; k < HORIZON; k++)
        for (int i = 0; i < OUTPUTS; i++)
            if (!isfinite(reference[k][i])) return BLOCK_NON_FINITE;
    int64_t at_ns = state->at_ns;
    if (captured_ns > at_ns) {
        correct(state, captured_ns, measured);
        at_ns = captured_ns;
    }
    predict(state, now_ns, at_ns, present);
    free_optimum(state, present, reference, best);
    limits(state, reference, best, lower, upper);
    const int status = optimise(state, best, lower, upper, x);
    if (status != BLOCK_NON_FINITE) state->at_ns = at_ns;
    if (status != BLOCK_OK) return status;
    for (int i = 0; i < DRIVES; i++) state->planned[i] = x[i];
    for (int i = 0; i < MUSCLES; i++) state->drive[i] = x[i];
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
        risen(state->pulses, rise);
        for (int i = 0; i < MUSCLES; i++) {
            const double now = state->drive[i];
            double next = state->planned[state->used * MUSCLES + i];
            if (next > now + SLEW) next = now + SLEW;
            if (next > DRIVE_GREATEST[i]) next = DRIVE_GREATEST[i];
            if (next > (rise[i] > now ? rise[i] : now)) next = rise[i] > now ? rise[i] : now;
            state->drive[i] = next;
        }
        state->used++;
        state->held_ns = BLOCK_NEVER;
        return;
    }
    if (state->held_ns == BLOCK_NEVER) {
        for (int i = 0; i < MUSCLES; i++) state->held[i] = state->drive[i];
        state->held_ns = now_ns;
    }
    const double ramping_ms = (double)(now_ns - state->held_ns) / 1e6 - HOLD_MS;
    double share = ramping_ms <= 0.0 ? 1.0 : 1.0 - ramping_ms / RAMP_MS;
    if (share < 0.0) share = 0.0;
    for (int i = 0; i < MUSCLES; i++) state->drive[i] = state->held[i] * share;
}

int block_step(block_state *state, const block_inputs *in, block_outputs *out)
{
    double reference[HORIZON][OUTPUTS];
    int status;
    for (int k = 0; k < HORIZON; k++)
        for (int i = 0; i < OUTPUTS; i++) reference[k][i] = REFERENCE_AT(in, k, i);
    const int64_t age_ns = in->time_ns - in->measured_newest_ns;
    if (in->REFERENCE_NEWEST_NS < 0 || in->measured_newest_ns < 0) status = BLOCK_NO_INPUT;
    else if ((double)age_ns > AGE_MAX_MS * 1e6) status = BLOCK_STALE_INPUT;
    else status = control(state, reference, in->measured, COMPENSATE_AGE ? in->measured_newest_ns : in->time_ns,
                          in->time_ns);
    if (status != BLOCK_OK) fall_back(state, status, in->time_ns);
    if ((double)in->time_ns < BEGIN_S * 1e9)
        for (int i = 0; i < MUSCLES; i++) state->drive[i] = 0.0;
    record(state, in->time_ns, state->drive);
    const int saturated = allocate(state->drive, state->pulses);
    for (int i = 0; i < MUSCLES; i++)
        for (int k = 0; k < 2; k++) out->stimulation[i][k] = state->pulses[i][k];
    return status == BLOCK_OK && saturated > 0 ? BLOCK_SATURATED : status;
}
