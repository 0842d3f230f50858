
/* ---- Values at any instant, from samples of known capture. ---- */

/* Number of knots with the measurement of one output at tick k; one that was captured before is none more. */
static int with_knot(block_state *state, int count, int k, int o)
{
    if (count > 0 && state->captured_ns[k] <= state->stamp_ns[count - 1]) return count;
    state->stamp_ns[count] = state->captured_ns[k];
    state->knot[count] = (double)(state->captured_ns[k] - state->stamp_ns[0]) / 1e9;
    state->value[count] = state->measured[k][o];
    state->moment[count] = 0.0;
    return count + 1;
}

/* Second derivatives of the cubic spline through `count` knots, 4 or more, whose third derivative is continuous at
 * the second and the last but one ("not a knot"). */
static void spline(block_state *state, int count)
{
    const double *x = state->knot, *y = state->value;
    double *m = state->moment, *diagonal = state->scratch;
    for (int i = 1; i < count - 1; i++) {
        const double before = x[i] - x[i - 1], after = x[i + 1] - x[i];
        double left = before, right = after, right_side;
        diagonal[i] = 2.0 * (before + after);
        if (i == 1) diagonal[i] += before * (1.0 + before / after), right -= before * before / after;
        if (i == count - 2) diagonal[i] += after * (1.0 + after / before), left -= after * after / before;
        right_side = 6.0 * ((y[i + 1] - y[i]) / after - (y[i] - y[i - 1]) / before);
        if (i > 1) {
            const double share = left / diagonal[i - 1];
            diagonal[i] -= share * state->above[i - 1];
            right_side -= share * m[i - 1];
        }
        state->above[i] = right;
        m[i] = right_side;
    }
    m[count - 2] /= diagonal[count - 2];
    for (int i = count - 3; i >= 1; i--) m[i] = (m[i] - state->above[i] * m[i + 1]) / diagonal[i];
    double ratio = (x[1] - x[0]) / (x[2] - x[1]);
    m[0] = m[1] + ratio * (m[1] - m[2]);
    ratio = (x[count - 1] - x[count - 2]) / (x[count - 2] - x[count - 3]);
    m[count - 1] = m[count - 2] + ratio * (m[count - 2] - m[count - 3]);
}

static double between(const block_state *state, int i, double at)
{
    const double h = state->knot[i + 1] - state->knot[i];
    const double b = (at - state->knot[i]) / h, a = 1.0 - b;
    return a * state->value[i] + b * state->value[i + 1]
           + ((a * a * a - a) * state->moment[i] + (b * b * b - b) * state->moment[i + 1]) * h * h / 6.0;
}

/* Value at an instant, by the spline or, with fewer than 4 samples, a line; 0 unless two samples at most GAP_MAX_NS
 * apart enclose it. `place` grows with the instant from call to call. */
static int enclosed(const block_state *state, int count, int64_t at_ns, int *place, double *value)
{
    if (count == 0 || at_ns < state->stamp_ns[0] || at_ns > state->stamp_ns[count - 1]) return 0;
    while (*place < count - 1 && state->stamp_ns[*place] < at_ns) ++*place; /* the first one at or after it */
    const int before = *place > 0 ? *place - 1 : 0;
    if (state->stamp_ns[*place] != at_ns && state->stamp_ns[*place] - state->stamp_ns[before] > GAP_MAX_NS) return 0;
    const double at = (double)(at_ns - state->stamp_ns[0]) / 1e9;
    *value = count == 1 ? state->value[0] : between(state, before, at);
    return 1;
}
