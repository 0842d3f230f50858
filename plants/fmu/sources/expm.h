#ifndef EXPM_H
#define EXPM_H

/* exp(a) of an n by n row-major matrix into `out`, n at most EXPM_SIZE. */
#define EXPM_SIZE 64
void expm(int n, const double *a, double *out);

#endif
