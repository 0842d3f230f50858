
/* ---- From drives to pulses: recruitment curves inverted at a fixed current. ---- */

/* Inverse of the normal distribution function for p in (0, 1): Abramowitz and Stegun 26.2.23, refined twice
 * by Halley's method on the smaller tail. */
static double normal_quantile(double p)
{
    double tail = p < 1.0 - p ? p : 1.0 - p;
    if (tail < 1e-300) tail = 1e-300;
    const double t = sqrt(-2.0 * log(tail));
    const double below = 1.0 + t * (1.432788 + t * (0.189269 + t * 0.001308));
    double z = t - (2.515517 + t * (0.802853 + t * 0.010328)) / below;
    for (int pass = 0; pass < 2; pass++) {
        const double error = 0.5 * erfc(z * SQRT_HALF) - tail;
        const double step = error * SQRT_TWO_PI * exp(0.5 * z * z);
        z += step / (1.0 - 0.5 * z * step);
    }
    return p < 0.5 ? -z : z;
}

/* Pulse of each channel, A and s; returns how many channels are at their longest pulse. */
static int allocate(const double drive[MUSCLES], double pulses[MUSCLES][2])
{
    int saturated = 0;
    for (int i = 0; i < MUSCLES; i++) {
        double width = 0.0;
        if (LINEAR_WIDTH_S[i] > 0.0) {
            width = drive[i] * LINEAR_WIDTH_S[i];
        } else if (drive[i] >= 1.0) {
            width = LONGEST_S[i];
            saturated++;
        } else if (drive[i] > LEAST_FRACTION) {
            const double effective_ma = THRESHOLD_MA[i] * exp(SPREAD[i] * normal_quantile(drive[i]));
            const double room_ma = 1e3 * CURRENT_A[i] - effective_ma;
            width = room_ma > 0.0 ? CHRONAXIE_S[i] * effective_ma / room_ma : LONGEST_S[i];
            if (width >= LONGEST_S[i]) {
                width = LONGEST_S[i];
                saturated++;
            }
        }
        pulses[i][0] = width != 0.0 ? CURRENT_A[i] : 0.0;
        pulses[i][1] = width;
    }
    return saturated;
}
