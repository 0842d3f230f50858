
/* ---- Zero-phase low-pass: a filter that runs forward, then backward. ---- */

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

/* Forward and backward over `count` values, in place, with `padding` values mirrored about either end, for which
 * there is room before and behind them. */
static void low_pass(double *values, int count, int padding)
{
    for (int k = 1; k <= padding; k++) {
        values[-k] = 2.0 * values[0] - values[k];
        values[count - 1 + k] = 2.0 * values[count - 1] - values[count - 1 - k];
    }
    section(values - padding, count + 2 * padding, 1);
    section(values + count + padding - 1, count + 2 * padding, -1);
}
