/* The same promises of REBLUR_DIFFUSE_SH. */
#define RIG_SH
#include "test_inputs.c"
