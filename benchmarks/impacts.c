/* Impacts of z'' = gbar + cos(pi t + phase) between walls at -d/2 and d/2, in closed form: the C peers of impacts.py.

   A flight is looked at in equal steps of time until it is past a wall, and solved there by Newton's method. Phases are
   in units of pi, modulo 2. Each function returns the flights evaluated per impact. */

#include <math.h>

#define PI 3.141592653589793
#define LANES 512

/* Of pi x, by one polynomial each in the square of the distance from the nearest whole number, to 7e-19 and 4e-18. */
static inline void sine_and_cosine(double x, double *sine, double *cosine) {
    double k = rint(x), r = x - k, u = r * r, half = 0.5 * k, sign = 1 - 4 * (half - floor(half));
    double s = 7.6978267682241906e-7, c = 4.1495643539425855e-6;
    s = -2.1903497074626017e-5 + u * s, c = -0.00010456655338748738 + u * c;
    s = 0.00046629981618983938 + u * s, c = 0.0019295562724817131 + u * c;
    s = -0.0073704305059169434 + u * s, c = -0.025806888737002203 + u * c;
    s = 0.08214588657310289502 + u * s, c = 0.23533063012953285 + u * c;
    s = -0.5992645293244946813 + u * s, c = -1.3352627688434471 + u * c;
    s = 2.5501640398773004745 + u * s, c = 4.0587121264164970 + u * c;
    s = -5.1677127800499696077 + u * s, c = -4.9348022005446768 + u * c;
    *sine = sign * r * (PI + u * s), *cosine = sign * (1 + u * c);
}

/* Position, velocity and acceleration at t after a start where w is the velocity less sin(phase)/pi, and c the cosine. */
static inline void flown(double t, double z, double w, double c, double p, double g, double *at, double *v, double *a) {
    double sine, cosine;
    sine_and_cosine(p + t, &sine, &cosine);
    *at = z + t * (w + 0.5 * g * t) + (c - cosine) * (1 / (PI * PI));
    *v = w + g * t + sine * (1 / PI);
    *a = g + cosine;
}

/* One trajectory, from an impact on the bottom; `last` is the velocity and the phase of the last one there. */
double one(double d, double g, double r, double speed, double phase, double h, long impacts, double *last) {
    double z = d / 2, v = -r * speed, p = phase / PI;
    long evaluations = 0;
    for (long i = 0; i < impacts; i++) {
        double s, c, t = 0, at, now, a, step = 0;
        sine_and_cosine(p, &s, &c);
        double w = v - s / PI;
        do {
            t += h, evaluations++;
            flown(t, z, w, c, p, g, &at, &now, &a);
        } while (fabs(at) <= d / 2);
        double low = t - h, high = t, wall = at > 0 ? d / 2 : -d / 2;
        for (int k = 0; k < 60; k++) {
            step = (wall - at) / now;
            if (fabs(step) < 1e-8) break; /* another step would change nothing: Newton's method squares the error */
            t += step;
            if (!(low < t && t < high)) t = (low + high) / 2;
            flown(t, z, w, c, p, g, &at, &now, &a), evaluations++;
            if (fabs(at) > d / 2) high = t; else low = t;
        }
        now += a * step;
        p += t + step, p -= 2 * floor(0.5 * p);
        if (wall > 0) last[0] = now, last[1] = p * PI;
        z = wall, v = -r * now;
    }
    return (double)evaluations / impacts;
}

/* Trajectories in lockstep: `speeds` and `phases` of impacts on the bottom at the start, and of the last ones there. */
double lockstep(double d, double g, double r, double *speeds, double *phases, double h, long impacts) {
    static double z[LANES], v[LANES], p[LANES], w[LANES], c[LANES], t[LANES], low[LANES], high[LANES], wall[LANES];
    static double at[LANES], now[LANES], a[LANES], step[LANES];
    long passes = 0;
    for (int j = 0; j < LANES; j++) z[j] = d / 2, v[j] = -r * speeds[j], p[j] = phases[j] / PI;
    for (long i = 0; i < impacts; i++) {
        for (int j = 0; j < LANES; j++) {
            double s;
            sine_and_cosine(p[j], &s, &c[j]);
            w[j] = v[j] - s / PI, t[j] = 0, at[j] = 0, step[j] = 0;
        }
        for (long left = 1; left; passes++) {
            left = 0;
            for (int j = 0; j < LANES; j++) {
                double next = t[j] + h, y, speed, b, flies = fabs(at[j]) <= d / 2 ? 1 : 0;
                flown(next, z[j], w[j], c[j], p[j], g, &y, &speed, &b);
                t[j] = flies ? next : t[j], at[j] = flies ? y : at[j];
                now[j] = flies ? speed : now[j], a[j] = flies ? b : a[j];
                left |= fabs(at[j]) <= d / 2;
            }
        }
        for (int j = 0; j < LANES; j++) low[j] = t[j] - h, high[j] = t[j], wall[j] = copysign(d / 2, at[j]);
        for (int k = 0; k < 60; k++) {
            long left = 0;
            for (int j = 0; j < LANES; j++) {
                step[j] = (wall[j] - at[j]) / now[j];
                left |= fabs(step[j]) >= 1e-8;
            }
            if (!left) break;
            passes++;
            for (int j = 0; j < LANES; j++) {
                double next = t[j] + step[j], y, speed, b, moves = fabs(step[j]) < 1e-8 ? 0 : 1;
                double tried = (low[j] < next && next < high[j]) ? next : (low[j] + high[j]) / 2;
                tried = moves ? tried : t[j];
                flown(tried, z[j], w[j], c[j], p[j], g, &y, &speed, &b);
                t[j] = tried, at[j] = y, now[j] = speed, a[j] = b;
                high[j] = fabs(y) > d / 2 ? tried : high[j], low[j] = fabs(y) > d / 2 ? low[j] : tried;
            }
        }
        for (int j = 0; j < LANES; j++) {
            double q = p[j] + t[j] + step[j], speed = now[j] + a[j] * step[j], bottom = wall[j] > 0 ? 1 : 0;
            p[j] = q - 2 * floor(0.5 * q);
            speeds[j] = bottom ? speed : speeds[j], phases[j] = bottom ? p[j] * PI : phases[j];
            z[j] = wall[j], v[j] = -r * speed;
        }
    }
    return (double)passes / impacts;
}
