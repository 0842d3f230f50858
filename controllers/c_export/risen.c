
/* Greatest drive of each channel for a rise of charge per phase above its present pulse; no limit if linear. */
static void risen(double pulses[MUSCLES][2], double drive[MUSCLES])
{
    for (int i = 0; i < MUSCLES; i++) {
        if (LINEAR_WIDTH_S[i] > 0.0) {
            drive[i] = INFINITY;
            continue;
        }
        const double width = pulses[i][1] + CHARGE_RISE_C / CURRENT_A[i];
        const double effective_ma = 1e3 * CURRENT_A[i] / (1.0 + CHRONAXIE_S[i] / width);
        drive[i] = 0.5 * erfc(-log(effective_ma / THRESHOLD_MA[i]) / SPREAD[i] * SQRT_HALF);
    }
}
