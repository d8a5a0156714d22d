// SPDX-License-Identifier: MIT
#include "base/io/bytes.h"
#include "import/pcd/pcd.h"

#include <assert.h>
#include <math.h>
#include <string.h>

double stp_pcd_value(const unsigned char* at, const stp_pcd_field* f)
{
    assert(f->type == 'F' ? f->size == 4 || f->size == 8 : f->size <= 8);
    if (f->type == 'F') {
        return f->size == 4 ? (double)stp_read_f32(at) : stp_read_f64(at);
    }
    uint64_t bits = f->size == 8   ? stp_read_u64(at)
                    : f->size == 4 ? stp_read_u32(at)
                    : f->size == 2 ? stp_read_u16(at)
                                   : *at;
    if (f->type == 'U') {
        return (double)bits;
    }
    unsigned unused = 64 - 8 * f->size;
    return (double)((int64_t)(bits << unused) >> unused);
}

void stp_pcd_read_column(const unsigned char* at, size_t stride, const stp_pcd_field* f,
                         size_t count, double* to)
{
    if (f->type == 'F' && f->size == 4) {
        for (size_t i = 0; i < count; ++i) {
            to[i] = (double)stp_read_f32(at + i * stride);
        }
    } else if (f->type == 'U' && f->size == 1) {
        for (size_t i = 0; i < count; ++i) {
            to[i] = (double)at[i * stride];
        }
    } else {
        for (size_t i = 0; i < count; ++i) {
            to[i] = stp_pcd_value(at + i * stride, f);
        }
    }
}

uint32_t stp_pcd_packed_color(stp_text at, stp_text end, double value)
{
    bool whole = true;
    for (at += *at == '-'; at < end; ++at) {
        whole = whole && *at >= '0' && *at <= '9';
    }
    if (whole) {
        return fabs(value) < 4294967296.0 ? (uint32_t)(int64_t)value : 0;
    }
    float bits = (float)value;
    uint32_t packed;
    memcpy(&packed, &bits, sizeof(packed));
    return packed;
}
