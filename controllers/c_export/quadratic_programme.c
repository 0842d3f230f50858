
/* ---- Quadratic programme: dual active set (Arnstrom, Bemporad and Axehill 2022, doi
 * 10.1109/TAC.2022.3176430).
 *
 * With H = R'R and u = R z the programme is: least |u| with low <= CONSTRAINT u <= high, whose rows have unit
 * length. A working set of rows at their bounds has the multipliers  - (W W')^-1 bound, with W W' = L D L'.
 * Rows with a multiplier of the wrong sign leave the set; else the most violated row enters. ---- */

#define ACTIVE_MAX (UNKNOWNS + 1)
#define ROW(k) ((k) * ((k) - 1) / 2) /* start of row k of L, which has k entries left of its diagonal of ones */

/* L x = b in place, over the first `count` rows. */
static void solve_lower(const block_qp *qp, int count, double *x)
{
    for (int i = 1; i < count; i++)
        for (int j = 0; j < i; j++) x[i] -= qp->lower[ROW(i) + j] * x[j];
}

/* L' x = b in place. */
static void solve_upper(const block_qp *qp, int count, double *x)
{
    for (int i = count - 1; i > 0; i--)
        for (int j = 0; j < i; j++) x[j] -= qp->lower[ROW(i) + j] * x[i];
}

/* Append a row to the working set, and to the factors; 0 if the set has become dependent. */
static int append(block_qp *qp, int row, int side, double multiplier)
{
    const int k = qp->count++;
    double *l = &qp->lower[ROW(k)];
    double pivot = 0.0;
    qp->set[k] = row;
    qp->side[row] = side;
    qp->multiplier[k] = multiplier;
    for (int j = 0; j < UNKNOWNS; j++) pivot += CONSTRAINT[row][j] * CONSTRAINT[row][j];
    for (int i = 0; i < k; i++) {
        l[i] = 0.0;
        for (int j = 0; j < UNKNOWNS; j++) l[i] += CONSTRAINT[qp->set[i]][j] * CONSTRAINT[row][j];
    }
    solve_lower(qp, k, l);
    for (int i = 0; i < k; i++) {
        const double scaled = l[i] / qp->pivot[i];
        pivot -= l[i] * scaled;
        l[i] = scaled;
    }
    qp->pivot[k] = pivot;
    return pivot >= PIVOT_LEAST && k < UNKNOWNS;
}

/* Remove the row at place r, with a rank-one update of the factors below it (Gill, Golub, Murray and Saunders
 * 1974, method C1); 0 if the set is still dependent. */
static int leave(block_qp *qp, int r)
{
    double *w = qp->scratch, alpha = qp->pivot[r];
    const int below = qp->count - r - 1;
    qp->side[qp->set[r]] = 0;
    for (int i = 0; i < below; i++) {
        const double *from = &qp->lower[ROW(r + 1 + i)];
        double *to = &qp->lower[ROW(r + i)];
        w[i] = from[r];
        for (int j = 0; j < r; j++) to[j] = from[j];
        for (int j = 0; j < i; j++) to[r + j] = from[r + 1 + j];
        qp->set[r + i] = qp->set[r + i + 1];
        qp->multiplier[r + i] = qp->multiplier[r + i + 1];
    }
    for (int j = 0; j < below; j++) {
        const double p = w[j], old = qp->pivot[r + 1 + j], updated = old + alpha * p * p;
        const double beta = p * alpha / updated;
        qp->pivot[r + j] = updated;
        alpha = old * alpha / updated;
        for (int i = j + 1; i < below; i++) {
            double *l = &qp->lower[ROW(r + i) + r + j];
            w[i] -= p * *l;
            *l += beta * w[i];
        }
    }
    qp->count--;
    return qp->count == 0 || qp->pivot[qp->count - 1] >= PIVOT_LEAST;
}

/* Factorise the working set again, in the order of the rows and without those that have no multiplier, so that
 * rounding does not add up from solve to solve. */
static void refresh(block_qp *qp)
{
    qp->solves = 0;
    for (int i = 0; i < qp->count; i++)
        if (qp->target[i] == 0.0) qp->side[qp->set[i]] = 0;
    qp->count = 0;
    for (int row = 0; row < BOUNDS; row++) {
        if (qp->side[row] == 0) continue;
        if (append(qp, row, qp->side[row], qp->side[row])) continue;
        for (qp->count--; row < BOUNDS; row++) qp->side[row] = 0;
    }
}

static void forget(block_qp *qp)
{
    for (int row = 0; row < BOUNDS; row++) qp->side[row] = 0;
    qp->count = qp->solves = 0;
}

/* Step the multipliers towards their target, or along it if the set is dependent, until one has no sign left: its
 * place; -1 if none does. */
static int blocking(block_qp *qp, int dependent)
{
    const double least = dependent ? -DIRECTION_TOLERANCE : -MULTIPLIER_TOLERANCE;
    double share = INFINITY;
    int place = -1;
    for (int i = 0; i < qp->count; i++) {
        const int side = qp->side[qp->set[i]];
        const double now = side * qp->multiplier[i], then = side * qp->target[i];
        if (then >= least) continue;
        const double candidate = -now / (dependent ? then : then - now);
        if (candidate < share) {
            share = candidate;
            place = i;
        }
    }
    if (place < 0) return place;
    for (int i = 0; i < qp->count; i++)
        qp->multiplier[i] += share * (dependent ? qp->target[i] : qp->target[i] - qp->multiplier[i]);
    return place;
}

/* One refinement of u on the working set, against the rounding of the factors. */
static void refine(block_qp *qp)
{
    for (int i = 0; i < qp->count; i++) {
        const int row = qp->set[i];
        qp->scratch[i] = qp->side[row] < 0 ? -qp->low[row] : -qp->high[row];
        for (int j = 0; j < UNKNOWNS; j++) qp->scratch[i] += CONSTRAINT[row][j] * qp->u[j];
    }
    solve_lower(qp, qp->count, qp->scratch);
    for (int i = 0; i < qp->count; i++) qp->scratch[i] /= qp->pivot[i];
    solve_upper(qp, qp->count, qp->scratch);
    for (int i = 0; i < qp->count; i++)
        for (int j = 0; j < UNKNOWNS; j++) qp->u[j] -= CONSTRAINT[qp->set[i]][j] * qp->scratch[i];
}

/* Least |u| between `low` and `high`; fills z. Returns BLOCK_OK, BLOCK_INFEASIBLE or BLOCK_ITERATION_LIMIT. */
static int solve_qp(block_qp *qp, double z[UNKNOWNS])
{
    int dependent = 0;
    if (qp->solves >= REFRESH) refresh(qp);
    qp->solves++;
    for (int iteration = 1; iteration < ITERATIONS_MAX; iteration++) {
        const int count = qp->count;
        if (dependent) {
            const int last = count - 1, side = qp->side[qp->set[last]];
            for (int i = 0; i < last; i++) qp->target[i] = -qp->lower[ROW(last) + i];
            solve_upper(qp, last, qp->target);
            qp->target[last] = 1.0;
            for (int i = 0; i < count; i++) qp->target[i] *= side;
            const int place = blocking(qp, 1);
            if (place < 0) return BLOCK_INFEASIBLE;
            dependent = !leave(qp, place);
            continue;
        }
        for (int i = 0; i < count; i++)
            qp->target[i] = qp->side[qp->set[i]] < 0 ? -qp->low[qp->set[i]] : -qp->high[qp->set[i]];
        solve_lower(qp, count, qp->target);
        for (int i = 0; i < count; i++) qp->target[i] /= qp->pivot[i];
        solve_upper(qp, count, qp->target);
        const int place = blocking(qp, 0);
        if (place >= 0) {
            dependent = !leave(qp, place);
            continue;
        }
        for (int j = 0; j < UNKNOWNS; j++) qp->u[j] = 0.0;
        for (int i = 0; i < count; i++)
            for (int j = 0; j < UNKNOWNS; j++) qp->u[j] -= CONSTRAINT[qp->set[i]][j] * qp->target[i];
        int worst = -1, side = 0;
        double least = 0.0;
        for (int row = 0; row < BOUNDS; row++) {
            if (qp->side[row] != 0) continue;
            double value = 0.0;
            for (int j = 0; j < UNKNOWNS; j++) value += CONSTRAINT[row][j] * qp->u[j];
            const double tolerated = -BOUND_TOLERANCE / LENGTH[row];
            const double above = qp->high[row] - value, beneath = value - qp->low[row];
            if (above < least && above < tolerated) {
                worst = row, side = 1, least = above;
            } else if (beneath < least && beneath < tolerated) {
                worst = row, side = -1, least = beneath;
            }
        }
        if (worst < 0) {
            refine(qp);
            for (int i = 0; i < UNKNOWNS; i++) {
                z[i] = 0.0;
                for (int j = i; j < UNKNOWNS; j++) z[i] += CONSTRAINT[i][j] * qp->u[j];
                z[i] *= LENGTH[i];
            }
            return BLOCK_OK;
        }
        for (int i = 0; i < count; i++) qp->multiplier[i] = qp->target[i];
        dependent = !append(qp, worst, side, -side * least);
    }
    return BLOCK_ITERATION_LIMIT;
}
