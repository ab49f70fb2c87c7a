/* constants.h: the named constants inside shaders, in a build of the shaders (make's tuning build) in which they are
   specialization constants with ids from CONSTANTS_FIRST_ID on. Values are changed where the modules lie in memory, so that
   pipelines created afterwards have them; the runtime needs to know nothing of it. */
#ifndef EXAMPLES_REPORT_CONSTANTS_H
#define EXAMPLES_REPORT_CONSTANTS_H

#include <stdbool.h>
#include <stdint.h>

enum { CONSTANTS_FIRST_ID = 100, CONSTANTS_MAX = 64, CONSTANTS_NAME = 64, CONSTANTS_PLACES = 16 };

/* One constant, which several modules may hold. */
typedef struct shader_constant {
    char name[CONSTANTS_NAME];
    uint32_t *places[CONSTANTS_PLACES]; /* its value in the modules, a float */
    int place_count;
} shader_constant;

typedef struct shader_constants { shader_constant list[CONSTANTS_MAX]; int count; } shader_constants;

/* Adds the constants of a module. False when there are too many, or it is no SPIR-V. */
bool constants_find(shader_constants *c, uint32_t *words, uint32_t size_bytes);

float constants_get(const shader_constant *c);
void constants_set(const shader_constant *c, float value);

#endif
