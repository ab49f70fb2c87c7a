#include "common/metrics_faults.h"

#include "common/metrics_guides.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define FIREFLY_FACTOR 3.0
#define FIREFLY_FLOOR 0.05
#define FIREFLY_RADIUS 2
#define DEPTH_BEND 0.02
#define GHOST_EPSILON 0.01

/* ---- fireflies ---- */

static double brightest_near(const image *m, int x, int y)
{
    double most = 0;
    for (int dy = -FIREFLY_RADIUS; dy <= FIREFLY_RADIUS; dy++)
        for (int dx = -FIREFLY_RADIUS; dx <= FIREFLY_RADIUS; dx++) {
            int tx = x + dx, ty = y + dy;
            if (tx >= 0 && ty >= 0 && tx < m->width && ty < m->height)
                most = fmax(most, image_luminance(m, (size_t)ty * (size_t)m->width + (size_t)tx));
        }
    return most;
}

long metrics_count_fireflies(const image *m, const image *reference, const unsigned char *mask, const metrics_scale *scale)
{
    double slack = FIREFLY_FLOOR / scale->exposure;
    long count = 0;
    for (int y = 0; y < m->height; y++)
        for (int x = 0; x < m->width; x++) {
            size_t i = (size_t)y * (size_t)m->width + (size_t)x;
            if (mask[i] && image_luminance(m, i) > FIREFLY_FACTOR * brightest_near(reference, x, y) + slack)
                count++;
        }
    return count;
}

/* ---- edges ---- */

static bool is_bent(const guides *g, size_t before, size_t i, size_t after)
{
    double z = g->view_z[i];
    return fabs((double)g->view_z[before] + g->view_z[after] - 2 * z) > DEPTH_BEND * fabs(z);
}

/* Whether there is an edge at pixel (x, y): between it and its neighbour to the right or below, or in its depth. */
static bool is_edge(const guides *g, int x, int y)
{
    int width = g->frame->width, height = g->frame->height;
    size_t i = (size_t)y * (size_t)width + (size_t)x, row = (size_t)width;
    if (x + 1 < width && !guides_are_alike(g, i, g, i + 1))
        return true;
    if (y + 1 < height && !guides_are_alike(g, i, g, i + row))
        return true;
    if (x > 0 && x + 1 < width && is_bent(g, i - 1, i, i + 1))
        return true;
    return y > 0 && y + 1 < height && is_bent(g, i - row, i, i + row);
}

static void mark_around(unsigned char *near, int width, int height, int x, int y, int radius)
{
    int left = x < radius ? 0 : x - radius, right = x + radius >= width ? width - 1 : x + radius;
    for (int ty = y < radius ? 0 : y - radius; ty <= y + radius && ty < height; ty++)
        memset(near + (size_t)ty * (size_t)width + (size_t)left, 1, (size_t)(right - left + 1));
}

bool metrics_keep_edges(const capture *frame, int radius, unsigned char *mask)
{
    guides g;
    size_t count = (size_t)frame->width * (size_t)frame->height;
    unsigned char *near = calloc(count, 1);
    if (!near)
        return false;
    if (guides_find(frame, false, &g))
        for (int y = 0; y < frame->height; y++)
            for (int x = 0; x < frame->width; x++)
                if (is_edge(&g, x, y))
                    mark_around(near, frame->width, frame->height, x, y, radius);
    for (size_t i = 0; i < count; i++)
        mask[i] = mask[i] && near[i];
    free(near);
    return true;
}

/* ---- the worst place ---- */

/* Mean square of one tile; 0 when less than half of it counts. */
static double tile_error(const image *m, const image *reference, const unsigned char *mask, const metrics_scale *scale, int left, int top)
{
    double sum = 0;
    long used = 0, all = 0;
    for (int y = top; y < top + METRICS_TILE && y < m->height; y++)
        for (int x = left; x < left + METRICS_TILE && x < m->width; x++) {
            size_t i = (size_t)y * (size_t)m->width + (size_t)x;
            all++;
            if (!mask[i])
                continue;
            used++;
            for (int k = 0; k < m->channels; k++) {
                double d = metrics_tone(m->planes[k][i], scale) - metrics_tone(reference->planes[k][i], scale);
                sum += d * d / m->channels;
            }
        }
    return used && 2 * used >= all ? sum / (double)used : 0;
}

double metrics_worst_tile(const image *m, const image *reference, const unsigned char *mask, const metrics_scale *scale)
{
    double worst = 0;
    for (int y = 0; y < m->height; y += METRICS_TILE)
        for (int x = 0; x < m->width; x += METRICS_TILE)
            worst = fmax(worst, tile_error(m, reference, mask, scale, x, y));
    return sqrt(worst);
}

/* ---- lag and ghosts ---- */

double metrics_lag(const double *response, int count)
{
    for (int i = 0; i < count; i++) {
        if (response[i] < METRICS_LAG_SHARE)
            continue;
        return i == 0 ? 0 : i - (response[i] - METRICS_LAG_SHARE) / (response[i] - response[i - 1]);
    }
    return count;
}

void metrics_add_ghost(const capture *then, const image *reference_then, const capture *now, const image *m, const image *reference,
                       const unsigned char *mask, metrics_ghost *ghost)
{
    guides g_then, g_now;
    if (now->cut || then->width != now->width || then->height != now->height || !guides_find(then, false, &g_then)
        || !guides_find(now, true, &g_now))
        return;
    for (int y = 0; y < now->height; y++)
        for (int x = 0; x < now->width; x++) {
            size_t i = (size_t)y * (size_t)now->width + (size_t)x, j;
            if (!mask[i] || !guides_previous_pixel(&g_now, x, y, &j) || guides_same_surface(&g_then, j, &g_now, i))
                continue;
            double expected = image_luminance(reference, i), was = image_luminance(reference_then, j), value = image_luminance(m, i);
            double weight = 1 / (expected * expected + was * was + GHOST_EPSILON);
            ghost->along += weight * ((isfinite(value) ? value : 0) - expected) * (was - expected);
            ghost->square += weight * (was - expected) * (was - expected);
            ghost->pixels++;
        }
}
