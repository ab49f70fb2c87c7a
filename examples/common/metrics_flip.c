#include "common/metrics_flip.h"

#include "common/convolve.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define PI 3.14159265358979323846
#define PIXELS_PER_DEGREE 67.0
#define COLOUR_RADIUS 10  /* px: three standard deviations of the widest kernel */
#define FEATURE_SIGMA (0.5 * 0.082 * PIXELS_PER_DEGREE)
#define FEATURE_RADIUS 9  /* px: three sigma */
#define COLOUR_POWER 0.7
#define FEATURE_POWER 0.5
#define KNEE_IN 0.4       /* of the largest colour distance .. */
#define KNEE_OUT 0.95     /* .. is mapped to this */

typedef struct colour { double v[3]; } colour;

/* Planes of one picture: opponent colours, filtered colours, features. */
typedef struct picture {
    double *opponent[3], *filtered[3], *edges, *points;
} picture;

typedef struct workspace {
    int width, height;
    double *memory, *scratch, *line; /* scratch, line: one plane each */
    picture pictures[2];
} workspace;

/* ---- colours ---- */

static const double white[3] = { 0.950428545, 1.0, 1.088900371 }; /* XYZ of D65 */

/* sRGB primaries, IEC 61966-2-1. */
static colour xyz_from_rgb(colour c)
{
    static const double m[3][3] = { { 0.4124564, 0.3575761, 0.1804375 }, { 0.2126729, 0.7151522, 0.0721750 }, { 0.0193339, 0.1191920, 0.9503041 } };
    colour out;
    for (int r = 0; r < 3; r++)
        out.v[r] = m[r][0] * c.v[0] + m[r][1] * c.v[1] + m[r][2] * c.v[2];
    return out;
}

static colour rgb_from_xyz(colour c)
{
    static const double m[3][3] = { { 3.2404542, -1.5371385, -0.4985314 }, { -0.9692660, 1.8760108, 0.0415560 }, { 0.0556434, -0.2040259, 1.0572252 } };
    colour out;
    for (int r = 0; r < 3; r++)
        out.v[r] = m[r][0] * c.v[0] + m[r][1] * c.v[1] + m[r][2] * c.v[2];
    return out;
}

static colour opponent_from_rgb(colour c)
{
    colour x = xyz_from_rgb(c);
    for (int k = 0; k < 3; k++)
        x.v[k] /= white[k];
    return (colour){ { 116 * x.v[1] - 16, 500 * (x.v[0] - x.v[1]), 200 * (x.v[1] - x.v[2]) } };
}

static colour rgb_from_opponent(colour c)
{
    double y = (c.v[0] + 16) / 116;
    colour xyz = { { (y + c.v[1] / 500) * white[0], y * white[1], (y - c.v[2] / 200) * white[2] } };
    colour rgb = rgb_from_xyz(xyz);
    for (int k = 0; k < 3; k++)
        rgb.v[k] = fmin(fmax(rgb.v[k], 0), 1);
    return rgb;
}

static double lab_curve(double x)
{
    const double delta = 6.0 / 29;
    return x > delta * delta * delta ? cbrt(x) : x / (3 * delta * delta) + 4.0 / 29;
}

/* L*a*b* whose chroma counts less in the dark (Hunt). */
static colour hunt_lab_from_rgb(colour c)
{
    colour x = xyz_from_rgb(c);
    for (int k = 0; k < 3; k++)
        x.v[k] = lab_curve(x.v[k] / white[k]);
    double l = 116 * x.v[1] - 16;
    return (colour){ { l, 0.01 * l * 500 * (x.v[0] - x.v[1]), 0.01 * l * 200 * (x.v[1] - x.v[2]) } };
}

static double colour_distance(colour rgb_a, colour rgb_b)
{
    colour a = hunt_lab_from_rgb(rgb_a), b = hunt_lab_from_rgb(rgb_b);
    return pow(fabs(a.v[0] - b.v[0]) + hypot(a.v[1] - b.v[1], a.v[2] - b.v[2]), COLOUR_POWER);
}

/* Distances to [0,1]: two straight lines that meet at the knee. */
static double map_distance(double distance, double largest)
{
    double knee = KNEE_IN * largest;
    return distance < knee ? distance * KNEE_OUT / knee : KNEE_OUT + (distance - knee) / (largest - knee) * (1 - KNEE_OUT);
}

/* ---- filters ---- */

static void convolve(const workspace *w, const double *in, double *out, bool across, const double *kernel, int radius)
{
    if (across)
        convolve_rows(in, out, w->width, w->height, kernel, radius);
    else
        convolve_columns(in, out, w->width, w->height, kernel, radius);
}

/* Contrast sensitivity of one opponent channel: a sum of two Gaussians a sqrt(pi / b) exp(-pi^2 x^2 / b), x in degrees. */
static void filter_colour(const workspace *w, const double *in, double *out, const double amplitude[2], const double width[2])
{
    size_t count = (size_t)w->width * (size_t)w->height;
    double total = 0;
    memset(out, 0, count * sizeof *out);
    for (int term = 0; term < 2; term++) {
        double kernel[2 * COLOUR_RADIUS + 1], sum = 0, scale = amplitude[term] * sqrt(PI / width[term]);
        if (amplitude[term] == 0)
            continue;
        for (int i = -COLOUR_RADIUS; i <= COLOUR_RADIUS; i++) {
            double degrees = i / PIXELS_PER_DEGREE;
            sum += kernel[i + COLOUR_RADIUS] = exp(-PI * PI * degrees * degrees / width[term]);
        }
        convolve(w, in, w->scratch, true, kernel, COLOUR_RADIUS);
        convolve(w, w->scratch, w->line, false, kernel, COLOUR_RADIUS);
        for (size_t i = 0; i < count; i++)
            out[i] += scale * w->line[i];
        total += scale * sum * sum;
    }
    for (size_t i = 0; i < count; i++)
        out[i] /= total;
}

static void filter_colours(const workspace *w, picture *p)
{
    static const double amplitudes[3][2] = { { 1, 0 }, { 1, 0 }, { 34.1, 13.5 } };
    static const double widths[3][2] = { { 0.0047, 1e-5 }, { 0.0053, 1e-5 }, { 0.04, 0.025 } };
    for (int k = 0; k < 3; k++)
        filter_colour(w, p->opponent[k], p->filtered[k], amplitudes[k], widths[k]);
}

/* Derivative of a Gaussian of order 1 or 2 whose positive weights add up to 1 and whose negative ones to -1, when applied
   across the Gaussian `smooth` of sum 1. */
static void feature_kernels(int order, double *smooth, double *derivative)
{
    double sum = 0, positive = 0, negative = 0, s2 = FEATURE_SIGMA * FEATURE_SIGMA;
    for (int i = -FEATURE_RADIUS; i <= FEATURE_RADIUS; i++) {
        double g = exp(-i * i / (2 * s2)), d = order == 1 ? -i * g : (i * i / s2 - 1) * g;
        sum += smooth[i + FEATURE_RADIUS] = g;
        derivative[i + FEATURE_RADIUS] = d;
        positive += fmax(d, 0);
        negative -= fmin(d, 0);
    }
    for (int i = 0; i <= 2 * FEATURE_RADIUS; i++) {
        smooth[i] /= sum;
        derivative[i] /= derivative[i] > 0 ? positive : negative;
    }
}

/* Length of the gradient (order 1: edges) or of the second derivatives (order 2: points) of the luminance in [0,1]. */
static void find_features(const workspace *w, const picture *p, int order, double *out)
{
    double smooth[2 * FEATURE_RADIUS + 1], derivative[2 * FEATURE_RADIUS + 1];
    size_t count = (size_t)w->width * (size_t)w->height;
    feature_kernels(order, smooth, derivative);
    for (int across = 0; across < 2; across++) {
        convolve(w, p->opponent[0], w->scratch, across, derivative, FEATURE_RADIUS);
        convolve(w, w->scratch, w->line, !across, smooth, FEATURE_RADIUS);
        for (size_t i = 0; i < count; i++)
            out[i] = across ? hypot(out[i], w->line[i] / 116) : w->line[i] / 116;
    }
}

/* ---- the whole ---- */

static void fill_picture(const workspace *w, const image *m, const unsigned char *mask, const metrics_scale *scale, picture *p)
{
    for (size_t i = 0; i < image_pixels(m); i++) {
        colour rgb = { { 0, 0, 0 } };
        for (int k = 0; k < 3 && mask[i]; k++)
            rgb.v[k] = pow(metrics_tone(m->planes[m->channels == 1 ? 0 : k][i], scale), 2.2);
        colour opponent = opponent_from_rgb(rgb);
        for (int k = 0; k < 3; k++)
            p->opponent[k][i] = opponent.v[k];
    }
    filter_colours(w, p);
    find_features(w, p, 1, p->edges);
    find_features(w, p, 2, p->points);
}

static double pixel_difference(const workspace *w, size_t i, double largest)
{
    const picture *a = &w->pictures[0], *b = &w->pictures[1];
    colour ca, cb;
    for (int k = 0; k < 3; k++) {
        ca.v[k] = a->filtered[k][i];
        cb.v[k] = b->filtered[k][i];
    }
    double seen = map_distance(colour_distance(rgb_from_opponent(ca), rgb_from_opponent(cb)), largest);
    double feature = fmax(fabs(a->edges[i] - b->edges[i]), fabs(a->points[i] - b->points[i]));
    return pow(seen, 1 - pow(feature / sqrt(2), FEATURE_POWER));
}

static bool make_workspace(workspace *w, int width, int height)
{
    size_t count = (size_t)width * (size_t)height, plane = 0;
    w->width = width;
    w->height = height;
    w->memory = malloc(count * 18 * sizeof *w->memory);
    if (!w->memory)
        return false;
    for (int k = 0; k < 2; k++) {
        picture *p = &w->pictures[k];
        for (int c = 0; c < 3; c++) {
            p->opponent[c] = w->memory + count * plane++;
            p->filtered[c] = w->memory + count * plane++;
        }
        p->edges = w->memory + count * plane++;
        p->points = w->memory + count * plane++;
    }
    w->scratch = w->memory + count * plane++;
    w->line = w->memory + count * plane;
    return true;
}

bool metrics_flip(const image *m, const image *reference, const unsigned char *mask, const metrics_scale *scale, double *out)
{
    const colour green = { { 0, 1, 0 } }, blue = { { 0, 0, 1 } };
    double sum = 0, largest = colour_distance(green, blue);
    size_t used = 0;
    workspace w;
    if (!make_workspace(&w, m->width, m->height))
        return false;
    fill_picture(&w, m, mask, scale, &w.pictures[0]);
    fill_picture(&w, reference, mask, scale, &w.pictures[1]);
    for (size_t i = 0; i < image_pixels(m); i++)
        if (mask[i]) {
            sum += pixel_difference(&w, i, largest);
            used++;
        }
    free(w.memory);
    *out = used ? sum / (double)used : 0;
    return true;
}
