// SPDX-License-Identifier: MIT
#include "builder/found_results.h"

#include <assert.h>
#include <stdlib.h>

static int compare_keys(const void* left, const void* right)
{
    const stp_hash* a = &((const stp_build_result*)left)->key;
    const stp_hash* b = &((const stp_build_result*)right)->key;
    if (a->high != b->high) {
        return a->high < b->high ? -1 : 1;
    }
    return a->low < b->low ? -1 : a->low > b->low ? 1 : 0;
}

size_t stp_build_count_found(stp_build_result* origins, size_t count)
{
    size_t found = 0;
    if (count > 1) {
        qsort(origins, count, sizeof(*origins), compare_keys);
    }
    for (size_t begin = 0, end; begin < count; begin = end) {
        bool made = false;
        assert((begin == 0 || compare_keys(&origins[begin - 1], &origins[begin]) < 0) &&
               "each key is one run");
        for (end = begin; end < count && stp_hash_equal(origins[begin].key, origins[end].key);
             ++end) {
            made = made || origins[end].made;
        }
        found += made ? 0 : end - begin;
    }
    return found;
}
