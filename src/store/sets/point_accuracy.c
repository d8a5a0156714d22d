// SPDX-License-Identifier: MIT
// Accuracy of the points in sets: whether normal signs are known, and the position error.
#include "store/sets/sets_internal.h"

#include <assert.h>

stp_result stp_store_validate_certainty(const stp_store* store)
{
    const stp_store_certainty* records = store->tables[STP_SECTION_CERTAINTY];
    for (uint32_t i = 0; i < store->counts[STP_SECTION_CERTAINTY]; ++i) {
        if (records[i].flags > STP_CERTAINTY_UNKNOWN_SIGNS ||
            !(records[i].position_error >= 0.0f)) {
            return stp_fail(store->context, STP_ERROR_FORMAT,
                            "%s: splat set %u: its certainty record is invalid", store->path, i);
        }
    }
    return STP_OK;
}

stp_result stp_store_link_certainty(stp_store* store)
{
    const stp_store_certainty* records = store->tables[STP_SECTION_CERTAINTY];
    stp_store_set_record* sets = store->tables[STP_SECTION_SPLAT_SETS];
    uint32_t count = store->counts[STP_SECTION_CERTAINTY];
    if (store->known[STP_SECTION_CERTAINTY] != NULL &&
        count != store->counts[STP_SECTION_SPLAT_SETS]) {
        return stp_fail(store->context, STP_ERROR_FORMAT,
                        "%s: lists the certainty of %u splat sets but has %u", store->path, count,
                        store->counts[STP_SECTION_SPLAT_SETS]);
    }
    stp_result result = stp_store_validate_certainty(store);
    assert(count <= store->counts[STP_SECTION_SPLAT_SETS]);
    for (uint32_t i = 0; i < count && result == STP_OK; ++i) {
        sets[i].splats.unknown_signs = (records[i].flags & STP_CERTAINTY_UNKNOWN_SIGNS) != 0;
        sets[i].splats.position_error = records[i].position_error;
    }
    return result;
}

double stp_store_position_error(const stp_store* store)
{
    const stp_store_certainty* records = store->tables[STP_SECTION_CERTAINTY];
    float maximum = 0.0f;
    for (uint32_t i = 0; i < store->counts[STP_SECTION_CERTAINTY]; ++i) {
        assert(records[i].position_error >= 0.0f && "validated when the file was opened");
        maximum = records[i].position_error > maximum ? records[i].position_error : maximum;
    }
    return (double)maximum;
}
