/* The same promises of REBLUR_SPECULAR_SH. */
#define RIG_SH
#define RIG_SPECULAR
#include "test_inputs.c"
