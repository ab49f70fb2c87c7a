#include "common/half.h"

#include <string.h>

static uint32_t bits_of(float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    return bits;
}

static float float_of(uint32_t bits)
{
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

/* Shifts right by 1..31 bits, rounding to nearest, ties to even. */
static uint32_t shift_right_round(uint32_t value, uint32_t shift)
{
    uint32_t rest = value & ((1u << shift) - 1), middle = 1u << (shift - 1), result = value >> shift;
    return result + (rest > middle || (rest == middle && (result & 1)));
}

uint16_t half_from_float(float value)
{
    uint32_t bits = bits_of(value), sign = bits >> 16 & 0x8000u, magnitude = bits & 0x7fffffffu, half;
    if (magnitude > 0x7f800000u)
        half = 0x7e00u;
    else if (magnitude == 0x7f800000u)
        half = 0x7c00u;
    else if (magnitude >= 0x38800000u) /* 2^-14: a normal half */
        half = shift_right_round(magnitude - 0x38000000u, 13);
    else if (magnitude >= 0x33000000u) /* 2^-25: half of the smallest one */
        half = shift_right_round((magnitude & 0x7fffffu) | 0x800000u, 126 - (magnitude >> 23));
    else
        half = 0;
    if (half > 0x7bffu && magnitude < 0x7f800000u)
        half = 0x7bffu;
    return (uint16_t)(sign | half);
}

float half_to_float(uint16_t half)
{
    uint32_t sign = (uint32_t)(half & 0x8000u) << 16, magnitude = half & 0x7fffu;
    if (magnitude >= 0x7c00u)
        return float_of(sign | 0x7f800000u | (magnitude & 0x3ffu) << 13);
    if (magnitude < 0x400u) /* 2^-24 each: exact in a float */
        return float_of(sign | bits_of((float)magnitude * 5.9604644775390625e-8f));
    return float_of(sign | ((magnitude << 13) + 0x38000000u));
}

void half_from_floats(uint16_t *out, const float *in, size_t count)
{
    for (size_t i = 0; i < count; i++)
        out[i] = half_from_float(in[i]);
}
