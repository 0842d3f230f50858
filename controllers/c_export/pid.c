
/* ---- PID: forward difference for the integral, backward for the filtered derivative of the measurement. ---- */

void block_init(block_state *state)
{
    static const block_state at_rest;
    *state = at_rest;
}

/* Whether the integral of a joint may grow: a muscle can follow, or most muscles, by weight, leave saturation. */
static int can_follow(int joint, const double drive[MUSCLES], double growth)
{
    double deeper = 0.0, back = 0.0;
    for (int i = 0; i < MUSCLES; i++) {
        const double change = MIXING[i][joint] * growth;
        const int low = drive[i] <= DRIVE_LEAST[i], high = drive[i] >= DRIVE_GREATEST[i];
        if (!low && !high && change != 0.0) return 1;
        if ((low && change < 0.0) || (high && change > 0.0)) deeper += fabs(MIXING[i][joint]);
        else if (change != 0.0) back += fabs(MIXING[i][joint]);
    }
    return back >= deeper;
}

int block_step(block_state *state, const block_inputs *in, block_outputs *out)
{
    const double keep = DERIVATIVE_FILTER_S / (DERIVATIVE_FILTER_S + PERIOD_S);
    double drive[MUSCLES];

    for (int i = 0; i < MUSCLES; i++) out->stimulation[i][0] = out->stimulation[i][1] = 0.0;
    if (in->reference_newest_ns < 0 || in->measured_newest_ns < 0) return BLOCK_NO_INPUT;
    for (int j = 0; j < JOINTS; j++)
        if (!isfinite(in->reference[j]) || !isfinite(in->measured[j])) return BLOCK_NON_FINITE;

    for (int i = 0; i < MUSCLES; i++) drive[i] = BIAS[i];
    for (int j = 0; j < JOINTS; j++) {
        const double gain = KD[j] / (DERIVATIVE_FILTER_S + PERIOD_S);
        const double moved = state->primed ? in->measured[j] - state->previous[j] : 0.0;
        state->derivative[j] = keep * state->derivative[j] - gain * moved;
        state->previous[j] = in->measured[j];
        const double command = KP[j] * (in->reference[j] - in->measured[j]) + state->integral[j]
                               + state->derivative[j];
        for (int i = 0; i < MUSCLES; i++) drive[i] += MIXING[i][j] * command;
    }
    for (int i = 0; i < MUSCLES; i++)
        if (!isfinite(drive[i])) return BLOCK_NON_FINITE;
    for (int j = 0; j < JOINTS; j++) {
        const double growth = KI[j] * PERIOD_S * (in->reference[j] - in->measured[j]);
        if (can_follow(j, drive, growth)) state->integral[j] += growth;
    }
    for (int i = 0; i < MUSCLES; i++) {
        if (drive[i] < DRIVE_LEAST[i]) drive[i] = DRIVE_LEAST[i];
        if (drive[i] > DRIVE_GREATEST[i]) drive[i] = DRIVE_GREATEST[i];
    }
    state->primed = 1;
    return allocate(drive, out->stimulation) > 0 ? BLOCK_SATURATED : BLOCK_OK;
}
