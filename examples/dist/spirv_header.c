/* spirv-header FOLDER QUALIFIER MODULE...: prints nrd_spirv.h: FOLDER/MODULE.spv as arrays of words, each under a condition that asks
   for the denoisers whose passes run it, as nrd.h has them. QUALIFIER: const, or nothing for arrays that can be written to. */
#define NRD_IMPLEMENTATION
#include "nrd.h"

#include <stdio.h>
#include <stdlib.h>

enum { WORDS_A_LINE = 8 };

static bool denoiser_runs(nrd_denoiser denoiser, const char *module)
{
    nrd_denoiser_desc one = { 0, denoiser };
    nrd_desc desc = { .width = 8, .height = 8, .denoisers = &one, .denoiser_count = 1, .features = NRD_FEATURE_ALL };
    nrd *instance = NULL;
    bool found = false;
    if (nrd_create(&desc, &instance) != NRD_RESULT_OK) return false;
    const nrd_info *info = nrd_get_info(instance);
    for (uint32_t i = 0; i < info->pipeline_count; i++) found |= strcmp(info->pipelines[i].shader, module) == 0;
    nrd_destroy(instance);
    return found;
}

/* False: no denoiser runs it. */
static bool print_condition(const char *module)
{
    static const char *const names[] = {
#define LIST_NAME(name, text, settings) #name,
        NRD_DENOISERS(LIST_NAME)
#undef LIST_NAME
    };
    uint32_t users = 0;
    printf("#if ");
    for (uint32_t i = 0; i < NRD_DENOISER_COUNT; i++)
        if (denoiser_runs((nrd_denoiser)i, module)) printf("%sNRDI_WITH(%s)", users++ ? " || " : "", names[i]);
    printf("\n");
    return users > 0;
}

static bool print_words(FILE *file)
{
    uint32_t word, count = 0;
    while (fread(&word, sizeof word, 1, file) == 1) printf("%s0x%08x,", count++ % WORDS_A_LINE ? " " : "\n    ", (unsigned)word);
    return count > 0 && !ferror(file);
}

static bool print_module(const char *folder, const char *qualifier, const char *module)
{
    char path[4096];
    if (snprintf(path, sizeof path, "%s/%s.spv", folder, module) >= (int)sizeof path) return false;
    FILE *file = fopen(path, "rb");
    if (!file) return fprintf(stderr, "spirv-header: cannot read %s\n", path), false;
    bool ok = print_condition(module);
    if (!ok) fprintf(stderr, "spirv-header: no denoiser of nrd.h runs %s\n", module);
    printf("static %s%suint32_t %s_words[] = {", qualifier, *qualifier ? " " : "", module);
    ok = print_words(file) && ok;
    printf("\n};\n#endif\n");
    fclose(file);
    return ok;
}

int main(int argc, char **argv)
{
    bool ok = argc > 3;
    if (!ok) fprintf(stderr, "usage: spirv-header FOLDER QUALIFIER MODULE...\n");
    printf("/* All passes as SPIR-V; generated from nrd_shaders/. */\n#ifndef NRD_SPIRV_H\n#define NRD_SPIRV_H\n#include \"nrd.h\"\n"
           "typedef struct nrd_spirv { const char *name; const uint32_t *words; uint32_t size_bytes; } nrd_spirv;\n");
    for (int i = 3; i < argc && ok; i++) ok = print_module(argv[1], argv[2], argv[i]);
    printf("static const nrd_spirv nrd_spirv_table[] = {\n");
    for (int i = 3; i < argc && ok; i++) {
        ok = print_condition(argv[i]);
        printf("    { \"%s\", %s_words, sizeof %s_words },\n#endif\n", argv[i], argv[i], argv[i]);
    }
    printf("};\nstatic const uint32_t nrd_spirv_count = sizeof nrd_spirv_table / sizeof nrd_spirv_table[0];\n#endif\n");
    return ok && !ferror(stdout) ? 0 : 1;
}
