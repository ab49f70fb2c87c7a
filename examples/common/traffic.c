#include "common/traffic.h"

static bool is_write(const nrd_binding *b)
{
    return b->access == NRD_ACCESS_WRITE;
}

static bool is_same_image(const nrd_binding *a, const nrd_binding *b)
{
    return a->resource == b->resource && (a->resource != NRD_RESOURCE_INTERNAL || (a->texture == b->texture && a->before_resize == b->before_resize));
}

static bool has_access(const nrd_dispatch *d, uint32_t bindings, const nrd_binding *image, bool write)
{
    for (uint32_t i = 0; i < bindings; i++)
        if (is_same_image(&d->bindings[i], image) && is_write(&d->bindings[i]) == write)
            return true;
    return false;
}

/* Is what dispatch `at` writes there written again before it is read? */
static bool is_overwritten(const nrd_dispatch *dispatches, uint32_t count, uint32_t at, const nrd_binding *image)
{
    for (uint32_t i = at + 1; i < count; i++) {
        const nrd_dispatch *d = &dispatches[i];
        if (has_access(d, d->binding_count, image, false))
            return false;
        if (has_access(d, d->binding_count, image, true))
            return true;
    }
    return false;
}

double traffic_bytes(const nrd_info *info, const nrd_dispatch *dispatches, uint32_t count, traffic_size size, const void *user)
{
    double bytes = 0;
    for (uint32_t i = 0; i < count; i++)
        for (uint32_t k = 0; k < dispatches[i].binding_count; k++) {
            const nrd_binding *b = &dispatches[i].bindings[k];
            if (has_access(&dispatches[i], k, b, is_write(b)) || (is_write(b) && is_overwritten(dispatches, count, i, b)))
                continue;
            bytes += b->resource == NRD_RESOURCE_INTERNAL ? (double)info->textures[b->texture].bytes : size(user, b->resource);
        }
    return bytes;
}
