
/* ---- Errors at the ticks, from samples of known capture. ---- */

/* Error of one output at each tick with a usable measurement; others are not covered. */
static void errors_of(block_state *state, int o)
{
    int count = 0;
    for (int k = 0; k < SAMPLES; k++) {
        state->covered[k][o] = 0;
        state->error[k][o] = 0.0;
        if (state->captured_ns[k] < 0 || state->doubtful[k][o]) continue;
        if (!ALIGN_CAPTURES) {
            state->covered[k][o] = state->ticks_ns[k] >= 0 && k >= BEGINS;
            if (state->covered[k][o]) state->error[k][o] = state->reference[k][o] - state->measured[k][o];
            continue;
        }
        count = with_knot(state, count, k, o);
    }
    if (count >= 4) spline(state, count);
    for (int k = BEGINS, place = 0; k < SAMPLES; k++) {
        double posture;
        if (!enclosed(state, count, state->ticks_ns[k], &place, &posture)) continue;
        state->covered[k][o] = 1;
        state->error[k][o] = state->reference[k][o] - posture;
    }
}

/* ---- Iterative learning: drives of a whole trial, improved between trials. ---- */

/* Clipped to their box, then tick by tick to the slew limit, from rest. */
static void within_limits(double drives[SAMPLES][MUSCLES])
{
    for (int m = 0; m < MUSCLES; m++) {
        double before = 0.0;
        for (int k = 0; k < SAMPLES; k++) {
            double drive = drives[k][m];
            if (drive < 0.0) drive = 0.0;
            if (drive > DRIVE_GREATEST[m]) drive = DRIVE_GREATEST[m];
            if (drive < before - SLEW) drive = before - SLEW;
            if (drive > before + SLEW) drive = before + SLEW;
            before = drives[k][m] = drive;
        }
    }
}

static double first_drive(int k, int m)
{
    return k >= BEGINS ? FIRST_DRIVE[m] : 0.0;
}

/* An empty record for the next trial. */
static void begin_trial(block_state *state)
{
    state->index = 0;
    for (int k = 0; k < SAMPLES; k++) {
        state->ticks_ns[k] = state->captured_ns[k] = BLOCK_NEVER;
        for (int o = 0; o < OUTPUTS; o++) {
            state->measured[k][o] = state->reference[k][o] = 0.0;
            state->doubtful[k][o] = 0;
        }
    }
}

void block_init(block_state *state)
{
    static const block_state at_rest;
    *state = at_rest;
    for (int k = 0; k < SAMPLES; k++)
        for (int m = 0; m < MUSCLES; m++) state->drives[k][m] = first_drive(k, m);
    within_limits(state->drives);
    for (int k = 0; k < SAMPLES; k++)
        for (int m = 0; m < MUSCLES; m++) state->first[k][m] = state->drives[k][m];
    begin_trial(state);
}

int block_step(block_state *state, const block_inputs *in, block_outputs *out)
{
    const int k = state->index < SAMPLES ? state->index++ : SAMPLES;
    const int saturated = allocate(state->drives[k < SAMPLES ? k : SAMPLES - 1], out->stimulation);
    if (k == SAMPLES) return BLOCK_PAST_END;
    int usable = in->reference_newest_ns >= 0;
    for (int o = 0; o < OUTPUTS; o++) usable = usable && isfinite(in->reference[o]);
    if (usable) {
        state->ticks_ns[k] = in->time_ns;
        for (int o = 0; o < OUTPUTS; o++) state->reference[k][o] = in->reference[o];
    }
    if (in->measured_newest_ns >= 0) {
        state->captured_ns[k] = in->measured_newest_ns;
        for (int o = 0; o < OUTPUTS; o++) {
            state->doubtful[k][o] = !isfinite(in->measured[o]) || DISTRUSTED(in, o);
            state->measured[k][o] = state->doubtful[k][o] ? 0.0 : in->measured[o];
        }
    }
    return usable ? saturated > 0 ? BLOCK_SATURATED : BLOCK_OK : BLOCK_NO_REFERENCE;
}

/* Share of the measurements that are doubtful. */
static double doubtful_share(const block_state *state)
{
    int came = 0, doubtful = 0;
    for (int k = 0; k < SAMPLES; k++) {
        if (state->captured_ns[k] < 0) continue;
        came++;
        for (int o = 0; o < OUTPUTS; o++) doubtful += state->doubtful[k][o];
    }
    return came > 0 ? (double)doubtful / ((double)came * OUTPUTS) : 0.0;
}

static void take_best(block_state *state)
{
    for (int k = 0; k < SAMPLES; k++)
        for (int m = 0; m < MUSCLES; m++) state->drives[k][m] = state->best[k][m];
}

void block_next_trial(block_state *state)
{
    double squares = 0.0, weights = 0.0;
    if (state->stopped) {
        take_best(state);
        begin_trial(state);
        return;
    }
    if (doubtful_share(state) > REJECT_SHARE) {
        begin_trial(state);
        return;
    }
    for (int o = 0; o < OUTPUTS; o++) errors_of(state, o);
    for (int k = 0; k < SAMPLES; k++)
        for (int o = 0; o < OUTPUTS; o++)
            if (state->covered[k][o]) {
                squares += OUTPUT_WEIGHT[o] * state->error[k][o] * state->error[k][o];
                weights += OUTPUT_WEIGHT[o];
            }
    if (weights > 0.0) {
        if (note_progress(state, sqrt(squares / weights)))
            for (int k = 0; k < SAMPLES; k++)
                for (int m = 0; m < MUSCLES; m++) state->best[k][m] = state->drives[k][m];
        if (state->stopped) {
            take_best(state);
            begin_trial(state);
            return;
        }
        for (int k = 0; k < SAMPLES; k++)
            for (int m = 0; m < MUSCLES; m++)
                state->next[k][m] = state->first[k][m]
                                    + (1.0 - FORGETTING) * (state->drives[k][m] - state->first[k][m]);
        within_limits(state->next);
        learn_change(state);
        for (int k = 0; k < SAMPLES; k++)
            for (int m = 0; m < MUSCLES; m++) state->next[k][m] += state->change[k][m];
        smooth(state);
        within_limits(state->next);
        for (int k = BEGINS; k < SAMPLES; k++)
            for (int m = 0; m < MUSCLES; m++) state->drives[k][m] = state->next[k][m];
        within_limits(state->drives);
    }
    begin_trial(state);
}
