
/* ---- Law "noilc": change = argmin |e - G d|^2_W + rho |d|^2, by the recursion of linear-quadratic tracking. ---- */

/* Solve S X = B in place, S symmetric and positive definite: Cholesky. */
static void solve_positive(double s[MUSCLES][MUSCLES], double b[MUSCLES][STATES + 1])
{
    for (int i = 0; i < MUSCLES; i++)
        for (int j = 0; j <= i; j++) {
            for (int k = 0; k < j; k++) s[i][j] -= s[i][k] * s[j][k];
            s[i][j] = i == j ? sqrt(s[i][i]) : s[i][j] / s[j][j];
        }
    for (int c = 0; c <= STATES; c++) {
        for (int i = 0; i < MUSCLES; i++) {
            for (int k = 0; k < i; k++) b[i][c] -= s[i][k] * b[k][c];
            b[i][c] /= s[i][i];
        }
        for (int i = MUSCLES - 1; i >= 0; i--) {
            for (int k = i + 1; k < MUSCLES; k++) b[i][c] -= s[k][i] * b[k][c];
            b[i][c] /= s[i][i];
        }
    }
}

/* Gains and feedforward of one instant; `ahead` and `pull` go from the instant after it to this one. */
static void backward(block_state *state, int k, double ahead[STATES][STATES], double pull[STATES])
{
    double seen[MUSCLES][STATES], s[MUSCLES][MUSCLES], solved[MUSCLES][STATES + 1];
    double closed[STATES][STATES], product[STATES][STATES], pulled[STATES];
    for (int m = 0; m < MUSCLES; m++)
        for (int j = 0; j < STATES; j++) {
            seen[m][j] = 0.0;
            for (int i = 0; i < STATES; i++) seen[m][j] += MODEL_B[i][m] * ahead[i][j];
        }
    for (int m = 0; m < MUSCLES; m++) {
        for (int n = 0; n < MUSCLES; n++) {
            s[m][n] = m == n ? CHANGE_WEIGHT : 0.0;
            for (int i = 0; i < STATES; i++) s[m][n] += seen[m][i] * MODEL_B[i][n];
        }
        for (int j = 0; j < STATES; j++) {
            solved[m][j] = 0.0;
            for (int i = 0; i < STATES; i++) solved[m][j] += seen[m][i] * MODEL_A[i][j];
        }
        solved[m][STATES] = 0.0;
        for (int i = 0; i < STATES; i++) solved[m][STATES] += MODEL_B[i][m] * pull[i];
    }
    solve_positive(s, solved);
    for (int m = 0; m < MUSCLES; m++) {
        for (int j = 0; j < STATES; j++) state->gains[k][m][j] = solved[m][j];
        state->forward[k][m] = solved[m][STATES];
    }
    for (int i = 0; i < STATES; i++)
        for (int j = 0; j < STATES; j++) {
            closed[i][j] = MODEL_A[i][j];
            for (int m = 0; m < MUSCLES; m++) closed[i][j] -= MODEL_B[i][m] * solved[m][j];
        }
    for (int i = 0; i < STATES; i++)
        for (int j = 0; j < STATES; j++) {
            product[i][j] = 0.0;
            for (int n = 0; n < STATES; n++) product[i][j] += ahead[i][n] * closed[n][j];
        }
    for (int i = 0; i < STATES; i++) {
        pulled[i] = 0.0;
        for (int o = 0; o < OUTPUTS; o++)
            if (state->covered[k][o]) pulled[i] += MODEL_C[o][i] * OUTPUT_WEIGHT[o] * state->error[k][o];
        for (int n = 0; n < STATES; n++) pulled[i] += closed[n][i] * pull[n];
    }
    for (int i = 0; i < STATES; i++) {
        pull[i] = pulled[i];
        for (int j = 0; j < STATES; j++) {
            closed[i][j] = 0.0;
            for (int o = 0; o < OUTPUTS; o++)
                if (state->covered[k][o]) closed[i][j] += MODEL_C[o][i] * OUTPUT_WEIGHT[o] * MODEL_C[o][j];
            for (int n = 0; n < STATES; n++) closed[i][j] += MODEL_A[n][i] * product[n][j];
        }
    }
    for (int i = 0; i < STATES; i++)
        for (int j = 0; j < STATES; j++) ahead[i][j] = 0.5 * (closed[i][j] + closed[j][i]);
}

static void learn_change(block_state *state)
{
    double ahead[STATES][STATES], x[STATES], after[STATES];
    for (int i = 0; i < STATES; i++) {
        x[i] = 0.0;
        for (int j = 0; j < STATES; j++) ahead[i][j] = 0.0;
    }
    for (int k = SAMPLES - 1; k >= 0; k--) backward(state, k, ahead, x);
    for (int i = 0; i < STATES; i++) x[i] = 0.0;
    for (int k = 0; k < SAMPLES; k++) {
        for (int m = 0; m < MUSCLES; m++) {
            state->change[k][m] = state->forward[k][m];
            for (int i = 0; i < STATES; i++) state->change[k][m] -= state->gains[k][m][i] * x[i];
        }
        for (int i = 0; i < STATES; i++) {
            after[i] = 0.0;
            for (int j = 0; j < STATES; j++) after[i] += MODEL_A[i][j] * x[j];
            for (int m = 0; m < MUSCLES; m++) after[i] += MODEL_B[i][m] * state->change[k][m];
        }
        for (int i = 0; i < STATES; i++) x[i] = after[i];
    }
}

static void smooth(block_state *state)
{
    (void)state; /* this law has no low-pass */
}
