/* frame_fixture.h: what the tests of nrd.h share: an allocator and a logger that remember, settings by name, frames. */
#ifndef TESTS_FRAME_FIXTURE_H
#define TESTS_FRAME_FIXTURE_H

#include "nrd.h"

#include "common/pose.h"
#include "common/settings.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* ---------------------------------------------------------------------------------------------------------------------------
   Spy  >>spy */
typedef struct spy {
    uint32_t messages, errors;     /* since forget_messages */
    nrd_severity severity;         /* of the last one */
    nrd_result result;
    char text[512];
    uint32_t allocations, releases;
    bool refuse;                   /* the allocator returns NULL */
    void *block;                   /* what it gave last */
    size_t bytes;
} spy;

static inline void *spy_allocate(void *user, size_t bytes)
{
    spy *s = (spy *)user;
    s->allocations++;
    s->bytes = bytes;
    s->block = s->refuse ? NULL : malloc(bytes);
    return s->block;
}

static inline void spy_release(void *user, void *memory)
{
    ((spy *)user)->releases++;
    free(memory);
}

static inline void spy_message(void *user, nrd_severity severity, nrd_result result, const char *text)
{
    spy *s = (spy *)user;
    s->messages++;
    s->errors += severity == NRD_SEVERITY_ERROR;
    s->severity = severity;
    s->result = result;
    snprintf(s->text, sizeof s->text, "%s", text);
}

static inline void forget_messages(spy *s)
{
    s->messages = s->errors = 0;
    s->text[0] = 0;
}

static inline nrd_desc spied_desc(spy *s, const nrd_denoiser_desc *denoisers, uint32_t count, uint32_t width, uint32_t height, uint32_t features)
{
    nrd_desc desc = { .width = width, .height = height, .denoisers = denoisers, .denoiser_count = count, .features = features,
                      .allocate = spy_allocate, .release = spy_release, .allocate_user = s, .message = spy_message, .message_user = s };
    return desc;
}

static inline nrd *create_one(spy *s, nrd_denoiser denoiser, uint32_t width, uint32_t height, uint32_t features)
{
    nrd_denoiser_desc one = { 7, denoiser };
    nrd_desc desc = spied_desc(s, &one, 1, width, height, features);
    nrd *instance = NULL;
    memset(s, 0, sizeof *s);
    assert_int_equal(nrd_create(&desc, &instance), NRD_RESULT_OK);
    return instance;
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Settings by name  >>settings */
/* denoiser NRD_DENOISER_COUNT: nrd_frame. False: there is no such setting. */
static inline bool find_setting(nrd_denoiser denoiser, const char *name, nrd_setting *out)
{
    for (uint32_t i = 0; nrd_get_setting(denoiser, i, out); i++)
        if (strcmp(out->name, name) == 0) return true;
    return false;
}

static inline bool put_setting_by_name(nrd_denoiser denoiser, void *settings, const char *name, double value)
{
    nrd_setting setting;
    if (!find_setting(denoiser, name, &setting)) return false;
    setting_put(&setting, settings, value);
    return true;
}

/* ---------------------------------------------------------------------------------------------------------------------------
   Instances and frames  >>frames */
/* A frame seen by a camera that stands at the origin. */
static inline nrd_frame still_frame(uint32_t frame_index)
{
    nrd_frame frame = nrd_frame_defaults();
    pose p = pose_at(0, 0, 0);
    frame.camera = pose_camera(&p);
    frame.frame_index = frame_index;
    return frame;
}

/* An instance with every denoiser, identified by its number, and every feature. */
static inline nrd *create_all(spy *s)
{
    nrd_denoiser_desc all[NRD_DENOISER_COUNT];
    nrd *instance = NULL;
    memset(s, 0, sizeof *s);
    for (uint32_t i = 0; i < NRD_DENOISER_COUNT; i++) all[i].identifier = i, all[i].denoiser = (nrd_denoiser)i;
    nrd_desc desc = spied_desc(s, all, NRD_DENOISER_COUNT, 64, 48, NRD_FEATURE_ALL);
    assert_int_equal(nrd_create(&desc, &instance), NRD_RESULT_OK);
    return instance;
}

#endif
