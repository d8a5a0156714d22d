// SPDX-License-Identifier: MIT
// Reads and writes little-endian numbers at any alignment. Compilers merge each into one load or
// store.
#pragma once

#include <stdint.h>
#include <string.h>

static inline uint16_t stp_read_u16(const void* bytes)
{
    const unsigned char* p = bytes;
    return (uint16_t)(p[0] | p[1] << 8);
}

static inline uint32_t stp_read_u32(const void* bytes)
{
    const unsigned char* p = bytes;
    return (uint32_t)p[0] | (uint32_t)p[1] << 8 | (uint32_t)p[2] << 16 | (uint32_t)p[3] << 24;
}

static inline uint64_t stp_read_u64(const void* bytes)
{
    return (uint64_t)stp_read_u32(bytes) | (uint64_t)stp_read_u32((const unsigned char*)bytes + 4)
                                               << 32;
}

static inline float stp_read_f32(const void* bytes)
{
    uint32_t bits = stp_read_u32(bytes);
    float value;
    memcpy(&value, &bits, sizeof(value));
    return value;
}

static inline double stp_read_f64(const void* bytes)
{
    uint64_t bits = stp_read_u64(bytes);
    double value;
    memcpy(&value, &bits, sizeof(value));
    return value;
}

static inline void stp_write_u16(void* bytes, uint16_t value)
{
    unsigned char* p = bytes;
    p[0] = (unsigned char)value;
    p[1] = (unsigned char)(value >> 8);
}

static inline void stp_write_u32(void* bytes, uint32_t value)
{
    stp_write_u16(bytes, (uint16_t)value);
    stp_write_u16((unsigned char*)bytes + 2, (uint16_t)(value >> 16));
}

static inline void stp_write_u64(void* bytes, uint64_t value)
{
    stp_write_u32(bytes, (uint32_t)value);
    stp_write_u32((unsigned char*)bytes + 4, (uint32_t)(value >> 32));
}

static inline void stp_write_f32(void* bytes, float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof(bits));
    stp_write_u32(bytes, bits);
}

static inline void stp_write_f64(void* bytes, double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof(bits));
    stp_write_u64(bytes, bits);
}
