/* device.h: the device of a test program. open_device, or open_validated_device, and close_device are the group's setup and teardown. */
#ifndef TESTS_DEVICE_H
#define TESTS_DEVICE_H

#include "common/gpu.h"

#include <setjmp.h>
#include <stdarg.h>

#include <cmocka.h>

static gpu device;

static inline int open_device_with(bool validation)
{
    char error[256];
    gpu_desc desc = { .validation = validation, .sync_validation = validation };
    if (gpu_open(&device, &desc, error, sizeof error)) return 0;
    print_error("%s\n", error);
    return -1;
}

static inline int open_device(void **state)
{
    (void)state;
    return open_device_with(false);
}

/* Under the validation layers, where they are installed. */
static inline int open_validated_device(void **state)
{
    (void)state;
    return open_device_with(gpu_validation_available());
}

/* Fails if the layers had something to say. */
static inline int close_device(void **state)
{
    uint32_t messages = gpu_message_count(&device);
    (void)state;
    gpu_close(&device);
    return messages ? -1 : 0;
}

#endif
