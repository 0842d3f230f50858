
/* ---- Law "phase_lead": change = gain K^+ e, LEAD ticks ahead, and a zero-phase low-pass of the drives. ---- */

static void learn_change(block_state *state)
{
    for (int k = 0; k < SAMPLES; k++)
        for (int m = 0; m < MUSCLES; m++) state->change[k][m] = 0.0;
    for (int o = 0; o < OUTPUTS; o++) {
        int last = SAMPLES - 1;
        while (last >= 0 && !state->covered[last][o]) last--;
        for (int k = 0; k <= last; k++) {
            const double ahead = state->error[k + LEAD < last ? k + LEAD : last][o];
            for (int m = 0; m < MUSCLES; m++) state->change[k][m] += LEARNING_GAIN * STATIC_INVERSE[m][o] * ahead;
        }
    }
}

#if LOW_PASS
/* Second-order section, in place, from its steady state at the first value; `stride` -1 runs backward. */
static void section(double *x, int count, int stride)
{
    double z0 = SECTION_STEADY[0] * *x, z1 = SECTION_STEADY[1] * *x;
    for (int k = 0; k < count; k++, x += stride) {
        const double in = *x, out = SECTION[0] * in + z0;
        z0 = SECTION[1] * in - SECTION[4] * out + z1;
        z1 = SECTION[2] * in - SECTION[5] * out;
        *x = out;
    }
}
#endif

/* Forward and backward, with PADDING samples mirrored about either end. */
static void smooth(block_state *state)
{
#if LOW_PASS
    double *padded = state->scratch;
    for (int m = 0; m < MUSCLES; m++) {
        for (int k = 0; k < SAMPLES; k++) padded[PADDING + k] = state->next[k][m];
        for (int k = 1; k <= PADDING; k++) {
            padded[PADDING - k] = 2.0 * state->next[0][m] - state->next[k][m];
            padded[PADDING + SAMPLES - 1 + k] = 2.0 * state->next[SAMPLES - 1][m] - state->next[SAMPLES - 1 - k][m];
        }
        section(padded, SAMPLES + 2 * PADDING, 1);
        section(padded + SAMPLES + 2 * PADDING - 1, SAMPLES + 2 * PADDING, -1);
        for (int k = 0; k < SAMPLES; k++) state->next[k][m] = padded[PADDING + k];
    }
#else
    (void)state;
#endif
}
