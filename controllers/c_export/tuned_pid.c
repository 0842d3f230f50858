
/* ---- Tuned PID: feedforward by the model's inverse at rest, feedback on what the model does not predict. ---- */

void block_init(block_state *state)
{
    static const block_state at_rest;
    *state = at_rest;
}

static double clip(double value, double least, double greatest)
{
    return value < least ? least : value > greatest ? greatest : value;
}

/* Drives from 0 to `greatest` whose effect at rest is nearest to `wanted`, the least among equals. */
static int mix(block_state *state, const double wanted[OUTPUTS], const double greatest[MUSCLES], double x[MUSCLES])
{
    block_qp *qp = &state->qp;
    double best[MUSCLES], worst = 0.0;
    for (int i = 0; i < MUSCLES; i++) {
        best[i] = 0.0;
        for (int j = 0; j < OUTPUTS; j++) best[i] += FREE[i][j] * wanted[j];
        qp->low[i] = (0.0 - best[i]) / LENGTH[i];
        qp->high[i] = (greatest[i] - best[i]) / LENGTH[i];
    }
    int status = solve_qp(qp, x);
    for (int i = 0; i < MUSCLES && status == BLOCK_OK; i++) {
        const double value = x[i] + best[i], bound = clip(value, 0.0, greatest[i]);
        const double broken = fabs(value - bound) / (1.0 + fabs(bound));
        if (broken > worst) worst = broken;
        x[i] = bound;
    }
    if (status == BLOCK_OK && !(worst <= ACCEPTED)) status = BLOCK_INACCURATE;
    if (status != BLOCK_OK) forget(qp);
    return status;
}

/* Drives of this tick; the state is as before where there are none. */
static int control(block_state *state, const block_inputs *in, double drive[MUSCLES])
{
    double measured[OUTPUTS], error[OUTPUTS], derivative[OUTPUTS], wanted[OUTPUTS], greatest[MUSCLES];
    for (int k = DELAYED - 1; k > 0 && state->primed; k--)
        for (int j = 0; j < OUTPUTS; j++) state->asked[k][j] = state->asked[k - 1][j];
    for (int j = 0; j < OUTPUTS; j++) {
        const double least = OFFSET[j] - FARTHEST[j], most = OFFSET[j] + FARTHEST[j];
        const double asked = clip(ASKED(in, j), least, most);
        measured[j] = clip(in->measured[j], least, most);
        double expected = clip(in->reference[j], least, most);
        if (FEEDFORWARD) {
            for (int k = 1; k < DELAYED && !state->primed; k++) state->asked[k][j] = measured[j];
            if (!state->primed) state->expected[j] = measured[j];
            state->asked[0][j] = asked;
            state->expected[j] = SLOW[j] * state->expected[j] + (1.0 - SLOW[j]) * state->asked[LATE[j]][j];
            expected = state->expected[j];
        }
        error[j] = expected - measured[j];
        derivative[j] = POLE[j] * state->derivative[j]
                        - RATE[j] * (state->primed ? measured[j] - state->previous[j] : 0.0);
        wanted[j] = KP[j] * error[j] + state->integral[j] + derivative[j];
        if (FEEDFORWARD) wanted[j] += asked - OFFSET[j];
    }
    risen(state->pulses, greatest);
    for (int i = 0; i < MUSCLES; i++)
        if (greatest[i] > DRIVE_GREATEST[i]) greatest[i] = DRIVE_GREATEST[i];
    const int status = mix(state, wanted, greatest, drive);
    if (status != BLOCK_OK) return status;
    for (int j = 0; j < OUTPUTS; j++) {
        double effect = -wanted[j];
        for (int i = 0; i < MUSCLES; i++) effect += GAIN[j][i] * drive[i];
        state->integral[j] = clip(state->integral[j] + INTEGRAL[j] * error[j] + PULL[j] * effect,
                                  -FARTHEST[j], FARTHEST[j]);
        state->derivative[j] = derivative[j];
        state->previous[j] = measured[j];
    }
    state->primed = 1;
    return status;
}

int block_step(block_state *state, const block_inputs *in, block_outputs *out)
{
    double drive[MUSCLES];
    int finite = 1, status;
    for (int j = 0; j < OUTPUTS; j++)
        if (!isfinite(in->reference[j]) || !isfinite(in->measured[j])) finite = 0;
    for (int j = 0; j < OUTPUTS * PREVIEW; j++)
        if (!isfinite(COMING(in, j / OUTPUTS, j % OUTPUTS))) finite = 0;
    if (in->reference_newest_ns < 0 || in->measured_newest_ns < 0) status = BLOCK_NO_INPUT;
    else if ((double)(in->time_ns - in->measured_newest_ns) > AGE_MAX_MS * 1e6) status = BLOCK_STALE_INPUT;
    else if (!finite) status = BLOCK_NON_FINITE;
    else if (in->time_ns < BEGIN_NS) status = BLOCK_OK;
    else status = control(state, in, drive);
    for (int i = 0; i < MUSCLES && (status != BLOCK_OK || in->time_ns < BEGIN_NS); i++) drive[i] = 0.0;
    const int saturated = allocate(drive, state->pulses);
    for (int i = 0; i < MUSCLES; i++)
        for (int k = 0; k < 2; k++) out->stimulation[i][k] = state->pulses[i][k];
    return status == BLOCK_OK && saturated > 0 ? BLOCK_SATURATED : status;
}
