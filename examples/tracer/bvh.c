#include "tracer/bvh.h"

#include <stdlib.h>
#include <string.h>

enum { BINS = 16, LEAF_SIZE = 4, MAX_LEAF_SIZE = 16 };

typedef struct box {
    float low[3], high[3];
} box;

typedef struct builder {
    bvh *out;
    box *boxes; /* of the triangles */
} builder;

typedef struct split {
    int axis;
    float position; /* of box centres */
    float cost;     /* relative to the area of the node; infinite: there is none */
} split;

static box empty_box(void) { return (box){ { INFINITY, INFINITY, INFINITY }, { -INFINITY, -INFINITY, -INFINITY } }; }

static void extend(box *b, const box *other)
{
    for (int c = 0; c < 3; c++) {
        b->low[c] = min(b->low[c], other->low[c]);
        b->high[c] = max(b->high[c], other->high[c]);
    }
}

static float half_area(const box *b)
{
    float x = b->high[0] - b->low[0], y = b->high[1] - b->low[1], z = b->high[2] - b->low[2];
    return x < 0.0f ? 0.0f : x * y + y * z + z * x;
}

static float center(const box *b, int axis) { return 0.5f * (b->low[axis] + b->high[axis]); }

static box triangle_box(const pt_triangle *t)
{
    box b = empty_box();
    for (int k = 0; k < 3; k++)
        for (int c = 0; c < 3; c++) {
            b.low[c] = min(b.low[c], t->p[k][c]);
            b.high[c] = max(b.high[c], t->p[k][c]);
        }
    return b;
}

typedef struct bin {
    box bounds;
    uint32_t count;
} bin;

static void fill_bins(const builder *b, uint32_t first, uint32_t count, int axis, float low, float scale, bin *bins)
{
    for (int i = 0; i < BINS; i++) bins[i] = (bin){ empty_box(), 0 };
    for (uint32_t i = first; i < first + count; i++) {
        const box *t = &b->boxes[b->out->order[i]];
        int k = (int)((center(t, axis) - low) * scale);
        bin *at = &bins[k < 0 ? 0 : k >= BINS ? BINS - 1 : k];
        extend(&at->bounds, t);
        at->count++;
    }
}

/* Best border between the bins of one axis. */
static split best_border(const bin *bins, int axis, float low, float width)
{
    float right_cost[BINS];
    box grown = empty_box();
    uint32_t count = 0;
    for (int i = BINS - 1; i > 0; i--) {
        extend(&grown, &bins[i].bounds);
        count += bins[i].count;
        right_cost[i] = count ? half_area(&grown) * (float)count : INFINITY;
    }
    split best = { axis, 0.0f, INFINITY };
    grown = empty_box();
    count = 0;
    for (int i = 0; i < BINS - 1; i++) {
        extend(&grown, &bins[i].bounds);
        count += bins[i].count;
        float cost = count ? half_area(&grown) * (float)count + right_cost[i + 1] : INFINITY;
        if (cost < best.cost) best = (split){ axis, low + width * (float)(i + 1), cost };
    }
    return best;
}

static split find_split(const builder *b, uint32_t first, uint32_t count)
{
    split best = { 0, 0.0f, INFINITY };
    for (int axis = 0; axis < 3; axis++) {
        float low = INFINITY, high = -INFINITY;
        for (uint32_t i = first; i < first + count; i++) {
            float c = center(&b->boxes[b->out->order[i]], axis);
            low = min(low, c);
            high = max(high, c);
        }
        if (!(high > low)) continue;
        bin bins[BINS];
        fill_bins(b, first, count, axis, low, (float)BINS / (high - low), bins);
        split s = best_border(bins, axis, low, (high - low) / (float)BINS);
        if (s.cost < best.cost) best = s;
    }
    return best;
}

/* Moves the triangles before the split to the front; returns how many there are. */
static uint32_t partition(builder *b, uint32_t first, uint32_t count, const split *s)
{
    uint32_t middle = first;
    for (uint32_t i = first; i < first + count; i++) {
        uint32_t id = b->out->order[i];
        if (center(&b->boxes[id], s->axis) >= s->position) continue;
        b->out->order[i] = b->out->order[middle];
        b->out->order[middle++] = id;
    }
    return middle - first;
}

static void build_node(builder *b, uint32_t index, uint32_t first, uint32_t count, int depth)
{
    pt_node *node = &b->out->nodes[index];
    box bounds = empty_box();
    for (uint32_t i = first; i < first + count; i++) extend(&bounds, &b->boxes[b->out->order[i]]);
    memcpy(node->low, bounds.low, sizeof node->low);
    memcpy(node->high, bounds.high, sizeof node->high);
    node->first = first;
    node->count = count;
    if (count <= LEAF_SIZE || depth == BVH_MAX_DEPTH - 1) return;
    split s = find_split(b, first, count);
    if (s.cost >= half_area(&bounds) * (float)count && count <= MAX_LEAF_SIZE) return;
    uint32_t left = s.cost < INFINITY ? partition(b, first, count, &s) : 0;
    if (left == 0 || left == count) left = count / 2; /* all centres in one place: any halves will do */
    node->first = b->out->node_count;
    node->count = 0;
    b->out->node_count += 2;
    uint32_t child = node->first;
    build_node(b, child, first, left, depth + 1);
    build_node(b, child + 1, first + left, count - left, depth + 1);
}

bool bvh_build(const pt_scene *scene, bvh *out)
{
    uint32_t count = scene->triangle_count;
    *out = (bvh){ 0 };
    if (count == 0) return false;
    out->nodes = malloc(2 * (size_t)count * sizeof *out->nodes);
    out->order = malloc(count * sizeof *out->order);
    builder b = { out, malloc(count * sizeof *b.boxes) };
    bool ok = out->nodes && out->order && b.boxes;
    for (uint32_t i = 0; ok && i < count; i++) {
        out->order[i] = i;
        b.boxes[i] = triangle_box(&scene->triangles[i]);
    }
    out->node_count = 1;
    if (ok)
        build_node(&b, 0, 0, count, 0);
    else
        bvh_free(out);
    free(b.boxes);
    return ok;
}

void bvh_free(bvh *b)
{
    free(b->nodes);
    free(b->order);
    *b = (bvh){ 0 };
}
