
/* ---- Disturbance that trials have in common, learnt from trial to trial. ---- */

/* Expected disturbance at a fractional tick; beyond the trial, that of its end. */
static void expected_at(const block_state *state, double tick, double expected[OUTPUTS])
{
    const double last = state->expected_count - 1.0;
    if (tick > last) tick = last;
    if (tick < 0.0) tick = 0.0;
    const int low = (int)(int64_t)tick, high = low + 1 < state->expected_count ? low + 1 : low;
    const double share = tick - low;
    for (int o = 0; o < OUTPUTS; o++)
        expected[o] = state->expected_count == 0
                          ? 0.0
                          : (1.0 - share) * state->expected[low][o] + share * state->expected[high][o];
}

/* Number of the tick of a step. */
static int64_t index_of(int64_t time_ns)
{
    return (time_ns + PERIOD_NS / 2) / PERIOD_NS;
}

/* Subtract what is expected from a measurement and from the coming references. */
static void expect(const block_state *state, int64_t captured_ns, int64_t now_ns, double measured[OUTPUTS],
                   double target[HORIZON][OUTPUTS])
{
    double expected[OUTPUTS];
    expected_at(state, (double)captured_ns / PERIOD_NS, expected);
    for (int o = 0; o < OUTPUTS; o++) measured[o] -= expected[o];
    for (int k = 0; k < HORIZON; k++) {
        expected_at(state, (double)(index_of(now_ns) + 1 + k), expected);
        for (int o = 0; o < OUTPUTS; o++) target[k][o] -= expected[o];
    }
}

/* Record a step after its drive; ticks beyond SAMPLES are not recorded. */
static void remember(block_state *state, const block_inputs *in, const double asked[OUTPUTS], int touching)
{
    const int64_t index = index_of(in->time_ns);
    if (index < 0 || index >= SAMPLES) return;
    const int k = (int)index;
    int sound = in->measured_newest_ns >= 0;
    for (; state->samples <= k; state->samples++) {
        state->recorded[state->samples] = 0;
        state->captured_ns[state->samples] = BLOCK_NEVER;
    }
    for (int o = 0; o < OUTPUTS; o++) sound = sound && isfinite(in->measured[o]);
    state->recorded[k] = 1;
    state->controlled[k] = in->REFERENCE_NEWEST_NS >= 0 && (double)in->time_ns >= BEGIN_S * 1e9;
    state->captured_ns[k] = sound ? in->measured_newest_ns : BLOCK_NEVER;
    for (int o = 0; o < OUTPUTS; o++) {
        state->measured[k][o] = in->measured[o];
        state->asked[k][o] = asked[o];
    }
    for (int m = 0; m < MUSCLES; m++) state->issued[k][m] = state->loop.drive[m];
    if (touching && state->touched < 0) state->touched = k;
}

/* Posture at the ticks of the trial, and which of them captures cover. */
static void find_posture(block_state *state)
{
    for (int o = 0; o < OUTPUTS; o++) {
        int count = 0, place = 0;
        for (int k = 0; k < state->samples; k++) {
            if (state->captured_ns[k] >= 0) count = with_knot(state, count, k, o);
        }
        if (count >= 4) spline(state, count);
        for (int k = 0; k < state->samples; k++) {
            double posture = 0.0;
            state->covered[k] = (unsigned char)enclosed(state, count, PERIOD_NS * k, &place, &posture);
            state->posture[k][o] = posture;
        }
    }
}

/* Whether an object may block an output at a tick. */
static int blocked(const block_state *state, int k, int o)
{
    return state->touched >= 0 && k >= state->touched && BLOCKED[o];
}

/* RMS error of the trial, rad; -1 where nothing was measured that counts. */
static double trial_error(const block_state *state)
{
    double squares = 0.0, weights = 0.0;
    for (int k = 0; k + 1 < state->samples; k++) {
        if (!state->recorded[k] || !state->controlled[k] || !state->covered[k + 1]) continue;
        for (int o = 0; o < OUTPUTS; o++) {
            const double error = state->posture[k + 1][o] - state->asked[k][o];
            if (!isfinite(state->asked[k][o]) || blocked(state, k + 1, o)) continue;
            squares += OUTPUT_WEIGHT[o] * error * error;
            weights += OUTPUT_WEIGHT[o];
        }
    }
    return weights > 0.0 ? sqrt(squares / weights) : -1.0;
}

/* Posture less the model's response to the drives of the trial, from rest, and less what was expected. */
static void subtract_response(block_state *state)
{
    double x[MODEL_STATES] = {0.0}, after[MODEL_STATES], drive[MUSCLES] = {0.0}, expected[OUTPUTS];
    for (int k = 0; k < state->samples; k++) {
        expected_at(state, (double)k, expected);
        for (int o = 0; o < OUTPUTS; o++) {
            double answer = 0.0;
            for (int i = 0; i < MODEL_STATES; i++) answer += MODEL_C[o][i] * x[i];
            state->posture[k][o] = state->posture[k][o] - answer - OFFSET[o] - expected[o];
        }
        if (state->recorded[k])
            for (int m = 0; m < MUSCLES; m++) drive[m] = state->issued[k][m];
        for (int i = 0; i < MODEL_STATES; i++) {
            after[i] = 0.0;
            for (int j = 0; j < MODEL_STATES; j++) after[i] += MODEL_A[i][j] * x[j];
            for (int m = 0; m < MUSCLES; m++) after[i] += MODEL_B[i][m] * drive[m];
        }
        for (int i = 0; i < MODEL_STATES; i++) x[i] = after[i];
    }
}

/* Whether the difference of an output is known at a tick. */
static int known_at(const block_state *state, int k, int o)
{
    return state->covered[k] && !blocked(state, k, o);
}

/* Take over a share of the difference of an output, low-passed; between known ticks it is a line. */
static void take_over(block_state *state, int o)
{
    double *values = state->scratch + PADDING;
    const int count = state->samples;
    int before = -1, next = 0;
    for (int k = 0; k < count; k++) {
        while (next < count && (next < k || !known_at(state, next, o))) next++;
        if (next == count && before < 0) return; /* none is known */
        if (next == k) before = k;
        if (next == count || next == k || before < 0) {
            values[k] = state->posture[next < count ? next : before][o];
        } else {
            const double first = state->posture[before][o];
            values[k] = (state->posture[next][o] - first) / (next - before) * (k - before) + first;
        }
    }
    if (count > 1) low_pass(values, count, count - 1 < PADDING ? count - 1 : PADDING);
    for (int k = 0; k < count; k++) state->learnt[k][o] += LEARNT_SHARE * values[k];
}

static void set_expected(block_state *state, double given[SAMPLES][OUTPUTS], int count)
{
    for (int k = 0; k < count; k++)
        for (int o = 0; o < OUTPUTS; o++) state->expected[k][o] = given[k][o];
    state->expected_count = count;
}

/* Learn from the trial that has ended, and empty its record. */
static void learn_trial(block_state *state)
{
    if (!state->stopped && state->samples > 0) {
        find_posture(state);
        const double error = trial_error(state);
        if (error >= 0.0 && note_progress(state, error)) {
            for (int k = 0; k < state->expected_count; k++)
                for (int o = 0; o < OUTPUTS; o++) state->best[k][o] = state->expected[k][o];
            state->best_count = state->expected_count;
        }
        if (!state->stopped) {
            for (int k = 0; k < state->samples; k++) expected_at(state, (double)k, state->learnt[k]);
            subtract_response(state);
            for (int o = 0; o < OUTPUTS; o++) take_over(state, o);
            set_expected(state, state->learnt, state->samples);
        }
    }
    if (state->stopped) set_expected(state, state->best, state->best_count);
    state->samples = 0;
    state->touched = -1;
}
