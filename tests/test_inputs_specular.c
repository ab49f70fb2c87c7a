/* test_inputs_specular.c: what test_inputs.c asks of the diffuse signal, asked of the specular one, on surfaces of roughness 1. */
#define RIG_SPECULAR
#include "test_inputs.c"
