/* test_sh_specular.c: what test_sh.c asks of the diffuse signal, asked of the specular one, on surfaces of roughness 1. */
#define RIG_SPECULAR
#include "test_sh.c"
