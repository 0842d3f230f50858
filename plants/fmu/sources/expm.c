/* Scaling and squaring around a Taylor series (Moler and Van Loan 2003, method 3, doi 10.1137/S00361445024180).
 *
 * The matrix is first balanced by powers of two (Osborne 1960), which costs no rounding and keeps states of
 * very different units (rad, rad/s, 1) from being squared more often than they need.
 */
#include "expm.h"

#include <math.h>
#include <string.h>

#define TERMS 18 /* of a matrix of norm at most 1/2: the remainder is below 1e-22 */

static void multiply(int n, const double *a, const double *b, double *out) {
    for (int i = 0; i < n; i++) {
        double row[EXPM_SIZE] = {0};
        for (int k = 0; k < n; k++)
            for (int j = 0; j < n; j++) row[j] += a[i * n + k] * b[k * n + j];
        memcpy(out + i * n, row, (size_t)n * sizeof(double));
    }
}

static void balance(int n, double *a, int *power) {
    for (int i = 0; i < n; i++) power[i] = 0;
    for (int sweep = 0, changed = 1; sweep < 20 && changed; sweep++) {
        changed = 0;
        for (int i = 0; i < n; i++) {
            double row = 0.0, column = 0.0;
            for (int j = 0; j < n; j++)
                if (j != i) {
                    row += fabs(a[i * n + j]);
                    column += fabs(a[j * n + i]);
                }
            if (row == 0.0 || column == 0.0) continue;
            int shift = (int)lround(0.5 * (log2(row) - log2(column)));
            if (!shift) continue;
            changed = 1;
            power[i] += shift;
            for (int j = 0; j < n; j++)
                if (j != i) {
                    a[i * n + j] = ldexp(a[i * n + j], -shift);
                    a[j * n + i] = ldexp(a[j * n + i], shift);
                }
        }
    }
}

static double norm(int n, const double *a) {
    double largest = 0.0;
    for (int i = 0; i < n; i++) {
        double sum = 0.0;
        for (int j = 0; j < n; j++) sum += fabs(a[i * n + j]);
        if (sum > largest) largest = sum;
    }
    return largest;
}

void expm(int n, const double *a, double *out) {
    double scaled[EXPM_SIZE * EXPM_SIZE], term[EXPM_SIZE * EXPM_SIZE];
    int power[EXPM_SIZE], squarings = 0;
    size_t size = (size_t)n * (size_t)n;
    memcpy(scaled, a, size * sizeof(double));
    balance(n, scaled, power);
    for (double left = norm(n, scaled); left > 0.5; left *= 0.5) squarings++;
    for (size_t i = 0; i < size; i++) scaled[i] = ldexp(scaled[i], -squarings);
    memset(term, 0, size * sizeof(double));
    for (int i = 0; i < n; i++) term[i * n + i] = 1.0;
    memcpy(out, term, size * sizeof(double));
    for (int k = 1; k <= TERMS; k++) {
        multiply(n, term, scaled, term);
        for (size_t i = 0; i < size; i++) {
            term[i] /= k;
            out[i] += term[i];
        }
    }
    for (int k = 0; k < squarings; k++) {
        memcpy(term, out, size * sizeof(double));
        multiply(n, term, term, out);
    }
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) out[i * n + j] = ldexp(out[i * n + j], power[i] - power[j]);
}
