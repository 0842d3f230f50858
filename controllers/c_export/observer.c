
/* ---- The plant's state from a measurement of known age and the drives issued since. ---- */

/* Over the duration of one rung of the ladder, under a held drive. */
static void advance_rung(int rung, double x[STATES], const double drive[MUSCLES])
{
    double after[STATES];
    for (int i = 0; i < STATES; i++) after[i] = 0.0;
    for (int j = 0; j < STATES; j++)
        for (int i = 0; i < STATES; i++) after[i] += LADDER[rung][j][i] * x[j];
    for (int j = 0; j < MUSCLES; j++)
        for (int i = 0; i < STATES; i++) after[i] += LADDER[rung][STATES + j][i] * drive[j];
    for (int i = 0; i < STATES; i++) x[i] = after[i];
}

/* Over a duration: whole periods, then the binary digits of the rest's ms, us and ns. */
static void advance_held(double x[STATES], const double drive[MUSCLES], int64_t duration_ns)
{
    static const int64_t unit_ns[3] = {1000000, 1000, 1};
    static const int first[3] = {20, 10, 0};
    for (; duration_ns >= PERIOD_NS; duration_ns -= PERIOD_NS) advance_rung(RUNGS - 1, x, drive);
    for (int k = 0; k < 3; k++) {
        int rung = first[k];
        for (int64_t count = duration_ns / unit_ns[k]; count > 0; count /= 2, rung++)
            if (count % 2) advance_rung(rung, x, drive);
        duration_ns %= unit_ns[k];
    }
}

/* Between two instants under the recorded drives, each of which acts DELAY_NS late. */
static void advance(const block_loop *loop, double x[STATES], int64_t from_ns, int64_t to_ns)
{
    int k = KEPT - 1;
    while (k > 0 && loop->stamps[k] + DELAY_NS > from_ns) k--;
    for (; from_ns < to_ns; k++) {
        int64_t stop_ns = to_ns;
        if (k + 1 < KEPT && loop->stamps[k + 1] + DELAY_NS < to_ns) stop_ns = loop->stamps[k + 1] + DELAY_NS;
        advance_held(x, loop->issued[k], stop_ns - from_ns);
        from_ns = stop_ns;
    }
}

/* To the capture, then the update by the measurement. */
static void correct(block_loop *loop, const double gain[STATES + OUTPUTS][OUTPUTS], int64_t captured_ns,
                    const double measured[OUTPUTS])
{
    advance(loop, loop->x, loop->at_ns, captured_ns);
    double innovation[OUTPUTS];
    for (int i = 0; i < OUTPUTS; i++) {
        innovation[i] = measured[i] - OFFSET[i] - loop->disturbance[i];
        for (int j = 0; j < STATES; j++) innovation[i] -= OUTPUT_MAP[i][j] * loop->x[j];
    }
    for (int i = 0; i < OUTPUTS; i++) {
        for (int j = 0; j < STATES; j++) loop->x[j] += gain[j][i] * innovation[i];
        for (int j = 0; j < OUTPUTS; j++) loop->disturbance[j] += gain[STATES + j][i] * innovation[i];
    }
}

/* State at an instant, then the drives of 1 to STORED periods before it. */
static void predict(const block_loop *loop, int64_t to_ns, int64_t from_ns, double present[PRESENT])
{
    for (int i = 0; i < STATES; i++) present[i] = loop->x[i];
    advance(loop, present, from_ns, to_ns);
    int k = KEPT - 1;
    for (int lag = 1; lag <= STORED; lag++) {
        /* half a period of tolerance: ticks of a period of fractional ns differ by 1 ns */
        while (k > 0 && loop->stamps[k] > to_ns - lag * PERIOD_NS + PERIOD_NS / 2) k--;
        for (int i = 0; i < MUSCLES; i++) present[STATES + (lag - 1) * MUSCLES + i] = loop->issued[k][i];
    }
}

static void record(block_loop *loop, int64_t time_ns, const double drive[MUSCLES])
{
    for (int k = 0; k + 1 < KEPT; k++) {
        loop->stamps[k] = loop->stamps[k + 1];
        for (int i = 0; i < MUSCLES; i++) loop->issued[k][i] = loop->issued[k + 1][i];
    }
    loop->stamps[KEPT - 1] = time_ns;
    for (int i = 0; i < MUSCLES; i++) loop->issued[KEPT - 1][i] = drive[i];
}
