
/* ---- Law "gradient": change = gain G'W e, by one pass of the adjoint model. ---- */

static void learn_change(block_state *state)
{
    double costate[STATES], after[STATES];
    for (int i = 0; i < STATES; i++) costate[i] = 0.0;
    for (int k = SAMPLES - 1; k >= 0; k--) {
        for (int m = 0; m < MUSCLES; m++) {
            state->change[k][m] = 0.0;
            for (int i = 0; i < STATES; i++) state->change[k][m] += LEARNING_GAIN * MODEL_B[i][m] * costate[i];
        }
        for (int i = 0; i < STATES; i++) {
            after[i] = 0.0;
            for (int j = 0; j < STATES; j++) after[i] += MODEL_A[j][i] * costate[j];
            for (int o = 0; o < OUTPUTS; o++)
                if (state->covered[k][o]) after[i] += MODEL_C[o][i] * OUTPUT_WEIGHT[o] * state->error[k][o];
        }
        for (int i = 0; i < STATES; i++) costate[i] = after[i];
    }
}

static void smooth(block_state *state)
{
    (void)state; /* this law has no low-pass */
}
