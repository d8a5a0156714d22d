// SPDX-License-Identifier: MIT
#include "import/las/laz_coder.h"

#include <assert.h>

enum {
    SHARE_BITS = 15,
    BIT_SHARE_BITS = 13,
    MAX_TABLE_BITS = 8, // shares reach 32768 + 64: one slot more holds them
    ABOVE_ALL = UINT16_MAX,
    LINE = 64
};

static unsigned table_bits(unsigned symbols)
{
    unsigned bits = 3;
    while (bits < MAX_TABLE_BITS && symbols > 2u << bits) {
        bits += 1;
    }
    return bits;
}

void stp_laz_model_make(stp_laz_pool* pool, stp_laz_model* model, unsigned symbols)
{
    assert(symbols >= 2 && symbols < 1u << SHARE_BITS);
    unsigned bits = table_bits(symbols);
    size_t size = (2 * symbols + 2 + ((size_t)1 << bits)) * sizeof(uint16_t);
    if (pool->bytes != NULL) {
        uint16_t* numbers = (uint16_t*)(void*)(pool->bytes + pool->used);
        *model = (stp_laz_model){.shares = numbers,
                                 .counts = numbers + symbols + 1,
                                 .table = numbers + 2 * symbols + 1,
                                 .symbols = (uint16_t)symbols,
                                 .shift = (uint8_t)(SHARE_BITS - bits)};
    }
    pool->used += (size + LINE - 1) / LINE * LINE;
}

void stp_laz_models_make(stp_laz_pool* pool, stp_laz_model* models, size_t count, unsigned symbols)
{
    for (size_t i = 0; i < count; ++i) {
        stp_laz_model_make(pool, &models[i], symbols);
    }
}

void stp_laz_integer_make(stp_laz_pool* pool, stp_laz_integer* integer, unsigned bits,
                          unsigned contexts)
{
    assert((bits == 16 || bits == 32) && contexts > 0 && contexts <= STP_LAZ_MAX_CONTEXTS);
    stp_laz_models_make(pool, integer->sizes, contexts, bits + 1);
    for (unsigned k = 1; k <= bits && k < STP_LAZ_MAX_BITS; ++k) {
        unsigned high = k < STP_LAZ_HIGH_BITS ? k : STP_LAZ_HIGH_BITS;
        stp_laz_model_make(pool, &integer->corrections[k], 1u << high);
    }
}

void stp_laz_model_update(stp_laz_model* m)
{
    unsigned symbols = m->symbols;
    m->total += m->cycle;
    if (m->total > 1u << SHARE_BITS) {
        m->total = 0;
        for (unsigned i = 0; i < symbols; ++i) {
            m->counts[i] = (uint16_t)((m->counts[i] + 1) >> 1);
            m->total += m->counts[i];
        }
    }
    uint32_t scale = ((uint32_t)1 << 31) / m->total, sum = 0;
    unsigned slot = 0, slots = (1u << SHARE_BITS >> m->shift) + 1;
    unsigned round = (1u << m->shift) - 1;
    for (unsigned i = 0; i < symbols; ++i) {
        uint32_t share = scale * sum >> (31 - SHARE_BITS);
        assert(share <= 1u << SHARE_BITS && (i == 0 || share >= m->shares[i - 1]));
        m->shares[i] = (uint16_t)share;
        sum += m->counts[i];
        for (unsigned first = (share + round) >> m->shift; slot < first; ++slot) {
            m->table[slot] = (uint16_t)(i - 1);
        }
    }
    assert(sum == m->total && "the total is that of the counts");
    for (; slot < slots; ++slot) {
        m->table[slot] = (uint16_t)(symbols - 1);
    }
    uint32_t cycle = m->cycle * 5 / 4, maximum = (symbols + 6) * 8;
    m->cycle = cycle < maximum ? cycle : maximum;
    m->left = m->cycle;
}

void stp_laz_model_reset(stp_laz_model* m, uint32_t epoch)
{
    for (unsigned i = 0; i < m->symbols; ++i) {
        m->counts[i] = 1;
    }
    m->shares[m->symbols] = ABOVE_ALL;
    m->epoch = epoch;
    m->total = 0;
    m->cycle = m->symbols;
    stp_laz_model_update(m);
    m->cycle = m->left = (m->symbols + 6u) / 2;
}

void stp_laz_bit_reset(stp_laz_bit* m, uint32_t epoch)
{
    *m = (stp_laz_bit){.zero_share = 1u << (BIT_SHARE_BITS - 1),
                       .zero_count = 1,
                       .count = 2,
                       .cycle = 4,
                       .left = 4,
                       .epoch = epoch};
}

void stp_laz_bit_update(stp_laz_bit* m)
{
    m->count += m->cycle;
    if (m->count > 1u << BIT_SHARE_BITS) {
        m->count = (m->count + 1) >> 1;
        m->zero_count = (m->zero_count + 1) >> 1;
        m->count += m->zero_count == m->count;
    }
    assert(m->zero_count > 0 && m->zero_count < m->count && "both bits stay possible");
    uint32_t scale = ((uint32_t)1 << 31) / m->count;
    m->zero_share = m->zero_count * scale >> (31 - BIT_SHARE_BITS);
    uint32_t cycle = m->cycle * 5 / 4;
    m->cycle = cycle < 64 ? cycle : 64;
    m->left = m->cycle;
}

stp_laz_decoder stp_laz_decoder_begin(const unsigned char* bytes, size_t size, unsigned char* tail,
                                      uint32_t epoch)
{
    stp_laz_decoder d = {.at = bytes,
                         .end = bytes + size,
                         .last = bytes + size,
                         .tail = tail,
                         .length = UINT32_MAX,
                         .epoch = epoch};
    stp_laz_ensure(&d, 8);
    for (int i = 0; i < 4; ++i) {
        d.value = d.value << 8 | *d.at++;
    }
    d.value -= d.value == UINT32_MAX; // never written: value is below length
    assert(d.value < d.length);
    return d;
}

stp_laz_decoder stp_laz_refill(stp_laz_decoder d)
{
    size_t left = (size_t)(d.end - d.at);
    bool in_tail = d.end == d.tail + STP_LAZ_TAIL;
    assert(d.at <= d.end && left <= STP_LAZ_MAX_ENSURED && "less than was asked for is left");
    if (!in_tail) {
        memcpy(d.tail, d.at, left);
        memset(d.tail + left, 0, STP_LAZ_TAIL - left);
        d.last = d.tail + left;
    } else {
        memset(d.tail, 0, STP_LAZ_TAIL);
        d.last = d.tail;
        d.failed = true;
    }
    d.at = d.tail;
    d.end = d.tail + STP_LAZ_TAIL;
    return d;
}
