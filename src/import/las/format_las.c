// SPDX-License-Identifier: MIT
//
// LAS 1.0 to 1.4, its compressed form LAZ, and COPC, which is LAZ in the order of an octree. Up is
// z. Flags of points (synthetic, key point, withheld, overlap) are not kept: all points are read.
#include "base/io/bytes.h"
#include "import/las/las.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>

#define POINTS_IN_SET ((uint64_t)1 << 27)

enum {
    EXTRA_BYTES_ID = 4,
    EXTRA_SIZE = 192, // bytes of an entry
    EXTRA_NAME = 4,
    EXTRA_NAME_SIZE = 32,
    TEXT_SIZE = 512
};

// Lists the names of extra bytes, as far as they fit. @return their number
static uint64_t name_extra_bytes(const stp_las* las, char text[TEXT_SIZE])
{
    stp_las_record record;
    text[0] = '\0';
    if (!stp_las_find_record(las, "LASF_Spec", EXTRA_BYTES_ID, &record)) {
        return 0;
    }
    size_t used = 0;
    uint64_t count = record.size / EXTRA_SIZE;
    for (uint64_t i = 0; i < count; ++i) {
        const char* name = (const char*)record.bytes + i * EXTRA_SIZE + EXTRA_NAME;
        size_t length = strnlen(name, EXTRA_NAME_SIZE);
        if (used + length + 3 < TEXT_SIZE) {
            used += (size_t)snprintf(text + used, TEXT_SIZE - used, "%s%.*s", i > 0 ? ", " : "",
                                     (int)length, name);
        }
    }
    assert(used < TEXT_SIZE);
    return count;
}

/// Counts content that is not kept, and lists extra bytes in one warning.
static void report_losses(stp_las* las)
{
    assert(las->record_size >= las->layout.size);
    size_t extra = las->record_size - las->layout.size;
    char names[TEXT_SIZE];
    if (las->layout.wave != STP_LAS_NO_FIELD) {
        stp_losses_add(&las->import->losses, STP_LOSS_WAVEFORM, las->point_count);
    }
    if (extra > 0) {
        uint64_t count = name_extra_bytes(las, names);
        stp_warn(las->context, "%s: %zu extra bytes of each point are not kept%s%s",
                 las->import->path, extra, count > 0 ? ": " : "", names);
    }
}

static stp_result read_file(stp_las* las, uint64_t points_in_set)
{
    stp_result result = stp_las_read_header(las);
    result = result == STP_OK ? stp_las_read_system(las) : result;
    if (result == STP_OK && las->import->desc.sample_points == 0) {
        report_losses(las);
        stp_las_check_copc(las);
    }
    if (result == STP_OK && las->import->desc.scan != NULL) {
        result = stp_las_describe(las, las->import->desc.scan);
    } else if (result == STP_OK) {
        result = stp_las_read_points(las, points_in_set);
    }
    return result;
}

stp_result stp_las_import(stp_import* import, uint64_t points_in_set)
{
    stp_las las = {.import = import, .context = import->context};
    stp_result result = read_file(&las, points_in_set);
    stp_free(las.context, las.chunks);
    return result;
}

static bool detect(const unsigned char* bytes, size_t size)
{
    return size >= 4 && memcmp(bytes, "LASF", 4) == 0;
}

static stp_result read(stp_import* import)
{
    return stp_las_import(import, POINTS_IN_SET);
}

const stp_importer stp_importer_las = {.name = "las",
                                       .title = "LAS, LAZ, COPC",
                                       .extensions = "las laz",
                                       .detect = detect,
                                       .read = read,
                                       .samples = true};
