/* cart: M(q) du/dt = f(t, q, u), dq/dt = u.

t  time [s]
q  S_1, Theta_2
u  SD_1, ThetaD_2
p  M, lambda, pow, pow_, g
M  mass matrix, 2 by 2, row by row
f  forcing, 2

SI units, angles in radians. Written by m4e_fmi. */
#include <math.h>

#ifndef M_PI
#define M_PI 3.14159265358979323846
#endif

static double f_(double t)
{
    static const double times[] = {0.0, 1.0, 2.5}, values[] = {0.0, 400.0, -200.0};
    const int last = sizeof times / sizeof *times - 1;
    int k = 0;
    if (t <= times[0]) return values[0];
    if (t >= times[last]) return values[last];
    while (times[k + 1] < t) ++k;
    return values[k] + (values[k + 1] - values[k]) * ((t - times[k]) / (times[k + 1] - times[k]));
}

void equations(double t, const double *q, const double *u, const double *p, double *M, double *f)
{
    const double Theta_2 = q[1];
    const double SD_1 = u[0];
    const double ThetaD_2 = u[1];
    const double M_ = p[0];
    const double lambda_ = p[1];
    const double pow__ = p[2];
    const double pow_ = p[3];
    const double g = p[4];
    const double c2 = cos(Theta_2);
    const double w1 = c2*lambda_;
    const double w2 = pow(lambda_, 2);
    const double w3 = pow(ThetaD_2, 2);
    const double s2 = sin(Theta_2);
    M[0] = (3.0/2.0)*M_;
    M[1] = -1.0/4.0*M_*w1;
    M[2] = M[1];
    M[3] = (1.0/6.0)*M_*w2;
    f[0] = -1.0/4.0*M_*lambda_*s2*w3 - pow(SD_1, 2)*pow__*(((SD_1) > 0) - ((SD_1) < 0)) + f_(t);
    f[1] = (1.0/8.0)*M_*c2*s2*w2*w3 + (1.0/4.0)*M_*lambda_*s2*(-g - 1.0/2.0*w1*w3) - pow_*sin(2*Theta_2) - 1.0/10.0*M_PI*tanh(100*ThetaD_2) - fmax(0, Theta_2);
}
