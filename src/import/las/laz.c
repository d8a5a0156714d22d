// SPDX-License-Identifier: MIT
#include "import/las/laz.h"

#include "import/las/laz_items.h"

#include <assert.h>

static void make_models(stp_laz* laz, stp_laz_pool* pool)
{
    assert((laz->pointwise != NULL) != (laz->layered != NULL));
    if (laz->pointwise != NULL) {
        stp_laz_pointwise_make(pool, laz->pointwise);
    } else {
        stp_laz_layered_make(pool, laz->layered);
    }
}

stp_laz* stp_laz_create(const stp_las* las)
{
    stp_laz* laz = STP_NEW_ZEROED(las->context, stp_laz, 1);
    if (laz == NULL) {
        return NULL;
    }
    laz->las = las;
    if (las->items == STP_LAZ_POINTWISE) {
        laz->pointwise = stp_laz_pointwise_create(las);
    } else {
        laz->layered = stp_laz_layered_create(las);
    }
    stp_laz_pool pool = {0};
    if (laz->pointwise != NULL || laz->layered != NULL) {
        make_models(laz, &pool);
        laz->numbers = stp_alloc(las->context, pool.used);
    }
    if (laz->numbers == NULL) {
        stp_laz_destroy(las, laz);
        return NULL;
    }
    size_t size = pool.used;
    pool = (stp_laz_pool){.bytes = laz->numbers};
    make_models(laz, &pool);
    assert(pool.used == size && "the models fill the memory that was counted");
    (void)size;
    return laz;
}

void stp_laz_destroy(const stp_las* las, stp_laz* laz)
{
    if (laz != NULL) {
        stp_laz_pointwise_destroy(las, laz->pointwise);
        stp_free(las->context, laz->layered);
        stp_free(las->context, laz->numbers);
        stp_free(las->context, laz);
    }
}

bool stp_laz_begin(stp_laz* laz, const stp_las_chunk* chunk)
{
    assert(chunk->offset + chunk->size <= laz->las->import->file.size);
    laz->chunk = *chunk;
    laz->given = 0;
    laz->epoch += 1;
    return chunk->size >= laz->las->record_size;
}

bool stp_laz_next(stp_laz* laz, size_t count, stp_las_block* block)
{
    const stp_las* las = laz->las;
    size_t first = 0;
    assert(count > 0 && count <= STP_LAS_BLOCK && laz->given + count <= laz->chunk.count);
    if (laz->given == 0) {
        const unsigned char* raw = las->import->file.bytes + laz->chunk.offset;
        const unsigned char* bytes = raw + las->record_size;
        size_t size = (size_t)(laz->chunk.size - las->record_size);
        stp_las_read_records(las, raw, 1, block, 0);
        first = 1;
        bool alone = laz->chunk.count == 1 && size == 0;
        bool good = alone                    ? true
                    : laz->pointwise != NULL ? stp_laz_pointwise_begin(laz, block, raw, bytes, size)
                                             : stp_laz_layered_begin(laz, block, raw, bytes, size);
        if (!good) {
            return false;
        }
    }
    laz->given += count;
    if (first == count) {
        return true;
    }
    return laz->pointwise != NULL ? stp_laz_pointwise_next(laz, first, count - first, block)
                                  : stp_laz_layered_next(laz, first, count - first, block);
}
