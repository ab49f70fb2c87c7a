/* scenes.h: the scenes that exist, one file each; scene.c lists them in a table. */
#ifndef EXAMPLES_SCENES_SCENES_H
#define EXAMPLES_SCENES_SCENES_H

#include "scenes/scene.h"

bool scene_build_interior(scene *s, const char *model, char *error, size_t error_size);
bool scene_build_colonnade(scene *s, const char *model, char *error, size_t error_size);
bool scene_build_roughness_ramp(scene *s, const char *model, char *error, size_t error_size);
bool scene_build_moving(scene *s, const char *model, char *error, size_t error_size);
bool scene_build_thin(scene *s, const char *model, char *error, size_t error_size);
bool scene_build_penumbrae(scene *s, const char *model, char *error, size_t error_size);
bool scene_build_sundial(scene *s, const char *model, char *error, size_t error_size);
bool scene_build_glass(scene *s, const char *model, char *error, size_t error_size);
bool scene_build_lamp(scene *s, const char *model, char *error, size_t error_size);
bool scene_build_model(scene *s, const char *model, char *error, size_t error_size);
void scene_animate_interior(scene *s, float time_s);
void scene_animate_colonnade(scene *s, float time_s);
void scene_animate_roughness_ramp(scene *s, float time_s);
void scene_animate_moving(scene *s, float time_s);
void scene_animate_thin(scene *s, float time_s);
void scene_animate_penumbrae(scene *s, float time_s);
void scene_animate_sundial(scene *s, float time_s);
void scene_animate_glass(scene *s, float time_s);
void scene_animate_lamp(scene *s, float time_s);
void scene_animate_model(scene *s, float time_s);

#endif
