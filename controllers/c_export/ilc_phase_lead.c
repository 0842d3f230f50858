
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

/* Low-pass of the drives, if there is one. */
static void smooth(block_state *state)
{
#if LOW_PASS
    double *values = state->scratch + PADDING;
    for (int m = 0; m < MUSCLES; m++) {
        for (int k = 0; k < SAMPLES; k++) values[k] = state->next[k][m];
        low_pass(values, SAMPLES, PADDING);
        for (int k = 0; k < SAMPLES; k++) state->next[k][m] = values[k];
    }
#else
    (void)state;
#endif
}
