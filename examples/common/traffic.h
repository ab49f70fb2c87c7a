/* traffic.h: bytes that the passes of a frame move at least, if nothing stays in caches, as counted from the graph. */
#ifndef EXAMPLES_TRAFFIC_H
#define EXAMPLES_TRAFFIC_H

#include "nrd.h"

/* Bytes of an image of the application's. */
typedef double (*traffic_size)(const void *user, nrd_resource resource);

/* In a pass an image counts once if it is read and once if it is written, however often it is bound: a binding that the pass's
   specialization does not look at holds an image that the pass has anyway. And a write does not count when another pass writes the
   image again before any has read it: steps of a filter that are one module bind what each of them writes, and write their own. */
double traffic_bytes(const nrd_info *info, const nrd_dispatch *dispatches, uint32_t count, traffic_size size, const void *user);

#endif
